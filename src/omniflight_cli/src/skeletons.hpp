// What `omniflight new` writes: the smallest file of each kind that loads, compiles and passes the tests.
#pragma once

#include <string>

namespace omniflight::cli {

/// A linear drag under a new name: equation, parameters and wrench to be replaced.
std::string effect_skeleton(const std::string& id);
/// A quadrotor of 1 kg.
std::string vehicle_skeleton(const std::string& name);
/// Up by 0.2 m and to the side in the test bed `pyramid`.
std::string mission_skeleton(const std::string& name);

}  // namespace omniflight::cli
