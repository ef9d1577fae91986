// The speed sensor of one rotor is wrong or stuck.
#include <fmt/format.h>

#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

std::string faulty_sensor(const KnownValues& v) {
  const auto rotor = v.find("rotor");
  const std::string of = rotor ? " of rotor " + std::to_string(std::lround(*rotor)) : "";
  if (v("scale") != 0)
    return "the speed sensor" + of + " reads " + in_percent(v("scale")) +
           by_sign(v("scale"), " high", " low");
  return "the speed sensor" + of + " is faulty";
}

class RotorSpeedSensorFault final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "rotor_speed_sensor_fault",
        .term = "rotor speed sensor fault",
        .equation = "y_k = (1 + e) Omega_k + b, from t_f on y_k(t) = y_k(t_f)",
        .latex = R"(y_k = (1+e)\,\Omega_k + b,\quad y_k(t>t_f) = y_k(t_f))",
        .source = "definition",
        .parameters = {{"rotor", "k", "1", 1, 16, 1, 1, false},
                       {"scale", "e", "1", -1, 1, 0.05, 0, true},
                       {"bias", "b", "rad/s", -1000, 1000, 0, 0, true},
                       {"freeze_time", "t_f", "s", 0, 1000000, 1000000, 1000000, false}},
        .signals = {"rotor_speed"},
        .channels = {"rotor_speed"},
        .stage = Stage::sensing,
        .aliases = {"rotor_thrust_scale"},
        .separated_by = "speeds of the other rotors and the motion say what this one does",
        .one_value = {"rotor"},
        .words = {{}, faulty_sensor}};
    return info;
  }

  Status check_feasible(const vehicle::Vehicle& vehicle, const RigidState&,
                        const double* theta) const override {
    if (std::lround(theta[0]) <= vehicle.rotor_count()) return {};
    return bad_input(
        fmt::format("is {:g}, and {} has {} rotors", theta[0], vehicle.name, vehicle.rotor_count()),
        parameter_field(0), "Count from 1");
  }
  void alter_sensing(const double* theta, Sensing& s) const override {
    const bool freezes = theta[3] < info().parameters[3].upper;
    if (theta[1] == 0 && theta[2] == 0 && !freezes) return;
    s.rotor_fault = static_cast<int>(std::lround(theta[0])) - 1;
    s.rotor_fault_scale += theta[1];
    s.rotor_fault_bias += theta[2];
    if (freezes) s.rotor_fault_freeze = std::min(s.rotor_fault_freeze, theta[3]);
  }
};

}  // namespace

const Effect& rotor_speed_sensor_fault_effect() {
  static const RotorSpeedSensorFault effect;
  return effect;
}

}  // namespace omniflight::physics
