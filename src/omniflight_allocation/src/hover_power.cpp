#include "omniflight_allocation/hover_power.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_allocation/box_qp.hpp"
#include "scaled_matrix.hpp"

namespace omniflight::allocation {
namespace {

constexpr int kRounds = 30;        // of reweighting; it converges linearly, by a factor of 2 a round
constexpr double kTracking = 1e7;  // weight of the wrench over that of the power
constexpr double kMet = 1e-4;      // of the weight: what may be missing of the wrench
constexpr double kIdle = 1e-3;     // of the largest thrust: below it the weight of a rotor no longer grows
constexpr double kWorking = 0.05;  // of the largest thrust in use

struct Cost {
  vehicle::RotorVector coefficient;  ///< W/N^1.5
  double of(const vehicle::RotorVector& u) const {
    return coefficient.dot(u.cwiseAbs().array().pow(1.5).matrix());
  }
};

Cost cost_of(const vehicle::Vehicle& v) {
  Cost c{vehicle::RotorVector(v.rotor_count())};
  for (int i = 0; i < v.rotor_count(); ++i) {
    const vehicle::Rotor& r = v.rotors[static_cast<std::size_t>(i)];
    c.coefficient[i] = r.drag_ratio / std::sqrt(r.thrust_coefficient);
  }
  return c;
}

}  // namespace

Result<HoverCost> hover_cost(const vehicle::Vehicle& v, double alpha, const Vec3& up_B) {
  if (auto ok = vehicle::validate(v); !ok) return Failure(ok.error());
  if (!std::isfinite(alpha) || !up_B.allFinite() || std::abs(up_B.norm() - 1) > 1e-6)
    return bad_input("needs a finite tilt (rad) and a unit direction", "hover_power",
                     "Correct the direction");
  const Eigen::MatrixXd B = scaled_matrix(v, alpha);
  const double weight = v.mass * kGravity, most = v.upper_thrusts().maxCoeff();
  Vec6 wanted = Vec6::Zero();
  wanted.head<3>() = weight * up_B;
  const Cost cost = cost_of(v);
  const double usual = std::max(cost.coefficient.maxCoeff(), 1e-12);
  const QpVector lower = v.lower_thrusts(), upper = v.upper_thrusts();
  const QpMatrix tracking = kTracking * (B.transpose() * B);
  const QpVector slope = -kTracking * (B.transpose() * wanted);
  QpVector penalty = QpVector::Ones(v.rotor_count());
  HoverCost out;
  ActiveSet active{};
  for (int round = 0; round < kRounds; ++round) {
    QpMatrix H = tracking;
    H.diagonal() += penalty;
    const BoxQpSolution found = solve_box_qp(H, slope, lower, upper, active);
    if (found.status != QpStatus::solved)
      return fail(ErrorCode::internal, std::string("the program was not solved: ") + to_string(found.status),
                  "hover_power");
    active = found.active_set;
    const bool settled = round > 0 && (found.u - out.u).norm() < 1e-9 * most;
    out.u = found.u;
    if (settled) break;
    // least of sum c |u|^1.5: weights c |u|^-0.5 of squares have the same stationary point
    for (int i = 0; i < v.rotor_count(); ++i)
      penalty[i] =
          std::max(cost.coefficient[i] / usual, 1e-6) / std::sqrt(std::max(std::abs(out.u[i]) / most, kIdle));
  }
  out.possible = (B * out.u - wanted).norm() <= kMet * weight;
  out.power = cost.of(out.u);
  const double largest = out.u.cwiseAbs().maxCoeff();
  for (int i = 0; i < v.rotor_count(); ++i) {
    const double magnitude = std::abs(out.u[i]);
    out.largest_load =
        std::max(out.largest_load, magnitude / v.rotors[static_cast<std::size_t>(i)].max_thrust);
    out.working += magnitude >= kWorking * largest;
  }
  return out;
}

Result<HoverMap> hover_map(const vehicle::Vehicle& vehicle, std::vector<double> alpha,
                           std::vector<double> lean, int azimuths) {
  if (azimuths < 1 || azimuths > 360)
    return bad_input("must lie in [1, 360]", "hover_power.azimuths", "Give another number");
  HoverMap out{std::move(alpha), std::move(lean), {}};
  for (const double angle : out.lean) {
    auto& row = out.worst.emplace_back();
    for (const double tilt : out.alpha) {
      HoverCost worst;
      for (int k = 0; k < azimuths; ++k) {
        const double azimuth = 2 * kPi * k / azimuths;
        const Vec3 up(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                      std::cos(angle));
        auto one = hover_cost(vehicle, tilt, up);
        if (!one) return Failure(one.error());
        if (k == 0 || (worst.possible && (!one->possible || one->power > worst.power)))
          worst = std::move(*one);
      }
      row.push_back(std::move(worst));
    }
  }
  return out;
}

}  // namespace omniflight::allocation
