#include "omniflight_simulation/plant.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::simulation {
namespace {

Status check_model(const physics::Model& model, const vehicle::Vehicle& vehicle) {
  double mass = vehicle.mass;
  for (const auto& e : model.effects) {
    if (!e.effect || static_cast<int>(e.theta.size()) != e.effect->parameter_count())
      return bad_input("an effect has the wrong number of parameters", "model");
    for (std::size_t k = 0; k < e.theta.size(); ++k) {
      const physics::Parameter& p = e.effect->info().parameters[k];
      if (!(e.theta[k] >= p.lower && e.theta[k] <= p.upper))
        return bad_input("is " + std::to_string(e.theta[k]) + " " + p.unit + ", outside [" +
                             std::to_string(p.lower) + ", " + std::to_string(p.upper) + "] " + p.unit,
                         "effects." + e.effect->info().id + "." + p.name);
    }
    if (e.effect->info().id == "payload_mass") mass += e.theta[0];
  }
  if (mass <= 0.0)
    return bad_input("leaves a mass of " + std::to_string(mass) + " kg", "effects.payload_mass.mass",
                     "The sum must be positive");
  return {};
}

}  // namespace

Result<Plant> Plant::create(const vehicle::Vehicle& vehicle, const physics::Model& model,
                            const PlantConfig& config) {
  if (auto ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (!(config.step > 0 && config.step <= 0.02))
    return bad_input("step of " + std::to_string(config.step) + " s is outside (0, 0.02] s",
                     "simulator.step_s");
  if (!is_finite(config.initial)) return bad_input("is not finite", "simulator.initial");
  if (auto ok = check_model(model, vehicle); !ok) return Failure(ok.error());
  for (const auto& track : config.neighbours)
    if (auto ok = physics::validate(track); !ok) return Failure(ok.error());
  physics::Actuation actuation;
  for (const auto& rotor : vehicle.rotors) {
    actuation.time_constant.push_back(rotor.time_constant);
    actuation.delay.push_back(0.0);
  }
  for (const auto& e : model.effects) e.effect->alter_actuation(vehicle, e.theta.data(), actuation);
  auto actuators = physics::Actuators::create(vehicle, actuation, config.step, config.initial_alpha);
  if (!actuators) return Failure(actuators.error());
  return Plant(vehicle, model, config, std::move(*actuators));
}

Plant::Plant(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config,
             physics::Actuators actuators)
    : vehicle_(vehicle),
      count_(vehicle.rotors.size()),
      config_(config),
      actuators_(std::move(actuators)),
      inverse_inertia_(vehicle.inertia.inverse()),
      inverse_mass_(1.0 / vehicle.mass),
      centred_(vehicle.center_of_mass.isZero()),
      body_(config.initial) {
  body_.q_WB.normalize();
  for (std::size_t i = 0; i < count(); ++i) speed_limit_[i] = vehicle_.rotors[i].max_speed();
  alpha_command_ = config.initial_alpha;
  std::size_t numbers = 0;
  for (const physics::ActiveEffect& e : model.effects) {
    const physics::MemorySize size = e.effect->memory_size();
    if (!e.effect->acts_on_wrench() && size.total() == 0) continue;
    effects_.push_back({e.effect, e.theta, numbers, size, e.effect->acts_on_wrench()});
    random_.emplace_back(config.seed, e.effect->info().id);
    numbers += static_cast<std::size_t>(size.total());
  }
  for (std::vector<double>* numbers_of : {&memory_, &stage_memory_, &memory_sum_, &memory_rate_})
    numbers_of->assign(numbers, 0.0);
  (void)answers();
  for (const Acting& e : effects_)
    if (e.size.total() > 0) e.effect->start_memory(situation_, e.theta.data(), memory_.data() + e.at);
}

std::span<const double> Plant::memory(const std::string& id) const {
  for (const Acting& e : effects_)
    if (e.effect->info().id == id) return {memory_.data() + e.at, static_cast<std::size_t>(e.size.total())};
  return {};
}

bool Plant::set_command(std::span<const double> rotor_speed, double alpha) {
  if (rotor_speed.size() != count() || !std::isfinite(alpha)) return false;
  for (const double s : rotor_speed)
    if (!std::isfinite(s)) return false;
  for (std::size_t i = 0; i < count(); ++i) {
    const double limit = speed_limit_[i];
    command_[i] = std::clamp(rotor_speed[i], vehicle_.rotors[i].bidirectional ? -limit : 0.0, limit);
  }
  alpha_command_ = std::clamp(alpha, vehicle_.tilt.min, vehicle_.tilt.max);
  if (vehicle_.tilt.kind == vehicle::TiltKind::none) alpha_command_ = 0.0;
  return true;
}

Vec6 Plant::rotor_wrench(const double* speed) const {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < count_; ++i)
    sum += (speed[i] * (vehicle_.rotors[i].bidirectional ? std::abs(speed[i]) : speed[i])) * map_[i];
  return sum;
}

void Plant::solve_motion(const Vec6& rotors, const physics::Wrench& sum, Derivative& out) const {
  const Vec3& w = situation_.body.w_WB_B;
  const Vec3& c = vehicle_.center_of_mass;
  const double m = vehicle_.mass;
  Vec3 force = rotors.head<3>() + sum.force_B + m * situation_.g_B;
  Vec3 torque = rotors.tail<3>() + sum.torque_B - w.cross(vehicle_.inertia * w);
  Vec3 a_B;
  if (centred_ && !sum.has_inertia) {
    a_B = inverse_mass_ * force;
    out.dw_B = inverse_inertia_ * torque;
  } else {
    // equations about the body origin: [A B; C D] (a, dw) = (force, torque), solved by blocks, since A and D
    // are mass and inertia and far from singular. The vehicle's inertia is about its centre of mass: add m
    // (|c|^2 I - c c^T)
    Mat3 A = m * Mat3::Identity(), B = Mat3::Zero(), C = Mat3::Zero(), D = vehicle_.inertia;
    if (!centred_) {
      const Mat3 cross = skew(c);
      const Mat3 shift = -m * cross * cross;
      force -= m * w.cross(w.cross(c));
      torque += m * c.cross(situation_.g_B) - w.cross(shift * w);
      B = -m * cross;
      C = m * cross;
      D += shift;
    }
    if (sum.has_inertia) {
      A += sum.inertia.topLeftCorner<3, 3>();
      B += sum.inertia.topRightCorner<3, 3>();
      C += sum.inertia.bottomLeftCorner<3, 3>();
      D += sum.inertia.bottomRightCorner<3, 3>();
    }
    const Mat3 inverse_A = A.inverse();
    if (B.isZero(0.0) && C.isZero(0.0)) {
      a_B = inverse_A * force;
      out.dw_B = D == vehicle_.inertia ? Vec3(inverse_inertia_ * torque) : Vec3(D.inverse() * torque);
    } else {
      const Mat3 CA = C * inverse_A;
      out.dw_B = (D - CA * B).inverse() * (torque - CA * force);
      a_B = inverse_A * (force - B * out.dw_B);
    }
  }
  situation_.a_WB_B = a_B;
  situation_.dw_WB_B = out.dw_B;
  out.a_W = situation_.R_WB * a_B;
}

double Plant::speed_rate(std::size_t i, double speed) const {
  if (fault_[i] == Fault::none) return actuators_.rate(i, speed);
  const double tau = actuators_.actuation().time_constant[i];
  return fault_[i] == Fault::seized || tau <= 0 ? 0.0 : -speed / tau;
}

void Plant::apply_rotor_faults() {
  for (std::size_t i = 0; i < count(); ++i) {
    if (fault_[i] == Fault::seized) speed_[i] = seized_at_[i];
    if (fault_[i] == Fault::cut && actuators_.actuation().time_constant[i] <= 0) speed_[i] = 0.0;
  }
}

/// What the effects look at. Most of it rests while the tilt does; prepare() is for when it moves.
void Plant::look(const RigidState& body, const double* speed, const Speeds& acceleration, double t,
                 bool rotors) const {
  const double alpha = actuators_.alpha();
  RigidState unit = body;
  unit.q_WB.coeffs() *= 1.0 / std::sqrt(body.q_WB.squaredNorm());
  if (alpha != mapped_alpha_) {
    physics::prepare(vehicle_, unit, alpha, {speed, count()}, {acceleration.data(), count()},
                     config_.environment, situation_);
    const vehicle::AllocationMatrix map = vehicle_.allocation_matrix(alpha);
    for (std::size_t i = 0; i < count(); ++i)
      map_[i] = vehicle_.rotors[i].thrust_coefficient * map.col(static_cast<Eigen::Index>(i));
    mapped_alpha_ = alpha;
  } else {
    situation_.body = unit;
    situation_.R_WB = unit.q_WB.toRotationMatrix();
    situation_.v_WB_B = situation_.R_WB.transpose() * unit.v_WB_W;
    situation_.g_B = -config_.environment.gravity * situation_.R_WB.row(2).transpose();
    for (std::size_t i = 0; rotors && i < count(); ++i) {
      physics::RotorSituation& r = situation_.rotors[i];
      r.speed = speed[i];
      r.acceleration = acceleration[i];
      r.thrust = vehicle_.rotors[i].thrust(speed[i]);
    }
  }
  situation_.t = t;
  if (!config_.neighbours.empty()) physics::set_neighbours(config_.neighbours, t, situation_);
  situation_.a_WB_B.setZero();
  situation_.dw_WB_B.setZero();
}

void Plant::evaluate(const RigidState& body, const double* speed, const double* memory, double t, bool held,
                     Derivative& out, double* memory_rate, Answers* answers) const {
  if (faulty_)
    for (std::size_t i = 0; i < count(); ++i) out.speed[i] = speed_rate(i, speed[i]);
  else
    actuators_.rates(speed, out.speed.data());
  // effects, disturbances and whoever asks for the answers look at single rotors
  look(body, speed, out.speed, t, !effects_.empty() || disturbance_ || answers);
  out.v_W = body.v_WB_W;
  out.w_B = body.w_WB_B;
  const Vec3 half = 0.5 * body.w_WB_B;
  out.q_WB = (body.q_WB * Quat(0, half.x(), half.y(), half.z())).coeffs();
  if (held) {
    out.a_W.setZero();
    out.dw_B.setZero();
    if (answers) *answers = {-situation_.g_B, Vec3::Zero(), Vec6::Zero()};
  } else {
    physics::Wrench& sum = wrench_;
    sum.force_B.setZero();
    sum.torque_B.setZero();
    if (sum.has_inertia) sum.inertia.setZero();
    sum.has_inertia = false;
    for (const Acting& e : effects_) {
      if (e.on_wrench) e.effect->add_wrench(situation_, e.theta.data(), sum);
      if (e.size.total() > 0) e.effect->add_memory_wrench(situation_, e.theta.data(), memory + e.at, sum);
    }
    if (disturbance_) disturbance_->add_wrench(situation_, sum);
    solve_motion(rotor_wrench(speed), sum, out);
    if (answers) *answers = {situation_.a_WB_B - situation_.g_B, out.dw_B, sum.at(situation_)};
  }
  if (!memory_rate) return;
  for (const Acting& e : effects_)
    if (e.size.continuous > 0)
      e.effect->state_rate(situation_, e.theta.data(), memory + e.at, memory_rate + e.at);
}

const Plant::Answers& Plant::answers() const {
  if (!answered_) {
    Derivative d;
    evaluate(body_, speed_.data(), memory_.data(), time_, held_, d, nullptr, &answers_);
    answered_ = true;
  }
  return answers_;
}

void Plant::euler_step(bool held) {
  const double h = config_.step;
  Derivative k;
  evaluate(body_, speed_.data(), memory_.data(), time_, held, k, memory_rate_.data(), nullptr);
  for (std::size_t i = 0; i < count(); ++i) speed_[i] += h * k.speed[i];
  over_continuous([&](std::size_t j) { memory_[j] += h * memory_rate_[j]; });
  if (held) return;
  body_.v_WB_W += h * k.a_W;
  body_.w_WB_B += h * k.dw_B;
  body_.p_WB += h * body_.v_WB_W;
  body_.q_WB = (body_.q_WB * exp_rotation(h * body_.w_WB_B)).normalized();
}

void Plant::runge_kutta_step(bool held) {
  const double h = config_.step;
  constexpr double kNode[] = {0.0, 0.5, 0.5, 1.0}, kWeight[] = {1.0, 2.0, 2.0, 1.0};
  Derivative k{}, sum{};
  RigidState body = body_;
  Speeds speed = speed_;
  stage_memory_ = memory_;  // same size: no allocation
  over_continuous([&](std::size_t j) { memory_sum_[j] = 0.0; });
  sum.v_W = sum.a_W = sum.dw_B = Vec3::Zero();
  sum.q_WB.setZero();
  for (int stage = 0; stage < 4; ++stage) {
    if (stage > 0) {
      const double f = kNode[stage] * h;
      for (std::size_t i = 0; i < count(); ++i) speed[i] = speed_[i] + f * k.speed[i];
      over_continuous([&](std::size_t j) { stage_memory_[j] = memory_[j] + f * memory_rate_[j]; });
      if (!held) {
        body.p_WB = body_.p_WB + f * k.v_W;
        body.v_WB_W = body_.v_WB_W + f * k.a_W;
        body.w_WB_B = body_.w_WB_B + f * k.dw_B;
        body.q_WB.coeffs() = body_.q_WB.coeffs() + f * k.q_WB;
      }
    }
    evaluate(body, speed.data(), stage_memory_.data(), time_ + kNode[stage] * h, held, k, memory_rate_.data(),
             nullptr);
    const double weight = kWeight[stage];
    sum.v_W += weight * k.v_W;
    sum.a_W += weight * k.a_W;
    sum.dw_B += weight * k.dw_B;
    sum.q_WB += weight * k.q_WB;
    for (std::size_t i = 0; i < count(); ++i) sum.speed[i] += weight * k.speed[i];
    over_continuous([&](std::size_t j) { memory_sum_[j] += weight * memory_rate_[j]; });
  }
  const double s = h / 6.0;
  for (std::size_t i = 0; i < count(); ++i) speed_[i] += s * sum.speed[i];
  over_continuous([&](std::size_t j) { memory_[j] += s * memory_sum_[j]; });
  if (held) return;
  body_.p_WB += s * sum.v_W;
  body_.v_WB_W += s * sum.a_W;
  body_.w_WB_B += s * sum.dw_B;
  body_.q_WB.coeffs() += s * sum.q_WB;
  body_.q_WB.normalize();
}

Status Plant::step(bool held) {
  // the power matters only to a battery that gives way
  const physics::Actuation& a = actuators_.actuation();
  const double power = a.battery_resistance != 0 || a.battery_drop != 0 ? mechanical_power() : 0.0;
  actuators_.begin_step({command_.data(), count()}, alpha_command_, power);
  for (std::size_t i = 0; i < count(); ++i) speed_[i] = actuators_.follows(i, speed_[i]);
  apply_rotor_faults();
  if (config_.integrator == Integrator::semi_implicit_euler)
    euler_step(held);
  else
    runge_kutta_step(held);
  ++steps_;
  time_ = static_cast<double>(steps_) * config_.step;
  held_ = held;
  answered_ = false;
  for (std::size_t k = 0; k < effects_.size(); ++k)
    if (const Acting& e = effects_[k]; e.size.total() > 0)
      e.effect->advance(situation(), e.theta.data(), config_.step, random_[k], memory_.data() + e.at);
  if (!memory_.empty()) answered_ = false;  // what an effect remembers may have changed its wrench
  return check();
}

Status Plant::check() const {
  const auto beyond = [this](const std::string& state, double value, const char* range) {
    return fail(ErrorCode::incomplete,
                "the integration left every reasonable range: " + state + " is " + std::to_string(value) +
                    " (reasonable: " + range + ") at t = " + std::to_string(time_) + " s",
                "simulator", "Check gains, effects and step");
  };
  static const char* const axis[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {  // written so that a NaN is beyond, too
    if (!(std::abs(body_.p_WB[k]) <= 1e3))
      return beyond(std::string("position ") + axis[k], body_.p_WB[k], "+-1000 m");
    if (!(std::abs(body_.v_WB_W[k]) <= 1e3))
      return beyond(std::string("velocity ") + axis[k], body_.v_WB_W[k], "+-1000 m/s");
    if (!(std::abs(body_.w_WB_B[k]) <= 1e3))
      return beyond(std::string("angular velocity ") + axis[k], body_.w_WB_B[k], "+-1000 rad/s");
  }
  if (!is_finite(body_)) return beyond("attitude", body_.q_WB.w(), "finite");
  for (std::size_t i = 0; i < count(); ++i)
    if (!(std::abs(speed_[i]) <= 1e5))
      return beyond("speed of rotor " + std::to_string(i + 1), speed_[i], "+-1e5 rad/s");
  bool fine = true;
  for (const double number : memory_) fine &= std::abs(number) <= 1e9;
  for (const Acting& e : effects_)
    for (std::size_t j = 0; !fine && j < static_cast<std::size_t>(e.size.total()); ++j)
      if (!(std::abs(memory_[e.at + j]) <= 1e9))
        return beyond("state " + std::to_string(j + 1) + " of effect " + e.effect->info().id,
                      memory_[e.at + j], "+-1e9");
  return {};
}

double Plant::mechanical_power() const {
  double power = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const auto& r = vehicle_.rotors[i];
    power += std::abs(r.drag_ratio * r.thrust_coefficient * speed_[i] * speed_[i] * speed_[i]);
  }
  for (const Acting& e : effects_) power += e.effect->shaft_power(situation(), e.theta.data());
  return power;
}

}  // namespace omniflight::simulation
