#include "omniflight_simulation/plant.hpp"

#include <algorithm>
#include <cmath>

#include "check_model.hpp"

namespace omniflight::simulation {
Result<Plant> Plant::create(const vehicle::Vehicle& vehicle, const physics::Model& model,
                            const PlantConfig& config) {
  if (auto ok = vehicle::validate(vehicle); !ok) return Failure(ok.error());
  if (!(config.step > 0 && config.step <= 0.02))
    return bad_input("step of " + std::to_string(config.step) + " s is outside (0, 0.02] s",
                     "simulator.step_s");
  if (!is_finite(config.initial))
    return bad_input(what_is_not_finite(config.initial), "simulator.initial", "Give a finite start");
  if (!std::isfinite(config.initial_alpha))
    return bad_input("is " + std::to_string(config.initial_alpha) + " rad", "simulator.initial_alpha",
                     "Give a finite tilt");
  for (const auto& track : config.neighbours)
    if (auto ok = physics::validate(track); !ok) return Failure(ok.error());
  if (auto ok = check_model(vehicle, model, config); !ok) return Failure(ok.error());
  physics::Actuation actuation = physics::nominal_actuation(vehicle);
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
  for (std::size_t i = 0; i < count(); ++i) {
    highest_[i] = vehicle_.rotors[i].max_speed();
    lowest_[i] = vehicle_.rotors[i].bidirectional ? -highest_[i] : 0.0;
    ideal_motor_ = ideal_motor_ || actuators_.actuation().time_constant[i] <= 0;
  }
  thrust_map_ = ThrustMap(vehicle_, model.effects);
  alpha_command_ = config.initial_alpha;
  std::size_t numbers = 0;
  for (const physics::ActiveEffect& e : model.effects) {
    const physics::MemorySize size = e.effect->memory_size();
    if (!e.effect->acts_on_wrench() && size.total() == 0) continue;
    const bool mapped = e.effect->linear_in_thrust();
    effects_.push_back({e.effect, e.theta, numbers, size, e.effect->acts_on_wrench(), mapped});
    bare_ = bare_ && mapped;
    const auto& signals = e.effect->info().signals;
    looks_at_speeds_ = looks_at_speeds_ ||
                       (!mapped && std::find(signals.begin(), signals.end(), "rotor_speed") != signals.end());
    // a second gust blows for itself
    const auto nth = std::count_if(effects_.begin(), effects_.end(),
                                   [&e](const Acting& other) { return other.effect == e.effect; });
    const std::string& id = e.effect->info().id;
    random_.emplace_back(config.seed, nth > 1 ? id + " " + std::to_string(nth) : id);
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
  if (rotor_speed.size() != count()) return false;
  double zero = 0.0 * alpha;  // of numbers that are finite
  for (const double s : rotor_speed) zero += 0.0 * s;
  if (!(zero == 0.0)) return false;
  for (std::size_t i = 0; i < count(); ++i)
    command_[i] = std::min(std::max(rotor_speed[i], lowest_[i]), highest_[i]);
  alpha_command_ = std::clamp(alpha, vehicle_.tilt.min, vehicle_.tilt.max);
  if (vehicle_.tilt.kind == vehicle::TiltKind::none) alpha_command_ = 0.0;
  return true;
}

Status Plant::step(bool held) {
  // the power matters only to a battery that gives way
  const physics::Actuation& a = actuators_.actuation();
  const double power = a.battery_resistance != 0 || a.battery_drop != 0 ? mechanical_power() : 0.0;
  actuators_.begin_step({command_.data(), count()}, alpha_command_, power);
  if (ideal_motor_) {
    for (std::size_t i = 0; i < count(); ++i) speed_[i] = actuators_.follows(i, speed_[i]);
    end_known_ = false;
  }
  if (faulty_) apply_rotor_faults();
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
  // written so that a NaN is beyond, too
  bool fine = body_.q_WB.squaredNorm() < 2.0;
  for (int k = 0; k < 3; ++k)
    fine &= std::abs(body_.p_WB[k]) <= 1e3 && std::abs(body_.v_WB_W[k]) <= 1e3 &&
            std::abs(body_.w_WB_B[k]) <= 1e3;
  for (std::size_t i = 0; i < count(); ++i) fine &= std::abs(speed_[i]) <= 1e5;
  for (const double number : memory_) fine &= std::abs(number) <= 1e9;
  return fine ? Status() : beyond_range();
}

Status Plant::beyond_range() const {
  const auto beyond = [this](const std::string& state, double value, const char* range) {
    return fail(ErrorCode::incomplete,
                "the integration left every reasonable range: " + state + " is " + std::to_string(value) +
                    " (reasonable: " + range + ") at t = " + std::to_string(time_) + " s",
                "simulator", "Check gains, effects and step");
  };
  static const char* const axis[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    if (!(std::abs(body_.p_WB[k]) <= 1e3))
      return beyond(std::string("position ") + axis[k], body_.p_WB[k], "+-1000 m");
    if (!(std::abs(body_.v_WB_W[k]) <= 1e3))
      return beyond(std::string("velocity ") + axis[k], body_.v_WB_W[k], "+-1000 m/s");
    if (!(std::abs(body_.w_WB_B[k]) <= 1e3))
      return beyond(std::string("angular velocity ") + axis[k], body_.w_WB_B[k], "+-1000 rad/s");
  }
  if (!(body_.q_WB.squaredNorm() < 2.0)) return beyond("attitude", body_.q_WB.w(), "finite");
  for (std::size_t i = 0; i < count(); ++i)
    if (!(std::abs(speed_[i]) <= 1e5))
      return beyond("speed of rotor " + std::to_string(i + 1), speed_[i], "+-1e5 rad/s");
  for (const Acting& e : effects_)
    for (std::size_t j = 0; j < static_cast<std::size_t>(e.size.total()); ++j)
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
