#include "omniflight_control/law.hpp"

#include "laws.hpp"

namespace omniflight::control {

const std::vector<std::string>& law_names() {
  static const std::vector<std::string> names{"full_pose", "thrust_vector", "cascaded", "incremental"};
  return names;
}

Result<std::unique_ptr<Law>> make_law(const std::string& name, const LawConfig& config) {
  const bool leans = !config.thrust_axis_B.isZero();
  if (!config.thrust_axis_B.allFinite() || (leans && std::abs(config.thrust_axis_B.norm() - 1.0) > 1e-6))
    return bad_input("is neither zero nor of unit length", "controller.thrust_axis",
                     "Give a unit vector in body axes, or [0, 0, 0] for a vehicle whose attitude is free");
  if (name == "full_pose") {
    if (leans)
      return bad_input(
          "the law full_pose commands the attitude and a force in every direction, a thrust axis says "
          "that there is one direction only",
          "controller.law", "Take thrust_vector, cascaded or incremental");
    return std::unique_ptr<Law>(std::make_unique<Controller>(config.gains));
  }
  if (name == "thrust_vector") {
    if (!leans)
      return bad_input(
          "the law thrust_vector leans into its acceleration and needs the direction of the thrust",
          "controller.thrust_axis", "Give a unit vector in body axes, for instance [0, 0, 1]");
    return make_thrust_vector(config);
  }
  if (name == "cascaded") return make_cascaded(config);
  if (name == "incremental") return make_incremental(config);
  std::string known;
  for (const std::string& n : law_names()) known += (known.empty() ? "" : ", ") + n;
  return bad_input("'" + name + "' is no control law", "controller.law", "Take one of " + known);
}

}  // namespace omniflight::control
