#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <nlohmann/json.hpp>

#include "design_compare.hpp"
#include "design_page.hpp"
#include "hover_power_page.hpp"
#include "omniflight_allocation/actuation.hpp"
#include "omniflight_allocation/feasible_set.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_report/page.hpp"
#include "survival_page.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

/// Every degree of the tilt and both limits.
std::vector<double> sweep_tilts(const vehicle::Vehicle& v) {
  if (v.tilt.kind == vehicle::TiltKind::none) return {0.0};
  std::vector<double> out;
  for (int k = 0; v.tilt.min + to_radians(k) < v.tilt.max - 1e-9; ++k)
    out.push_back(v.tilt.min + to_radians(k));
  out.push_back(v.tilt.max);
  return out;
}

/// rad, largest lean at which the weight is still carried: with force along one axis the vehicle leans, and
/// its thrust is the limit; else it hovers leaning.
double lean_limit(const allocation::ActuationAtTilt& at) {
  if (at.force_rank != 1) return at.lean;
  return at.thrust_to_weight > 1 ? std::acos(1 / at.thrust_to_weight) : 0.0;
}

/// What hovering leaves, in words.
std::string hover_words(const allocation::ActuationAtTilt& at, const allocation::DesignPoint& point) {
  return fmt::format(
      "at {:.0f} deg: thrust to weight {:.2f}, {} up to {:.1f} deg, torques up to {:.3f} Nm while it hovers",
      to_degrees(at.alpha), at.thrust_to_weight,
      at.force_rank == 1 ? "holds its height while it leans" : "hovers leaning in every direction",
      to_degrees(lean_limit(at)), point.torque_at_hover.d_max);
}

/// Weakest force over the tilt; the tilts at which every attitude hovers are shaded.
report::TimePlot sweep_plot(const allocation::DesignResult& sweep) {
  report::Series inradius{.name = "force inradius"}, limit{.name = "weight"};
  for (const auto& p : sweep.points) {
    inradius.x.push_back(to_degrees(p.alpha));
    inradius.y.push_back(p.force_at_zero_torque.d_min_surface);
    limit.x.push_back(to_degrees(p.alpha));
    limit.y.push_back(sweep.mass * kGravity);
  }
  limit.dashed = true;
  report::TimePlot plot{.title = "Force in the weakest direction, at zero torque",
                        .x_label = "tilt [deg]",
                        .y_label = "force [N]",
                        .series = {inradius, limit}};
  if (sweep.omnidirectional_tilt)
    plot.windows.push_back(
        {to_degrees(*sweep.omnidirectional_tilt), to_degrees(sweep.points.back().alpha),
         fmt::format("hovers in every attitude from {:.2f} deg on", to_degrees(*sweep.omnidirectional_tilt)),
         report::Tone::ok});
  return plot;
}

nlohmann::json sweep_json(const allocation::DesignResult& sweep) {
  auto out = nlohmann::json::array();
  for (const auto& p : sweep.points)
    out.push_back({{"alpha_deg", to_degrees(p.alpha)},
                   {"force_inradius_N", p.force_at_zero_torque.d_min_surface},
                   {"torque_inradius_Nm", p.torque_at_zero_force.d_min_surface},
                   {"robust_torque_inradius_Nm", p.torque_at_any_attitude.d_min_surface},
                   {"mass_limit_kg", p.mass_limit}});
  return out;
}

/// `design A B`.
Result<int> compare_designs(const std::vector<std::string>& names, const std::vector<double>& alphas,
                            double f_max, double mass, const std::vector<std::string>& set, Common& common) {
  std::vector<ComparedDesign> both;
  for (const std::string& name : names) {
    const auto vehicle = vehicle::load_vehicle(name, set);
    if (!vehicle) return Failure(vehicle.error());
    auto one = design_to_compare(*vehicle, alphas, f_max, mass);
    if (!one) return Failure(one.error());
    both.push_back(std::move(*one));
  }
  const nlohmann::json j = comparison_json(both[0], both[1]);
  print_json(common, j);
  for (const std::string& line : comparison_lines(both[0], both[1])) say(common, line);
  if (common.out.empty()) return 0;
  if (auto ok = make_folder(common.out); !ok) return Failure(ok.error());
  if (auto ok = files::write_file_atomic(common.out + "/comparison.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = comparison_page(both[0], both[1]).write(common.out + "/report.html"); !ok)
    return Failure(ok.error());
  say(common, "report: " + common.out + "/report.html");
  return 0;
}

}  // namespace

Action add_design(CLI::App& verb, Common& common) {
  struct DesignOptions {
    std::vector<std::string> vehicles;
    std::vector<double> alpha_deg;
    double f_max = 0, mass = 0;
    std::vector<std::string> set;
    bool hover_power = false, survival = false;
  };
  auto o = std::make_shared<DesignOptions>();
  verb.add_option("vehicle", o->vehicles,
                  "Name or path; two of them are put beside each other, for instance design omnimorph "
                  "omnicopter --out compared")
      ->required()
      ->expected(1, 2);
  verb.add_option("--alpha", o->alpha_deg, "Tilt [deg]; may be given several times");
  verb.add_option("--f-max", o->f_max, "Largest thrust of a rotor [N]; default: the vehicle's")
      ->check(not_negative(false));
  verb.add_option("--mass", o->mass, "Mass to carry [kg]; default: the vehicle's")
      ->check(not_negative(false));
  verb.add_option("--set", o->set, "Override a vehicle field");
  verb.add_flag("--hover-power", o->hover_power,
                "Power and rotor loads of hovering, over attitude and tilt; for instance design omnimorph "
                "--hover-power --out design");
  verb.add_flag(
          "--survival", o->survival,
          "Which weights and tilts survive a full roll, over its time, the tilt's rate and lost thrust; for "
          "instance design omnimorph --survival --out survival")
      ->excludes("--hover-power")
      ->excludes("--alpha");
  return [o, &common]() -> Result<int> {
    std::vector<double> alphas;
    for (const double a : o->alpha_deg) alphas.push_back(to_radians(a));
    if (o->vehicles.size() == 2) {
      for (const auto& [given, option] :
           {std::pair{o->hover_power, "--hover-power"}, {o->survival, "--survival"}})
        if (given)
          return bad_input("maps one vehicle", option,
                           std::string("Give one vehicle, or leave ") + option + " out");
      return compare_designs(o->vehicles, alphas, o->f_max, o->mass, o->set, common);
    }
    auto vehicle = vehicle::load_vehicle(o->vehicles.front(), o->set);
    if (!vehicle) return Failure(vehicle.error());
    if (o->survival) return map_survival(loaded(*vehicle, o->mass, o->f_max), common);
    if (alphas.empty())
      for (double a = vehicle->tilt.min; a <= vehicle->tilt.max + 1e-9; a += to_radians(5))
        alphas.push_back(a);
    auto result = allocation::design(*vehicle, alphas, o->f_max, o->mass);
    if (!result) return Failure(result.error());
    const vehicle::Vehicle carried = loaded(*vehicle, o->mass, o->f_max);
    const auto actuation = allocation::classify_actuation(carried);
    if (!actuation) return Failure(actuation.error());
    const allocation::ActuationAtTilt& strongest = actuation->strongest();
    const auto at_strongest = allocation::design(*vehicle, {strongest.alpha}, o->f_max, o->mass);
    if (!at_strongest) return Failure(at_strongest.error());
    const std::string hover = hover_words(strongest, at_strongest->points[0]);
    auto sweep = allocation::design(*vehicle, sweep_tilts(*vehicle), o->f_max, o->mass);
    if (!sweep) return Failure(sweep.error());
    nlohmann::json j;
    to_json(j, *result);
    j["actuation"] = {{"words", actuation->words()},
                      {"alpha_deg", to_degrees(strongest.alpha)},
                      {"thrust_to_weight", strongest.thrust_to_weight},
                      {"lean_deg", to_degrees(lean_limit(strongest))},
                      {"torque_at_hover_Nm", at_strongest->points[0].torque_at_hover.d_max}};
    j["sweep"] = sweep_json(*sweep);
    allocation::HoverMap map;
    std::vector<std::string> half;
    if (o->hover_power) {
      auto found = hover_power_map(carried);
      if (!found) return Failure(found.error());
      map = std::move(*found);
      auto lines = half_carried(carried, map);
      if (!lines) return Failure(lines.error());
      half = std::move(*lines);
      j["hover_power"] = hover_power_json(map, half);
    }
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
    say(common, actuation->words());
    say(common, hover);
    for (const std::string& line : half) say(common, line);
    if (common.out.empty()) return 0;
    if (auto ok = make_folder(common.out); !ok) return Failure(ok.error());
    if (auto ok = files::write_file_atomic(common.out + "/design.json", j.dump(2) + "\n"); !ok)
      return Failure(ok.error());
    report::Page page("Feasible wrenches of " + result->vehicle, fmt::format("{:.3f} kg", result->mass));
    design_verdict(page, *result, actuation->words() + "; " + hover + ".");
    page.section("Sets");
    design_hulls(page, *result);
    page.table(table());
    if (sweep->points.size() > 1) page.plot(sweep_plot(*sweep));
    if (o->hover_power) hover_power_section(map, half, page);
    if (auto ok = page.write(common.out + "/report.html"); !ok) return Failure(ok.error());
    say(common, "report: " + common.out + "/report.html");
    return 0;
  };
}

}  // namespace omniflight::cli
