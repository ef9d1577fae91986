#include "flown_plan.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "omniflight_components/replanning_message.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/replan.hpp"

namespace omniflight::cli {

Result<FlownPlan> flown_plan(const Setup& s) {
  FlownPlan out{s.plan, s.mission, s.after, {}};
  for (int k = 1;; ++k) {
    const auto folder = s.out / kReplans / std::to_string(k);
    if (!std::filesystem::exists(folder / components::kJoinFile)) break;
    const auto text = files::read_file(folder / components::kJoinFile, 100);
    if (!text) return Failure(text.error());
    const double join = std::strtod(text->c_str(), nullptr);
    auto next = planning::read_plan(folder);
    if (!next) return Failure(next.error());
    auto mission = planning::load_mission(next->certificate.mission_file);
    if (!mission) return Failure(mission.error());
    auto whole = planning::joined(out.plan.trajectory, join, next->trajectory);
    if (!whole) return Failure(whole.error());
    out.remarks.push_back(fmt::format("{} was flown from {:.1f} s of the plan on ({}/{})",
                                      next->certificate.mission, join, kReplans, k));
    out.plan = {std::move(*whole), next->certificate, {}};
    out.mission = std::move(*mission);
  }
  out.after -= out.plan.trajectory.duration() - s.plan.trajectory.duration();
  return out;
}

}  // namespace omniflight::cli
