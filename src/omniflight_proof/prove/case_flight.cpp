#include "case_flight.hpp"

#include <cmath>

#include "case_log.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_proof/plant.hpp"

namespace omniflight::proof {
namespace {

constexpr double kStep = 0.002;
constexpr int kControlEvery = 2;  ///< plant steps
constexpr double kHeld = 1.0;     ///< s

/// Projects two fixed patterns of thrusts onto what gives no wrench at this tilt: continuous in the tilt.
vehicle::RotorVector null_thrusts(const vehicle::AllocationMatrix& B, double first, double second) {
  const int n = static_cast<int>(B.cols());
  vehicle::RotorVector wanted(n);
  for (int i = 0; i < n; ++i)  // uneven enough to reach both directions of the null space
    wanted[i] = first * std::cos(1.1 + 2.3 * i) + second * std::sin(0.4 + 1.7 * i * i);
  const Mat6 gram = B * B.transpose();
  const Vec6 wrench = B * wanted;
  return wanted - B.transpose() * gram.ldlt().solve(wrench);
}

struct Squares {
  std::array<double, 6> sum{}, mean{};
  int n = 0;
  void add(const Vec6& w) {
    ++n;
    for (std::size_t c = 0; c < 6; ++c) {
      const double x = w[static_cast<int>(c)];
      sum[c] += x * x;
      mean[c] += x;
    }
  }
  std::array<double, 6> rms() const {
    std::array<double, 6> out{};
    for (std::size_t c = 0; c < 6; ++c) out[c] = n ? std::sqrt(sum[c] / n) : 0;
    return out;
  }
  std::array<double, 6> variance() const {
    std::array<double, 6> out{};
    for (std::size_t c = 0; c < 6; ++c) out[c] = n ? sum[c] / n - mean[c] * mean[c] / n / n : 0;
    return out;
  }
};

}  // namespace

control::ControllerConfig usual_gains() {
  control::ControllerConfig c;
  c.kp = Vec3::Constant(12);
  c.kv = Vec3::Constant(6);
  c.ki = Vec3::Constant(12);
  c.kR = Vec3::Constant(100);
  c.kw = Vec3::Constant(20);
  c.kI = Vec3::Constant(20);
  return c;
}

Result<Flown> fly(const vehicle::Vehicle& vehicle, const FlightSetup& setup) {
  const Path& path = setup.path;
  const Reference start = path.at(0);
  PlantOptions options{.step = kStep, .initial = {}, .initial_alpha = start.alpha, .seed = setup.seed};
  options.initial.p_WB = start.p_WB;
  options.initial.q_WB = start.q_WB;
  auto plant = MujocoPlant::create(vehicle, setup.world, options);
  if (!plant) return Failure(plant.error());
  SensorSuite sensors(setup.sensors, setup.world.sensors, kStep, setup.seed);
  control::Estimator estimator({.position_bandwidth = 25});
  control::Controller controller(setup.flown), told(setup.told);
  auto config = allocation::AllocatorConfig::case_a();
  config.tilt_mode = allocation::TiltMode::fixed;
  config.initial_tilt = start.alpha;
  auto allocator = allocation::Allocator::create(vehicle, config);
  if (!allocator) return Failure(allocator.error());

  const int n = vehicle.rotor_count();
  Flown out;
  Log log(vehicle);
  SensorFrame frame;
  Squares wrench, command, control;
  Vec6 demand = Vec6::Zero(), achieved = Vec6::Zero();
  std::vector<double> speeds(static_cast<std::size_t>(n)), lagged(static_cast<std::size_t>(n));
  vehicle::RotorVector thrust(n);
  double error = 0, dw = 0, alpha_command = start.alpha;
  int controls = 0, saturated = 0, samples = 0;
  const int steps = static_cast<int>(std::lround((kHeld + path.duration) / kStep));
  for (int step = 0; step <= steps; ++step) {
    if (interrupted())
      return fail(ErrorCode::incomplete, "stopped in flight", "", "The same command resumes");
    const double time = step * kStep, t = time - kHeld;
    const bool held = t < 0;
    sensors.sample(*plant, frame);
    if (frame.imu)
      estimator.add_imu(frame.imu_sample.t, frame.imu_sample.specific_force_B, frame.imu_sample.gyro_B);
    if (frame.mocap)
      estimator.add_mocap(frame.mocap_sample.t, frame.mocap_sample.p_WB, frame.mocap_sample.q_WB);
    if (setup.record && !held) log.sensors(frame);
    if (step % kControlEvery == 0) {
      const Reference r = path.at(t);
      const double dt = held ? 0.0 : kStep * kControlEvery;
      if (held) controller.reset(), told.reset();
      RigidState state = estimator.state();
      if (!estimator.ready()) {
        state.p_WB = r.p_WB;
        state.q_WB = r.q_WB;
      }
      const Vec6 unachieved = demand - achieved;
      const Vec6 replayed = told.update(r, state, dt, unachieved);
      demand = controller.update(r, state, dt, unachieved);
      allocation::AllocationInput in;
      in.qdd_ref = demand;
      in.q_WB = state.q_WB;
      in.w_WB_B = state.w_WB_B;
      in.alpha = r.alpha;
      auto u = allocator->allocate(in);
      if (!u) return Failure(u.error());
      achieved = u->qdd;
      alpha_command = u->alpha;
      const auto B = vehicle.allocation_matrix(alpha_command);
      thrust = u->u + null_thrusts(B, path.null_space[0].at(t).value, path.null_space[1].at(t).value);
      for (int i = 0; i < n; ++i) {
        const auto& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
        thrust[i] = std::clamp(thrust[i], rotor.lower_thrust(), rotor.max_thrust);
        if (std::abs(thrust[i]) < rotor.min_thrust) thrust[i] = std::copysign(rotor.min_thrust, thrust[i]);
        speeds[static_cast<std::size_t>(i)] = rotor.speed(thrust[i]);
      }
      if (!plant->set_command(speeds, alpha_command))
        return fail(ErrorCode::incomplete, "the controller gave up", path.name);
      if (!held) {
        ++controls;
        saturated += u->active_bounds > 0;
        out.lowest_thrust = std::min(out.lowest_thrust, thrust.minCoeff());
        Vec6 difference = demand - replayed;
        difference.head<3>() *= vehicle.mass;
        difference.tail<3>() = vehicle.inertia * Vec3(difference.tail<3>());
        control.add(difference);
        if (setup.record) {
          log.command(time, speeds, alpha_command);
          if (step % (4 * kControlEvery) == 0) log.reasons(time, r, demand, achieved, thrust);
        }
      }
    }
    if (step == steps) break;
    if (auto ok = plant->step(held); !ok) return Failure(ok.error());
    for (int i = 0; i < n; ++i) {  // what commands would give with the vehicle file's lag
      const auto k = static_cast<std::size_t>(i);
      const double tau = vehicle.rotors[k].time_constant;
      lagged[k] = tau > 0 ? speeds[k] + (lagged[k] - speeds[k]) * std::exp(-kStep / tau) : speeds[k];
    }
    if (held) continue;
    const RigidState& body = plant->body();
    const Reference r = path.at(t + kStep);
    const double off = (body.p_WB - r.p_WB).norm();
    if (!(off < 0.6) || !(log_rotation(r.q_WB.conjugate() * body.q_WB).norm() < 1.0))
      return fail(ErrorCode::incomplete, "lost after " + std::to_string(t) + " s", path.name);
    error += off * off;
    dw += plant->angular_acceleration().squaredNorm();
    ++samples;
    if (t < 1.0) continue;
    wrench.add(plant->unmodelled_wrench());
    vehicle::RotorVector difference(n);
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      difference[i] = vehicle.rotors[k].thrust(plant->rotor_speed()[k]) - vehicle.rotors[k].thrust(lagged[k]);
    }
    command.add(vehicle.allocation_matrix(plant->alpha()) * difference);
  }
  out.wrench = wrench.rms();
  out.command = command.rms();
  out.control = control.rms();
  out.variance = wrench.variance();
  out.dw = std::sqrt(dw / std::max(1, samples));
  out.position_rms = std::sqrt(error / std::max(1, samples));
  out.saturated = static_cast<double>(saturated) / std::max(1, controls);
  if (setup.record) out.recording = log.finish();
  return out;
}

}  // namespace omniflight::proof
