#include "family_flight.hpp"

#include <cmath>

#include "family_log.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_proof/plant.hpp"

namespace omniflight::proof {
namespace {

constexpr double kHeld = 1.0;          ///< s on the stand before it is let go
constexpr double kMostAttitude = 1.3;  ///< rad from the wanted attitude: lost

struct Squares {
  std::array<double, 6> square{}, sum{};
  int n = 0;
  void add(const Vec6& w) {
    ++n;
    for (std::size_t c = 0; c < 6; ++c) {
      const double x = w[static_cast<int>(c)];
      square[c] += x * x;
      sum[c] += x;
    }
  }
  std::array<double, 6> rms() const {
    std::array<double, 6> out{};
    for (std::size_t c = 0; c < 6; ++c) out[c] = std::sqrt(square[c] / std::max(1, n));
    return out;
  }
  std::array<double, 6> mean() const {
    std::array<double, 6> out{};
    for (std::size_t c = 0; c < 6; ++c) out[c] = sum[c] / std::max(1, n);
    return out;
  }
};

/// First-order, for derivatives of what is slower than 5 Hz.
struct Slow {
  Vec3 value = Vec3::Zero();
  bool begun = false;
  Vec3 rate(const Vec3& x, double dt) {
    if (!begun) value = x;
    begun = true;
    const Vec3 change = (x - value) * (1 - std::exp(-2 * kPi * 5 * dt));
    value += change;
    return change / dt;
  }
};

vehicle::RotorVector null_thrusts(const vehicle::AllocationMatrix& B, double first, double second) {
  const int n = static_cast<int>(B.cols());
  vehicle::RotorVector wanted(n);
  for (int i = 0; i < n; ++i)
    wanted[i] = first * std::cos(0.7 + 1.9 * i) + second * std::sin(0.2 + 1.3 * i * i);
  const Mat6 gram = B * B.transpose();
  const Vec6 wrench = B * wanted;
  return wanted - B.transpose() * gram.ldlt().solve(wrench);
}

/// Everything that is added up along the way.
struct Measures {
  Squares wrench, command, control;
  double force2 = 0, rate2 = 0, change2 = 0, lever2 = 0, jerk2 = 0, rate_jerk2 = 0, speed2 = 0, thrust2 = 0,
         thrust_rate2 = 0, off2 = 0;
  int n = 0;
  Slow force, turning;
  vehicle::RotorVector last_thrust;

  void put_into(FamilyFlown& out) const {
    out.wrench = wrench.rms();
    out.mean = wrench.mean();
    out.command = command.rms();
    out.control = control.rms();
    const auto root = [&](double sum) { return std::sqrt(sum / std::max(1, n)); };
    out.specific_force = root(force2);
    out.rate = root(rate2);
    out.rate_change = root(change2);
    out.lever = root(lever2);
    out.jerk = root(jerk2);
    out.rate_jerk = root(rate_jerk2);
    out.speed = root(speed2);
    out.thrust = root(thrust2);
    out.thrust_rate = root(thrust_rate2);
    out.tracking = root(off2);
  }
};

class Flight {
 public:
  Flight(const FamilyFlight& f, MujocoPlant& plant)
      : f_(f),
        v_(f.vehicle.nominal),
        plant_(plant),
        sensors_(f.sensors, f.world.sensors, f.step, f.seed),
        estimator_({.position_bandwidth = 25}),
        controller_(f.vehicle, f.flown),
        told_(f.vehicle, f.told),
        log_(v_, f.logging, kHeld + f.lead) {
    const auto n = static_cast<std::size_t>(v_.rotor_count());
    speeds_.resize(n);
    lagged_.resize(n);
  }

  Status run() {
    const int steps = static_cast<int>(std::lround((kHeld + f_.path.duration) / f_.step));
    for (int k = 0; k <= steps; ++k) {
      if (interrupted())
        return fail(ErrorCode::incomplete, "stopped in flight", "", "The same command resumes");
      const double t = k * f_.step - kHeld;
      sense();
      if (auto ok = control(t); !ok) return ok;
      if (k == steps) break;
      if (auto ok = plant_.step(t < 0); !ok) return ok;
      if (t < 0) {
        settle_lag();
        continue;
      }
      if (auto ok = measure(t + f_.step, k); !ok) return ok;
    }
    return {};
  }

  FamilyFlown finish() {
    FamilyFlown out;
    measures_.put_into(out);
    out.lowest_thrust = lowest_;
    out.series = std::move(series_);
    if (f_.record) out.recording = log_.finish();
    return out;
  }

 private:
  void sense() {
    sensors_.sample(plant_, frame_);
    if (frame_.imu) {
      force_ = frame_.imu_sample.specific_force_B;
      estimator_.add_imu(frame_.imu_sample.t, force_, frame_.imu_sample.gyro_B);
    }
    if (frame_.mocap)
      estimator_.add_mocap(frame_.mocap_sample.t, frame_.mocap_sample.p_WB, frame_.mocap_sample.q_WB);
    if (f_.record) log_.sensors(plant_.time(), frame_);
  }

  Status control(double t) {
    const Reference r = f_.path.at(std::max(0.0, t));
    const bool held = t < 0;
    ControlInput in;
    in.reference = r;
    in.state = estimator_.state();
    if (!estimator_.ready()) {
      in.state.p_WB = r.p_WB;
      in.state.q_WB = r.q_WB;
    }
    in.specific_force_B = force_;
    in.rotor_speed = plant_.rotor_speed();
    in.alpha = plant_.alpha();
    in.dt = f_.step;
    if (held) {
      controller_.reset();
      told_.reset();
      in.reference.v_WB_W.setZero();
    }
    const ControlOutput u = controller_.update(in);
    Vec6 difference = Vec6::Zero();
    if (f_.told.kind == f_.flown.kind) difference = u.demand - told_.update(in).demand;
    vehicle::RotorVector thrust = u.thrust;
    if (!f_.path.null_space[0].sines.empty() && v_.rotor_count() > 6)
      thrust += null_thrusts(v_.allocation_matrix(in.alpha), f_.path.null_space[0].at(t).value,
                             f_.path.null_space[1].at(t).value);
    for (int i = 0; i < v_.rotor_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const auto& rotor = v_.rotors[k];
      thrust[i] = std::clamp(thrust[i], rotor.lower_thrust(), rotor.max_thrust);
      if (std::abs(thrust[i]) < rotor.min_thrust) thrust[i] = std::copysign(rotor.min_thrust, thrust[i]);
      speeds_[k] = rotor.speed(thrust[i]);
    }
    if (!plant_.set_command(speeds_, r.alpha))
      return fail(ErrorCode::incomplete, "the controller gave up", f_.path.name);
    wanted_ = u.attitude;
    if (held) return {};
    if (t >= f_.lead) {
      difference.head<3>() *= v_.mass;
      difference.tail<3>() = v_.inertia * Vec3(difference.tail<3>());
      measures_.control.add(difference);
      lowest_ = std::min(lowest_, thrust.minCoeff());
    }
    if (f_.record) log_.reasons(plant_.time(), r, u, speeds_, thrust);
    return {};
  }

  void settle_lag() {
    for (std::size_t k = 0; k < speeds_.size(); ++k) lagged_[k] = speeds_[k];
  }

  Status measure(double t, int k) {
    const RigidState& b = plant_.body();
    const Reference r = f_.path.at(t);
    const double off = (b.p_WB - r.p_WB).norm();
    if (!(off < 1.0 + f_.vehicle.reach) ||
        !(log_rotation(wanted_.conjugate() * b.q_WB).norm() < kMostAttitude))
      return fail(ErrorCode::incomplete, "lost after " + std::to_string(t) + " s", f_.path.name);
    if (b.p_WB.z() < f_.world.floor_z + 0.05)
      return fail(ErrorCode::incomplete, "on the floor after " + std::to_string(t) + " s", f_.path.name);
    const int n = v_.rotor_count();
    vehicle::RotorVector difference(n), thrust(n);
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double tau = v_.rotors[at].time_constant;
      lagged_[at] =
          tau > 0 ? speeds_[at] + (lagged_[at] - speeds_[at]) * std::exp(-f_.step / tau) : speeds_[at];
      thrust[i] = v_.rotors[at].thrust(plant_.rotor_speed()[at]);
      difference[i] = thrust[i] - v_.rotors[at].thrust(lagged_[at]);
    }
    if (t < f_.lead) return {};
    const vehicle::AllocationMatrix B = v_.allocation_matrix(plant_.alpha());
    const Vec6 wrench = plant_.unmodelled_wrench(), command = B * difference;
    measures_.wrench.add(wrench);
    measures_.command.add(command);
    const Vec3 f = plant_.specific_force(), dw = plant_.angular_acceleration();
    Measures& m = measures_;
    ++m.n;
    m.force2 += f.squaredNorm();
    m.rate2 += b.w_WB_B.squaredNorm();
    m.change2 += dw.squaredNorm();
    m.lever2 += (skew(dw) + skew(b.w_WB_B) * skew(b.w_WB_B)).squaredNorm() / 3;
    m.jerk2 += m.force.rate(f, f_.step).squaredNorm();
    m.rate_jerk2 += m.turning.rate(dw, f_.step).squaredNorm();
    m.speed2 += b.v_WB_W.squaredNorm();
    m.thrust2 += thrust.squaredNorm() / n;
    if (m.n > 1) m.thrust_rate2 += (thrust - m.last_thrust).squaredNorm() / n / (f_.step * f_.step);
    m.last_thrust = thrust;
    m.off2 += off * off;
    const int every = std::max(1, static_cast<int>(std::lround(1 / (kSeriesRate * f_.step))));
    if (f_.series && k % every == 0) {
      series_.wrench.push_back(wrench);
      series_.command.push_back(command);
      series_.state.push_back(b);
      series_.specific_force.push_back(f);
      series_.angular_acceleration.push_back(dw);
      vehicle::RotorVector speed(n);
      for (int i = 0; i < n; ++i) speed[i] = plant_.rotor_speed()[static_cast<std::size_t>(i)];
      series_.speed.push_back(speed);
      series_.alpha.push_back(plant_.alpha());
    }
    return {};
  }

  const FamilyFlight& f_;
  const vehicle::Vehicle& v_;
  MujocoPlant& plant_;
  SensorSuite sensors_;
  control::Estimator estimator_;
  FamilyController controller_, told_;
  FamilyLog log_;
  SensorFrame frame_;
  Vec3 force_ = kGravity * Vec3::UnitZ();
  std::vector<double> speeds_, lagged_;
  Quat wanted_ = Quat::Identity();
  double lowest_ = 1e300;
  Measures measures_;
  FlightSeries series_;
};

}  // namespace

Result<FamilyFlown> fly(const FamilyFlight& f) {
  const Reference start = f.path.at(0);
  PlantOptions options{.step = f.step, .initial = {}, .initial_alpha = start.alpha, .seed = f.seed};
  options.initial.p_WB = start.p_WB;
  options.initial.q_WB =
      f.vehicle.fully_actuated ? start.q_WB : from_roll_pitch_yaw({0, 0, roll_pitch_yaw(start.q_WB).z()});
  auto plant = MujocoPlant::create(f.vehicle.nominal, f.world, options);
  if (!plant) return Failure(plant.error());
  Flight flight(f, *plant);
  if (auto ok = flight.run(); !ok) return Failure(ok.error());
  return flight.finish();
}

}  // namespace omniflight::proof
