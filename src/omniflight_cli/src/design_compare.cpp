#include "design_compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "omniflight_allocation/outline.hpp"

namespace omniflight::cli {
namespace {

using allocation::DesignPoint;

constexpr double kRounding = 1e-9;  // of the weight: a smaller force in the weakest direction is none

bool tilts(const vehicle::Vehicle& v) {
  return v.tilt.kind != vehicle::TiltKind::none && v.tilt.max > v.tilt.min;
}

/// Every degree of the tilt is in the class; the point of the largest ball of forces among them.
Result<double> best_tilt(const vehicle::Vehicle& v, const allocation::ActuationClass& actuation, double f_max,
                         double mass) {
  std::vector<double> alphas;
  for (const auto& at : actuation.tilts) alphas.push_back(at.alpha);
  const auto sweep = allocation::design(v, alphas, f_max, mass);
  if (!sweep) return Failure(sweep.error());
  const auto most =
      std::max_element(sweep->points.begin(), sweep->points.end(), [](const auto& a, const auto& b) {
        return a.force_at_zero_torque.d_min_surface < b.force_at_zero_torque.d_min_surface;
      });
  const bool everywhere = most->force_at_zero_torque.d_min_surface > kRounding * sweep->mass * kGravity;
  return everywhere ? most->alpha : actuation.strongest().alpha;
}

std::string cell(double value, bool known) { return known ? fmt::format("{:.4g}", value) : "none"; }

/// Hulls of one set of both, from above and from the side, or over each one's weight.
std::vector<report::OutlineView> views(const ComparedDesign* const (&both)[2], std::size_t k,
                                       std::vector<Vec3> DesignPoint::*vertices, const std::string& quantity,
                                       const std::string& unit, bool over_weight) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  std::vector<report::OutlineView> out;
  for (const int up : {1, 2}) {
    report::OutlineView view{.x_label = fmt::format("{}x [{}]", quantity, unit),
                             .y_label = fmt::format("{}{} [{}]", quantity, kAxes[up], unit)};
    for (const ComparedDesign* design : both) {
      auto points = design->result.points[k].*vertices;
      if (over_weight)
        for (Vec3& p : points) p /= design->result.mass * kGravity;
      view.outlines.push_back({compared_name(*design, k), allocation::outline(points, 0, up)});
    }
    out.push_back(std::move(view));
  }
  return out;
}

/// The hulls of one set of both in space, or over each one's weight.
report::Surfaces hulls(const ComparedDesign* const (&both)[2], std::size_t k, report::Surfaces out,
                       std::vector<Vec3> DesignPoint::*vertices,
                       std::vector<std::array<int, 3>> DesignPoint::*triangles, bool over_weight) {
  for (const ComparedDesign* design : both) {
    const DesignPoint& point = design->result.points[k];
    const double scale = over_weight ? 1 / (design->result.mass * kGravity) : 1.0;
    report::Surface one{.name = compared_name(*design, k), .triangles = point.*triangles};
    for (const Vec3& p : point.*vertices) one.points.push_back({scale * p.x(), scale * p.y(), scale * p.z()});
    out.surfaces.push_back(std::move(one));
  }
  return out;
}

}  // namespace

vehicle::Vehicle loaded(vehicle::Vehicle v, double mass, double f_max) {
  if (mass > 0) v.mass = mass;
  for (vehicle::Rotor& rotor : v.rotors)
    if (f_max > 0) rotor.max_thrust = f_max;
  return v;
}

Result<ComparedDesign> design_to_compare(const vehicle::Vehicle& vehicle, const std::vector<double>& alphas,
                                         double f_max, double mass) {
  const vehicle::Vehicle carried = loaded(vehicle, mass, f_max);
  ComparedDesign out;
  auto actuation = allocation::classify_actuation(carried);
  if (!actuation) return Failure(actuation.error());
  out.actuation = std::move(*actuation);
  std::vector<double> at = alphas;
  if (!tilts(vehicle)) at.assign(std::max<std::size_t>(1, alphas.size()), out.actuation.tilts.front().alpha);
  if (at.empty()) {
    const auto best = best_tilt(vehicle, out.actuation, f_max, mass);
    if (!best) return Failure(best.error());
    at.push_back(*best);
  }
  auto result = allocation::design(vehicle, at, f_max, mass);
  if (!result) return Failure(result.error());
  out.result = std::move(*result);
  for (const double alpha : at) {
    const auto here = allocation::actuation_at(carried, alpha);
    if (!here) return Failure(here.error());
    out.thrust_to_weight.push_back(here->thrust_to_weight);
  }
  return out;
}

std::vector<ComparedFigure> compared_figures(const ComparedDesign& first, const ComparedDesign& second,
                                             std::size_t k) {
  const DesignPoint &a = first.result.points[k], &b = second.result.points[k];
  const auto &omni_a = first.result.omnidirectional_tilt, &omni_b = second.result.omnidirectional_tilt;
  return {
      {"tilt", "deg", to_degrees(a.alpha), to_degrees(b.alpha)},
      {"mass", "kg", first.result.mass, second.result.mass},
      {"rank", "", static_cast<double>(a.rank), static_cast<double>(b.rank)},
      {"thrust to weight", "", first.thrust_to_weight[k], second.thrust_to_weight[k]},
      {"force inradius", "N", a.force_at_zero_torque.d_min_surface, b.force_at_zero_torque.d_min_surface},
      {"largest force", "N", a.force_at_zero_torque.d_max, b.force_at_zero_torque.d_max},
      {"force U, vertex", "%", 100 * a.force_at_zero_torque.uniformity_vertex,
       100 * b.force_at_zero_torque.uniformity_vertex},
      {"force U, surface", "%", 100 * a.force_at_zero_torque.uniformity_surface,
       100 * b.force_at_zero_torque.uniformity_surface},
      {"torque inradius", "Nm", a.torque_at_zero_force.d_min_surface, b.torque_at_zero_force.d_min_surface},
      {"torque U, vertex", "%", 100 * a.torque_at_zero_force.uniformity_vertex,
       100 * b.torque_at_zero_force.uniformity_vertex},
      {"torque inradius while it hovers upright", "Nm", a.torque_at_hover.d_min_surface,
       b.torque_at_hover.d_min_surface},
      {"torque inradius in the worst attitude", "Nm", a.torque_at_any_attitude.d_min_surface,
       b.torque_at_any_attitude.d_min_surface},
      {"mass limit", "kg", a.mass_limit, b.mass_limit},
      {"hovers in every attitude from", "deg", omni_a ? to_degrees(*omni_a) : 0.0,
       omni_b ? to_degrees(*omni_b) : 0.0, omni_a && omni_b},
  };
}

std::string compared_name(const ComparedDesign& design, std::size_t k) {
  if (design.actuation.tilts.size() < 2) return design.result.vehicle;
  return fmt::format("{} at {:.4g} deg", design.result.vehicle, to_degrees(design.result.points[k].alpha));
}

nlohmann::json comparison_json(const ComparedDesign& first, const ComparedDesign& second) {
  nlohmann::json out = {{"schema", "omniflight.design_comparison/1"}, {"designs", nlohmann::json::array()}};
  for (const ComparedDesign* design : {&first, &second}) {
    nlohmann::json one;
    to_json(one, design->result);
    one["actuation"] = design->actuation.words();
    out["designs"].push_back(std::move(one));
  }
  for (std::size_t k = 0; k < first.result.points.size(); ++k) {
    auto figures = nlohmann::json::array();
    for (const ComparedFigure& f : compared_figures(first, second, k)) {
      nlohmann::json one = {{"figure", f.name}, {"unit", f.unit}};
      if (f.known) one.update({{"first", f.first}, {"second", f.second}, {"difference", f.second - f.first}});
      figures.push_back(std::move(one));
    }
    out["figures"].push_back(std::move(figures));
  }
  return out;
}

std::vector<std::string> comparison_lines(const ComparedDesign& first, const ComparedDesign& second) {
  std::vector<std::string> out;
  for (std::size_t k = 0; k < first.result.points.size(); ++k) {
    out.push_back(fmt::format("  {:44} {:>24} {:>24} {:>12}", "", compared_name(first, k),
                              compared_name(second, k), "difference"));
    for (const ComparedFigure& f : compared_figures(first, second, k))
      out.push_back(fmt::format("  {:44} {:>24} {:>24} {:>12}",
                                f.name + (f.unit.empty() ? "" : " [" + f.unit + "]"), cell(f.first, f.known),
                                cell(f.second, f.known), cell(f.second - f.first, f.known)));
  }
  for (const ComparedDesign* design : {&first, &second})
    out.push_back(design->result.vehicle + ": " + design->actuation.words());
  return out;
}

report::Page comparison_page(const ComparedDesign& first, const ComparedDesign& second) {
  report::Page page("Feasible wrenches of " + first.result.vehicle + " and " + second.result.vehicle,
                    fmt::format("{:.3f} kg and {:.3f} kg", first.result.mass, second.result.mass));
  // of the tilt at which the first carries most
  std::size_t best = 0;
  for (std::size_t k = 1; k < first.result.points.size(); ++k)
    if (first.result.points[k].mass_limit > first.result.points[best].mass_limit) best = k;
  const double a = first.result.points[best].mass_limit, b = second.result.points[best].mass_limit;
  const auto lifts = [](double kg) {
    return kg > 1e-3 ? fmt::format("lifts {:.3g} kg in every attitude", kg)
                     : std::string("cannot hover in every attitude");
  };
  page.verdict(report::Tone::unknown,
               fmt::format("{} {}, {} {}", compared_name(first, best), lifts(a), compared_name(second, best),
                           lifts(b)),
               fmt::format("They weigh {:.3f} kg and {:.3f} kg.", first.result.mass, second.result.mass));
  page.paragraph(first.result.vehicle + ": " + first.actuation.words() + ".");
  page.paragraph(second.result.vehicle + ": " + second.actuation.words() + ".");
  const ComparedDesign* const both[2] = {&first, &second};
  for (std::size_t k = 0; k < first.result.points.size(); ++k) {
    page.section(compared_name(first, k) + " and " + compared_name(second, k));
    report::Table t;
    t.caption = "Figures beside each other; difference: the second less the first";
    t.columns = {{.name = "figure"},
                 {.name = "unit"},
                 {.name = compared_name(first, k)},
                 {.name = compared_name(second, k)},
                 {.name = "difference"}};
    for (const ComparedFigure& f : compared_figures(first, second, k))
      t.rows.push_back({report::Cell(f.name), report::Cell(f.unit), report::Cell(cell(f.first, f.known)),
                        report::Cell(cell(f.second, f.known)),
                        report::Cell(cell(f.second - f.first, f.known))});
    page.table(t);
    page.surfaces(hulls(both, k,
                        {.title = "Forces at zero torque over the weight, body axes, in space",
                         .quantity = "F",
                         .unit = "m g",
                         .sphere = 1.0,
                         .sphere_label = "weight; a hull around all of it hovers in every attitude"},
                        &DesignPoint::force_vertices, &DesignPoint::force_triangles, true));
    page.surfaces(
        hulls(both, k, {.title = "Torques at zero force, body axes, in space", .quantity = "M", .unit = "Nm"},
              &DesignPoint::torque_vertices, &DesignPoint::torque_triangles, false));
    page.outlines({.title = "Forces at zero torque, body axes: from above, and from the side",
                   .views = views(both, k, &DesignPoint::force_vertices, "F", "N", false)});
    page.outlines({.title = "Forces at zero torque over the weight",
                   .views = views(both, k, &DesignPoint::force_vertices, "F", "m g", true),
                   .circle = 1.0,
                   .circle_label = "weight: a hull around all of it hovers in every attitude"});
    page.outlines({.title = "Torques at zero force, body axes",
                   .views = views(both, k, &DesignPoint::torque_vertices, "M", "Nm", false)});
  }
  return page;
}

}  // namespace omniflight::cli
