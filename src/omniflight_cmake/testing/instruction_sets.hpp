// Runs code that Highway dispatches once with every instruction set of the processor and the build.
#pragma once

#include <hwy/targets.h>

#include <cstdint>

namespace omniflight::test {

/// check(name of the instruction set) with only that set allowed; afterwards all are. Returns how many there
/// were.
template <class Check>
int for_each_instruction_set(Check check) {
  int sets = 0;
  for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1, ++sets) {
    const std::int64_t target = left & -left;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    check(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return sets;
}

}  // namespace omniflight::test
