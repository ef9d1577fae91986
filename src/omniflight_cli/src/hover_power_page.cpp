#include "hover_power_page.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace omniflight::cli {
namespace {

constexpr int kAzimuths = 24, kLeanStep = 15, kTiltStep = 5;  // deg but for the first

/// As it is printed, without a minus before zero.
double rounded(double x) { return std::round(100 * x) / 100 + 0.0; }
std::string degrees(double rad) { return fmt::format("{:.4g}", to_degrees(rad)); }

}  // namespace

Result<allocation::HoverMap> hover_power_map(const vehicle::Vehicle& v) {
  std::vector<double> tilts{v.tilt.kind == vehicle::TiltKind::none ? 0.0 : v.tilt.min}, leans;
  while (v.tilt.kind != vehicle::TiltKind::none && tilts.back() < v.tilt.max - 1e-9)
    tilts.push_back(std::min(v.tilt.max, tilts.back() + to_radians(kTiltStep)));
  for (int lean = 0; lean <= 180; lean += kLeanStep) leans.push_back(to_radians(lean));
  return allocation::hover_map(v, tilts, leans, kAzimuths);
}

Result<std::vector<std::string>> half_carried(const vehicle::Vehicle& v, const allocation::HoverMap& map) {
  std::vector<std::string> out;
  for (int k = 0; k < kAzimuths; ++k) {
    const double azimuth = 2 * kPi * k / kAzimuths;
    const Vec3 up(std::cos(azimuth), std::sin(azimuth), 0);
    allocation::HoverCost best;
    double at = 0;
    for (const double tilt : map.alpha) {
      auto one = allocation::hover_cost(v, tilt, up);
      if (!one) return Failure(one.error());
      if (one->possible && (!best.possible || one->power < best.power)) best = std::move(*one), at = tilt;
    }
    if (!best.possible || 2 * best.working > v.rotor_count()) continue;
    std::string rotors;
    for (int i = 0; i < v.rotor_count(); ++i)
      if (std::abs(best.u[i]) >= 0.05 * best.u.cwiseAbs().maxCoeff())
        rotors += (rotors.empty() ? "" : ", ") + std::to_string(i + 1);
    out.push_back(fmt::format(
        "on its side with ({:.2f}, {:.2f}, 0) up, at a tilt of {} deg: rotors {} carry the "
        "weight, {:.1f} W, {:.0f} % of a rotor's limit",
        rounded(up.x()), rounded(up.y()), degrees(at), rotors, best.power, 100 * best.largest_load));
  }
  return out;
}

nlohmann::json hover_power_json(const allocation::HoverMap& map,
                                const std::vector<std::string>& half_carried) {
  nlohmann::json j{{"half_carried", half_carried}};
  for (const double a : map.alpha) j["alpha_deg"].push_back(to_degrees(a));
  for (std::size_t k = 0; k < map.lean.size(); ++k) {
    j["lean_deg"].push_back(to_degrees(map.lean[k]));
    auto power = nlohmann::json::array(), load = power, working = power;
    for (const allocation::HoverCost& c : map.worst[k]) {
      power.push_back(c.possible ? nlohmann::json(c.power) : nlohmann::json());
      load.push_back(c.possible ? nlohmann::json(c.largest_load) : nlohmann::json());
      working.push_back(c.possible ? nlohmann::json(c.working) : nlohmann::json());
    }
    j["power_W"].push_back(power);
    j["largest_load"].push_back(load);
    j["working_rotors"].push_back(working);
  }
  return j;
}

void hover_power_section(const allocation::HoverMap& map, const std::vector<std::string>& half_carried,
                         report::Page& page) {
  report::Matrix power{.title = "Power of hovering, the most expensive direction of each lean",
                       .value_label = "power [W]",
                       .row_title = "lean [deg]",
                       .column_title = "tilt of the rotors [deg]"};
  report::Matrix load = power;
  load.title = "Largest load of a rotor there";
  load.value_label = "share of its limit [%]";
  for (const double a : map.alpha) power.columns.push_back(degrees(a));
  for (std::size_t k = 0; k < map.lean.size(); ++k) {
    power.rows.push_back(degrees(map.lean[k]));
    auto &powers = power.values.emplace_back(), &loads = load.values.emplace_back();
    for (const allocation::HoverCost& c : map.worst[k]) {
      powers.push_back(c.possible ? c.power : std::numeric_limits<double>::quiet_NaN());
      loads.push_back(c.possible ? 100 * c.largest_load : std::numeric_limits<double>::quiet_NaN());
    }
  }
  load.rows = power.rows;
  load.columns = power.columns;
  page.section("Power of hovering").matrix(power).matrix(load);
  page.paragraph("A dash: some direction of that lean cannot be held at that tilt.");
  for (const std::string& line : half_carried) page.paragraph(line + ".");
}

}  // namespace omniflight::cli
