#include "omniflight_simulation/plant.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::simulation {
Result<Plant> Plant::create(const vehicle::Vehicle& vehicle, const physics::Model& model,
                            const PlantConfig& config) {
  if (auto ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (!(config.step > 0 && config.step <= 0.02))
    return bad_input("step of " + std::to_string(config.step) + " s is outside (0, 0.02] s",
                     "simulator.step_s");
  if (!is_finite(config.initial)) return bad_input("is not finite", "simulator.initial");
  for (const auto& e : model.effects) {
    if (!e.effect || static_cast<int>(e.theta.size()) != e.effect->parameter_count())
      return bad_input("an effect has the wrong number of parameters", "model");
    for (std::size_t k = 0; k < e.theta.size(); ++k)
      if (!std::isfinite(e.theta[k]))
        return bad_input("is not finite (" + e.effect->info().parameters[k].unit + ")",
                         "effects." + e.effect->info().id + "." + e.effect->info().parameters[k].name);
  }
  Plant plant(vehicle, model, config);
  for (std::size_t i = 0; i < plant.count(); ++i) {
    const double tau = plant.actuation_.time_constant[i];
    if (tau > 0 && config.step > 1.5 * tau)
      return bad_input("step of " + std::to_string(config.step) +
                           " s does not resolve the time constant of rotor " + std::to_string(i + 1) + ", " +
                           std::to_string(tau) + " s",
                       "simulator.step_s", "Take a step of at most the time constant");
    if (!(plant.actuation_.delay[i] >= 0 && plant.actuation_.delay[i] <= 1.0))
      return bad_input("is outside [0, 1] s", "transport_delay");
  }
  double mass = vehicle.mass;
  for (const auto& e : model.effects)
    if (e.effect->info().id == "payload_mass") mass += e.theta[0];
  if (mass <= 0.0)
    return bad_input("leaves a mass of " + std::to_string(mass) + " kg", "effects.payload_mass.mass",
                     "The sum must be positive");
  return plant;
}

Plant::Plant(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config)
    : vehicle_(vehicle), effects_(model.effects), config_(config), body_(config.initial) {
  body_.q_WB.normalize();
  alpha_ = alpha_command_ = config.initial_alpha;
  for (const auto& rotor : vehicle_.rotors) {
    actuation_.time_constant.push_back(rotor.time_constant);
    actuation_.delay.push_back(0.0);
  }
  for (const auto& e : effects_) e.effect->alter_actuation(vehicle_, e.theta.data(), actuation_);
  // wrench effects only from here on
  std::erase_if(effects_, [](const physics::ActiveEffect& e) { return !e.effect->acts_on_wrench(); });
  std::size_t longest = 0;
  for (const double delay : actuation_.delay) {
    delay_steps_.push_back(static_cast<std::size_t>(std::llround(std::max(0.0, delay) / config_.step)));
    longest = std::max(longest, delay_steps_.back());
  }
  history_.assign(longest + 1, {});
  refresh(true);
}

bool Plant::set_command(std::span<const double> rotor_speed, double alpha) {
  if (rotor_speed.size() != count() || !std::isfinite(alpha)) return false;
  for (const double s : rotor_speed)
    if (!std::isfinite(s)) return false;
  for (std::size_t i = 0; i < count(); ++i) {
    const double limit = vehicle_.rotors[i].max_speed();
    target_[i] = std::clamp(rotor_speed[i], vehicle_.rotors[i].bidirectional ? -limit : 0.0, limit);
  }
  alpha_command_ = std::clamp(alpha, vehicle_.tilt.min, vehicle_.tilt.max);
  if (vehicle_.tilt.kind == vehicle::TiltKind::none) alpha_command_ = 0.0;
  return true;
}

void Plant::evaluate(const RigidState& body, const double* speed, Derivative& out, bool held) {
  const std::array<double, vehicle::kMaxRotors>& command = history_[steps_ % history_.size()];
  for (std::size_t i = 0; i < count(); ++i) {
    const double tau = actuation_.time_constant[i];
    out.speed[i] = tau > 0 ? (command[i] - speed[i]) / tau : 0.0;
  }
  RigidState unit = body;
  unit.q_WB.normalize();
  physics::prepare(vehicle_, unit, alpha_, {speed, count()}, {out.speed.data(), count()}, config_.environment,
                   situation_);
  out.v_W = body.v_WB_W;
  out.w_B = body.w_WB_B;
  if (held) {
    out.a_W.setZero();
    out.dw_B.setZero();
    specific_force_ = -situation_.g_B;
    effect_wrench_.setZero();
    return;
  }
  const Vec6 rotors = physics::rotor_wrench(situation_);
  physics::Wrench sum;
  for (const auto& e : effects_) e.effect->add_wrench(situation_, e.theta.data(), sum);

  const Vec3& w = body.w_WB_B;
  const Vec3& c = vehicle_.center_of_mass;
  const double m = vehicle_.mass;
  Vec3 force = rotors.head<3>() + sum.force_B + m * situation_.g_B;
  Vec3 torque = rotors.tail<3>() + sum.torque_B - w.cross(vehicle_.inertia * w);
  const bool offset = !c.isZero();
  Vec3 a_B;
  if (!offset && !sum.has_inertia) {
    a_B = force / m;
    out.dw_B = vehicle_.inertia.llt().solve(torque);
  } else {
    // equations about the body origin; inertia is about the centre of mass, so add m (|c|^2 I - c c^T)
    const Mat3 C = skew(c);
    const Mat3 shift = -m * C * C;
    force -= m * w.cross(w.cross(c));
    torque += m * c.cross(situation_.g_B) - w.cross(shift * w);
    Mat6 M = sum.inertia;
    M.topLeftCorner<3, 3>() += m * Mat3::Identity();
    M.topRightCorner<3, 3>() -= m * C;
    M.bottomLeftCorner<3, 3>() += m * C;
    M.bottomRightCorner<3, 3>() += vehicle_.inertia + shift;
    Vec6 rhs;
    rhs << force, torque;
    const Vec6 nu = M.partialPivLu().solve(rhs);
    a_B = nu.head<3>();
    out.dw_B = nu.tail<3>();
  }
  out.a_W = situation_.R_WB * a_B;
  specific_force_ = a_B - situation_.g_B;
  situation_.a_WB_B = a_B;
  situation_.dw_WB_B = out.dw_B;
  effect_wrench_ = sum.at(situation_);
  situation_.a_WB_B.setZero();
  situation_.dw_WB_B.setZero();
}

void Plant::refresh(bool held) {
  Derivative d;
  evaluate(body_, speed_.data(), d, held);
  angular_acceleration_ = d.dw_B;
}

Status Plant::step(bool held) {
  const double h = config_.step;
  // the command reaches each rotor after its own delay, exact to the step
  auto& now = history_[steps_ % history_.size()];
  std::array<double, vehicle::kMaxRotors> delayed{};
  now = target_;
  for (std::size_t i = 0; i < count(); ++i)
    delayed[i] = steps_ >= delay_steps_[i] ? history_[(steps_ - delay_steps_[i]) % history_.size()][i] : 0.0;
  const auto kept = now;
  now = delayed;
  if (vehicle_.tilt.rate > 0)
    alpha_ += std::clamp(alpha_command_ - alpha_, -vehicle_.tilt.rate * h, vehicle_.tilt.rate * h);
  else
    alpha_ = alpha_command_;
  for (std::size_t i = 0; i < count(); ++i)
    if (actuation_.time_constant[i] <= 0) speed_[i] = delayed[i];

  Derivative k1;
  evaluate(body_, speed_.data(), k1, held);
  if (config_.integrator == Integrator::semi_implicit_euler) {
    for (std::size_t i = 0; i < count(); ++i) speed_[i] += h * k1.speed[i];
    const Vec3 v = body_.v_WB_W + h * k1.a_W, w = body_.w_WB_B + h * k1.dw_B;
    if (!held) {
      body_.p_WB += h * v;
      body_.q_WB = (body_.q_WB * exp_rotation(h * w)).normalized();
      body_.v_WB_W = v;
      body_.w_WB_B = w;
    }
  } else {
    Derivative k2, k3, k4;
    std::array<double, vehicle::kMaxRotors> speed;
    // attitude: RK4 on the quaternion needs the product at each stage
    const auto rate = [](const Quat& q, const Vec3& w) {
      return Eigen::Vector4d((q * Quat(0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z())).coeffs());
    };
    const Eigen::Vector4d r1 = rate(body_.q_WB, k1.w_B);
    const auto at = [&](const Derivative& k, const Eigen::Vector4d& r, double f) {
      RigidState b = body_;
      if (held) return b;
      b.p_WB += f * h * k.v_W;
      b.v_WB_W += f * h * k.a_W;
      b.w_WB_B += f * h * k.dw_B;
      b.q_WB.coeffs() += f * h * r;
      return b;
    };
    const auto speeds_at = [&](const Derivative& k, double f) {
      for (std::size_t i = 0; i < count(); ++i) speed[i] = speed_[i] + f * h * k.speed[i];
    };
    const RigidState b2 = at(k1, r1, 0.5);
    speeds_at(k1, 0.5);
    evaluate(b2, speed.data(), k2, held);
    const Eigen::Vector4d r2 = rate(b2.q_WB, b2.w_WB_B);
    const RigidState b3 = at(k2, r2, 0.5);
    speeds_at(k2, 0.5);
    evaluate(b3, speed.data(), k3, held);
    const Eigen::Vector4d r3 = rate(b3.q_WB, b3.w_WB_B);
    const RigidState b4 = at(k3, r3, 1.0);
    speeds_at(k3, 1.0);
    evaluate(b4, speed.data(), k4, held);
    const Eigen::Vector4d r4 = rate(b4.q_WB, b4.w_WB_B);
    const double s = h / 6.0;
    for (std::size_t i = 0; i < count(); ++i)
      speed_[i] += s * (k1.speed[i] + 2 * k2.speed[i] + 2 * k3.speed[i] + k4.speed[i]);
    if (!held) {
      body_.p_WB += s * (k1.v_W + 2 * k2.v_W + 2 * k3.v_W + k4.v_W);
      body_.v_WB_W += s * (k1.a_W + 2 * k2.a_W + 2 * k3.a_W + k4.a_W);
      body_.w_WB_B += s * (k1.dw_B + 2 * k2.dw_B + 2 * k3.dw_B + k4.dw_B);
      body_.q_WB.coeffs() += s * (r1 + 2 * r2 + 2 * r3 + r4);
      body_.q_WB.normalize();
    }
  }
  refresh(held);
  now = kept;
  ++steps_;
  time_ = static_cast<double>(steps_) * h;
  if (!is_finite(body_) || body_.p_WB.norm() > 1e3 || body_.w_WB_B.norm() > 1e3)
    return fail(ErrorCode::incomplete,
                "the integration left every reasonable range (|p| <= 1000 m, |w| <= 1000 rad/s) at t = " +
                    std::to_string(time_) + " s",
                "simulator", "Check gains, effects and step");
  return {};
}

double Plant::mechanical_power() const {
  double power = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const auto& r = vehicle_.rotors[i];
    power += std::abs(r.drag_ratio * r.thrust_coefficient * speed_[i] * speed_[i] * speed_[i]);
  }
  return power;
}

}  // namespace omniflight::simulation
