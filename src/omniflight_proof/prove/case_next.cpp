#include "case_next.hpp"

#include <cmath>

#include "omniflight_files/yaml.hpp"

namespace omniflight::proof {
namespace {

using files::between;

constexpr double kLongest = 660, kWidest = 3, kSettle = 2;  // s, m, s
constexpr double kTiltRate = to_radians(15);  // rad/s, half of what the servo of the vehicle does

Vec3 rotation_of(files::YamlReader& at, const Vec3& otherwise) {
  auto attitude = at.optional_child("attitude");
  if (!attitude) return otherwise;
  const Vec3 rpy = attitude->vec3("rpy_deg", between(-90, 90, "deg"));
  return log_rotation(from_roll_pitch_yaw(rpy * (kPi / 180)));
}

}  // namespace

Result<Path> read_next_flight(std::string_view mission, const std::string& name) {
  auto yaml = files::YamlReader::parse(mission, name);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.mission/1")
    yaml->error_at("schema", "is not omniflight.mission/1");
  for (const char* not_needed : {"name", "notes", "vehicle", "test_bed", "clearance_m", "seed", "budget_ms"})
    yaml->ignore(not_needed);
  Path p;
  p.name = "next";
  p.alpha.start = to_radians(yaml->number("alpha_deg", between(0, 60, "deg"), 30));
  auto limits = yaml->child("limits");
  const double speed = limits.number("speed_mps", between(0.02, 3, "m/s"));
  const double acceleration = limits.number("acceleration_mps2", between(0.02, 10, "m/s2"));
  const double rate = to_radians(limits.number("rate_dps", between(1, 720, "deg/s"), 30));
  const double turning =
      to_radians(limits.number("angular_acceleration_dps2", between(1, 10000, "deg/s2"), 90));
  limits.ignore("rotor_headroom");
  auto start = yaml->child("start");
  Vec3 at = start.vec3("position", between(-5, 5, "m")), turned = rotation_of(start, Vec3::Zero());
  for (int k = 0; k < 3; ++k) {
    p.position[k].start = at[k];
    p.rotation[k].start = turned[k];
  }
  double t = kSettle + start.number("hold_s", between(0, 60, "s"), 1);
  const Vec3 from = at;
  double alpha = p.alpha.start;
  for (auto& w : yaml->children("waypoints", 1, 1200)) {
    w.ignore("name");
    const Vec3 by = w.vec3("by", between(-kWidest, kWidest, "m"), Vec3::Zero()), to = rotation_of(w, turned);
    const double way = by.norm(), turn = (to - turned).norm();
    const double T = std::max({0.5, 1.875 * way / speed, std::sqrt(5.78 * way / acceleration),
                               1.875 * turn / rate, std::sqrt(5.78 * turn / turning)});
    for (int k = 0; k < 3; ++k) {
      if (by[k] != 0) p.position[k].steps.push_back({t, T, by[k]});
      if (to[k] != turned[k]) p.rotation[k].steps.push_back({t, T, to[k] - turned[k]});
    }
    if (w.has("alpha_deg")) {
      const double angle = to_radians(w.number("alpha_deg", between(0, 60, "deg")));
      const double moving = std::max(0.5, 1.875 * std::abs(angle - alpha) / kTiltRate);
      if (angle != alpha) p.alpha.steps.push_back({t + T, moving, angle - alpha});
      t += moving;
      alpha = angle;
    }
    at += by;
    turned = to;
    t += T + w.number("hold_s", between(0, 60, "s"), 1);
    if ((at - from).norm() > kWidest) w.error("is more than 3 m from the start");
  }
  p.duration = t + 1;
  if (p.duration > kLongest) yaml->error("takes longer than 660 s");
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return p;
}

}  // namespace omniflight::proof
