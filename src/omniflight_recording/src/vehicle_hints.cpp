#include "omniflight_recording/vehicle_hints.hpp"

#include <cmath>
#include <cstdlib>
#include <map>

#include "frame_conversion.hpp"

namespace omniflight::recording {
namespace {

constexpr int kMostRotors = 12;         // of PX4's allocation
constexpr double kDefaultThrust = 6.5;  // CA_ROTORn_CT of an allocation that nobody filled in

class Parameters {
 public:
  explicit Parameters(const std::map<std::string, double>& values) : values_(values) {}
  std::optional<double> find(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::nullopt : std::optional(found->second);
  }
  double get(const std::string& name, double otherwise) const { return find(name).value_or(otherwise); }

 private:
  const std::map<std::string, double>& values_;
};

/// MAV_TYPE of MAVLink, common.xml: the multirotors.
void read_type(const Parameters& p, VehicleHints& out) {
  struct Kind {
    int type, rotors;
    const char* name;
  };
  static const Kind kinds[] = {{2, 4, "quadrotor"},  {13, 6, "hexarotor"},    {14, 8, "octorotor"},
                               {15, 3, "tricopter"}, {29, 12, "dodecarotor"}, {35, 10, "decarotor"}};
  const auto type = p.find("MAV_TYPE");
  for (const Kind& kind : kinds)
    if (type && *type == kind.type) {
      out.airframe = kind.name;
      out.rotor_count = kind.rotors;
    }
  const double count = p.get("CA_ROTOR_COUNT", 0);
  if (count >= 1 && count <= kMostRotors) out.rotor_count = static_cast<int>(count);
}

/// PX4 has FRD and lets thrust act along the axis (default: up, -z); KM > 0 turns counter-clockwise seen from
/// above, its reaction torque on the body is -KM * thrust along the axis.
void read_rotors(const Parameters& p, VehicleHints& out) {
  if (!p.find("CA_ROTOR_COUNT") || out.rotor_count == 0) return;
  bool somewhere = false;
  for (int i = 0; i < out.rotor_count; ++i) {
    const std::string name = "CA_ROTOR" + std::to_string(i) + "_";
    RotorHint rotor;
    rotor.p_B =
        to_our_axes(Vec3(p.get(name + "PX", 0), p.get(name + "PY", 0), p.get(name + "PZ", 0)), Axes::frd);
    const Vec3 axis(p.get(name + "AX", 0), p.get(name + "AY", 0), p.get(name + "AZ", -1));
    if (axis.norm() > 1e-3) rotor.axis_B = to_our_axes(Vec3(axis.normalized()), Axes::frd);
    rotor.p_B += Vec3::Zero();  // no -0
    rotor.axis_B += Vec3::Zero();
    const double km = p.get(name + "KM", 0);
    rotor.spin = km > 0 ? -1 : 1;
    rotor.drag_ratio = std::abs(km);
    const double thrust = p.get(name + "CT", kDefaultThrust);
    if (thrust > 0 && thrust != kDefaultThrust) rotor.max_thrust = thrust;
    somewhere = somewhere || rotor.p_B.norm() > 0;
    out.rotors.push_back(rotor);
  }
  if (!somewhere) out.rotors.clear();  // never filled in
}

/// ver_sw_release: major, minor, patch and kind, a byte each.
std::string version_of(unsigned long release) {
  return "v" + std::to_string(release >> 24 & 0xff) + "." + std::to_string(release >> 16 & 0xff) + "." +
         std::to_string(release >> 8 & 0xff);
}

}  // namespace

VehicleHints vehicle_hints(const Recording& recording) {
  VehicleHints out;
  const Parameters p(recording.parameters);
  const auto told = [&](const char* key) {
    const auto found = recording.metadata.find(key);
    return found == recording.metadata.end() ? std::string() : found->second;
  };
  out.autopilot = told("ulog.sys_name");
  if (const std::string release = told("ulog.ver_sw_release"); !release.empty())
    out.autopilot += " " + version_of(std::strtoul(release.c_str(), nullptr, 10));
  else if (const std::string hash = told("ulog.ver_sw"); !hash.empty())
    out.autopilot += " " + hash.substr(0, 10);
  if (const auto board = told("ulog.ver_hw"); !board.empty()) out.autopilot += " on " + board;
  read_type(p, out);
  read_rotors(p, out);
  if (const auto mass = p.find("SIH_MASS");
      mass && *mass > 0 && told("ulog.ver_hw").find("SIH") != std::string::npos)
    out.mass = *mass;
  if (const auto xx = p.find("SIH_IXX"); xx && out.mass)
    out.inertia = Vec3(*xx, p.get("SIH_IYY", *xx), p.get("SIH_IZZ", *xx));
  if (const auto hover = p.find("MPC_THR_HOVER"); hover && *hover > 0 && *hover < 1) out.hover_duty = *hover;
  for (const char* name : {"BAT1_N_CELLS", "BAT_N_CELLS"})
    if (const auto cells = p.find(name); cells && *cells > 0 && *cells < 100 && !out.battery_cells)
      out.battery_cells = static_cast<int>(*cells);
  return out;
}

}  // namespace omniflight::recording
