// The page that `plan` writes: whether the plan holds, how near it comes to map and limits, and where.
#pragma once

#include <filesystem>

#include "omniflight_planning/plan.hpp"

namespace omniflight::cli {

/// A page of a plan that was certified, with the figures of its knots as far as the plan has them.
Status write_plan_page(const planning::Plan& plan, const planning::Mission& mission,
                       const vehicle::Vehicle& vehicle, const std::filesystem::path& path);

}  // namespace omniflight::cli
