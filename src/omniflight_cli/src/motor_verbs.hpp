// Verbs about motors beside identify-motor.
#pragma once

#include "verbs.hpp"

namespace omniflight::cli {

Action add_thrust_curve(CLI::App& verb, Common& common);
Action add_tune_motor(CLI::App& verb, Common& common);
Action add_compare_runs(CLI::App& verb, Common& common);
Action add_motor_bench(CLI::App& verb, Common& common);

}  // namespace omniflight::cli
