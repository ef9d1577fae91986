#include "knot_figures.hpp"

#include "omniflight_allocation/box_qp.hpp"

namespace omniflight::planning {
namespace {

/// Weight of the wrench's error over that of the thrusts: the wrench is met to a millionth.
constexpr double kWrenchWeight = 1e7;
constexpr std::size_t kKnotsBetweenLooks = 64;  // at the clock: 1 ms

/// Least thrusts for wrenches at one tilt.
class Thrusts {
 public:
  Thrusts(const vehicle::Vehicle& vehicle, double alpha)
      : B_(vehicle.allocation_matrix(alpha)),
        lower_(vehicle.lower_thrusts()),
        upper_(vehicle.upper_thrusts()) {
    allocation::QpMatrix H = kWrenchWeight * B_.transpose() * B_;
    H.diagonal().array() += 1.0;
    solver_.set_matrix(H);
  }
  Eigen::VectorXd of(const Vec6& wrench_B) {
    const auto found = solver_.solve(-kWrenchWeight * B_.transpose() * wrench_B, lower_, upper_, warm_);
    warm_ = found.active_set;
    return found.u;
  }

 private:
  vehicle::AllocationMatrix B_;
  allocation::QpVector lower_, upper_;
  allocation::BoxQpSolver solver_;
  allocation::ActiveSet warm_{};
};

}  // namespace

Result<std::vector<KnotFigures>> figures_of(const std::vector<TrajectoryKnot>& knots,
                                            const vehicle::Vehicle& vehicle, Tilts& tilts,
                                            const Deadline& deadline) {
  std::vector<KnotFigures> out;
  std::optional<Thrusts> thrusts;
  const AtTilt* here = nullptr;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (k % kKnotsBetweenLooks == 0 && deadline.passed()) break;
    const Reference& r = knots[k].reference;
    if (!here || r.alpha != knots[k - 1].reference.alpha) {
      const auto found = tilts.at(r.alpha);
      if (!found) return Failure(found.error());
      here = *found;
      thrusts.emplace(vehicle, r.alpha);
    }
    const Vec6 wrench = here->rotors->required_wrench(r);
    out.push_back({here->check.clearance({r.p_WB, r.q_WB}).distance, 1.0 - here->rotors->load(wrench),
                   thrusts->of(wrench)});
  }
  return out;
}

}  // namespace omniflight::planning
