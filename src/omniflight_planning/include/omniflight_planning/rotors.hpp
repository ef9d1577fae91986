// What a motion asks of the rotors at one tilt: thrusts within their range, which change no faster than the
// lag of the motors lets them.
#pragma once

#include "omniflight_allocation/box_qp.hpp"
#include "omniflight_allocation/rotor_load.hpp"
#include "omniflight_vehicle/vehicle.hpp"

namespace omniflight::planning {

/// Thrusts [N] between which a rotor's lies after some time.
struct ThrustReach {
  double low = 0.0, high = 0.0;
};

/// The bound on the rate of thrust. A motor's speed w follows its command c, which the rotor's range of
/// thrust bounds, with a first-order lag: tau dw/dt = c - w. Commanded to the end c of its range, it has
/// after `seconds` = h the speed w + (c - w) (1 - exp(-h / tau)) and the thrust k w |w|. So the rate of
/// thrust is at most (k w(h) |w(h)| - f) / h, for small h 2 k |w| (c - w) / tau: the less, the nearer the
/// thrust f is to the end of its range, and none in the instant of a reversal, which is why the bound is one
/// of a finite step. A rotor without lag reaches its whole range.
ThrustReach reachable_thrusts(const vehicle::Rotor& rotor, double thrust, double seconds);

/// Share of the rate of thrust that the lag allows; 1 is the limit, infinite where it allows none.
struct ThrustRate {
  double share = 0.0;
  int rotor = 0;  ///< that needs it, from 1; 0: none
};

class Rotors {
 public:
  /// Refuses what RotorLoad::create refuses. alpha: rad; headroom: share of every rotor's range, half of it
  /// at each end, that thrusts leave free, [0, 1).
  static Result<Rotors> create(const vehicle::Vehicle& vehicle, double alpha, double headroom);

  const allocation::RotorLoad& load() const { return load_; }
  double slowest() const;  ///< s, the largest time constant of a motor

  /// Thrusts [N] for wrenches one after the other: least squares within the range less the headroom (the
  /// flight's allocator may share them out differently). One thread; the Rotors must live as long.
  class Thrusts {
   public:
    explicit Thrusts(const Rotors& rotors) : rotors_(rotors), solver_(rotors.solver_) {}
    /// wrench_B: force [N], then torque [Nm] about the body origin, body axes.
    vehicle::RotorVector of(const Vec6& wrench_B);

   private:
    const Rotors& rotors_;
    allocation::BoxQpSolver solver_;
    allocation::ActiveSet warm_{};
  };

  /// The largest share that any rotor needs for a change of thrusts [N] in `seconds`.
  ThrustRate rate(const vehicle::RotorVector& from, const vehicle::RotorVector& to, double seconds) const;

 private:
  explicit Rotors(allocation::RotorLoad load) : load_(std::move(load)) {}

  allocation::RotorLoad load_;
  vehicle::AllocationMatrix B_;
  allocation::QpVector lower_, upper_, unseen_;  // N; unseen: a change that counts as none
  allocation::BoxQpSolver solver_;
  std::vector<vehicle::Rotor> rotors_;
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::ColMajor, allocation::kMaxInputs, 6>
      unbounded_;  // thrusts = unbounded wrench where all are within their bounds
};

}  // namespace omniflight::planning
