// Rotor thrusts and tilt that give a wanted acceleration best: equations 4.2, 4.3 and 5.3 of the OmniMorph
// thesis.
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "omniflight_allocation/config.hpp"
#include "omniflight_allocation/gap_qp.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::allocation {

struct TiltTerms;
struct TiltPrograms;

struct AllocationInput {
  Vec6 qdd_ref = Vec6::Zero();   ///< wanted acceleration: linear of the body origin, world [m/s^2]; angular,
                                 ///< body [rad/s^2]
  Quat q_WB = Quat::Identity();  ///< measured attitude
  Vec3 w_WB_B = Vec3::Zero();    ///< rad/s, measured angular velocity, body
  double position_error = 0;     ///< m, |p_ref - p|; used by the dynamic weights only
  std::optional<double> alpha;   ///< rad, tilt to use in fixed mode; empty: stay where it is
};

struct Allocation {
  vehicle::RotorVector u;      ///< N, thrust of each rotor
  vehicle::RotorVector speed;  ///< rad/s, signed, for each rotor
  double alpha = 0;            ///< rad
  Vec6 qdd = Vec6::Zero();     ///< acceleration that u gives, same layout as qdd_ref
  Vec6 unachieved_wrench =
      Vec6::Zero();         ///< N, Nm: wanted minus given wrench about the body origin, body axes
  double cost = 0;          ///< value of equation 4.3 at u
  double w_input = 0;       ///< weight W1 that was used
  double kkt_residual = 0;  ///< of the quadratic program, see BoxQpSolution
  int active_bounds = 0;    ///< rotors at a limit, the edges of a thrust gap included
  int iterations = 0;       ///< linear systems solved, all candidate tilts together
  int programs = 0;         ///< quadratic programs solved, all candidate tilts together
};

/// Control allocation of one vehicle. Minimises over u within the thrust limits
///   |qdd(alpha, u) - qdd_ref|^2_W2 + W3 |u - u_previous|^2 + W1 |u|^2
/// (with keep_min_thrust also outside the gap about zero that a rotor cannot hold)
/// exactly, at the given tilt or at the best of the candidates within a step of the previous tilt and within
/// the limits. Holds its own previous u, tilt and weight; deterministic; allocate() allocates nothing.
class Allocator {
 public:
  /// Refuses an invalid vehicle or config and more than kMaxInputs rotors. Rotors that tilt one by one are
  /// given one tilt, as if they tilted together.
  static Result<Allocator> create(const vehicle::Vehicle& vehicle, const AllocatorConfig& config);

  /// One control period. A number that is not finite or a tilt outside the limits is refused and changes
  /// nothing.
  Result<Allocation> allocate(const AllocationInput& input);

  /// Starts anew at a tilt [rad], clipped to the limits, with thrusts [N] of the period before (zero by
  /// default).
  void reset(double alpha, const vehicle::RotorVector* u_previous = nullptr);

  /// Leaves a rotor out from now on: its column is dropped, its thrust is 0. Refuses one that there is not,
  /// and the last one. Allocates.
  Status drop_rotor(int rotor);

  const AllocatorConfig& config() const { return config_; }

 private:
  Allocator() = default;
  struct Wish;
  struct Candidate;
  struct Tilt {
    double alpha, c, s;  // rad, cosine, sine
  };
  using Tilts = std::array<Tilt, 8>;
  void assemble_products();
  void assemble_quadratic(double c, double s, QpMatrix& H) const;
  double next_weight(double position_error) const;
  Wish wish(const AllocationInput& input) const;
  int tilts(double centre, Tilts& out) const;
  Status solve(const Wish& wish, const Tilt& tilt, ActiveSet& warm, Candidate& out);
  Status search(const Wish& wish, const Tilts& tilts, int count, Candidate& best);
  void fill(const Wish& wish, const Tilts& tilts, int count, TiltPrograms& p) const;
  Vec6 acceleration(const Mat3& R_WB, const Vec3& w_WB_B, const vehicle::AllocationMatrix& A,
                    const vehicle::RotorVector& u) const;

  AllocatorConfig config_;
  int n_ = 0;
  double alpha_min_ = 0, alpha_max_ = 0;
  Mat6 M_, M_inverse_;  // wrench about the body origin -> acceleration, body axes
  Mat3 inertia_, inertia_inverse_;
  Vec3 com_;
  vehicle::AllocationMatrix A0_, Ac_, As_;  // M B(alpha) = A0 + cos Ac + sin As
  bool constant_part_ = true;
  QpMatrix Q00_, Qcc_, Qss_, Q0c_, Q0s_, Qcs_;  // their weighted products
  vehicle::RotorVector lower_, upper_, gap_, unit_weight_;
  std::vector<vehicle::Rotor> rotors_;
  std::array<double, 4> cos_step_{}, sin_step_{};  ///< of the pairs of candidates
  Vec6 weight_;
  bool has_gap_ = false;
  std::uint32_t dropped_ = 0;               ///< bit 0 is the first rotor
  std::shared_ptr<const TiltTerms> terms_;  ///< up to 8 rotors
  // memory
  vehicle::RotorVector u_previous_;
  double alpha_ = 0, w_input_ = 0;
  std::array<ActiveSet, 8> warm_{};  ///< of each candidate
  std::array<std::uint8_t, 8> lanes_at_low_{}, lanes_at_high_{};
  BoxQpSolver kept_;  ///< at kept_alpha_ with weight kept_w_
  double kept_alpha_ = std::numeric_limits<double>::quiet_NaN(), kept_w_ = 0;
};

}  // namespace omniflight::allocation
