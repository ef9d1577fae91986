// A cable as a chain of point masses: hangs, lies on the floor, goes taut and slack. The finest of three
// fidelities (hung_cable is the algebraic one, cable_pendulum has one mode).
#pragma once

#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::physics {

struct CableConfig {
  int nodes = 20;               ///< links, and free nodes unless the far end is fixed
  double length = 2.0;          ///< m
  double linear_density = 0.1;  ///< kg/m
  double damping = 0.1;         ///< 1/s, force -damping * mass * velocity on every node
  double friction = 0.5;        ///< 1, on the floor
  double floor_z = 0.0;         ///< m
  double gravity = kGravity;    ///< m/s^2
  bool fixed_end = false;       ///< the far end stays where it starts
};

/// How the cable answers to the acceleration a [m/s^2, world] of its upper end over the coming step:
/// force on the body [N, world] = (pull - mass * direction.a) * direction - end_mass * (a - g).
struct CableAnswer {
  Vec3 direction = -Vec3::UnitZ();  ///< unit, along the uppermost link, away from the body
  double pull = 0;                  ///< N
  double mass = 0;                  ///< kg, effective mass along the direction
  double end_mass = 0;              ///< kg, half of the uppermost link moves with the body
};

/// Numbers of a chain in structure-of-arrays order, owned by whoever steps it.
struct CableArrays {
  double *x, *y, *z;     ///< m, nodes 0 (upper end) ... n
  double *vx, *vy, *vz;  ///< m/s
  double* tension;       ///< N, links 1 ... n at index 1 ... n; 0 = slack
  double* split;         ///< m of a link that moves with its upper end, index as tension
};
inline constexpr int kCableArrays = 8;

/// Positions p+ = p + h v with a direct solve of all length constraints (tridiagonal) at the end of the step;
/// links pull and never push, the floor is a stiff implicit spring with friction.
class CableChain {
 public:
  /// Refuses lengths, densities and node counts (2 to 1000) that make no cable.
  static Result<CableChain> create(const CableConfig& config);

  /// Hangs straight down from the upper end; what reaches the floor lies there in a heap.
  void hang(const Vec3& upper_end);
  /// Straight from the upper to the far end, bent slightly aside (never a perfectly straight column).
  void stretch(const Vec3& upper_end, const Vec3& far_end);

  /// Moves the upper end there within `step` seconds. Allocates nothing. O(nodes).
  void step(const Vec3& upper_end, double step);

  Vec3 position(int node) const { return {at(0)[node], at(1)[node], at(2)[node]}; }  ///< m, 0 ... nodes
  Vec3 velocity(int node) const { return {at(3)[node], at(4)[node], at(5)[node]}; }  ///< m/s
  double tension(int link) const { return at(6)[link]; }                             ///< N, 1 ... nodes
  /// Force [N, world] on whatever holds the upper end, without the inertia of the uppermost half link.
  Vec3 end_force() const;
  const CableConfig& config() const { return config_; }
  /// Kinetic and potential energy [J], of the nodes below the upper end.
  double energy() const;

 private:
  explicit CableChain(const CableConfig& config);
  const double* at(int array) const {
    return state_.data() + static_cast<std::size_t>(array * (config_.nodes + 1));
  }
  CableArrays arrays();
  CableConfig config_;
  std::vector<double> state_, work_;
  CableAnswer answer_;
};

/// The kernel of CableChain::step on arrays and workspace (cable_work_size() doubles) of the caller.
CableAnswer step_cable(const CableConfig& config, const CableArrays& arrays, const Vec3& upper_end,
                       double step, double* work);
constexpr int cable_work_size(int nodes) { return 13 * (nodes + 2) + 3 * (nodes + 1); }
void hang_cable(const CableConfig& config, const CableArrays& arrays, const Vec3& upper_end);

}  // namespace omniflight::physics
