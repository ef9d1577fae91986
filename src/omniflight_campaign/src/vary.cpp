#include "omniflight_campaign/vary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "omniflight_core/random.hpp"

namespace omniflight::campaign {
namespace {

constexpr const char* kStart[] = {"x", "y", "z", "roll", "pitch", "yaw"};
constexpr const char* kGains[] = {"kp", "kv", "ki", "kR", "kw", "kI"};
/// A normal distribution is refused when less than this share of it lies within its bounds.
constexpr double kLeastWithin = 0.01;

template <class Names>
int index_of(const Names& names, const std::string& name) {
  const auto at = std::find(std::begin(names), std::end(names), name);
  return at == std::end(names) ? -1 : static_cast<int>(at - std::begin(names));
}

double normal_share_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

int parameter_of(const physics::Effect& effect, const std::string& name) {
  const auto& all = effect.info().parameters;
  const auto at = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; });
  return at == all.end() ? -1 : static_cast<int>(at - all.begin());
}

std::string names_of(const physics::Effect& effect) {
  std::string out;
  for (const auto& p : effect.info().parameters) out += (out.empty() ? "" : ", ") + p.name;
  return out;
}

/// Bounds and unit of the place.
Status place(Varied& v, const std::string& where, double& least, double& most) {
  least = -1e300, most = 1e300;
  if (v.of == Varied::Of::start) {
    const int k = index_of(kStart, v.parameter);
    if (k < 0)
      return bad_input("'" + v.parameter + "' is no coordinate of the start", where + ".start",
                       "Give x, y, z, roll, pitch or yaw");
    v.unit = k < 3 ? "m" : "rad";
    most = k < 3 ? 10 : kPi;
    least = -most;
    return {};
  }
  if (v.of == Varied::Of::gain) {
    if (index_of(kGains, v.parameter) < 0)
      return bad_input("'" + v.parameter + "' is no gain of the control law", where + ".gain",
                       "Give kp, kv, ki, kR, kw or kI");
    v.unit = "";
    least = 0, most = 100;
    return {};
  }
  const physics::Effect* effect = physics::find_effect(v.effect);
  if (!effect)
    return bad_input("there is no effect '" + v.effect + "'", where + ".effect",
                     "'omniflight effects' lists them");
  if (!acts_without_sensors(*effect))
    return bad_input("the effect " + v.effect + " acts on sensors, which these flights have not",
                     where + ".effect", "Vary another one");
  const int k = parameter_of(*effect, v.parameter);
  if (k < 0)
    return bad_input("the effect " + v.effect + " has no parameter '" + v.parameter + "'",
                     where + ".parameter", "It has " + names_of(*effect));
  const auto& p = effect->info().parameters[static_cast<std::size_t>(k)];
  v.unit = p.unit;
  least = p.lower, most = p.upper;
  return {};
}

}  // namespace

bool acts_without_sensors(const physics::Effect& effect) {
  return effect.info().stage != physics::Stage::sensing;
}

Status check(Varied& v, const std::string& where) {
  double least = 0, most = 0;
  if (auto ok = place(v, where, least, most); !ok) return ok;
  Distribution& d = v.distribution;
  if (d.kind == Distribution::Kind::uniform) {
    if (!(d.a < d.b))
      return bad_input(fmt::format("goes from {:g} to {:g}", d.a, d.b), where + ".uniform",
                       "Give the smaller value first");
    if (d.a < least || d.b > most)
      return bad_input(
          fmt::format("{:g} to {:g} {} leaves what is allowed, {:g} to {:g}", d.a, d.b, v.unit, least, most),
          where + ".uniform");
    return {};
  }
  if (!(d.b > 0))
    return bad_input(fmt::format("has a standard deviation of {:g} {}", d.b, v.unit), where + ".normal",
                     "Give [mean, standard deviation], the latter more than 0");
  d.least = std::max(d.least, least);
  d.most = std::min(d.most, most);
  if (!(normal_share_below((d.most - d.a) / d.b) - normal_share_below((d.least - d.a) / d.b) >= kLeastWithin))
    return bad_input(fmt::format("nearly all of it lies outside of {:g} to {:g} {}", d.least, d.most, v.unit),
                     where + ".normal", "Give a mean within");
  return {};
}

std::vector<double> draw(std::span<const Varied> varied, std::uint64_t seed) {
  std::vector<double> out;
  for (const Varied& v : varied) {
    Random random(seed, "vary " + v.name);
    const Distribution& d = v.distribution;
    if (d.kind == Distribution::Kind::uniform) {
      out.push_back(random.uniform(d.a, d.b));
      continue;
    }
    double value = 0;
    do value = d.a + d.b * random.normal();  // check() has seen that one in a hundred lies within
    while (value < d.least || value > d.most);
    out.push_back(value);
  }
  return out;
}

physics::Model with_values(const physics::Model& model, std::span<const Varied> varied,
                           std::span<const double> values) {
  physics::Model out = model;
  for (std::size_t i = 0; i < varied.size(); ++i) {
    if (varied[i].of != Varied::Of::effect) continue;
    const physics::Effect* effect = physics::find_effect(varied[i].effect);
    auto at = std::find_if(out.effects.begin(), out.effects.end(),
                           [&](const auto& e) { return e.effect == effect; });
    if (at == out.effects.end()) {
      physics::ActiveEffect added{effect, {}};
      for (const auto& p : effect->info().parameters) added.theta.push_back(p.neutral);
      at = out.effects.insert(out.effects.end(), std::move(added));
    }
    at->theta[static_cast<std::size_t>(parameter_of(*effect, varied[i].parameter))] = values[i];
  }
  return out;
}

RigidState start_with(const RigidState& start, std::span<const Varied> varied,
                      std::span<const double> values) {
  RigidState out = start;
  Vec3 turn = Vec3::Zero();
  for (std::size_t i = 0; i < varied.size(); ++i) {
    if (varied[i].of != Varied::Of::start) continue;
    const int k = index_of(kStart, varied[i].parameter);
    (k < 3 ? out.p_WB[k] : turn[k - 3]) += values[i];
  }
  out.q_WB = out.q_WB * exp_rotation(turn);
  return out;
}

control::ControllerConfig gains_with(const control::ControllerConfig& gains, std::span<const Varied> varied,
                                     std::span<const double> values) {
  control::ControllerConfig out = gains;
  Vec3* const places[] = {&out.kp, &out.kv, &out.ki, &out.kR, &out.kw, &out.kI};
  for (std::size_t i = 0; i < varied.size(); ++i)
    if (varied[i].of == Varied::Of::gain) *places[index_of(kGains, varied[i].parameter)] *= values[i];
  return out;
}

}  // namespace omniflight::campaign
