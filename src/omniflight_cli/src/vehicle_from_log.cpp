#include "vehicle_from_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "omniflight_files/files.hpp"
#include "omniflight_recording/vehicle_hints.hpp"

namespace omniflight::cli {
namespace {

using recording::Recording;
using recording::RotorHint;
using recording::Signal;

constexpr double kMadeUpMass = 1.0;         // kg
constexpr double kMadeUpArm = 0.17;         // m, from the centre to a rotor
constexpr double kMadeUpDragRatio = 0.016;  // m
constexpr double kThrustToWeight = 2.0;     // of all rotors together
constexpr int kMostRotors = 16;             // that a vehicle file may have

int rotors_of(const Recording& r, const recording::VehicleHints& hints) {
  if (hints.rotor_count > 0) return hints.rotor_count;
  for (const char* name : {"rotor_speed", "rotor_command", "pwm", "motor_power", "thrust_model"})
    if (const Signal* s = r.find(name)) return static_cast<int>(s->width());
  return 0;
}

/// On a circle, in the order of PX4 for four (front right, back left, front left, back right; the first two
/// turn counter-clockwise, which is spin -1), otherwise around from the front.
std::vector<RotorHint> made_up_rotors(int count) {
  std::vector<RotorHint> out(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    static constexpr double kPx4Quad[] = {-45, 135, 45, -135};  // deg, to the left from the front
    const double angle = count == 4 ? to_radians(kPx4Quad[i]) : 2 * kPi * (i + 0.5) / count;
    RotorHint& rotor = out[static_cast<std::size_t>(i)];
    rotor.p_B = kMadeUpArm * Vec3(std::cos(angle), std::sin(angle), 0);
    rotor.spin = count == 4 ? (i < 2 ? -1 : 1) : (i % 2 == 0 ? 1 : -1);
    rotor.drag_ratio = kMadeUpDragRatio;
  }
  return out;
}

/// Median over the flight of the sum of squared speeds [(rad/s)^2]; 0 without measured speeds of turning
/// rotors.
double median_square_sum(const Recording& r) {
  const Signal* speed = r.find("rotor_speed");
  if (!speed) return 0;
  const Eigen::VectorXd sums = speed->values.array().square().rowwise().sum();
  const double turning = 0.1 * sums.maxCoeff();  // on the ground they idle or stand
  std::vector<double> flying;
  for (const double s : sums)
    if (s > turning) flying.push_back(s);
  if (flying.size() < 10) return 0;
  std::nth_element(flying.begin(), flying.begin() + static_cast<std::ptrdiff_t>(flying.size() / 2),
                   flying.end());
  return flying[flying.size() / 2];
}

std::string vec(const Vec3& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

std::string quoted_yaml(std::string text) {
  std::erase_if(text, [](char c) { return c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20; });
  return '"' + text + '"';
}

std::string yaml_list(const std::vector<std::string>& lines) {
  std::string out;
  for (const auto& line : lines) out += (out.empty() ? "" : ",\n            ") + quoted_yaml(line);
  return "[" + out + "]";
}

}  // namespace

Result<VehicleDraft> vehicle_from_log(const std::string& name, const Recording& r) {
  const auto hints = recording::vehicle_hints(r);
  const int count = rotors_of(r, hints);
  if (count < 1 || count > kMostRotors)
    return bad_input(count < 1
                         ? "does not tell how many rotors the vehicle has"
                         : "tells of " + std::to_string(count) + " rotors; a vehicle file has at most 16",
                     r.file, "Start from a skeleton: omniflight new vehicle " + name);
  VehicleDraft out;
  const auto told = [&](std::string what) { out.told.push_back(std::move(what)); };
  const auto missing = [&](std::string what) { out.missing.push_back(std::move(what)); };
  told(fmt::format("{} rotors{}", count, hints.airframe.empty() ? "" : ", " + hints.airframe));
  std::vector<RotorHint> rotors = hints.rotors;
  if (rotors.empty()) {
    rotors = made_up_rotors(count);
    missing("rotor positions and spins: made up; measure them, in the order of the motors of the log");
    missing("drag_ratio: made up; torque over thrust of a rotor");
  } else {
    told("rotor positions, axes and spins: CA_ROTOR* of the autopilot");
    told("drag_ratio: CA_ROTOR*_KM of the autopilot, which may be its default of 0.05 m");
  }
  const double mass = hints.mass.value_or(kMadeUpMass);
  if (hints.mass)
    told("mass and inertia: SIH_* of the simulator that wrote the log");
  else
    missing("mass: made up; put the vehicle on a scale");
  double arm = 0;
  for (const RotorHint& rotor : rotors) arm = std::max(arm, rotor.p_B.norm());
  const Vec3 inertia = hints.inertia.value_or(mass * arm * arm * Vec3(0.28, 0.28, 0.48));
  if (!hints.inertia) missing("inertia: made up from mass and size; from CAD or a swing test");
  const double squares = median_square_sum(r), weight = mass * kGravity;
  const double coefficient = squares > 0 ? weight / squares : 5.0e-6;
  if (squares > 0)
    told(
        "thrust_coefficient: so that the median of the recorded speeds carries the weight; it follows the "
        "mass");
  else
    missing("thrust_coefficient: made up; from a thrust stand, or a log with rotor speeds");
  missing("max_thrust, radius, time_constant: made up");

  out.yaml = fmt::format(
      "# From the log {}. What is made up stands under provenance: missing.\n"
      "schema: omniflight.vehicle/1\nname: {}\nmass: {:.6g}                                        # kg\n"
      "inertia: [{:.4g}, {:.4g}, {:.4g}, 0, 0, 0]          # kg m2: xx yy zz xy xz yz about the centre of "
      "mass\n"
      "center_of_mass: [0, 0, 0]                        # m, body frame\n"
      "rotors:                                          # spin +1: positive thrust exerts +drag_ratio * "
      "thrust along "
      "the axis\n",
      quoted_yaml(std::filesystem::path(r.file).filename().string()), name, mass, inertia.x(), inertia.y(),
      inertia.z());
  for (const RotorHint& rotor : rotors) {
    const double most = rotor.max_thrust.value_or(kThrustToWeight * weight / count);
    out.yaml += fmt::format(
        "  - {{position: {}, axis: {}, tilt_axis: null, spin: {:+}, thrust_coefficient: {:.4g}, drag_ratio: "
        "{:.4g}, "
        "min_thrust: {:.4g}, max_thrust: {:.4g}, radius: {:.4g}, time_constant: 0.03, board: 0}}\n",
        vec(rotor.p_B), vec(rotor.axis_B), rotor.spin, coefficient,
        rotor.drag_ratio > 0 ? rotor.drag_ratio : kMadeUpDragRatio, 0.01 * most, most,
        std::max(0.02, 0.4 * arm));
  }
  out.yaml += "tilt: {kind: none, min_deg: 0, max_deg: 0, rate_deg_s: 0}\nprovenance:\n  geometry: " +
              quoted_yaml(hints.rotors.empty() ? "made up" : "parameters of the autopilot in the log") +
              "\n  missing: " + yaml_list(out.missing) + "\n";
  return out;
}

}  // namespace omniflight::cli
