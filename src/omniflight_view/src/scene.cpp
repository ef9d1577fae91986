#include "omniflight_view/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace omniflight::view {
namespace {

using nlohmann::json;

/// Five significant digits are a tenth of a millimetre at ten metres; null where a number is not known.
void append(std::string& out, double x, int digits = 5) {
  if (std::isfinite(x))
    fmt::format_to(std::back_inserter(out), "{:.{}g}", x, digits);
  else
    out += "null";
}
template <class Numbers>
void append_list(std::string& out, const Numbers& numbers, int digits = 5) {
  out += '[';
  bool first = true;
  for (const double x : numbers) {
    if (!std::exchange(first, false)) out += ',';
    append(out, x, digits);
  }
  out += ']';
}
std::string list(const Vec3& v) {
  std::string out;
  append_list(out, v);
  return out;
}
json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

double load_of(const vehicle::Rotor& rotor, double speed) {
  return std::abs(rotor.thrust(speed)) / rotor.max_thrust;
}
double power_of(const vehicle::Rotor& rotor, double speed) {
  return rotor.drag_ratio * rotor.thrust_coefficient * std::pow(std::abs(speed), 3);
}

json solid(const planning::Primitive& p) {
  const char* const kinds[] = {"box", "capsule", "cylinder"};
  return {{"name", p.name},
          {"kind", kinds[static_cast<std::size_t>(p.kind)]},
          {"a", array(p.a)},
          {"b", array(p.b)},
          {"radius", p.radius}};
}

/// Values on the grid; the nearest one beyond the ends of a signal.
Eigen::MatrixXd on_grid(const recording::Signal* signal, const std::vector<double>& t) {
  if (!signal) return {};
  return recording::resample(*signal, t, 0.5);
}

}  // namespace

std::string scene_json(const Scene& scene) {
  const vehicle::Vehicle& v = scene.vehicle;
  json rotors = json::array(), solids = json::array();
  for (const vehicle::Rotor& r : v.rotors)
    rotors.push_back({{"p", array(r.p_BR)},
                      {"axis", array(r.axis_B)},
                      {"tilts", r.tilts},
                      {"tilt_axis", array(r.tilt_axis_B)},
                      {"spin", r.spin},
                      {"radius", r.radius > 0 ? r.radius : 0.05},
                      {"max_thrust_N", r.max_thrust},
                      {"bidirectional", r.bidirectional}});
  for (const auto& p : scene.solids) solids.push_back(solid(p));
  return json{{"schema", "omniflight.view_scene/1"},
              {"title", scene.title},
              {"subtitle", scene.subtitle},
              {"live", scene.live},
              {"may_stop", scene.may_stop},
              {"vehicle",
               {{"name", v.name}, {"mass_kg", v.mass}, {"rotors", rotors}, {"size_m", v.bounding_radius()}}},
              {"solids", solids}}
      .dump();
}

std::string frame_json(const Frame& f, const vehicle::Vehicle& vehicle) {
  std::string out = "{\"t\":";
  append(out, f.t, 9);
  out += ",\"p\":" + list(f.p_WB) + ",\"q\":";
  append_list(out, std::array{f.q_WB.w(), f.q_WB.x(), f.q_WB.y(), f.q_WB.z()});
  out += ",\"ref\":" + list(f.p_WR) + ",\"alpha\":";
  append(out, f.alpha);
  std::vector<double> load;
  double power = f.rotor_speed.empty() ? Frame::kUnknown : 0;
  for (std::size_t k = 0; k < std::min(f.rotor_speed.size(), vehicle.rotors.size()); ++k) {
    load.push_back(load_of(vehicle.rotors[k], f.rotor_speed[k]));
    power += power_of(vehicle.rotors[k], f.rotor_speed[k]);
  }
  out += ",\"load\":";
  append_list(out, load);
  out += ",\"power\":";
  append(out, power);
  out += ",\"failsafe\":" + json(f.failsafe).dump(-1, ' ', true, json::error_handler_t::replace);
  out += ",\"gate\":" + json(f.gate).dump(-1, ' ', true, json::error_handler_t::replace) + "}";
  return out;
}

Result<std::string> replay_json(const recording::Recording& r, const vehicle::Vehicle& vehicle,
                                double rate_hz, std::size_t most) {
  const recording::Signal* position = nullptr;
  for (const char* name : {"position", "est_position", "truth_position"})
    if (!position) position = r.find(name);
  if (!position)
    return bad_input("has no position to show", r.file, "A replay needs position or est_position [m]");
  const std::string prefix = position->name.substr(0, position->name.size() - std::string("position").size());
  const double from = position->t_s.front(), span = position->t_s.back() - from;
  const auto count = static_cast<std::size_t>(
      std::clamp(std::floor(span * rate_hz) + 1, 1.0, static_cast<double>(std::max<std::size_t>(most, 2))));
  std::vector<double> t(count);
  for (std::size_t i = 0; i < count; ++i)
    t[i] = count > 1 ? from + span * static_cast<double>(i) / static_cast<double>(count - 1) : from;
  const Eigen::MatrixXd p = on_grid(position, t), q = on_grid(r.find(prefix + "attitude"), t),
                        ref = on_grid(r.find("ref_position"), t), alpha = on_grid(r.find("alpha"), t),
                        speed = on_grid(r.find("rotor_speed"), t);
  const auto rotors = std::min<Eigen::Index>(speed.cols(), vehicle.rotor_count());
  Eigen::MatrixXd load(speed.rows(), rotors);
  Eigen::VectorXd power = Eigen::VectorXd::Zero(speed.rows());
  for (Eigen::Index k = 0; k < rotors; ++k) {
    const vehicle::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < speed.rows(); ++i) {
      load(i, k) = load_of(rotor, speed(i, k));
      power[i] += power_of(rotor, speed(i, k));
    }
  }
  std::string out = "{\"schema\":\"omniflight.view_replay/1\",\"t\":";
  append_list(out, t, 9);
  const auto columns = [&out](const char* name, const Eigen::MatrixXd& m) {
    fmt::format_to(std::back_inserter(out), ",\"{}\":[", name);
    for (Eigen::Index k = 0; k < m.cols(); ++k) {
      if (k > 0) out += ',';
      append_list(out, m.col(k));
    }
    out += ']';
  };
  columns("p", p);
  columns("q", q);
  columns("ref", ref);
  columns("alpha", alpha);
  columns("load", load);
  columns("power", rotors > 0 ? Eigen::MatrixXd(power) : Eigen::MatrixXd());
  out += ",\"notes\":[";
  for (std::size_t i = 0; i < std::min<std::size_t>(r.notes.size(), 20); ++i)
    out += (i > 0 ? "," : "") + json(r.notes[i].text).dump(-1, ' ', true, json::error_handler_t::replace);
  return out + "]}";
}

std::string path_json(const std::vector<Vec3>& path) {
  constexpr std::size_t kMost = 2000;
  const std::size_t step = std::max<std::size_t>(1, (path.size() + kMost - 1) / kMost);
  std::string out = "[";
  for (std::size_t i = 0; i < path.size(); i += step) out += (i > 0 ? "," : "") + list(path[i]);
  return out + "]";
}

}  // namespace omniflight::view
