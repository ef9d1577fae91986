#include "pilot_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include "omniflight_physics/effect.hpp"

namespace omniflight::cli {
namespace {

using diagnosis::Diagnosis;
using diagnosis::Finding;
using diagnosis::ParameterValue;
using diagnosis::Verdict;

/// The identifiable numbers of a finding by name.
class Values {
 public:
  explicit Values(const Finding& f) {
    for (const ParameterValue& p : f.parameters)
      if (diagnosis::identifiable(f.effect, p)) known_[p.name] = p.value;
  }
  std::optional<double> find(const std::string& name) const {
    const auto at = known_.find(name);
    return at == known_.end() ? std::nullopt : std::optional(at->second);
  }
  double operator()(const std::string& name) const { return find(name).value_or(0.0); }
  double norm(const std::string& a, const std::string& b, const std::string& c) const {
    return Vec3((*this)(a), (*this)(b), (*this)(c)).norm();
  }
  const std::map<std::string, double>& all() const { return known_; }

 private:
  std::map<std::string, double> known_;
};

std::string mass(double kg) {
  return std::abs(kg) < 0.1 ? fmt::format("{:.2g} g", 1e3 * std::abs(kg))
                            : fmt::format("{:.2f} kg", std::abs(kg));
}
std::string length(double m) {
  return std::abs(m) < 0.1 ? fmt::format("{:.2g} mm", 1e3 * std::abs(m))
                           : fmt::format("{:.2f} m", std::abs(m));
}
std::string degrees(double rad) { return fmt::format("{:.2g} deg", to_degrees(std::abs(rad))); }
std::string percent(double share) { return fmt::format("{:.2g} %", 100 * std::abs(share)); }
const char* more(double x, const char* when_more, const char* when_less) {
  return x > 0 ? when_more : when_less;
}

/// " from 1.06 m up", and how long, as far as they are known.
std::string from_height(const Values& v) {
  std::string out;
  if (const auto h = v.find("start_height")) out += fmt::format(" from {:.2f} m up", *h);
  return out;
}

/// "12 mm forward, 3 mm to the left": body axes x forward, y left, z up; parts below a fifth are left out.
std::string along_body(const Values& v) {
  const Vec3 p(v("x"), v("y"), v("z"));
  const std::array<std::array<const char*, 2>, 3> words{
      {{"forward", "backward"}, {"to the left", "to the right"}, {"up", "down"}}};
  std::string out;
  for (std::size_t k = 0; k < 3; ++k) {
    const double part = p[static_cast<Eigen::Index>(k)];
    if (std::abs(part) < 0.2 * p.norm() || part == 0) continue;
    out += (out.empty() ? "" : ", ") + length(part) + " " + words[k][part > 0 ? 0 : 1];
  }
  return out;
}

std::string pull(const Values& v) {
  const Vec3 f(v("x"), v("y"), v("z"));
  const double level = f.head<2>().norm();
  const char* where = std::abs(f.z()) > 2 * level   ? more(f.z(), " upward", " downward")
                      : level > 2 * std::abs(f.z()) ? " sideways"
                                                    : more(f.z(), " sideways and up", " sideways and down");
  return fmt::format("a steady pull of {:.2g} N{}", f.norm(), where);
}

std::string single_rotors(const Values& v) {
  std::string out;
  for (const auto& [name, scale] : v.all())
    if (name.rfind("scale_", 0) == 0 && scale != 0)
      out += fmt::format("{}rotor {} gives {} {} thrust than modelled", out.empty() ? "" : ", ",
                         name.substr(6), percent(scale), more(scale, "more", "less"));
  return out;
}

std::string rotor_speed_sensor(const Values& v) {
  const std::string of = v.find("rotor") ? fmt::format(" of rotor {:.0f}", v("rotor")) : "";
  if (v("scale") != 0)
    return "the speed sensor" + of + " reads " + percent(v("scale")) + more(v("scale"), " high", " low");
  return "the speed sensor" + of + " is faulty";
}

std::string camera_offset(const Values& v) {
  std::string out;
  if (const double d = v.norm("x", "y", "z"); d > 0) out = length(d);
  if (const double turn = v.norm("roll", "pitch", "yaw"); turn > 0)
    out += (out.empty() ? "" : " and ") + degrees(turn);
  return "the motion capture body is off by " + out;
}

std::string clock(const Values& v) {
  if (v("offset") != 0)
    return fmt::format("motion capture stamps {:.2g} ms too {}", 1e3 * std::abs(v("offset")),
                       more(v("offset"), "late", "early"));
  return fmt::format("the motion capture clock drifts by {:.2g} ppm", 1e6 * v("skew"));
}

std::string tilted(const Values& v) {
  const double loss = v("loss");
  return fmt::format("{} {} thrust than modelled, by the tilt of the rotors", percent(loss),
                     more(-loss, "more", "less"));
}

/// Words of one effect; `needs`: without one of these numbers there are no words.
struct Phrase {
  std::vector<const char*> needs;
  std::string (*words)(const Values&);
};

const std::map<std::string, Phrase>& phrases() {
  using V = const Values&;
  static const std::map<std::string, Phrase> table{
      // rigid body
      {"payload_mass",
       {{"mass"}, [](V v) { return mass(v("mass")) + more(v("mass"), " too heavy", " too light"); }}},
      {"com_offset",
       {{"x", "y", "z"}, [](V v) { return "the centre of mass is " + along_body(v) + " of its place"; }}},
      {"tilt_offset",
       {{"offset"},
        [](V v) {
          return "the rotors stand " + degrees(v("offset")) + more(v("offset"), " more", " less") +
                 " tilted than they say";
        }}},
      // rotors
      {"thrust_scale",
       {{"scale"},
        [](V v) {
          return "the rotors give " + percent(v("scale")) + more(v("scale"), " more", " less") +
                 " thrust than modelled";
        }}},
      {"rotor_thrust_scale",
       {{"scale_1", "scale_2", "scale_3", "scale_4", "scale_5", "scale_6", "scale_7", "scale_8"},
        single_rotors}},
      {"reverse_thrust_asymmetry",
       {{"change"},
        [](V v) {
          return "rotors in reverse give " + percent(v("change")) + more(v("change"), " more", " less") +
                 " thrust than forward";
        }}},
      {"drag_torque_scale",
       {{"scale"},
        [](V v) {
          return "the drag torque of the rotors is " + percent(v("scale")) +
                 more(v("scale"), " larger", " smaller") + " than modelled";
        }}},
      {"tilt_efficiency", {{"loss"}, tilted}},
      // air
      {"wind",
       {{"x", "y"},
        [](V v) { return fmt::format("a steady wind of {:.2g} m/s", std::hypot(v("x"), v("y"))); }}},
      {"gust", {{"intensity"}, [](V v) { return fmt::format("gusts of {:.2g} m/s", v("intensity")); }}},
      // tether and load
      {"hung_cable",
       {{"linear_density"},
        [](V v) { return fmt::format("a cable of {:.2f} kg/m", v("linear_density")) + from_height(v); }}},
      {"cable_pendulum",
       {{"linear_density"},
        [](V v) {
          return fmt::format("a swinging cable of {:.2f} kg/m", v("linear_density")) + from_height(v);
        }}},
      {"cable_chain",
       {{"linear_density"},
        [](V v) { return fmt::format("a swinging cable of {:.2f} kg/m", v("linear_density")); }}},
      {"overhead_rope",
       {{"linear_density"},
        [](V v) { return fmt::format("a rope from above of {:.2f} kg/m", v("linear_density")); }}},
      {"slung_load",
       {{"mass"},
        [](V v) {
          return "a load of " + mass(v("mass")) + " on a cable" +
                 (v.find("length") ? " of " + length(v("length")) : "");
        }}},
      {"constant_pull", {{"x", "y", "z"}, pull}},
      {"lateral_stiffness",
       {{"stiffness"},
        [](V v) { return fmt::format("a sideways pull back of {:.2g} N per m", v("stiffness")); }}},
      {"guide_friction",
       {{"vertical", "horizontal"},
        [](V v) {
          return fmt::format("friction of {:.2g} N against the motion",
                             std::max(v("vertical"), v("horizontal")));
        }}},
      // actuation
      {"motor_lag",
       {{"time_constant"},
        [](V v) {
          return fmt::format("motors {:.2g} ms {} than modelled", 1e3 * std::abs(v("time_constant")),
                             more(v("time_constant"), "slower", "faster"));
        }}},
      {"transport_delay",
       {{"board_0", "board_1"},
        [](V v) {
          return fmt::format("commands reach the rotors {:.2g} ms late",
                             1e3 * std::max(v("board_0"), v("board_1")));
        }}},
      {"actuator_saturation",
       {{"limit_loss"},
        [](V v) { return "the largest thrust is " + percent(v("limit_loss")) + " less than modelled"; }}},
      {"tilt_servo_lag",
       {{"time_constant"},
        [](V v) { return fmt::format("the tilt follows {:.2g} ms late", 1e3 * v("time_constant")); }}},
      // control and sensing
      {"controller_mismatch", {{}, [](V) { return std::string("the gains flown are not those told"); }}},
      {"accelerometer_error",
       {{"bias_x", "bias_y", "bias_z"},
        [](V v) {
          return fmt::format("the accelerometer is off by {:.2g} m/s2", v.norm("bias_x", "bias_y", "bias_z"));
        }}},
      {"gyro_error",
       {{"bias_x", "bias_y", "bias_z"},
        [](V v) {
          return fmt::format("the gyroscope is off by {:.2g} deg/s",
                             to_degrees(v.norm("bias_x", "bias_y", "bias_z")));
        }}},
      {"imu_lever_arm",
       {{"x", "y", "z"}, [](V v) { return "the inertial sensor sits " + along_body(v) + " of its place"; }}},
      {"mocap_tilt",
       {{"x", "y"},
        [](V v) { return "the motion capture world is tilted by " + degrees(std::hypot(v("x"), v("y"))); }}},
      {"mocap_offset", {{"x", "y", "z", "roll", "pitch", "yaw"}, camera_offset}},
      {"clock_offset", {{"offset", "skew"}, clock}},
      {"rotor_speed_sensor_fault", {{}, rotor_speed_sensor}}};
  return table;
}

/// "affine thrust curve: linear 0.0003 N s/rad".
std::string by_its_term(const Finding& f) {
  const physics::Effect* effect = physics::find_effect(f.effect);
  const std::string term = effect ? effect->info().term : f.effect;
  const ParameterValue* first = nullptr;
  for (const ParameterValue& p : f.parameters)
    if (!first && p.value != 0 && diagnosis::identifiable(f.effect, p)) first = &p;
  if (!first) return term + (f.parameters.empty() ? "" : ", its size not identifiable");
  std::string name = first->name;
  std::replace(name.begin(), name.end(), '_', ' ');
  return fmt::format(
      "{} ({} {:.3g}{})", term, name, first->value,
      first->unit == "1" || first->unit.empty() || first->unit == "-" ? "" : " " + first->unit);
}

bool is_physics(const Finding& f) {
  return f.stage != physics::Stage::sensing && f.stage != physics::Stage::control &&
         f.stage != physics::Stage::reference;
}

/// The findings of one kind, each with what it cannot be told apart from.
std::string phrases_of(const Diagnosis& d, bool physics) {
  std::string out;
  for (const Finding& f : d.findings) {
    if (is_physics(f) != physics) continue;
    out += (out.empty() ? "" : "; ") + pilot_words(f);
    const auto rivals = std::min(f.cannot_be_told_apart_from.size(), static_cast<std::size_t>(f.rivals));
    for (std::size_t k = 0; k < rivals; ++k) {
      const physics::Effect* other = physics::find_effect(f.cannot_be_told_apart_from[k]);
      out += " or " + (other ? other->info().term : f.cannot_be_told_apart_from[k]);
    }
  }
  return out;
}

std::string unnamed(const Diagnosis& d) {
  std::string channels;
  for (const auto& u : d.unexplained)
    if (channels.find(u.channel) == std::string::npos) channels += (channels.empty() ? "" : ", ") + u.channel;
  return channels.empty() ? "something that no known effect explains"
                          : "something in " + channels + " that no known effect explains";
}

std::string capitalised(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

}  // namespace

std::string pilot_words(const Finding& f) {
  const Values v(f);
  const auto at = phrases().find(f.effect);
  if (at == phrases().end()) return by_its_term(f);
  const Phrase& phrase = at->second;
  const auto there = [&](const char* name) { return v(name) != 0; };
  if (!phrase.needs.empty() && std::none_of(phrase.needs.begin(), phrase.needs.end(), there))
    return by_its_term(f);
  return phrase.words(v);
}

bool names_physics(const Diagnosis& d) {
  return std::any_of(d.findings.begin(), d.findings.end(), is_physics);
}

std::string first_sentence(const Diagnosis& d) {
  if (d.verdict == Verdict::checked)
    return "Only looked at: nothing was fitted, so nothing is said about missing physics";
  if (d.verdict == Verdict::unfinished) return "Not finished: this is no answer yet";
  if (d.verdict == Verdict::unusable)
    return d.intake.sensors.empty() ? "This recording cannot be used" : "Only the sensors can be judged";
  const std::string vehicle = phrases_of(d, true), others = phrases_of(d, false);
  const bool open = d.verdict == Verdict::unexplained;
  if (vehicle.empty() && !open) {
    if (others.empty()) return "The model explains this flight";
    return "The vehicle flies as modelled; " + others;
  }
  std::string out = vehicle;
  if (open) out += (out.empty() ? "" : "; ") + unnamed(d);
  if (!others.empty()) out += "; " + others;
  return capitalised(out);
}

}  // namespace omniflight::cli
