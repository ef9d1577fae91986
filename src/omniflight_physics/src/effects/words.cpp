#include "effects/words.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "omniflight_core/frames.hpp"

namespace omniflight::physics {

std::string two_digits(double x) { return fmt::format("{:.2g}", x); }
std::string hundredths(double x) { return fmt::format("{:.2f}", x); }
std::string in_mass(double kg) {
  return std::abs(kg) < 0.1 ? two_digits(1e3 * std::abs(kg)) + " g" : hundredths(std::abs(kg)) + " kg";
}
std::string in_length(double m) {
  return std::abs(m) < 0.1 ? two_digits(1e3 * std::abs(m)) + " mm" : hundredths(std::abs(m)) + " m";
}
std::string in_degrees(double rad) { return two_digits(to_degrees(std::abs(rad))) + " deg"; }
std::string in_percent(double share) { return two_digits(100 * std::abs(share)) + " %"; }

const char* by_sign(double x, const char* when_positive, const char* otherwise) {
  return x > 0 ? when_positive : otherwise;
}

double norm_of(const KnownValues& v, const char* x, const char* y, const char* z) {
  return Vec3(v(x), v(y), v(z)).norm();
}

std::string along_body(const KnownValues& v) {
  const Vec3 p(v("x"), v("y"), v("z"));
  static constexpr std::array<std::array<const char*, 2>, 3> kWords{
      {{"forward", "backward"}, {"to the left", "to the right"}, {"up", "down"}}};
  std::string out;
  for (std::size_t k = 0; k < 3; ++k) {
    const double part = p[static_cast<Eigen::Index>(k)];
    if (std::abs(part) < 0.2 * p.norm() || part == 0) continue;
    out += (out.empty() ? "" : ", ") + in_length(part) + " " + kWords[k][part > 0 ? 0 : 1];
  }
  return out;
}

std::string from_height(const KnownValues& v) {
  const auto height = v.find("start_height");
  return height ? " from " + hundredths(*height) + " m up" : "";
}

}  // namespace omniflight::physics
