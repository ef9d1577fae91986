// Child processes, as the verbs name them.
#pragma once

#include "omniflight_jobs/child.hpp"

namespace omniflight::cli {

using jobs::Child;
using jobs::ChildOptions;

}  // namespace omniflight::cli
