#include "closed_loop.hpp"

#include <cmath>

#include "omniflight_allocation/actuation.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_control/law.hpp"
#include "omniflight_control/leaning_gains.hpp"
#include "omniflight_simulation/plant.hpp"

namespace omniflight::python {
namespace {

using recording::Recording;
using recording::Signal;

constexpr double kStep = 0.001;      // s
constexpr int kControlEvery = 4;     // steps
constexpr double kOnTheStand = 0.5;  // s, the rotors come up to speed while the body rests
constexpr double kLost = 2.0;        // m from the reference
constexpr double kLongest = 600.0;   // s

/// Signals, sample by sample.
class Log {
 public:
  void add(const char* name, double t, const Eigen::Ref<const Eigen::VectorXd>& x) {
    Kept& kept = kept_[name];
    kept.width = x.size();
    kept.t.push_back(t);
    kept.values.insert(kept.values.end(), x.data(), x.data() + x.size());
  }
  void add(const char* name, double t, const Quat& q) {
    add(name, t, Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
  }
  void add(const char* name, double t, double x) { add(name, t, Eigen::Matrix<double, 1, 1>(x)); }
  void into(Recording& out) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    for (const auto& [name, kept] : kept_) {
      const auto n = static_cast<Eigen::Index>(kept.t.size());
      const Eigen::MatrixXd values = Eigen::Map<const RowMajor>(kept.values.data(), n, kept.width);
      out.signals[name] = Signal{name, recording::find_spec(name)->unit, kept.t, values, "simulated"};
    }
  }

 private:
  struct Kept {
    Eigen::Index width = 0;
    std::vector<double> t, values;
  };
  std::map<std::string, Kept> kept_;
};

Eigen::Map<const Eigen::VectorXd> column(std::span<const double> x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}

class Flight {
 public:
  Flight(simulation::Plant plant, simulation::SensorSuite sensors, std::unique_ptr<control::Law> law,
         allocation::Allocator allocator, const Trajectory& trajectory, const LoopOptions& options)
      : plant_(std::move(plant)),
        sensors_(std::move(sensors)),
        law_(std::move(law)),
        allocator_(std::move(allocator)),
        trajectory_(trajectory),
        options_(options) {}

  Result<Recording> run() {
    const double end = kOnTheStand + 2 * options_.hold_s + trajectory_.duration();
    const auto steps = static_cast<std::int64_t>(end / kStep);
    for (std::int64_t step = 0; step <= steps; ++step) {
      const double t = static_cast<double>(step) * kStep;
      held_ = t < kOnTheStand;
      sense(t);
      if (step % kControlEvery == 0) {
        if (options_.stop && options_.stop()) return fail(ErrorCode::incomplete, "stopped", "simulate");
        if (auto ok = control(t); !ok) return Failure(ok.error());
      }
      if (auto ok = plant_.step(held_); !ok) return Failure(ok.error());
    }
    Recording out;
    out.file = out.format = "simulated";
    out.duration_s = end - kOnTheStand;
    out.metadata["omniflight.vehicle"] = plant_.vehicle().name;
    out.metadata["omniflight.seed"] = std::to_string(options_.seed);
    log_.into(out);
    return out;
  }

 private:
  void sense(double t) {
    sensors_.sample(plant_, frame_);
    const auto& f = frame_;
    const double flown = t - kOnTheStand;
    if (f.imu) estimator_.add_imu(t, f.imu_sample.specific_force_B, f.imu_sample.gyro_B);
    if (f.mocap) estimator_.add_mocap(t, f.mocap_sample.p_WB, f.mocap_sample.q_WB);
    if (held_) return;
    if (f.imu) {
      log_.add("acc", flown, f.imu_sample.specific_force_B);
      log_.add("gyro", flown, f.imu_sample.gyro_B);
    }
    if (f.mocap) {
      log_.add("position", flown, f.mocap_sample.p_WB);
      log_.add("attitude", flown, f.mocap_sample.q_WB);
    }
    if (f.rotor) {
      const std::span<const double> speed{f.rotor_sample.speed.data(), plant_.rotor_speed().size()};
      log_.add("rotor_speed", flown, column(speed));
      log_.add("alpha", flown, f.rotor_sample.alpha);
    }
  }

  Status control(double t) {
    const Reference r = trajectory_.sample(t - kOnTheStand - options_.hold_s);
    if (held_) law_->reset();
    const RigidState state = estimator_.ready() ? estimator_.state() : plant_.body();
    const double period = kStep * kControlEvery;
    const Vec6 unachieved = demand_ - achieved_;
    demand_ = law_->update(r, state, held_ ? 0.0 : period, unachieved);
    allocation::AllocationInput in;
    in.qdd_ref = demand_;
    in.q_WB = state.q_WB;
    in.w_WB_B = state.w_WB_B;
    in.position_error = (state.p_WB - r.p_WB).norm();
    in.alpha = r.alpha;
    const auto u = allocator_.allocate(in);
    if (!u) return Failure(u.error());
    achieved_ = u->qdd;
    const std::span<const double> speed{u->speed.data(), static_cast<std::size_t>(u->speed.size())};
    if (!plant_.set_command(speed, u->alpha))
      return fail(ErrorCode::incomplete, "a command is not finite", "simulate");
    if (!((plant_.body().p_WB - r.p_WB).norm() < kLost))
      return fail(
          ErrorCode::incomplete,
          "the vehicle is more than 2 m from its reference at " + std::to_string(t - kOnTheStand) + " s",
          "simulate", "Fly slower, or with other gains or effects");
    if (!held_) keep(t - kOnTheStand, r, *u);
    return {};
  }

  void keep(double t, const Reference& r, const allocation::Allocation& u) {
    log_.add("ref_position", t, r.p_WB);
    log_.add("ref_attitude", t, r.q_WB);
    log_.add("ref_velocity", t, r.v_WB_W);
    log_.add("ref_angular_velocity", t, r.w_WB_B);
    log_.add("ref_acceleration", t, r.a_WB_W);
    log_.add("ref_angular_acceleration", t, r.dw_WB_B);
    log_.add("qddr", t, demand_);
    log_.add("qdd", t, achieved_);
    log_.add("thrust_command", t, u.u);
    log_.add("rotor_command", t, u.speed);
    log_.add("alpha_command", t, u.alpha);
    log_.add("integral", t, law_->integral_action());
    log_.add("truth_position", t, plant_.body().p_WB);
    log_.add("truth_attitude", t, plant_.body().q_WB);
    log_.add("truth_velocity", t, plant_.body().v_WB_W);
    log_.add("truth_angular_velocity", t, plant_.body().w_WB_B);
    log_.add("truth_wrench", t, plant_.effect_wrench());
    log_.add("truth_power", t, plant_.mechanical_power());
  }

  simulation::Plant plant_;
  simulation::SensorSuite sensors_;
  simulation::SensorFrame frame_;
  control::Estimator estimator_{{}};
  std::unique_ptr<control::Law> law_;
  allocation::Allocator allocator_;
  const Trajectory& trajectory_;
  const LoopOptions& options_;
  Log log_;
  Vec6 demand_ = Vec6::Zero(), achieved_ = Vec6::Zero();
  bool held_ = true;
};

}  // namespace

Result<Recording> fly(const vehicle::Vehicle& vehicle, const physics::Model& model,
                      const Trajectory& trajectory, const LoopOptions& options) {
  if (trajectory.empty() || trajectory.duration() > kLongest)
    return bad_input("lasts " + std::to_string(trajectory.duration()) + " s", "trajectory",
                     "Give one of more than 0 and at most 600 s");
  if (!(options.hold_s >= 0 && options.hold_s <= 60))
    return bad_input("is " + std::to_string(options.hold_s) + " s, must lie between 0 and 60 s",
                     "simulate: hold_s");
  const Reference start = trajectory.sample(0);
  simulation::PlantConfig config;
  config.step = kStep;
  config.environment = options.environment;
  config.initial.p_WB = start.p_WB;
  config.initial.q_WB = start.q_WB;
  config.initial_alpha = start.alpha;
  config.seed = options.seed;
  auto plant = simulation::Plant::create(vehicle, model, config);
  if (!plant) return Failure(plant.error());
  const auto actuation = allocation::actuation_at(vehicle, start.alpha);
  if (!actuation) return Failure(actuation.error());
  const bool leans = actuation->kind == allocation::ActuationKind::underactuated;
  control::LawConfig law;
  if (leans) {
    double slowest = 0;
    for (const vehicle::Rotor& rotor : vehicle.rotors) slowest = std::max(slowest, rotor.time_constant);
    law.thrust_axis_B = actuation->thrust_axis_B;
    law.gains = control::leaning_gains(slowest);
  }
  if (options.gains) options.gains(law.gains);
  auto controller = control::make_law(leans ? "thrust_vector" : "full_pose", law);
  if (!controller) return Failure(controller.error());
  auto weights = allocation::AllocatorConfig::case_a();
  weights.tilt_mode = allocation::TiltMode::fixed;
  weights.initial_tilt = start.alpha;
  auto allocator = allocation::Allocator::create(vehicle, weights);
  if (!allocator) return Failure(allocator.error());
  return Flight(std::move(*plant), simulation::SensorSuite(options.sensors, model, kStep, options.seed),
                std::move(*controller), std::move(*allocator), trajectory, options)
      .run();
}

}  // namespace omniflight::python
