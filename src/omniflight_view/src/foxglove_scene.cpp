#include "omniflight_view/foxglove_scene.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace omniflight::view {
namespace {

using nlohmann::json;

json type(const char* name) { return {{"type", name}}; }
json object(const json& properties) { return {{"type", "object"}, {"properties", properties}}; }
json list(const json& items) { return {{"type", "array"}, {"items", items}}; }

json time_schema() { return object({{"sec", type("integer")}, {"nsec", type("integer")}}); }
json vector_schema() { return object({{"x", type("number")}, {"y", type("number")}, {"z", type("number")}}); }
json quaternion_schema() {
  json out = vector_schema();
  out["properties"]["w"] = type("number");
  return out;
}
json pose_schema() { return object({{"position", vector_schema()}, {"orientation", quaternion_schema()}}); }
json colour_schema() {
  return object({{"r", type("number")}, {"g", type("number")}, {"b", type("number")}, {"a", type("number")}});
}

/// foxglove.SceneUpdate, with the primitives that are used here.
std::string scene_schema() {
  const json solid = object({{"pose", pose_schema()}, {"size", vector_schema()}, {"color", colour_schema()}});
  json cylinder = solid;
  cylinder["properties"]["bottom_scale"] = cylinder["properties"]["top_scale"] = type("number");
  const json line = object({{"type", type("integer")},
                            {"pose", pose_schema()},
                            {"thickness", type("number")},
                            {"scale_invariant", type("boolean")},
                            {"points", list(vector_schema())},
                            {"color", colour_schema()},
                            {"colors", list(colour_schema())},
                            {"indices", list(type("integer"))}});
  const json entity = object({{"timestamp", time_schema()},
                              {"frame_id", type("string")},
                              {"id", type("string")},
                              {"lifetime", time_schema()},
                              {"frame_locked", type("boolean")},
                              {"cubes", list(solid)},
                              {"cylinders", list(cylinder)},
                              {"lines", list(line)}});
  json out = object({{"deletions", list(object(json::object()))}, {"entities", list(entity)}});
  out["title"] = "foxglove.SceneUpdate";
  return out.dump();
}

std::string transform_schema() {
  json out = object({{"timestamp", time_schema()},
                     {"parent_frame_id", type("string")},
                     {"child_frame_id", type("string")},
                     {"translation", vector_schema()},
                     {"rotation", quaternion_schema()}});
  out["title"] = "foxglove.FrameTransform";
  return out.dump();
}

FoxgloveChannel scene_channel(const char* topic, bool latched) {
  return {topic, "json", "foxglove.SceneUpdate", scene_schema(), "jsonschema", latched};
}

json time_of(std::int64_t ns) { return {{"sec", ns / 1'000'000'000}, {"nsec", ns % 1'000'000'000}}; }
json vector_of(const Vec3& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }
json quaternion_of(const Quat& q) { return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}; }
json pose_of(const Vec3& p, const Quat& q) {
  return {{"position", vector_of(p)}, {"orientation", quaternion_of(q)}};
}
json colour(double r, double g, double b, double a) { return {{"r", r}, {"g", g}, {"b", b}, {"a", a}}; }

/// From one point to another; a cylinder lies along its z.
json cylinder(const Vec3& from, const Vec3& to, double radius, const json& painted) {
  const Vec3 along = to - from;
  return {{"pose", pose_of(0.5 * (from + to), shortest_rotation(Vec3::UnitZ(), along))},
          {"size", vector_of({2 * radius, 2 * radius, along.norm()})},
          {"bottom_scale", 1.0},
          {"top_scale", 1.0},
          {"color", painted}};
}

json entity(const char* id, const char* frame, std::int64_t ns) {
  return {{"timestamp", time_of(ns)},   {"frame_id", frame},     {"id", id},
          {"lifetime", time_of(0)},     {"frame_locked", true},  {"cubes", json::array()},
          {"cylinders", json::array()}, {"lines", json::array()}};
}
std::string update(json one) {
  return json{{"deletions", json::array()}, {"entities", json::array({std::move(one)})}}.dump();
}

}  // namespace

FoxgloveChannel transform_channel() {
  return {"/view/transform", "json", "foxglove.FrameTransform", transform_schema(), "jsonschema", false};
}
FoxgloveChannel vehicle_channel() { return scene_channel("/view/vehicle", false); }
FoxgloveChannel world_channel() { return scene_channel("/view/world", true); }
FoxgloveChannel plan_channel() { return scene_channel("/view/plan", true); }

std::string transform_message(const Frame& f, std::int64_t ns) {
  if (!f.p_WB.allFinite() || !f.q_WB.coeffs().allFinite()) return {};
  return json{{"timestamp", time_of(ns)},
              {"parent_frame_id", "world"},
              {"child_frame_id", "body"},
              {"translation", vector_of(f.p_WB)},
              {"rotation", quaternion_of(f.q_WB)}}
      .dump();
}

std::string vehicle_message(const vehicle::Vehicle& v, const Frame& f, std::int64_t ns) {
  json out = entity("vehicle", "body", ns);
  const double size = v.bounding_radius(), alpha = std::isfinite(f.alpha) ? f.alpha : 0.0;
  for (int k = 0; k < v.rotor_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const vehicle::Rotor& r = v.rotors[i];
    if (r.p_BR.norm() > 1e-6)
      out["cylinders"].push_back(cylinder(Vec3::Zero(), r.p_BR, 0.018 * size, colour(0.25, 0.28, 0.33, 1)));
    const double load = i < f.rotor_speed.size() ? std::abs(r.thrust(f.rotor_speed[i])) / r.max_thrust : 0.0;
    const json painted = load >= 0.98   ? colour(0.84, 0.37, 0, 0.8)
                         : load >= 0.85 ? colour(0.9, 0.62, 0, 0.8)
                                        : colour(0, 0.62, 0.45, 0.8);
    const Vec3 half = 0.01 * size * v.rotor_axis(k, alpha);
    out["cylinders"].push_back(
        cylinder(r.p_BR - half, r.p_BR + half, r.radius > 0 ? r.radius : 0.05, painted));
  }
  return update(std::move(out));
}

std::string world_message(const std::vector<planning::Primitive>& solids, std::int64_t ns) {
  json out = entity("test bed", "world", ns);
  const json painted = colour(0.55, 0.58, 0.62, 0.6);
  for (const planning::Primitive& p : solids)
    if (p.kind == planning::Primitive::Kind::box)
      out["cubes"].push_back(
          {{"pose", pose_of(p.a, Quat::Identity())}, {"size", vector_of(p.b)}, {"color", painted}});
    else
      out["cylinders"].push_back(cylinder(p.a, p.b, p.radius, painted));
  return update(std::move(out));
}

std::string plan_message(const std::vector<Vec3>& path, std::int64_t ns) {
  constexpr std::size_t kMost = 2000;
  json points = json::array();
  const std::size_t step = std::max<std::size_t>(1, (path.size() + kMost - 1) / kMost);
  for (std::size_t i = 0; i < path.size(); i += step) points.push_back(vector_of(path[i]));
  json out = entity("plan", "world", ns);
  out["lines"].push_back({{"type", 0},
                          {"pose", pose_of(Vec3::Zero(), Quat::Identity())},
                          {"thickness", 3.0},
                          {"scale_invariant", true},
                          {"points", points},
                          {"color", colour(0.9, 0.62, 0, 1)},
                          {"colors", json::array()},
                          {"indices", json::array()}});
  return update(std::move(out));
}

}  // namespace omniflight::view
