#include "omniflight_components/tilt_schedule_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "omniflight_files/yaml.hpp"

namespace omniflight::components {

std::string tilt_schedule_text(const allocation::TiltSchedule& schedule) {
  std::string out =
      fmt::format("schema: omniflight.tilt_schedule/1\nperiod_s: {:.17g}\nalpha_deg: [", schedule.period);
  for (std::size_t k = 0; k < schedule.alpha.size(); ++k)
    out += fmt::format("{}{:.10g}",
                       k == 0        ? ""
                       : k % 16 == 0 ? ",\n  "
                                     : ", ",
                       to_degrees(schedule.alpha[k]));
  return out + "]\n";
}

Result<allocation::TiltSchedule> read_tilt_schedule(const std::filesystem::path& path,
                                                    const vehicle::Tilt& tilt) {
  constexpr double kRounding = to_radians(1e-6);
  auto yaml = files::YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  if (yaml->string("schema") != "omniflight.tilt_schedule/1")
    yaml->error_at("schema", "is not omniflight.tilt_schedule/1",
                   "Give a file that `fly --tilt lookahead` wrote");
  allocation::TiltSchedule out;
  out.period = yaml->number("period_s", files::between(1e-3, 10, "s"));
  out.alpha = yaml->numbers(
      "alpha_deg", 0,
      files::between(to_degrees(tilt.min - kRounding), to_degrees(tilt.max + kRounding), "deg"));
  if (out.alpha.empty()) yaml->error_at("alpha_deg", "has no tilt (deg)");
  for (double& a : out.alpha) a = std::clamp(to_radians(a), tilt.min, tilt.max);
  for (std::size_t k = 1; k < out.alpha.size() && tilt.rate > 0; ++k)
    if (std::abs(out.alpha[k] - out.alpha[k - 1]) > tilt.rate * out.period * (1 + 1e-6) + kRounding) {
      yaml->error_at(
          "alpha_deg",
          fmt::format("moves by {:.4g} deg in {:.4g} s to its value {}, the servo does {:.4g} deg/s",
                      to_degrees(std::abs(out.alpha[k] - out.alpha[k - 1])), out.period, k + 1,
                      to_degrees(tilt.rate)),
          "Move it more slowly");
      break;
    }
  if (auto ok = yaml->finish(); !ok) return Failure(ok.error());
  return out;
}

}  // namespace omniflight::components
