#include "manoeuvres.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "least_thrusts.hpp"

namespace omniflight::diagnosis {
namespace {

using Waypoints = std::vector<ProposedWaypoint>;

// Sizes, numbers and rates of all manoeuvres in this file are chosen for a test bed of a few metres.
constexpr double kOtherTilt = 0.21;  // rad, change of rotor tilt for a manoeuvre as a whole
constexpr double kMovedTilt = 0.35;  // rad, change of rotor tilt within a manoeuvre, at rest

Waypoints ascent() {
  Waypoints w{{{0, 0, 0}, {0, 0, 0}, 4}};
  for (const double by : {0.55, 0.55, -0.55, -0.55}) w.push_back({{0, 0, by}, {0, 0, 0}, 4});
  return w;
}

Waypoints up_and_down() {
  Waypoints w{{{0, 0, 0.3}, {0, 0, 0}, 3}};
  for (int k = 0; k < 6; ++k) w.push_back({{0, 0, k % 2 == 0 ? 0.4 : -0.4}, {0, 0, 0}, 1});
  return w;
}

Waypoints side_steps() {
  Waypoints w{{{0, 0, 0.1}, {0, 0, 0}, 3}};
  for (int level = 0; level < 2; ++level) {
    for (const Vec3& by :
         {Vec3(0.3, 0, 0), Vec3(-0.6, 0, 0), Vec3(0.3, 0.3, 0), Vec3(0, -0.6, 0), Vec3(0, 0.3, 0)})
      w.push_back({by, {0, 0, 0}, 1.5});
    if (level == 0) w.push_back({{0, 0, 0.6}, {0, 0, 0}, 2});
  }
  return w;
}

void lean(Waypoints& w, double deg) {
  for (const Vec3& rpy :
       {Vec3(deg, 0, 0), Vec3(-deg, 0, 0), Vec3(0, deg, 0), Vec3(0, -deg, 0), Vec3(0, 0, 0)})
    w.push_back({{0, 0, 0}, rpy, 2});
}

Waypoints tilts() {
  Waypoints w{{{0, 0, 0.2}, {0, 0, 0}, 3}};
  lean(w, 20);
  w.push_back({{0, 0, 0.5}, {0, 0, 0}, 2});
  lean(w, 20);
  return w;
}

/// Oscillation about one axis without pauses. Its torque scales with thrust, not with mass or load.
void rock(Waypoints& w, int axis, double deg, int times) {
  for (int k = 0; k < 2 * times; ++k)
    w.push_back({{0, 0, 0}, Vec3::Unit(axis) * (k % 2 == 0 ? deg : -deg), 0});
  w.push_back({{0, 0, 0}, {0, 0, 0}, 1});
}

/// Vertical oscillation without pauses: separates mass (inertial force) from a constant pull.
void heave(Waypoints& w, double stroke_m, int times) {
  for (int k = 0; k < 2 * times; ++k) w.push_back({{0, 0, k % 2 == 0 ? stroke_m : -stroke_m}, {0, 0, 0}, 0});
  w.push_back({{0, 0, 0}, {0, 0, 0}, 1});
}

/// Half of the vertical acceleration reserve of the upright vehicle, within 0.2 to 3.7 m/s^2 (chosen).
double spare_acceleration(const vehicle::Vehicle& v, double alpha) {
  constexpr double kGravity = 9.81, kMost = 3.7;
  Vec6 weight = Vec6::Zero();
  weight[2] = v.mass * kGravity;
  const vehicle::RotorVector hover = LeastThrusts(v, alpha)(weight);
  double times = std::numeric_limits<double>::infinity();  // max thrust over hover thrust
  for (std::size_t r = 0; r < v.rotors.size(); ++r) {
    const double thrust = std::abs(hover[static_cast<Eigen::Index>(r)]);
    if (thrust > 1e-9) times = std::min(times, v.rotors[r].max_thrust / thrust);
  }
  return std::clamp(0.5 * (times - 1) * kGravity, 0.2, kMost);
}

/// Three heights, each with oscillations about every axis and along z, leaning at the lowest and the highest;
/// at each, the rotors move through `tilts` [rad].
Waypoints survey(double stroke_m, const std::vector<double>& tilts = {}) {
  Waypoints w{{{0, 0, 0}, {0, 0, 0}, 3}};
  for (int level = 0; level < 3; ++level) {
    for (int axis = 0; axis < 3; ++axis) rock(w, axis, 28, axis < 2 ? 12 : 6);
    heave(w, level < 2 ? stroke_m : -stroke_m,
          12);  // the topmost stroke goes down, to stay within the height of the stages
    if (level != 1) lean(w, 20);
    for (const double alpha : tilts) w.push_back({{0, 0, 0}, {0, 0, 0}, 3, alpha});
    if (level < 2) w.push_back({{0, 0, 0.5}, {0, 0, 0}, 3});
  }
  return w;
}

}  // namespace

std::vector<ProposedFlight> manoeuvres(const vehicle::Vehicle& vehicle, double alpha) {
  const bool turns = LeastThrusts(vehicle, alpha).rank() == 6;
  std::vector<ProposedFlight> out;
  const auto add = [&](double tilt, const std::string& name, const std::string& words,
                       Waypoints waypoints) -> auto& {
    ProposedFlight& f = out.emplace_back();
    f.alpha = tilt, f.name = name, f.words = words, f.waypoints = std::move(waypoints);
    return f;
  };
  const auto add_survey = [&](double tilt, const std::string& name, const std::string& words,
                              const std::vector<double>& tilts = {}) {
    double spare = spare_acceleration(vehicle, tilt);
    for (const double other : tilts) spare = std::min(spare, spare_acceleration(vehicle, other));
    // s, one way; peak acceleration of a quintic stroke: 5.78 length / time^2
    constexpr double kStroke = 0.5;
    ProposedFlight& f = add(tilt, name, words, survey(spare * kStroke * kStroke / 5.78, tilts));
    f.speed = 0.8, f.acceleration = spare;
    f.rate = 3.7, f.angular_acceleration = 23;
  };
  add(alpha, "ascent_with_pauses", "climb by 1.1 m in two steps with pauses, and down again", ascent());
  auto& fast = add(alpha, "fast_up_and_down", "climb and sink by 0.4 m as fast as the vehicle may, six times",
                   up_and_down());
  fast.speed = 0.8, fast.acceleration = 1.6;
  auto& aside =
      add(alpha, "side_steps_at_two_heights", "step 0.3 m to every side, at two heights", side_steps());
  aside.speed = 0.6, aside.acceleration = 1.0;
  if (!turns) return out;
  add(alpha, "tilts_in_place", "roll and pitch by 20 deg both ways in one place, at two heights", tilts());
  const std::string rocking = "rock quickly about every axis, heave and lean by 20 deg, at three heights";
  add_survey(alpha, "rocking_at_three_heights", rocking);
  if (vehicle.tilt.kind == vehicle::TiltKind::none) return out;
  const auto possible = [&](double tilt) {
    return tilt <= vehicle.tilt.max && tilt >= vehicle.tilt.min && LeastThrusts(vehicle, tilt).rank() == 6;
  };
  std::vector<double> sweep;
  for (const double way : {1.0, -1.0}) {
    if (const double moved = alpha + way * kMovedTilt; possible(moved)) sweep.push_back(moved);
    const double other = alpha + way * kOtherTilt;
    if (!possible(other)) continue;
    const std::string direction = way > 0 ? "further" : "less";
    const std::string tilted = "with the rotors tilted 12 deg " + direction;
    add(other, "ascent_tilted_" + direction, "the ascent with pauses " + tilted, ascent());
    add_survey(other, "rocking_tilted_" + direction, rocking + ", " + tilted);
  }
  if (sweep.empty()) return out;
  sweep.push_back(alpha);
  add_survey(alpha, "rocking_and_tilting", rocking + ", and move the tilt of the rotors by 20 deg at each",
             sweep);
  return out;
}

}  // namespace omniflight::diagnosis
