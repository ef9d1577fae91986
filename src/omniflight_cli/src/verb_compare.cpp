#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "compare.hpp"
#include "control_signals.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

Action add_compare(CLI::App& verb, Common& common) {
  struct CompareOptions {
    std::string simulated, real, vehicle = "omnimorph";
    std::vector<std::string> set;
  };
  auto o = std::make_shared<CompareOptions>();
  verb.add_option("simulated", o->simulated, "Recording of the simulated flight")->required();
  verb.add_option("real", o->real, "Recording of the real (or otherwise different) flight")->required();
  verb.add_option("--vehicle", o->vehicle, "Vehicle whose coefficients give the power");
  verb.add_option("--set", o->set, "Override a vehicle field");
  return [o, &common]() -> Result<int> {
    auto vehicle = vehicle::load_vehicle(o->vehicle, o->set);
    if (!vehicle) return Failure(vehicle.error());
    recording::Recording recordings[2];
    FlightMetrics metrics[2];
    const std::string* const paths[] = {&o->simulated, &o->real};
    for (int k = 0; k < 2; ++k) {
      auto r = recording::load(*paths[k], {});
      if (!r) return Failure(r.error());
      auto m = assess(*r, *vehicle);
      if (!m) return Failure(m.error());
      metrics[k] = *m;
      recordings[k] = std::move(*r);
    }
    const auto rows = compare(metrics[0], metrics[1]);
    const Flown simulated{recordings[0], metrics[0], *vehicle}, real{recordings[1], metrics[1], *vehicle};
    const auto control = compare_control(simulated, real);
    const nlohmann::json j{{"schema", "omniflight.compare/1"},
                           {"simulated", o->simulated},
                           {"real", o->real},
                           {"rows", to_json(rows)},
                           {"tracking", {{"simulated", to_json(metrics[0])}, {"real", to_json(metrics[1])}}},
                           {"control", to_json(control)}};
    print_json(common, j);
    say(common, to_text(rows));
    if (common.out.empty()) return 0;
    if (auto ok = make_folder(common.out); !ok) return Failure(ok.error());
    if (auto ok = files::write_file_atomic(common.out + "/compare.json", j.dump(2) + "\n"); !ok)
      return Failure(ok.error());
    report::Page page("Simulated and recorded", o->simulated + " against " + o->real);
    add_headline(page, rows);
    page.section("Table").table(
        comparison_table(rows, "RMSE against the reference while it moves; ratio = recorded / simulated"));
    page.section("Tracking");
    plot_tracking(page, metrics[0], "simulated");
    plot_tracking(page, metrics[1], "recorded");
    page.section("Control signals").table(control_table(control));
    plot_control(page, simulated, real);
    if (auto ok = page.write(common.out + "/report.html"); !ok) return Failure(ok.error());
    say(common, "report: " + common.out + "/report.html");
    return 0;
  };
}

}  // namespace omniflight::cli
