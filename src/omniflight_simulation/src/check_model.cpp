#include "check_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::simulation {
namespace {

std::string number(double value, const std::string& unit) {
  std::ostringstream text;
  text << value;
  if (unit != "1") text << ' ' << unit;
  return text.str();
}

Status check_bounds(const physics::ActiveEffect& e) {
  if (!e.effect || static_cast<int>(e.theta.size()) != e.effect->parameter_count())
    return bad_input("an effect has the wrong number of parameters", "model");
  for (std::size_t k = 0; k < e.theta.size(); ++k) {
    const physics::Parameter& p = e.effect->info().parameters[k];
    if (!(e.theta[k] >= p.lower && e.theta[k] <= p.upper))
      return bad_input("is " + number(e.theta[k], p.unit) + ", outside [" + number(p.lower, "1") + ", " +
                           number(p.upper, "1") + "] " + p.unit,
                       e.effect->parameter_field(k));
  }
  return {};
}

/// Two of an effect add up, as their wrenches and errors do, but for parameters of which a vehicle has one.
Status check_twice(const physics::ActiveEffect& first, const physics::ActiveEffect& again) {
  const physics::EffectInfo& info = first.effect->info();
  for (std::size_t k = 0; k < info.parameters.size(); ++k) {
    const physics::Parameter& p = info.parameters[k];
    if (std::find(info.one_value.begin(), info.one_value.end(), p.name) == info.one_value.end()) continue;
    if (again.theta[k] != first.theta[k])
      return bad_input("is " + number(first.theta[k], p.unit) + " and, where the effect is listed again, " +
                           number(again.theta[k], p.unit) + "; there is one",
                       first.effect->parameter_field(k), "List the effect once, or with the same value");
  }
  return {};
}

Status check_twice(const physics::Model& model) {
  std::map<const physics::Effect*, const physics::ActiveEffect*> first;
  for (const physics::ActiveEffect& e : model.effects) {
    const auto [at, is_new] = first.emplace(e.effect, &e);
    if (is_new) continue;
    if (auto ok = check_twice(*at->second, e); !ok) return ok;
  }
  return {};
}

/// What would silently do nothing, or cannot be.
Status check_idle(const vehicle::Vehicle& vehicle, const physics::ActiveEffect& e,
                  const PlantConfig& config) {
  const physics::EffectInfo& info = e.effect->info();
  const auto& signals = info.signals;
  const bool flies_along =
      std::any_of(config.neighbours.begin(), config.neighbours.end(),
                  [](const auto& track) { return track.t_s.size() == 1 || track.t_s.back() >= 0; });
  if (!flies_along && std::find(signals.begin(), signals.end(), "neighbour") != signals.end())
    return bad_input(
        "needs the signal 'neighbour', and no track of one reaches the time of the simulation, from 0 s on",
        "effects." + info.id,
        "Give where it flies: `omniflight fly --neighbour FILE` (t_s, px_m, py_m, pz_m), or "
        "PlantConfig::neighbours");
  return e.effect->check_feasible(vehicle, config.initial, e.theta.data());
}

/// The rigid body that flies: the vehicle with the mass and inertia that effects without memory add to it.
/// Ropes and loads have a memory, and bodies of their own.
struct Body {
  double mass = 0;
  Vec3 moments = Vec3::Zero();  ///< kg m2, principal, about its centre of mass, ascending
  double excess() const { return moments[2] - moments[1] - moments[0]; }
};

Body body_of(const vehicle::Vehicle& vehicle, const physics::Model& model,
             const physics::Situation& situation) {
  physics::Wrench sum;
  for (const physics::ActiveEffect& e : model.effects)
    if (e.effect->acts_on_wrench() && e.effect->memory_size().total() == 0)
      e.effect->add_wrench(situation, e.theta.data(), sum);
  Body out;
  out.mass = vehicle.mass + sum.mass;
  const Mat3 lever = vehicle.mass * skew(vehicle.center_of_mass);
  const Mat3 A = out.mass * Mat3::Identity() + sum.inertia.topLeftCorner<3, 3>();
  const Mat3 B = sum.inertia.topRightCorner<3, 3>() - lever;
  const Mat3 C = sum.inertia.bottomLeftCorner<3, 3>() + lever;
  const Mat3 D =
      vehicle.inertia - lever * skew(vehicle.center_of_mass) + sum.inertia.bottomRightCorner<3, 3>();
  const Mat3 about_centre = D - C * A.inverse() * B;
  out.moments =
      Eigen::SelfAdjointEigenSolver<Mat3>(0.5 * (about_centre + about_centre.transpose())).eigenvalues();
  return out;
}

/// The parameter without which a body would be closest to a possible one.
struct Blamed {
  std::string field, is;  ///< "is 0.3 kg and "; empty where the model has no parameters
};

Blamed blame(const vehicle::Vehicle& vehicle, const physics::Model& model,
             const physics::Situation& situation, double (*impossible)(const Body&)) {
  Blamed out;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < model.effects.size(); ++i)
    for (std::size_t k = 0; k < model.effects[i].theta.size(); ++k) {
      const physics::Effect& effect = *model.effects[i].effect;
      const physics::Parameter& p = effect.info().parameters[k];
      physics::Model without = model;
      without.effects[i].theta[k] = p.neutral;
      const double left = impossible(body_of(vehicle, without, situation));
      if (left >= least) continue;
      least = left;
      out = {effect.parameter_field(k), "is " + number(model.effects[i].theta[k], p.unit) + " and "};
    }
  return out;
}

Status check_body(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config) {
  physics::Situation situation;
  const std::vector<double> still(vehicle.rotors.size(), 0.0);
  physics::prepare(vehicle, config.initial, config.initial_alpha, still, {}, config.environment, situation);
  const Body body = body_of(vehicle, model, situation);
  if (!(body.mass > 0)) {
    const Blamed lightest = blame(vehicle, model, situation, [](const Body& b) { return -b.mass; });
    return bad_input("leaves a mass of " + number(body.mass, "kg") + ", must be above 0 kg",
                     lightest.field.empty() ? "mass" : lightest.field, "Take away less than the vehicle has");
  }
  const double rounding = 1e-9 * body.moments[2];
  const bool definite = body.moments[0] > rounding;
  if (definite && body.excess() <= rounding) return {};
  const Blamed most = blame(vehicle, model, situation, [](const Body& b) { return b.excess(); });
  const auto kgm2 = [](double value) { return number(value, "kg m2"); };
  const std::string limit = definite ? "the largest may be at most the sum of the others, " +
                                           kgm2(body.moments[0] + body.moments[1])
                                     : std::string("each must be above 0 kg m2");
  return bad_input(most.is + "leaves principal moments of inertia of " + number(body.moments[0], "1") + ", " +
                       number(body.moments[1], "1") + " and " + kgm2(body.moments[2]) +
                       " about the centre of mass; " + limit,
                   most.field.empty() ? "inertia" : most.field,
                   std::string("Bring it closer to zero, or add the inertia that goes with it (") +
                       physics::effect_id::com_offset + " keeps that about the body origin)");
}

}  // namespace

Status check_model(const vehicle::Vehicle& vehicle, const physics::Model& model, const PlantConfig& config) {
  for (const physics::ActiveEffect& e : model.effects)
    if (auto ok = check_bounds(e); !ok) return ok;
  if (auto ok = check_twice(model); !ok) return ok;
  for (const physics::ActiveEffect& e : model.effects)
    if (auto ok = check_idle(vehicle, e, config); !ok) return ok;
  return check_body(vehicle, model, config);
}

}  // namespace omniflight::simulation
