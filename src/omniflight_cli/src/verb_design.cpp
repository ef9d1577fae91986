#include <fmt/format.h>

#include "omniflight_allocation/feasible_set.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_report/page.hpp"
#include "verbs.hpp"

namespace omniflight::cli {

Action add_design(CLI::App& verb, Common& common) {
  struct Options {
    std::string vehicle;
    std::vector<double> alpha_deg;
    double f_max = 0, mass = 0;
    std::vector<std::string> set;
  };
  auto o = std::make_shared<Options>();
  verb.add_option("vehicle", o->vehicle, "Name or path")->required();
  verb.add_option("--alpha", o->alpha_deg, "Tilt [deg]; may be given several times");
  verb.add_option("--f-max", o->f_max, "Largest thrust of a rotor [N]; default: the vehicle's")
      ->check(not_negative(false));
  verb.add_option("--mass", o->mass, "Mass to carry [kg]; default: the vehicle's")
      ->check(not_negative(false));
  verb.add_option("--set", o->set, "Override a vehicle field");
  return [o, &common]() -> Result<int> {
    auto vehicle = vehicle::load_vehicle(o->vehicle, o->set);
    if (!vehicle) return Failure(vehicle.error());
    std::vector<double> alphas;
    for (const double a : o->alpha_deg) alphas.push_back(to_radians(a));
    if (alphas.empty())
      for (double a = vehicle->tilt.min; a <= vehicle->tilt.max + 1e-9; a += to_radians(5))
        alphas.push_back(a);
    auto result = allocation::design(*vehicle, alphas, o->f_max, o->mass);
    if (!result) return Failure(result.error());
    nlohmann::json j;
    to_json(j, *result);
    print_json(common, j);
    const auto table = [&] {
      report::Table t;
      t.caption = "Largest ball inside each set (inradius), and uniformity by vertex and by surface";
      t.columns = {{.name = "tilt", .unit = "deg"},           {.name = "force inradius", .unit = "N"},
                   {.name = "force U, vertex", .unit = "%"},  {.name = "force U, surface", .unit = "%"},
                   {.name = "torque inradius", .unit = "Nm"}, {.name = "torque U, vertex", .unit = "%"},
                   {.name = "mass limit", .unit = "kg"}};
      for (const auto& p : result->points)
        t.rows.push_back(
            {report::Cell(to_degrees(p.alpha)), report::Cell(p.force_at_zero_torque.d_min_surface),
             report::Cell(100 * p.force_at_zero_torque.uniformity_vertex),
             report::Cell(100 * p.force_at_zero_torque.uniformity_surface),
             report::Cell(p.torque_at_zero_force.d_min_surface),
             report::Cell(100 * p.torque_at_zero_force.uniformity_vertex), report::Cell(p.mass_limit)});
      return t;
    };
    say(common,
        "  tilt [deg]  force inradius [N]  U vertex [%]  U surface [%]  torque inradius [Nm]  U vertex [%]  "
        "mass limit [g]");
    for (const auto& p : result->points)
      say(common,
          fmt::format("  {:10.4f}  {:18.3f}  {:12.2f}  {:13.2f}  {:20.3f}  {:12.2f}  {:14.1f}",
                      to_degrees(p.alpha), p.force_at_zero_torque.d_min_surface,
                      100 * p.force_at_zero_torque.uniformity_vertex,
                      100 * p.force_at_zero_torque.uniformity_surface, p.torque_at_zero_force.d_min_surface,
                      100 * p.torque_at_zero_force.uniformity_vertex, 1000 * p.mass_limit));
    say(common, result->omnidirectional_tilt
                    ? fmt::format("smallest tilt at which {:.3f} kg can hover in every attitude: {:.2f} deg",
                                  result->mass, to_degrees(*result->omnidirectional_tilt))
                    : fmt::format("{:.3f} kg cannot hover in every attitude at any tilt", result->mass));
    if (common.out.empty()) return 0;
    if (auto ok = make_folder(common.out); !ok) return Failure(ok.error());
    if (auto ok = files::write_file_atomic(common.out + "/design.json", j.dump(2) + "\n"); !ok)
      return Failure(ok.error());
    report::Page page("Feasible wrenches of " + result->vehicle, fmt::format("{:.3f} kg", result->mass));
    page.section("Sets").table(table());
    report::Series inradius{.name = "force inradius"}, limit{.name = "weight"};
    for (const auto& p : result->points) {
      inradius.x.push_back(to_degrees(p.alpha));
      inradius.y.push_back(p.force_at_zero_torque.d_min_surface);
      limit.x.push_back(to_degrees(p.alpha));
      limit.y.push_back(result->mass * kGravity);
    }
    limit.dashed = true;
    page.plot({.title = "Force in the weakest direction, at zero torque",
               .x_label = "tilt [deg]",
               .y_label = "force [N]",
               .series = {inradius, limit}});
    if (auto ok = page.write(common.out + "/report.html"); !ok) return Failure(ok.error());
    say(common, "report: " + common.out + "/report.html");
    return 0;
  };
}

}  // namespace omniflight::cli
