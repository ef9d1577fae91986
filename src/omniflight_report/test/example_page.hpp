// A page with every kind of block, from a computed flight; also the source of the pictures in the
// documentation.
#pragma once

#include <cmath>
#include <numbers>

#include "omniflight_report/page.hpp"

namespace omniflight::report {

struct Flight {
  std::vector<double> t, x, y, z, z_reference, error, force, force_model, low, high;
};

/// A climbing lemniscate of 40 s at 200 Hz; below the model lies what a cable of 0.25 kg/m pulls.
inline Flight example_flight(std::size_t n = 8000) {
  Flight flight;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = 40.0 * static_cast<double>(i) / static_cast<double>(n),
                 a = 2.0 * std::numbers::pi * t / 20.0;
    const double height = 0.3 + 1.2 * std::pow(std::sin(std::numbers::pi * t / 40.0), 2);
    const double noise = 0.15 * std::sin(137.0 * t) * std::cos(91.3 * t);
    const double pull = -9.81 * (0.28 + 0.25 * height);
    flight.t.push_back(t);
    flight.x.push_back(1.4 * std::sin(a) + 0.006 * std::sin(7.0 * t));
    flight.y.push_back(0.9 * std::sin(a) * std::cos(a));
    flight.z_reference.push_back(height);
    flight.z.push_back(height - 0.02 * height + 0.1 * noise);
    flight.error.push_back(std::abs(flight.z.back() - height) + 0.004);
    flight.force.push_back(pull + noise);
    flight.force_model.push_back(pull + 0.02 * std::sin(t));
    flight.low.push_back(pull - 0.25);
    flight.high.push_back(pull + 0.25);
  }
  for (std::size_t i = n / 2; i < n / 2 + n / 40; ++i) flight.force[i] = std::nan("");  // motion capture lost
  return flight;
}

inline Page example_page() {
  const Flight f = example_flight();
  Page page("Flight 7 of trajectory 2, with a cable", "OmniMorph, 1.595 kg, simulated plant, seed 7");
  page.verdict(Tone::warn, "Something pulls the vehicle down, more so the higher it flies",
               "From 0.4 m upwards the vertical force lacks 2.7 to 6.4 N. A constant load and a hanging "
               "cable explain 97 % of it; "
               "the tracking error alone would not have shown it.");
  page.facts({{"duration", "40.0", "s"},
              {"samples", "8000", ""},
              {"position RMSE", "0.021", "m"},
              {"attitude RMSE", "0.62", "deg"},
              {"mean power", "212", "W"},
              {"worst rotor margin", "0.41", "N"}});
  page.filter("Sections with these words");
  page.section("Flight path")
      .path_plot({"Where the vertical error is", f.x, f.y, f.z, f.error, "vertical error [m]", f.t, f.x, f.y,
                  f.z_reference, 340});
  page.section("Forces");
  page.plot(
      {"Height",
       "time [s]",
       "z [m]",
       {{"reference", f.t, f.z_reference, {}, {}, true, false}, {"flown", f.t, f.z, {}, {}, false, false}},
       {{12.0, 28.0, "mismatch", Tone::bad}},
       220,
       "flight"});
  page.plot({"What the model lacks",
             "time [s]",
             "vertical force [N]",
             {{"measured", f.t, f.force, {}, {}, false, false},
              {"load and cable", f.t, f.force_model, f.low, f.high, false, false}},
             {{12.0, 28.0, "mismatch", Tone::bad}, {36.0, 39.0, "left out of the fit", Tone::unknown}},
             260,
             "flight"});
  page.plot({"Force against height",
             "height [m]",
             "vertical force [N]",
             {{"samples", f.z, f.force, {}, {}, false, true}},
             {},
             240,
             ""});
  page.section("Findings");
  page.bars({"Probability of each explanation",
             "",
             {{"hung_cable", 0.94, 0.9, 0.97, ""},
              {"payload_mass", 0.91, 0.84, 0.95, "alias of constant_pull"},
              {"wind", 0.06, {}, {}, ""}},
             1.0,
             0.5,
             "named from here on"});
  page.equation(
      "F_z = -\\left(m_0 + \\lambda\\,(z - z_0)\\right) g,\\qquad \\lambda = 0.25\\ \\mathrm{kg/m}");
  page.table({{{"axis", "", Align::left, 4},
               {"real", "m", Align::automatic, 3},
               {"simulated before", "m", Align::automatic, 3},
               {"simulated after", "m", Align::automatic, 3},
               {"ratio after", "", Align::automatic, 3}},
              {{"x", 0.0213, 0.0041, 0.0208, {0.977, 0.977}},
               {"y", 0.0187, 0.0112, 0.0231, {1.235, 1.235}},
               {"z", 0.0342, 1.7e-5, 0.0339, Cell(0.55, 0.55)},
               {"yaw", std::nan(""), 0.0031, 0.0062, {1.9, 1.9}}},
              "Tracking error (RMSE) of the real and the simulated flight"});
  page.matrix({"Which explanations look alike",
               {"hung_cable", "constant_pull", "payload_mass", "wind"},
               {"hung_cable", "constant_pull", "payload_mass", "wind"},
               {{1, .62, .58, -.11}, {.62, 1, .97, .08}, {.58, .97, 1, .05}, {-.11, .08, .05, 1}},
               "cosine of the signatures",
               "",
               ""});
  page.outlines({"Feasible forces",
                 {{"Fx [N]",
                   "Fy [N]",
                   {{"0 deg", {{3, 3}, {-3, 3}, {-3, -3}, {3, -3}}},
                    {"30 deg", {{14, 0}, {0, 14}, {-14, 0}, {0, -14}}}}},
                  {"Fx [N]",
                   "Fz [N]",
                   {{"0 deg", {{3, 40}, {-3, 40}, {-3, -40}, {3, -40}}},
                    {"30 deg", {{14, 0}, {0, 34}, {-14, 0}, {0, -34}}}}}},
                 12.9,
                 "weight"});
  page.section("Details").details("How this was computed", [&](Page& inside) {
    inside.paragraph("The wrench is the measured acceleration times the mass, less what the rotors give.");
    inside.plot({"Position error",
                 "time [s]",
                 "error [m]",
                 {{"vertical", f.t, f.error, {}, {}, false, false}},
                 {},
                 180,
                 "flight"});
  });
  return page;
}

}  // namespace omniflight::report
