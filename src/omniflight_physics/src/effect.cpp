#include "omniflight_physics/effect.hpp"

#include <algorithm>
#include <array>

namespace omniflight::physics {

const std::vector<std::string>& known_channels() {
  static const std::vector<std::string> channels{"Fx",      "Fy",       "Fz",      "Mx",    "My",
                                                 "Mz",      "position", "acc",     "gyro",  "stamp",
                                                 "voltage", "attitude", "current", "alpha", "rotor_speed"};
  return channels;
}

double Effect::power_taken(const Situation& s, const double* theta, const double* memory) const {
  Wrench w;
  if (acts_on_wrench()) add_wrench(s, theta, w);
  if (memory) add_memory_wrench(s, theta, memory, w);
  const Vec6 total = w.at(s);
  return -total.head<3>().dot(s.v_WB_B) - total.tail<3>().dot(s.body.w_WB_B);
}

void Effect::replay(std::span<const Situation> motion, double, const double* theta, double* wrench,
                    double* jacobian) const {
  const auto n = static_cast<std::size_t>(parameter_count());
  std::array<double, 6 * kMaxParameters> columns{};
  for (std::size_t i = 0; i < motion.size(); ++i) {
    wrench_with_jacobian(motion[i], theta, wrench + 6 * i, columns.data());
    if (!jacobian) continue;
    for (std::size_t k = 0; k < n; ++k)
      std::copy_n(columns.data() + 6 * k, 6, jacobian + 6 * motion.size() * k + 6 * i);
  }
}

}  // namespace omniflight::physics
