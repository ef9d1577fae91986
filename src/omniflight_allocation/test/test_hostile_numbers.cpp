// Whatever numbers come, the allocation is refused or finite and within the rotors' limits, and the next
// sound one is as good as before.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "hostile_numbers.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_core/random.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

using hostile::any_number;
using hostile::samples;

TEST(HostileNumbers, AreRefusedOrAllocatedWithinTheLimits) {
  const vehicle::Vehicle v = omnimorph();
  AllocatorConfig config = AllocatorConfig::case_b();
  config.tilt_mode = TiltMode::search;
  Allocator allocator = Allocator::create(v, config).value();
  Random random(3);
  long refused = 0, unsound = 0;
  for (long k = 0; k < samples(); ++k) {
    AllocationInput in;
    for (int i = 0; i < 6; ++i) in.qdd_ref[i] = any_number(random);
    for (int i = 0; i < 3; ++i) in.w_WB_B[i] = 0.1 * any_number(random);
    if (random.uniform() < 0.5)
      in.q_WB = Quat(any_number(random), any_number(random), any_number(random), any_number(random));
    in.position_error = any_number(random);
    const auto out = allocator.allocate(in);
    if (!out) {
      ++refused;
      continue;
    }
    bool sound = out->u.size() == v.rotor_count() && out->u.allFinite() && out->speed.allFinite() &&
                 std::isfinite(out->alpha) && out->alpha >= v.tilt.min - 1e-9 &&
                 out->alpha <= v.tilt.max + 1e-9;
    for (int i = 0; sound && i < v.rotor_count(); ++i) {
      const auto& rotor = v.rotors[static_cast<std::size_t>(i)];
      sound = out->u[i] <= rotor.max_thrust * (1 + 1e-9) &&
              std::abs(out->speed[i]) <= rotor.max_speed() * (1 + 1e-9);
    }
    unsound += !sound;
  }
  std::printf("%ld hostile inputs to the allocator: %ld refused, %ld outside of the limits\n", samples(),
              refused, unsound);
  EXPECT_EQ(unsound, 0);
  EXPECT_GT(refused, samples() / 10);
  EXPECT_LT(refused, samples() * 99 / 100);
}

}  // namespace
}  // namespace omniflight::allocation
