#include "skeletons.hpp"

#include <cctype>

namespace omniflight::cli {
namespace {

std::string filled(std::string text, const std::string& mark, const std::string& with) {
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + with.size()))
    text.replace(at, mark.size(), with);
  return text;
}

constexpr const char* kEffect =
    R"(// Say in one sentence what happens physically. As generated: drag in proportion to speed.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class CLASS final : public WrenchEffect<CLASS> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{.id = "ID",
                                 .term = "the field's name for it",
                                 .equation = "dF = -k v",
                                 .latex = R"tex(\Delta F = -k\,v)tex",
                                 .source = "paper and equation",
                                 .parameters = {{"coefficient", "k", "N s/m", 0, 1, 0.05, 0, true}},
                                 .signals = {"velocity", "attitude"},
                                 .channels = {"Fx", "Fy", "Fz"},
                                 .stage = Stage::wrench,
                                 .aliases = {"rotor_drag"},
                                 .separated_by = "the manoeuvre that tells it from its aliases"};
    return info;
  }

  /// About the body origin, body axes [N, N m]; nothing at the neutral parameters. T is double or a dual number.
  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    out.force_B += theta[0] * (-s.v_WB_B).cast<T>();
  }
};

}  // namespace

const Effect& ID_effect() {
  static const CLASS effect;
  return effect;
}

}  // namespace omniflight::physics
)";

constexpr const char* kVehicle = R"(# Say what it is and where its figures come from.
schema: omniflight.vehicle/1
name: NAME
mass: 1.0                                        # kg
inertia: [0.008, 0.008, 0.014, 0, 0, 0]          # kg m2: xx yy zz xy xz yz about the centre of mass
center_of_mass: [0, 0, 0]                        # m, body frame
rotors:                                          # spin +1: positive thrust exerts +drag_ratio * thrust along the axis
  - {position: [0.12, 0.12, 0], axis: [0, 0, 1], tilt_axis: null, spin: +1, thrust_coefficient: 5.0e-6, drag_ratio: 0.016, min_thrust: 0.1, max_thrust: 6.0, radius: 0.1, time_constant: 0.02, board: 0}
  - {position: [-0.12, 0.12, 0], axis: [0, 0, 1], tilt_axis: null, spin: -1, thrust_coefficient: 5.0e-6, drag_ratio: 0.016, min_thrust: 0.1, max_thrust: 6.0, radius: 0.1, time_constant: 0.02, board: 0}
  - {position: [-0.12, -0.12, 0], axis: [0, 0, 1], tilt_axis: null, spin: +1, thrust_coefficient: 5.0e-6, drag_ratio: 0.016, min_thrust: 0.1, max_thrust: 6.0, radius: 0.1, time_constant: 0.02, board: 0}
  - {position: [0.12, -0.12, 0], axis: [0, 0, 1], tilt_axis: null, spin: -1, thrust_coefficient: 5.0e-6, drag_ratio: 0.016, min_thrust: 0.1, max_thrust: 6.0, radius: 0.1, time_constant: 0.02, board: 0}
tilt: {kind: none, min_deg: 0, max_deg: 0, rate_deg_s: 0, time_constant_s: 0, backlash_deg: 0}   # the last two: lag and play of the servo
provenance:
  geometry: "say where it is from"
  missing: ["everything: these are made-up figures to start from"]
)";

constexpr const char* kMission = R"(# Say what it is for.
schema: omniflight.mission/1
name: NAME
vehicle: omnimorph
test_bed: pyramid
alpha_deg: 30                                    # or search
clearance_m: 0.08
seed: 1
budget_ms: 10000
limits: {speed_mps: 0.3, acceleration_mps2: 0.4, rate_dps: 30, angular_acceleration_dps2: 90, rotor_headroom: 0.1}
start: {position: [0, 0, 1.2], attitude: {rpy_deg: [0, 0, 0]}, hold_s: 2}
waypoints:
  - {name: up, by: [0, 0, 0.2], hold_s: 2}
  - {name: aside and tilted, by: [0.2, 0, 0], attitude: {rpy_deg: [0, 10, 0]}, hold_s: 2}
)";

}  // namespace

std::string effect_skeleton(const std::string& id) {
  std::string name;
  bool start = true;
  for (const char c : id) {
    if (c != '_') name += start ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    start = c == '_';
  }
  return filled(filled(kEffect, "CLASS", name), "ID", id);
}
std::string vehicle_skeleton(const std::string& name) { return filled(kVehicle, "NAME", name); }
std::string mission_skeleton(const std::string& name) { return filled(kMission, "NAME", name); }

}  // namespace omniflight::cli
