// Chooses the lanes of lane_kernel-inl.hpp by the processor at run time.
#include "lanes.hpp"

#define HWY_DISABLED_TARGETS HWY_SSSE3  // as there
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lane_dispatch.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"

namespace omniflight::simulation::lanes::HWY_NAMESPACE {
void Run(const Common& c, Block& b, const Trains& trains, int steps, bool held);
std::string Name();
}  // namespace omniflight::simulation::lanes::HWY_NAMESPACE

#if HWY_ONCE
namespace omniflight::simulation::lanes {

HWY_EXPORT(Run);
HWY_EXPORT(Name);

void run(const Common& common, Block& block, const Trains& trains, int steps, bool held) {
  HWY_DYNAMIC_DISPATCH(Run)(common, block, trains, steps, held);
}

std::string instruction_set() { return HWY_DYNAMIC_DISPATCH(Name)(); }

}  // namespace omniflight::simulation::lanes
#endif
