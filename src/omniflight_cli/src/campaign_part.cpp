// A part of a campaign without a bus: read, flown, written.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <ctime>

#include "campaign_many.hpp"
#include "flight_setup.hpp"
#include "omniflight_components/loop_parameters.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::cli {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "omniflight.campaign_part/1";
constexpr std::size_t kLargest = 256 * files::kMegabyte;

/// The loop that the components of this flight would close.
Result<campaign::Loop> loop_of(const std::string& folder, const components::LoopParameters& p) {
  auto plan = planning::read_plan(folder);
  if (!plan) return Failure(plan.error());
  campaign::Loop loop;
  loop.vehicle = p.vehicle;
  loop.believed = p.allocator.vehicle;
  loop.plant = p.plant;
  loop.control_period = p.control_period;
  loop.hold = p.hold;
  loop.settle = p.settle;
  loop.duration = p.duration;
  loop.law = p.law.name;
  loop.anti_windup = p.law.anti_windup;
  loop.allocator = p.allocator.config;
  loop.trajectory = std::move(plan->trajectory);
  loop.schedule = p.allocator.schedule;
  // a tilt that the allocator searches is not the plan's, and neither is one that stays
  loop.follow_plan = p.allocator.follow_plan;
  return loop;
}

struct Bounds {
  planning::Tube tube;
  bool headroom = false;  ///< the mission keeps some
};

/// As judge_flight() judges, without the map: whoever stays within its tracking bounds keeps clear by the
/// plan's certificate.
std::string verdict_of(const campaign::FlightFigures& f, const Bounds& bounds) {
  if (f.ended_early || !(f.position_rmse.norm() < kLeftReference) ||
      !(to_degrees(f.attitude_rmse.norm()) < kTurnedAway) || f.end_error > kLeftReference)
    return kLost;
  const bool kept = f.end_error <= bounds.tube.position && f.worst_position <= bounds.tube.position &&
                    f.worst_attitude <= bounds.tube.attitude &&
                    !(bounds.headroom && f.share_at_limit > kMostAtLimit);
  return kept ? kFlown : kFlownBadly;
}

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

std::string Part::name(const Campaign& campaign) const {
  return fmt::format("{}-{:07}-{}", campaign.groups[group].name, first, count);
}
std::string Part::spec() const { return fmt::format("{}:{}:{}", group, first, count); }

Result<Part> part_from(const std::string& spec, const Campaign& campaign) {
  Part part;
  std::size_t* const places[] = {&part.group, &part.first, &part.count};
  const char *at = spec.data(), *const end = spec.data() + spec.size();
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [stop, error] = std::from_chars(at, end, *places[k]);
    if (error != std::errc() || (k < 2 ? stop == end || *stop != ':' : stop != end))
      return bad_input("is not GROUP:FIRST:COUNT", "--part " + spec);
    at = k < 2 ? stop + 1 : stop;
  }
  if (part.group >= campaign.groups.size() || part.first >= campaign.seeds.size() ||
      part.count > campaign.seeds.size() - part.first)
    return bad_input("is none of this campaign's", "--part " + spec,
                     "The campaign's file has changed; --resume it");
  return part;
}

Result<int> fly_part(const CampaignOptions& o, const Common& common) {
  const auto campaign = load_campaign(o.file, Flying::in_process);
  if (!campaign) return Failure(campaign.error());
  const auto part = part_from(o.part, *campaign);
  if (!part) return Failure(part.error());
  const Case& group = campaign->groups[part->group];
  const std::string folder = o.plans + "/" + group.name;
  auto inputs = files::read_file(folder + "/inputs.sha256", 1000);
  if (!inputs) return Failure(inputs.error());
  auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  const auto p = components::read_loop_parameters(
      {(*configs / "components" / "default.yaml").string(), folder + "/params.yaml"});
  if (!p) return Failure(p.error());
  const auto loop = loop_of(folder, *p);
  if (!loop) return Failure(loop.error());
  const auto mission = planning::load_mission(group.options.mission);
  if (!mission) return Failure(mission.error());
  const Bounds bounds{planning::tube_of(*mission, p->vehicle), mission->limits.rotor_headroom > 0};

  std::vector<campaign::OneFlight> flights;
  PartResult result{*inputs, 0, loop->duration, {}};
  for (std::size_t k = 0; k < part->count; ++k) {
    ManyFlight one;
    one.group = part->group;
    one.seed = campaign->seeds[part->first + k];
    one.drawn = campaign::draw(campaign->varied, one.seed);
    campaign::OneFlight flight{campaign::with_values(p->model, campaign->varied, one.drawn),
                               campaign::start_with(p->plant.initial, campaign->varied, one.drawn),
                               p->law.config, one.seed};
    flight.law.gains = campaign::gains_with(p->law.config.gains, campaign->varied, one.drawn);
    flights.push_back(std::move(flight));
    result.flights.push_back(std::move(one));
  }
  const auto figures = campaign::fly_many(*loop, flights, interrupted);
  if (!figures) return Failure(figures.error());
  for (std::size_t k = 0; k < figures->size(); ++k) {
    const campaign::FlightFigures& f = (*figures)[k];
    ManyFlight& one = result.flights[k];
    one.verdict = verdict_of(f, bounds);
    one.position_rmse = f.position_rmse.norm();
    one.worst_position = f.worst_position;
    one.attitude_rmse_deg = to_degrees(f.attitude_rmse.norm());
    one.power_W = f.mean_power;
    one.least_headroom = f.least_headroom;
    one.lost_at_s = f.ended_early.value_or(0.0);
  }
  result.cpu_s = cpu_seconds();
  if (auto ok = files::write_file_atomic(common.out + "/part.json", to_text(result)); !ok)
    return Failure(ok.error());
  return 0;
}

std::string to_text(const PartResult& part) {
  json j{{"schema", kSchema},
         {"inputs_sha256", part.inputs},
         {"cpu_s", part.cpu_s},
         {"simulated_s", part.simulated_s},
         {"flights", json::array()}};
  for (const ManyFlight& f : part.flights)
    j["flights"].push_back({{"group", f.group},
                            {"seed", f.seed},
                            {"drawn", f.drawn},
                            {"verdict", f.verdict},
                            {"position_rmse_m", f.position_rmse},
                            {"worst_position_m", f.worst_position},
                            {"attitude_rmse_deg", f.attitude_rmse_deg},
                            {"power_W", f.power_W},
                            {"least_headroom", f.least_headroom},
                            {"lost_at_s", f.lost_at_s}});
  return j.dump() + "\n";
}

Result<PartResult> read_part(const std::string& file) {
  auto text = files::read_file(file, kLargest);
  if (!text) return Failure(text.error());
  const json j = json::parse(*text, nullptr, false);
  if (!j.is_object() || j.value("schema", json()) != kSchema)
    return bad_input("is no part of a campaign", file, "Remove its folder; it is flown again");
  PartResult out;
  try {  // the library reports a wrong type by an exception
    out.inputs = j.at("inputs_sha256").get<std::string>();
    out.cpu_s = j.at("cpu_s").get<double>();
    out.simulated_s = j.at("simulated_s").get<double>();
    for (const json& f : j.at("flights")) {
      ManyFlight one;
      one.group = f.at("group").get<std::size_t>();
      one.seed = f.at("seed").get<std::uint64_t>();
      one.drawn = f.at("drawn").get<std::vector<double>>();
      one.verdict = f.at("verdict").get<std::string>();
      one.position_rmse = f.at("position_rmse_m").get<double>();
      one.worst_position = f.at("worst_position_m").get<double>();
      one.attitude_rmse_deg = f.at("attitude_rmse_deg").get<double>();
      one.power_W = f.at("power_W").get<double>();
      one.least_headroom = f.at("least_headroom").get<double>();
      one.lost_at_s = f.at("lost_at_s").get<double>();
      out.flights.push_back(std::move(one));
    }
  } catch (const json::exception& e) {
    return bad_input(std::string("is damaged: ") + e.what(), file, "Remove its folder; it is flown again");
  }
  return out;
}

}  // namespace omniflight::cli
