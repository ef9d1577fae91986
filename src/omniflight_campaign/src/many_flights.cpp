#include "omniflight_campaign/many_flights.hpp"

#include <cmath>
#include <memory>

#include "omniflight_allocation/allocator.hpp"
#include "omniflight_campaign/judged_part.hpp"
#include "omniflight_simulation/batch.hpp"

namespace omniflight::campaign {
namespace {

constexpr std::size_t kTogether = 32;  // flights: their memory stays in the processor's second-level cache
constexpr int kAskEvery = 500;         // control periods between two questions whether to stop

/// Control law, allocator and sums of one flight.
struct Pilot {
  std::unique_ptr<control::Law> law;
  allocation::Allocator allocator;
  Vec6 demand = Vec6::Zero(), achieved = Vec6::Zero();
  bool known = false;  ///< what was achieved of the last demand
  bool gone = false;
  Vec3 position_sum = Vec3::Zero(), attitude_sum = Vec3::Zero();
  double power_sum = 0;
  int looks = 0, at_limit = 0;
  FlightFigures figures;
};

/// One moment of the plan, which all flights share.
struct Moment {
  double t = 0, along = 0;  ///< s, flight time; time of the plan
  bool held = false, look = false, moving = false, ending = false;
  Reference reference;
  std::optional<double> alpha;
};

class Flights {
 public:
  /// `first` is the number of the first of them.
  Flights(const Loop& loop, std::size_t first, simulation::Batch batch, std::vector<Pilot> pilots)
      : loop_(loop),
        first_(first),
        batch_(std::move(batch)),
        pilots_(std::move(pilots)),
        motion_(motion_of(loop.trajectory).value_or(std::pair{0.0, loop.trajectory.duration()})) {}

  /// False when it was stopped.
  Result<bool> fly(bool (*stop)()) {
    const int steps_a_period = static_cast<int>(std::llround(loop_.control_period / loop_.plant.step));
    const auto steps = static_cast<long>(std::ceil(loop_.duration / loop_.plant.step));
    for (long k = 0; k + steps_a_period <= steps; k += steps_a_period) {
      const long period = k / steps_a_period;
      if (stop && period % kAskEvery == 0 && stop()) return false;
      const Moment now = at(static_cast<double>(k) * loop_.plant.step, period);
      for (std::size_t i = 0; i < pilots_.size(); ++i)
        if (!pilots_[i].gone)
          if (auto ok = control(now, i); !ok) return Failure(ok.error());
      (void)batch_.step(steps_a_period, now.held);
    }
    return true;
  }

  FlightFigures figures(std::size_t i) const {
    const Pilot& p = pilots_[i];
    FlightFigures out = p.figures;
    if (p.looks == 0) return out;
    out.position_rmse = (p.position_sum / p.looks).cwiseSqrt();
    out.attitude_rmse = (p.attitude_sum / p.looks).cwiseSqrt();
    out.mean_power = p.power_sum / p.looks;
    out.share_at_limit = static_cast<double>(p.at_limit) / p.looks;
    return out;
  }

 private:
  Moment at(double t, long period) {
    Moment now;
    now.t = t;
    now.held = t < loop_.hold - 1e-9;
    if (now.held) free_since_ = t;  // as the controller component counts: from the last held tick
    now.along = now.held ? -loop_.settle : t - free_since_ - loop_.settle;
    now.reference = loop_.trajectory.sample(now.along);
    if (loop_.follow_plan) now.alpha = now.reference.alpha;
    if (loop_.schedule) now.alpha = loop_.schedule->at(now.along);
    now.look = period % kLookEvery == 0;
    now.moving = now.along >= motion_.first && now.along <= motion_.second;
    const double end = loop_.trajectory.duration();
    now.ending = now.along >= end - kAtEnd && now.along <= end;
    return now;
  }

  Status control(const Moment& now, std::size_t i) {
    Pilot& p = pilots_[i];
    const RigidState state = batch_.body(i);
    const Vec3 error = state.p_WB - now.reference.p_WB;
    const double distance = error.norm();
    if (batch_.lost(i) || !(distance <= kGone)) {
      p.gone = true;
      p.figures.ended_early = now.t;
      return {};
    }
    if (now.held) p.law->reset();
    const Vec6 unachieved = loop_.anti_windup && p.known ? Vec6(p.demand - p.achieved) : Vec6::Zero();
    p.demand = p.law->update(now.reference, state, now.held ? 0.0 : loop_.control_period, unachieved);
    allocation::AllocationInput in;
    in.qdd_ref = p.demand;
    in.q_WB = state.q_WB;
    in.w_WB_B = state.w_WB_B;
    in.position_error = distance;
    in.alpha = now.alpha;
    const auto out = p.allocator.allocate(in);
    if (!out) return Failure(out.error());
    p.achieved = out->qdd;
    p.known = true;
    if (now.look) look(now, i, state, *out, error, distance);
    if (!batch_.set_command(i, {out->speed.data(), static_cast<std::size_t>(out->speed.size())}, out->alpha))
      return fail(ErrorCode::internal, "the allocator commands a speed that is not finite",
                  "flight " + std::to_string(i));
    return {};
  }

  void look(const Moment& now, std::size_t i, const RigidState& state, const allocation::Allocation& a,
            const Vec3& error, double distance) {
    Pilot& p = pilots_[i];
    FlightFigures& f = p.figures;
    if (loop_.watch && now.along >= 0) loop_.watch({first_ + i, now.along, state, batch_.alpha(i), a.u});
    if (now.ending) f.end_error = std::max(f.end_error, distance);
    if (!now.moving) return;
    ++p.looks;
    const Vec3 turned = log_rotation(now.reference.q_WB.conjugate() * state.q_WB);
    p.position_sum += error.cwiseAbs2();
    p.attitude_sum += turned.cwiseAbs2();
    if (distance > f.worst_position) f.worst_position = distance, f.worst_position_at = now.t;
    f.worst_attitude = std::max(f.worst_attitude, turned.norm());
    double most = 0;
    for (std::size_t r = 0; r < loop_.vehicle.rotors.size(); ++r) {
      const vehicle::Rotor& rotor = loop_.vehicle.rotors[r];
      const double w = std::abs(batch_.rotor_speed(i, r));
      p.power_sum += rotor.drag_ratio * rotor.thrust_coefficient * w * w * w;
      most =
          std::max(most, std::abs(a.u[static_cast<Eigen::Index>(r)]) / loop_.believed.rotors[r].max_thrust);
    }
    p.at_limit += most >= kAtLimit;
    f.least_headroom = std::min(f.least_headroom, 1 - most);
  }

  const Loop& loop_;
  std::size_t first_;
  simulation::Batch batch_;
  std::vector<Pilot> pilots_;
  std::pair<double, double> motion_;
  double free_since_ = 0;
};

Result<Flights> prepare(const Loop& loop, std::size_t first, std::span<const OneFlight> flights) {
  simulation::BatchConfig config;
  config.plant = loop.plant;
  std::vector<physics::Model> models;
  std::vector<Pilot> pilots;
  for (const OneFlight& one : flights) {
    models.push_back(one.model);
    config.initial.push_back(one.start);
    config.seeds.push_back(one.seed);
    auto law = control::make_law(loop.law, one.law);
    if (!law) return Failure(law.error());
    auto allocator = allocation::Allocator::create(loop.believed, loop.allocator);
    if (!allocator) return Failure(allocator.error());
    pilots.push_back({.law = std::move(*law), .allocator = std::move(*allocator), .figures = {}});
  }
  auto batch = simulation::Batch::create(loop.vehicle, models, config);
  if (!batch) return Failure(batch.error());
  return Flights(loop, first, std::move(*batch), std::move(pilots));
}

}  // namespace

Result<std::vector<FlightFigures>> fly_many(const Loop& loop, std::span<const OneFlight> flights,
                                            bool (*stop)()) {
  std::vector<FlightFigures> out;
  for (std::size_t first = 0; first < flights.size(); first += kTogether) {
    const auto some = flights.subspan(first, std::min(kTogether, flights.size() - first));
    auto group = prepare(loop, first, some);
    if (!group) return Failure(group.error());
    const auto whole = group->fly(stop);
    if (!whole) return Failure(whole.error());
    if (!*whole) return fail(ErrorCode::incomplete, "stopped", "campaign");
    for (std::size_t i = 0; i < some.size(); ++i) out.push_back(group->figures(i));
  }
  return out;
}

}  // namespace omniflight::campaign
