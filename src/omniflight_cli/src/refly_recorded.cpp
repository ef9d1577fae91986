#include "refly_recorded.hpp"

#include <algorithm>
#include <cmath>

#include "omniflight_allocation/actuation.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_control/law.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_simulation/plant.hpp"
#include "omniflight_simulation/sensors.hpp"

namespace omniflight::cli {
namespace {

using recording::Signal;

constexpr double kStep = 0.002, kPeriod = 0.004, kHeld = 1.0, kStart = 2.0;  // s

/// Everything that was asked for, on the control grid.
struct Asked {
  std::vector<double> t;
  Eigen::MatrixXd p, q, v, w, a, dw, alpha, thrust;
  Reference at(std::size_t i) const {
    const auto k = static_cast<Eigen::Index>(i);
    Reference r;
    r.p_WB = p.row(k).transpose();
    r.q_WB = Quat(q(k, 0), q(k, 1), q(k, 2), q(k, 3)).normalized();
    r.v_WB_W = v.row(k).transpose();
    r.w_WB_B = w.row(k).transpose();
    r.a_WB_W = a.row(k).transpose();
    r.dw_WB_B = dw.row(k).transpose();
    r.alpha = alpha(k, 0);
    return r;
  }
};

Result<Asked> asked_of(const recording::Recording& r) {
  Asked out;
  const Signal* first = r.find("ref_position");
  if (!first || first->size() < 10)
    return bad_input("no reference was recorded", r.file, "Record ref_position ... ref_angular_acceleration");
  for (double t = first->t_s.front(); t <= first->t_s.back() - kPeriod; t += kPeriod) out.t.push_back(t);
  const auto read = [&](const char* name, Eigen::MatrixXd& into, bool needed) -> Status {
    const Signal* s = r.find(name);
    if (!s)
      return needed ? Status(Failure(Error{ErrorCode::bad_input, std::string("no signal '") + name + "'",
                                           r.file, "A flight is flown again only along a whole reference"}))
                    : Status();
    into = recording::resample(*s, out.t);
    for (Eigen::Index i = into.rows(); i-- > 0;)  // beyond the ends of a signal the nearest value holds
      if (!into.row(i).allFinite() && i + 1 < into.rows()) into.row(i) = into.row(i + 1);
    for (Eigen::Index i = 1; i < into.rows(); ++i)
      if (!into.row(i).allFinite()) into.row(i) = into.row(i - 1);
    return into.allFinite() ? Status()
                            : bad_input(std::string("signal '") + name + "' has no values", r.file);
  };
  for (const auto& [name, into] : {std::pair{"ref_position", &out.p},
                                   {"ref_attitude", &out.q},
                                   {"ref_velocity", &out.v},
                                   {"ref_angular_velocity", &out.w},
                                   {"ref_acceleration", &out.a},
                                   {"ref_angular_acceleration", &out.dw}})
    if (auto ok = read(name, *into, true); !ok) return Failure(ok.error());
  if (auto ok = read(r.find("alpha_command") ? "alpha_command" : "alpha", out.alpha, false); !ok)
    return Failure(ok.error());
  if (out.alpha.size() == 0) out.alpha = Eigen::MatrixXd::Zero(out.p.rows(), 1);
  if (auto ok = read("thrust_command", out.thrust, false); !ok) return Failure(ok.error());
  return out;
}

/// Coloured wrench as strong as told.
class Ambient final : public simulation::Disturbance {
 public:
  Ambient(double force, double torque, double time, std::uint64_t seed)
      : keep_(time > 0 ? std::exp(-kStep / time) : 0), random_(seed, "ambient") {
    rms_ << Vec3::Constant(force), Vec3::Constant(torque);
    for (int c = 0; c < 6; ++c) now_[c] = rms_[c] * random_.normal();
  }
  void advance() {
    for (int c = 0; c < 6; ++c)
      now_[c] = keep_ * now_[c] + std::sqrt(1 - keep_ * keep_) * rms_[c] * random_.normal();
  }
  void add_wrench(const physics::Situation&, physics::Wrench& out) const override {
    out.force_B += now_.head<3>();
    out.torque_B += now_.tail<3>();
  }

 private:
  double keep_;
  Random random_;
  Vec6 rms_, now_;
};

struct Tracked {
  Vec6 sum = Vec6::Zero(), integrals = Vec6::Zero();
  int integrated = 0;
  double power = 0;
  int n = 0, powers = 0;
  void add(const Reference& r, const Vec3& p, const Quat& q) {
    Vec6 e;
    e << p - r.p_WB, (180 / kPi) * log_rotation(r.q_WB.conjugate() * q);
    sum += e.cwiseAbs2();
    ++n;
  }
  void add_power(const vehicle::Vehicle& v, std::span<const double> speed) {
    for (std::size_t k = 0; k < speed.size(); ++k)
      power += v.rotors[k].drag_ratio * v.rotors[k].thrust_coefficient * std::pow(std::abs(speed[k]), 3);
    ++powers;
  }
  void add_integral(const Vec6& action) {
    integrals += action.cwiseAbs2();
    ++integrated;
  }
  /// Integral action, RMS; not a number where it was not recorded.
  double integral(Eigen::Index axis) const { return std::sqrt(integrals[axis] / integrated); }
  Vec6 rmse() const { return (sum / std::max(1, n)).cwiseSqrt(); }
  double mean_power() const { return power / std::max(1, powers); }
};

Tracked recorded(const recording::Recording& r, const vehicle::Vehicle& v, const Asked& asked) {
  Tracked out;
  const Eigen::MatrixXd p = recording::resample(r.signals.at("position"), asked.t, 0.1),
                        q = recording::resample(r.signals.at("attitude"), asked.t, 0.1),
                        s = recording::resample(r.signals.at("rotor_speed"), asked.t, 0.1);
  const Signal* kept = r.find("integral");
  const Eigen::MatrixXd integral =
      kept && kept->width() == 6 ? recording::resample(*kept, asked.t, 0.1) : Eigen::MatrixXd();
  for (std::size_t i = 0; i < asked.t.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (asked.t[i] < asked.t.front() + kStart) continue;
    if (integral.size() > 0 && integral.row(k).allFinite()) out.add_integral(integral.row(k).transpose());
    if (p.row(k).allFinite() && q.row(k).allFinite())
      out.add(asked.at(i), p.row(k).transpose(), Quat(q(k, 0), q(k, 1), q(k, 2), q(k, 3)).normalized());
    const Eigen::VectorXd speed = s.row(k).transpose();
    if (speed.allFinite()) out.add_power(v, {speed.data(), static_cast<std::size_t>(speed.size())});
  }
  return out;
}

class Loop {
 public:
  Loop(const vehicle::Vehicle& vehicle, const diagnosis::PriorKnowledge& told,
       const physics::Environment& environment)
      : vehicle_(vehicle), environment_(environment), told_(told) {}

  Result<Tracked> fly(const Asked& asked, const physics::Model& model,
                      const diagnosis::ToldController& controlled) const {
    const Reference start = asked.at(0);
    simulation::PlantConfig config;
    config.step = kStep;
    config.environment = environment_;
    config.initial.p_WB = start.p_WB;
    config.initial.q_WB = start.q_WB;
    config.initial_alpha = start.alpha;
    auto plant = simulation::Plant::create(vehicle_, model, config);
    if (!plant) return Failure(plant.error());
    simulation::SensorConfig s;
    s.imu_rate = 250;
    s.mocap_rate = 125;
    s.mocap_latency = 0.008;
    s.accelerometer_noise = told("sensors.accelerometer.noise_rms_mps2");
    s.gyro_noise = told("sensors.gyro.noise_rms_radps");
    s.mocap_position_noise = told("sensors.mocap.position_noise_m");
    s.mocap_attitude_noise = told("sensors.mocap.attitude_noise_rad");
    simulation::SensorSuite sensors(s, model, kStep, 1);
    Ambient ambient(told("ambient.turbulence_force_rms_N"), told("ambient.turbulence_torque_rms_Nm"),
                    told("ambient.correlation_time_s"), 1);
    control::ControllerConfig gains;
    gains.kp = controlled.kp, gains.kv = controlled.kv, gains.ki = controlled.ki;
    gains.kR = controlled.kR, gains.kw = controlled.kw, gains.kI = controlled.kI;
    const auto actuation = allocation::actuation_at(vehicle_, start.alpha);
    if (!actuation) return Failure(actuation.error());
    const bool leans = actuation->kind == allocation::ActuationKind::underactuated;
    control::LawConfig law;
    law.gains = gains;
    if (leans) law.thrust_axis_B = actuation->thrust_axis_B;
    const auto controller = control::make_law(leans ? "thrust_vector" : "full_pose", law);
    if (!controller) return Failure(controller.error());
    control::Estimator estimator({.position_bandwidth = 25});
    auto allocation = allocation::AllocatorConfig::case_a();
    allocation.tilt_mode = allocation::TiltMode::fixed;
    allocation.initial_tilt = start.alpha;
    auto allocator = allocation::Allocator::create(vehicle_, allocation);
    if (!allocator) return Failure(allocator.error());
    Tracked out;
    Vec6 demand = Vec6::Zero(), achieved = Vec6::Zero();
    simulation::SensorFrame frame;
    std::vector<double> speeds(vehicle_.rotors.size());
    const auto held = static_cast<std::size_t>(kHeld / kPeriod);
    for (std::size_t i = 0; i < asked.t.size() + held; ++i) {
      if (interrupted())
        return fail(ErrorCode::incomplete, "stopped", "closed loop", "What was found is kept");
      const bool free = i >= held;
      const std::size_t at = free ? i - held : 0;
      const Reference r = free ? asked.at(at) : start;
      sensors.sample(*plant, frame);
      take(frame, estimator);
      if (!free) (*controller)->reset();
      RigidState state = estimator.ready() ? estimator.state() : plant->body();
      const Vec6 unachieved = demand - achieved;
      demand = (*controller)->update(r, state, free ? kPeriod : 0.0, unachieved);
      allocation::AllocationInput in;
      in.qdd_ref = demand;
      in.q_WB = state.q_WB;
      in.w_WB_B = state.w_WB_B;
      in.alpha = r.alpha;
      auto u = allocator->allocate(in);
      if (!u) return Failure(u.error());
      achieved = u->qdd;
      command(*plant, *u, asked, at, speeds);
      for (int half = 0; half < 2; ++half) {
        ambient.advance();
        plant->set_disturbance(free ? &ambient : nullptr);
        if (auto ok = plant->step(!free); !ok) return Failure(ok.error());
        if (half == 0) {
          sensors.sample(*plant, frame);
          take(frame, estimator);
        }
      }
      if (free && asked.t[at] >= asked.t.front() + kStart && at + 1 < asked.t.size()) {
        out.add(asked.at(at + 1), plant->body().p_WB, plant->body().q_WB);
        out.add_power(vehicle_, plant->rotor_speed());
        out.add_integral((*controller)->integral_action());
      }
      if (free && !((plant->body().p_WB - r.p_WB).norm() < 2))
        return fail(ErrorCode::incomplete, "left its reference", "closed loop", "The model cannot be flown");
    }
    return out;
  }

 private:
  double told(const char* key) const {
    const auto found = told_.numbers.find(key);
    return found == told_.numbers.end() ? 0.0 : found->second[0];
  }
  static void take(const simulation::SensorFrame& f, control::Estimator& e) {
    if (f.imu) e.add_imu(f.imu_sample.t, f.imu_sample.specific_force_B, f.imu_sample.gyro_B);
    if (f.mocap) e.add_mocap(f.mocap_sample.t, f.mocap_sample.p_WB, f.mocap_sample.q_WB);
  }
  /// What is allocated, and the part of the recorded thrusts that gives no wrench.
  void command(simulation::Plant& plant, const allocation::Allocation& u, const Asked& asked, std::size_t at,
               std::vector<double>& speeds) const {
    vehicle::RotorVector thrust = u.u;
    if (asked.thrust.size() > 0) {
      const auto B = vehicle_.allocation_matrix(u.alpha);
      const vehicle::RotorVector seen = asked.thrust.row(static_cast<Eigen::Index>(at)).transpose();
      const Vec6 wrench = B * seen;
      thrust += seen - B.completeOrthogonalDecomposition().solve(wrench);
    }
    for (std::size_t k = 0; k < speeds.size(); ++k) {
      const auto& rotor = vehicle_.rotors[k];
      speeds[k] = rotor.speed(
          std::clamp(thrust[static_cast<Eigen::Index>(k)], rotor.lower_thrust(), rotor.max_thrust));
    }
    (void)plant.set_command(speeds, u.alpha);
  }

  const vehicle::Vehicle& vehicle_;
  physics::Environment environment_;
  const diagnosis::PriorKnowledge& told_;
};

}  // namespace

Status refly_recorded(const recording::Recording& r, const vehicle::Vehicle& vehicle,
                      const diagnosis::PriorKnowledge& told, const diagnosis::Options& options,
                      diagnosis::Diagnosis& d) {
  for (const char* key : {"kp", "kv", "ki", "kR", "kw", "kI"})
    if (!told.numbers.count(std::string("controller.") + key))
      return bad_input(std::string("controller.") + key + " is not told",
                       told.file.empty() ? r.file : told.file, "Give all six gains in told.yaml");
  for (const char* name : {"position", "attitude", "rotor_speed"})
    if (!r.find(name)) return bad_input(std::string("no signal '") + name + "'", r.file);
  if (r.find("rotor_speed")->width() != vehicle.rotor_count())
    return bad_input("rotor_speed has another count than the vehicle has rotors", r.file);
  auto asked = asked_of(r);
  if (!asked) return Failure(asked.error());
  if (asked->thrust.size() > 0 && asked->thrust.cols() != vehicle.rotor_count()) asked->thrust.resize(0, 0);
  const Loop loop(vehicle, told, options.environment);
  const auto before = loop.fly(*asked, {}, options.controller),
             after = loop.fly(*asked, {d.model, {}}, d.controller.value_or(options.controller));
  if (!before) return Failure(before.error());
  if (!after) return Failure(after.error());
  const Tracked real = recorded(r, vehicle, *asked);
  const char* const names[] = {"px", "py", "pz", "roll", "pitch", "yaw"};
  for (int k = 0; k < 6; ++k)
    d.fit.closed_loop.push_back({names[k],
                                 k < 3 ? "m" : "deg",
                                 real.rmse()[k],
                                 before->rmse()[k],
                                 after->rmse()[k],
                                 {real.integral(k), before->integral(k), after->integral(k)}});
  d.fit.power = {real.mean_power(), before->mean_power(), after->mean_power()};
  return {};
}

}  // namespace omniflight::cli
