#include "plan_page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "omniflight_planning/map_solids.hpp"
#include "omniflight_report/page.hpp"

namespace omniflight::cli {
namespace {

using namespace planning;

/// A figure over all knots in time.
template <class Get>
report::Series over_time(std::string name, const Plan& plan, Get get) {
  report::Series s{.name = std::move(name)};
  const auto& knots = plan.trajectory.knots();
  for (std::size_t k = 0; k < knots.size(); ++k) {
    s.x.push_back(knots[k].t);
    s.y.push_back(get(k));
  }
  return s;
}

/// Of a knot; not a number where the plan has no figures of it.
double clearance(const Plan& plan, std::size_t k) {
  return k < plan.figures.size() ? plan.figures[k].clearance : std::nan("");
}

void add_path(report::Page& page, const Plan& plan) {
  report::PathPlot path{.title = "The way, coloured by the distance to the map",
                        .value_label = "clearance [m]"};
  const auto& knots = plan.trajectory.knots();
  for (std::size_t k = 0; k < knots.size() && k < plan.figures.size(); ++k) {
    const Vec3& p = knots[k].reference.p_WB;
    path.x.push_back(p.x());
    path.y.push_back(p.y());
    path.z.push_back(p.z());
    path.t.push_back(knots[k].t);
    path.value.push_back(clearance(plan, k));
  }
  if (path.x.size() > 1) page.path_plot(std::move(path));
}

std::array<double, 3> point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

report::SpaceSolid solid_of(const Primitive& p, bool is_zone) {
  return {.name = p.name,
          .is_rod = p.kind != Primitive::Kind::box,
          .a = point(p.a),
          .b = point(p.b),
          .radius = p.radius,
          .is_zone = is_zone};
}

/// The way among what the map holds, the rotors at places along it, and the tether there.
Status add_space(report::Page& page, const Plan& plan, const Mission& mission,
                 const vehicle::Vehicle& vehicle) {
  constexpr std::size_t kMostPoints = 1000, kMostPlaces = 24;
  const auto drawn = map_solids(mission);
  if (!drawn) return Failure(drawn.error());
  report::Space space{.title = "The way among the obstacles, coloured by the distance to them",
                      .value_label = "clearance [m]"};
  for (std::size_t i = 0; i < drawn->solids.size(); ++i)
    space.solids.push_back(solid_of(drawn->solids[i], i + drawn->zones >= drawn->solids.size()));
  const auto& knots = plan.trajectory.knots();
  const auto every = [&](std::size_t most) { return (knots.size() + most - 1) / most; };
  for (std::size_t k = 0; k < knots.size(); k += every(kMostPoints)) {
    space.path.push_back(point(knots[k].reference.p_WB));
    space.value.push_back(clearance(plan, k));
  }
  for (std::size_t k = 0; k < knots.size(); k += every(kMostPlaces)) {
    const Reference& r = knots[k].reference;
    for (std::size_t i = 0; i < vehicle.rotors.size(); ++i)
      space.discs.push_back({.center = point(r.p_WB + r.q_WB * vehicle.rotors[i].p_BR),
                             .axis = point(r.q_WB * vehicle.rotor_axis(static_cast<int>(i), r.alpha)),
                             .radius = vehicle.rotors[i].radius});
    if (mission.tether)
      space.lines.push_back(
          {point(mission.tether->anchor_W), point(mission.tether->attachment_W(r.p_WB, r.q_WB))});
  }
  if (space.path.size() > 1) page.space(space);
  return {};
}

void add_curves(report::Page& page, const Plan& plan) {
  const auto& knots = plan.trajectory.knots();
  if (!plan.figures.empty()) {
    const double asked = plan.certificate.clearance_asked;
    report::TimePlot near{
        .title = "Clearance: a lower bound at every knot", .y_label = "clearance [m]", .group = "plan"};
    near.series.push_back(over_time("planned", plan, [&](std::size_t k) { return clearance(plan, k); }));
    near.series.push_back(over_time("asked", plan, [&](std::size_t) { return asked; }));
    near.series.back().dashed = true;
    page.plot(std::move(near));
    page.plot({.title = "Rotors: the share of their range in use",
               .y_label = "largest load [%]",
               .series = {over_time("largest of the rotors", plan,
                                    [&](std::size_t k) {
                                      return k < plan.figures.size() ? 100 * (1 - plan.figures[k].headroom)
                                                                     : std::nan("");
                                    })},
               .group = "plan"});
  }
  page.plot({.title = "Speed",
             .y_label = "speed [m/s]",
             .series = {over_time("along the way", plan,
                                  [&](std::size_t k) { return knots[k].reference.v_WB_W.norm(); })},
             .group = "plan"});
  page.plot({.title = "Lean from level, and tilt of the rotors",
             .y_label = "angle [deg]",
             .series = {over_time("lean", plan,
                                  [&](std::size_t k) {
                                    const Vec3 up = knots[k].reference.q_WB * Vec3::UnitZ();
                                    return to_degrees(std::acos(std::clamp(up.z(), -1.0, 1.0)));
                                  }),
                        over_time("tilt", plan,
                                  [&](std::size_t k) { return to_degrees(knots[k].reference.alpha); })},
             .group = "plan"});
}

/// What was asked beside the largest value on the way.
report::Table limits(const Certificate& c) {
  report::Table t;
  t.caption = "Limits, and the largest value on the way";
  t.columns = {{.name = "quantity"}, {.name = "unit"}, {.name = "limit"}, {.name = "largest"}};
  t.rows = {{"speed", "m/s", c.limits.speed, c.peak.speed},
            {"acceleration", "m/s2", c.limits.acceleration, c.peak.acceleration},
            {"angular rate", "deg/s", to_degrees(c.limits.rate), to_degrees(c.peak.rate)},
            {"angular acceleration", "deg/s2", to_degrees(c.limits.angular_acceleration),
             to_degrees(c.peak.angular_acceleration)},
            {"rotors' range in use", "%", 100 * (1 - c.limits.rotor_headroom), 100 * c.peak.rotor_load}};
  if (c.leans) t.rows.push_back({"lean", "deg", to_degrees(c.limits.lean), to_degrees(c.peak.lean)});
  return t;
}

}  // namespace

Status write_plan_page(const Plan& plan, const Mission& mission, const vehicle::Vehicle& vehicle,
                       const std::filesystem::path& path) {
  const Certificate& c = plan.certificate;
  report::Page page("Plan of " + c.mission,
                    fmt::format("{}, {:.3f} kg, seed {}", c.vehicle, c.vehicle_mass, c.seed));
  page.verdict(report::Tone::ok,
               fmt::format("Certified: {:.1f} s, never nearer than {:.2f} m to anything in the map",
                           c.duration, c.min_clearance),
               fmt::format("{:.2f} m were asked; nearest at {:.1f} s. The rotors use up to {:.0f} % of their "
                           "range, at {:.1f} s.{}",
                           c.clearance_asked, c.min_clearance_at, 100 * c.peak.rotor_load,
                           c.peak.rotor_load_at, c.reason.empty() ? "" : "\n" + c.reason));
  page.facts({{"duration", fmt::format("{:.1f}", c.duration), "s"},
              {"least clearance", fmt::format("{:.3f}", c.min_clearance), "m"},
              {"largest speed", fmt::format("{:.2f}", c.peak.speed), "m/s"},
              {"tilt of the rotors",
               c.alpha_highest > c.alpha_lowest
                   ? fmt::format("{:.0f} to {:.0f}", to_degrees(c.alpha_lowest), to_degrees(c.alpha_highest))
                   : fmt::format("{:.0f}", to_degrees(c.alpha)),
               "deg"}});
  page.section("The way");
  if (auto ok = add_space(page, plan, mission, vehicle); !ok) return ok;
  add_path(page, plan);
  page.section("How near the limits").table(limits(c));
  add_curves(page, plan);
  page.section("What was checked");
  page.details(fmt::format("{} poses along the curve, and the files they were checked with", c.witnesses),
               fmt::format("mission {}\nsha256 {}\nvehicle {}\nsha256 {}\nmap {}\nsha256 {}", c.mission_file,
                           c.mission_sha256, c.vehicle_file, c.vehicle_sha256, c.map_file, c.map_sha256));
  return page.write(path);
}

}  // namespace omniflight::cli
