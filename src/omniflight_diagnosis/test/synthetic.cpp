#include "synthetic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>

#include "omniflight_core/random.hpp"
#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis::test {
namespace {

/// Smooth step from 0 to 1 over [a, b] with zero velocity and acceleration at both ends.
double step(double t, double a, double b) {
  const double s = std::clamp((t - a) / (b - a), 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

}  // namespace

vehicle::Vehicle omnimorph() {
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle("omnimorph");
  EXPECT_TRUE(v) << v.error().text();
  return *v;
}

Vec3 path(double t, const Flown& f) {
  const double T = f.duration_s;
  const double up =
      0.5 * step(t, 0.15 * T, 0.25 * T) + 0.5 * step(t, 0.4 * T, 0.5 * T) - step(t, 0.8 * T, 0.92 * T);
  const double side = step(t, 0.3 * T, 0.36 * T) - step(t, 0.6 * T, 0.66 * T);
  return {f.side_m * side, 0.5 * f.side_m * (step(t, 0.55 * T, 0.6 * T) - step(t, 0.7 * T, 0.75 * T)),
          0.4 + f.climb_m * up};
}

Quat attitude(double t, const Flown& f) {
  if (f.wanders) {
    Vec3 angle = Vec3::Zero();
    constexpr std::array<double, 5> kRates{0.5, 1.1, 1.9, 2.7, 3.9};  // rad/s
    for (std::size_t k = 0; k < kRates.size(); ++k) {
      const double phase = kRates[k] * t + 1.7 * static_cast<double>(k * k);
      angle += f.sway / std::sqrt(5.0) *
               Vec3(std::sin(phase), std::sin(1.13 * phase + 1), 0.5 * std::cos(0.9 * phase));
    }
    return exp_rotation(angle);
  }
  return exp_rotation(
      Vec3(f.sway * std::sin(2.6 * t), f.sway * std::sin(1.9 * t + 1.0), 0.5 * f.sway * std::sin(t)));
}

namespace {

/// State and accelerations at time t [s].
struct Moment {
  RigidState x;
  Vec3 a_W, dw_B;  ///< m/s^2, rad/s^2
};
Moment moment(double t, const Flown& f) {
  constexpr double h = 1e-3;  // s
  Moment out;
  RigidState& x = out.x;
  x.p_WB = path(t, f);
  x.v_WB_W = (path(t + h, f) - path(t - h, f)) / (2 * h);
  out.a_W = (path(t + h, f) - 2 * path(t, f) + path(t - h, f)) / (h * h);
  x.q_WB = attitude(t, f);
  const auto rate = [&](double at) {
    return Vec3(log_rotation(attitude(at - h, f).conjugate() * attitude(at + h, f)) / (2 * h));
  };
  x.w_WB_B = rate(t);
  out.dw_B = (rate(t + h) - rate(t - h)) / (2 * h);
  return out;
}

/// Wrench [N, Nm; 6 x samples] of the effects with memory in this flight.
Eigen::MatrixXd wrench_of_loads(const vehicle::Vehicle& vehicle,
                                const std::vector<physics::ActiveEffect>& effects, const Flown& f, int n) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(6, n), one(6, n);
  if (std::none_of(effects.begin(), effects.end(),
                   [](const auto& e) { return e.effect->memory_size().total() > 0; }))
    return out;
  std::vector<physics::Situation> motion(static_cast<std::size_t>(n));
  const std::vector<double> still(static_cast<std::size_t>(vehicle.rotor_count()), 0.0);
  for (int i = 0; i < n; ++i) {
    const Moment now = moment(i / f.rate_hz, f);
    physics::Situation& s = motion[static_cast<std::size_t>(i)];
    physics::prepare(vehicle, now.x, f.alpha, still, {}, {}, s);
    s.t = i / f.rate_hz;
    s.a_WB_B = now.x.q_WB.conjugate() * now.a_W;
    s.dw_WB_B = now.dw_B;
  }
  for (const auto& e : effects) {
    if (e.effect->memory_size().total() == 0) continue;
    std::vector<double> offset(e.effect->start_spread(e.theta.data()).size(), 0.0);
    if (!offset.empty()) offset[0] = std::sin(f.swing);
    e.effect->replay_from(motion, 1 / f.rate_hz, e.theta.data(), offset.data(), one.data());
    out += one;
  }
  return out;
}

}  // namespace

recording::Recording fly(const vehicle::Vehicle& vehicle, const std::vector<physics::ActiveEffect>& effects,
                         const Flown& f) {
  recording::Recording out;
  out.file = "synthetic";
  out.duration_s = f.duration_s;
  const int n = static_cast<int>(f.duration_s * f.rate_hz), rotors = vehicle.rotor_count();
  const auto add = [&](const char* name, const char* unit, int width) -> recording::Signal& {
    recording::Signal& s = out.signals[name];
    s.name = name;
    s.unit = unit;
    s.values.resize(n, width);
    for (int i = 0; i < n; ++i) s.t_s.push_back(i / f.rate_hz);
    return s;
  };
  recording::Signal &p = add("position", "m", 3), &q = add("attitude", "1", 4),
                    &v = add("velocity", "m/s", 3), &gyro = add("gyro", "rad/s", 3),
                    &acc = add("acc", "m/s2", 3), &speed = add("rotor_speed", "rad/s", rotors),
                    &alpha = add("alpha", "rad", 1);
  Random random(f.seed, "synthetic");
  const auto A = vehicle.allocation_matrix(f.alpha);
  const auto solver = A.completeOrthogonalDecomposition();
  Vec6 disturbance = Vec6::Zero(), answered = Vec6::Zero();
  Vec3 drift = Vec3::Zero();                // of the rate, from the disturbing torque
  const double damping = 5e-3 * f.rate_hz;  // 1/s, at which the rate forgets it
  const double a = std::exp(-1.0 / (f.rate_hz * f.correlation_s)), b = std::sqrt(1 - a * a);
  std::vector<double> omega(static_cast<std::size_t>(rotors), 300.0);
  physics::Environment environment;
  physics::Situation s;
  const Eigen::MatrixXd loads = wrench_of_loads(vehicle, effects, f, n);
  for (int i = 0; i < n; ++i) {
    const double t = i / f.rate_hz;
    const auto [x, a_W, turn] = moment(t, f);
    const Mat3 R_BW = x.q_WB.conjugate().toRotationMatrix();
    const Vec3 force_B = R_BW * (a_W + Vec3(0, 0, environment.gravity));
    // two passes: effects look at the rotor speeds they change
    for (int pass = 0; pass < 3; ++pass) {
      physics::prepare(vehicle, x, f.alpha, omega, {}, environment, s);
      s.t = t;
      s.a_WB_B = R_BW * a_W;
      s.dw_WB_B = turn;
      Vec6 need = Vec6::Zero();
      need.head<3>() = vehicle.mass * force_B;
      need.tail<3>() = vehicle.inertia * turn + x.w_WB_B.cross(vehicle.inertia * x.w_WB_B);
      for (const auto& e : effects) {
        physics::Wrench w;
        e.effect->add_wrench(s, e.theta.data(), w);
        need -= w.at(s);
      }
      need -= loads.col(i) + answered;
      if (f.damped) need.tail<3>() -= damping * (vehicle.inertia * drift);
      const Eigen::VectorXd thrust = solver.solve(need);
      for (int r = 0; r < rotors; ++r)
        omega[static_cast<std::size_t>(r)] = vehicle.rotors[static_cast<std::size_t>(r)].speed(thrust[r]);
    }
    for (int c = 0; c < 6; ++c)
      disturbance[c] =
          a * disturbance[c] + b * (c < 3 ? f.force_noise_N : f.torque_noise_Nm) * random.normal();
    const Vec6 left = disturbance - answered;  // moves the body
    if (f.answer_s > 0) answered += (disturbance - answered) / (1 + f.answer_s * f.rate_hz);
    // its angular part is what the gyro integrates
    const Vec3 dw = vehicle.inertia.ldlt().solve(Vec3(left.tail<3>()));
    for (int c = 0; c < 3; ++c) {
      p.values(i, c) = x.p_WB[c] + 2e-4 * random.normal();
      v.values(i, c) = x.v_WB_W[c] + 2e-3 * random.normal();
      acc.values(i, c) = force_B[c] + left[c] / vehicle.mass + f.accelerometer_noise * random.normal();
      drift[c] += (dw[c] - damping * drift[c]) / f.rate_hz;
      gyro.values(i, c) = x.w_WB_B[c] + drift[c];
    }
    q.values.row(i) << x.q_WB.w(), x.q_WB.x(), x.q_WB.y(), x.q_WB.z();
    alpha.values(i, 0) = f.alpha;
    for (int r = 0; r < rotors; ++r)
      speed.values(i, r) = omega[static_cast<std::size_t>(r)] + f.speed_noise * random.normal();
  }
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) gyro.values(i, c) += f.gyro_noise * random.normal();
  return out;
}

void drive_by_duty(recording::Recording& r, const vehicle::Vehicle& v, double full) {
  recording::Signal duty = r.signals["rotor_speed"];
  const recording::Signal speed = duty;
  duty.name = "pwm";
  const Eigen::Index last = duty.size() - 1;
  for (Eigen::Index i = 0; i <= last; ++i)
    for (Eigen::Index k = 0; k < duty.width(); ++k) {
      const vehicle::Rotor& rotor = v.rotors[static_cast<std::size_t>(k)];
      const Eigen::Index from = std::max<Eigen::Index>(0, i - 1), to = std::min(last, i + 1);
      const double lead =
          rotor.time_constant * (speed.values(to, k) - speed.values(from, k)) /
          (speed.t_s[static_cast<std::size_t>(to)] - speed.t_s[static_cast<std::size_t>(from)]);
      duty.values(i, k) = std::pow(full * std::abs(speed.values(i, k) + lead) / rotor.max_speed(), 1 / 0.85);
    }
  r.signals.erase("rotor_speed");
  r.signals["pwm"] = duty;
}

Eigen::MatrixXd jittering_speeds(const vehicle::Vehicle& v, double rate_hz) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd x(5000, v.rotor_count());
  for (double& value : x.reshaped()) value = normal(random);
  x = low_pass(x, rate_hz, 20);
  for (Eigen::Index r = 0; r < x.cols(); ++r) {
    const double hover = 0.6 * v.rotors[static_cast<std::size_t>(r)].max_speed();
    x.col(r) = (hover + 0.3 * hover * x.col(r).array()).matrix();
  }
  return x;
}

}  // namespace omniflight::diagnosis::test
