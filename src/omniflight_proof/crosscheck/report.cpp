#include "report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "omniflight_report/page.hpp"

namespace omniflight::proof {

std::vector<std::string> CrossCheck::failures() const {
  std::vector<std::string> out;
  const auto hold = [&](const std::string& what, double value, double limit, const char* unit) {
    if (!(value < limit))
      out.push_back(fmt::format("{}: {:.4g} {} is not under {:.4g}", what, value, unit, limit));
  };
  for (const FlightDifference& f : flights) {
    hold(f.mission + ", position RMSE", f.position_rmse, kPositionLimit, "m");
    hold(f.mission + ", attitude RMSE", f.attitude_rmse_deg, kAttitudeLimitDeg, "deg");
    hold(f.mission + ", mean power", std::abs(f.power_ratio() - 1), kPowerLimit, "of the simulator's");
  }
  for (const HungMass::Rest& r : cable.rests)
    hold(fmt::format("hung mass at {} m going {}", r.height, r.upward ? "up" : "down"),
         std::abs(r.mass / r.expected - 1), kHungMassLimit, "of lambda (h - h0)");
  return out;
}

nlohmann::json to_json(const CrossCheck& check) {
  nlohmann::json j{{"schema", "omniflight.crosscheck/1"}};
  j["flights"] = nlohmann::json::array();
  for (const FlightDifference& f : check.flights)
    j["flights"].push_back({{"mission", f.mission},
                            {"position_rmse_m", f.position_rmse},
                            {"position_max_m", f.position_max},
                            {"attitude_rmse_deg", f.attitude_rmse_deg},
                            {"power_simulator_W", f.power[0]},
                            {"power_mujoco_W", f.power[1]},
                            {"tracking_rmse_simulator_m", f.tracking_rmse[0]},
                            {"tracking_rmse_mujoco_m", f.tracking_rmse[1]},
                            {"duration_s", f.duration}});
  j["hung_mass"] = nlohmann::json::array();
  for (const HungMass::Rest& r : check.cable.rests)
    j["hung_mass"].push_back({{"height_m", r.height},
                              {"direction", r.upward ? "up" : "down"},
                              {"mass_kg", r.mass},
                              {"law_kg", r.expected}});
  j["hysteresis"] = check.cable.hysteresis();
  for (const RealTimeFactor& s : check.speeds) j["real_time_factor"][s.world] = s.factor;
  j["failures"] = check.failures();
  return j;
}

Status write_report(const CrossCheck& check, const std::filesystem::path& file) {
  using namespace report;
  Page page("Two worlds, one vehicle", "omniflight_simulation against MuJoCo, which share no dynamics code");
  const auto failures = check.failures();
  std::string text = fmt::format(
      "Limits: position RMSE under {} mm, attitude under {} deg, mean power within {} %, hung mass within {} "
      "% of its "
      "law.",
      1e3 * kPositionLimit, kAttitudeLimitDeg, 100 * kPowerLimit, 100 * kHungMassLimit);
  for (const std::string& f : failures) text += " " + f + ".";
  page.verdict(failures.empty() ? Tone::ok : Tone::bad,
               failures.empty() ? "The two worlds agree" : "The two worlds differ", text);

  page.section("Nominal flights");
  Table table{{{"mission"},
               {"position RMSE", "mm"},
               {"largest", "mm"},
               {"attitude RMSE", "deg"},
               {"power, simulator", "W"},
               {"power, MuJoCo", "W"},
               {"ratio less 1", "%"}},
              {},
              "Difference between the true states; mean power by rotor telemetry"};
  for (const FlightDifference& f : check.flights)
    table.rows.push_back({f.mission, 1e3 * f.position_rmse, 1e3 * f.position_max, f.attitude_rmse_deg,
                          f.power[0], f.power[1], 100 * (f.power_ratio() - 1)});
  page.table(table);
  for (const FlightDifference& f : check.flights) {
    page.plot({.title = f.mission + ": distance between the worlds",
               .y_label = "distance [mm]",
               .series = {{"distance", f.t, f.distance_mm}},
               .group = f.mission});
    page.plot({.title = f.mission + ": angle between the worlds",
               .y_label = "angle [0.001 deg]",
               .series = {{"angle", f.t, f.angle_mdeg}},
               .group = f.mission});
  }

  if (check.cable.rests.empty()) return page.write(file);
  page.section("Articulated cable").equation(R"(m(h) = \lambda\,(h - h_0))");
  page.paragraph(
      "The vehicle is moved as on a rail, down and up again, with pauses. Links bend, lie on the floor and "
      "rub on it, "
      "so going down and up differ: by up to " +
      fmt::format("{:.1f}", 100 * check.cable.hysteresis()) +
      " % of the largest mass, in bins of 5 cm. The law knows no such hysteresis.");
  Series down{.name = "going down"}, up{.name = "going up"}, law{.name = "law", .dashed = true};
  const std::size_t lowest = static_cast<std::size_t>(
      std::min_element(check.cable.height.begin(), check.cable.height.end()) - check.cable.height.begin());
  for (std::size_t i = 0; i < check.cable.height.size(); ++i) {
    Series& s = i < lowest ? down : up;
    s.x.push_back(check.cable.height[i]);
    s.y.push_back(check.cable.mass[i]);
  }
  for (const HungMass::Rest& r : check.cable.rests)
    if (!r.upward) {
      law.x.push_back(r.height);
      law.y.push_back(r.expected);
    }
  down.points = up.points = true;
  page.plot({.title = "Hung mass over height",
             .x_label = "height of the vehicle [m]",
             .y_label = "hung mass [kg]",
             .series = {down, up, law},
             .height_px = 420});
  Table rests{
      {{"height", "m"}, {"way"}, {"hung mass", "kg"}, {"law", "kg"}, {"ratio less 1", "%"}}, {}, "At rest"};
  for (const HungMass::Rest& r : check.cable.rests)
    rests.rows.push_back(
        {r.height, r.upward ? "up" : "down", r.mass, r.expected, 100 * (r.mass / r.expected - 1)});
  page.table(rests);
  page.plot({.title = "The same over time",
             .y_label = "hung mass [kg]",
             .series = {{"mass", check.cable.t, check.cable.mass}}});

  page.section("Speed");
  Table speeds{
      {{"world"}, {"simulated per processor time"}}, {}, "Real-time factor of one processor, in process"};
  for (const RealTimeFactor& s : check.speeds) speeds.rows.push_back({s.world, s.factor});
  page.table(speeds);
  return page.write(file);
}

}  // namespace omniflight::proof
