#include "omniflight_planning/rotors.hpp"

#include <cmath>
#include <limits>

namespace omniflight::planning {
namespace {

/// Weight of the wrench's error over that of the thrusts: the wrench is met to a millionth.
constexpr double kWrenchWeight = 1e7;
/// Share of the range: a first-order lag comes to a thrust as near as this and never quite there.
constexpr double kSameThrust = 1e-3;

}  // namespace

ThrustReach reachable_thrusts(const vehicle::Rotor& rotor, double thrust, double seconds) {
  const double low = rotor.lower_thrust(), high = rotor.max_thrust;
  if (!(rotor.time_constant > 0.0)) return {low, high};
  const double gone = -std::expm1(-seconds / rotor.time_constant), speed = rotor.speed(thrust);
  const auto after = [&](double command) { return rotor.thrust(speed + gone * (command - speed)); };
  return {after(rotor.speed(low)), after(rotor.speed(high))};
}

Result<Rotors> Rotors::create(const vehicle::Vehicle& vehicle, double alpha, double headroom) {
  auto load = allocation::RotorLoad::create(vehicle, alpha);
  if (!load) return Failure(load.error());
  Rotors out(std::move(*load));
  out.B_ = vehicle.allocation_matrix(alpha);
  const allocation::QpVector range = vehicle.upper_thrusts() - vehicle.lower_thrusts();
  out.lower_ = vehicle.lower_thrusts() + 0.5 * headroom * range;
  out.upper_ = vehicle.upper_thrusts() - 0.5 * headroom * range;
  out.unseen_ = kSameThrust * range;
  out.rotors_ = vehicle.rotors;
  allocation::QpMatrix H = kWrenchWeight * out.B_.transpose() * out.B_;
  H.diagonal().array() += 1.0;
  out.solver_.set_matrix(H);
  // H^-1 weight B', in the form whose matrix is that of wrenches: weight B' (weight B B' + 1)^-1
  Mat6 of_wrenches = kWrenchWeight * out.B_ * out.B_.transpose();
  of_wrenches.diagonal().array() += 1.0;
  out.unbounded_ =
      kWrenchWeight * of_wrenches.ldlt().solve(Mat6(Mat6::Identity())).lazyProduct(out.B_).transpose();
  return out;
}

double Rotors::slowest() const {
  double out = 0.0;
  for (const vehicle::Rotor& rotor : rotors_) out = std::max(out, rotor.time_constant);
  return out;
}

vehicle::RotorVector Rotors::Thrusts::of(const Vec6& wrench_B) {
  const allocation::QpVector free = rotors_.unbounded_.lazyProduct(wrench_B);
  if ((free.array() > rotors_.lower_.array() && free.array() < rotors_.upper_.array()).all()) return free;
  const auto found = solver_.solve(-kWrenchWeight * rotors_.B_.transpose() * wrench_B, rotors_.lower_,
                                   rotors_.upper_, warm_);
  warm_ = found.active_set;
  return found.u;
}

ThrustRate Rotors::rate(const vehicle::RotorVector& from, const vehicle::RotorVector& to,
                        double seconds) const {
  ThrustRate out;
  for (std::size_t i = 0; i < rotors_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double change = to[k] - from[k];
    const double seen = std::abs(change) - unseen_[k];
    if (seen <= 0.0 || !(rotors_[i].time_constant > 0.0)) continue;
    const ThrustReach reach = reachable_thrusts(rotors_[i], from[k], seconds);
    const double room = change > 0.0 ? reach.high - from[k] : from[k] - reach.low;
    const double share = room > 0.0 ? seen / room : std::numeric_limits<double>::infinity();
    if (share > out.share) out = {share, static_cast<int>(i) + 1};
  }
  return out;
}

}  // namespace omniflight::planning
