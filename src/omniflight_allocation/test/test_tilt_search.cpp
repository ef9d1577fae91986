// The search for the tilt: its candidates, in lanes and one by one.
#include <gtest/gtest.h>

#include "counted_malloc.hpp"
#include "instruction_sets.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_core/random.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

AllocationInput random_input(Random& rng, double linear, double angular) {
  AllocationInput in;
  for (int i = 0; i < 6; ++i) in.qdd_ref[i] = (i < 3 ? linear : angular) * rng.normal();
  in.q_WB = exp_rotation(0.6 * Vec3(rng.normal(), rng.normal(), rng.normal()));
  return in;
}

AllocatorConfig searching(int candidates) {
  AllocatorConfig config = AllocatorConfig::case_b();
  config.input_unit = InputUnit::hz2;
  config.tilt_candidates = candidates;
  return config;
}

/// Vehicles with 8, 6 and 10 rotors: lanes of 8 and of 6, and more rotors than lanes have.
std::vector<vehicle::Vehicle> vehicles() {
  std::vector<vehicle::Vehicle> out(3, omnimorph());
  out[1].rotors.resize(6);
  out[2].rotors.push_back(out[2].rotors[0]);
  out[2].rotors.push_back(out[2].rotors[6]);
  out[2].rotors[8].p_BR *= 1.3;
  out[2].rotors[9].p_BR *= 0.6;
  out[0].rotors[2].tilt_axis_B = Vec3::UnitZ();  // a rotor that does not move: part of A is constant
  return out;
}

TEST(TiltSearch, TakesTheCheapestOfItsCandidates) {
  for (const vehicle::Vehicle& v : vehicles()) {
    for (const int candidates : {1, 2, 3, 5, 8}) {
      AllocatorConfig config = searching(candidates);
      auto search = Allocator::create(v, config).value();
      config.tilt_mode = TiltMode::fixed;
      auto fixed = Allocator::create(v, config).value();
      Random rng(5);
      double alpha = config.initial_tilt;
      int moved = 0;
      vehicle::RotorVector u = vehicle::RotorVector::Zero(v.rotor_count());
      for (int i = 0; i < 100; ++i) {
        AllocationInput in = random_input(rng, 4.0, 12.0);
        const auto found = search.allocate(in);
        ASSERT_TRUE(found) << found.error().text();
        ASSERT_LT(found->kkt_residual, 1e-12);
        double lowest = HUGE_VAL, step = config.tilt_step;
        for (int k = 0; k < candidates; ++k) {
          const double sign = k == 0 ? 0.0 : k % 2 == 1 ? -1.0 : 1.0;
          in.alpha = std::clamp(alpha + sign * step, v.tilt.min, v.tilt.max);
          if (k > 0 && k % 2 == 0) step *= 0.5;
          fixed.reset(alpha, &u);
          lowest = std::min(lowest, fixed.allocate(in).value().cost);
        }
        ASSERT_NEAR(found->cost, lowest, 1e-9 * lowest) << v.rotor_count() << " rotors, " << candidates;
        ASSERT_LE(std::abs(found->alpha - alpha), config.tilt_step * (1 + 1e-12));
        moved += found->alpha != alpha;
        alpha = found->alpha;
        u = found->u;
      }
      EXPECT_EQ(moved > 0, candidates > 1);
    }
  }
}

TEST(TiltSearch, EveryInstructionSetGivesTheSameBits) {
  const auto flown = [] {
    std::vector<double> out;
    for (const vehicle::Vehicle& v : vehicles()) {
      auto allocator = Allocator::create(v, searching(8)).value();
      Random rng(6);
      for (int i = 0; i < 200; ++i) {
        const Allocation a = allocator.allocate(random_input(rng, 4.0, 12.0)).value();
        out.insert(out.end(), a.u.begin(), a.u.end());
        out.insert(out.end(), {a.alpha, a.cost, static_cast<double>(a.iterations)});
      }
    }
    return out;
  };
  const std::vector<double> best = flown();
  const int sets =
      test::for_each_instruction_set([&](const char* name) { EXPECT_EQ(flown(), best) << name; });
  EXPECT_GE(sets, 1);
}

TEST(TiltSearch, AllocatesNoMemory) {
  if (!counted::works) GTEST_SKIP() << "a sanitizer owns malloc";
  auto a = Allocator::create(omnimorph(), searching(8)).value();
  Random rng(9);
  const long before = counted::allocations;
  double sum = 0;
  for (int i = 0; i < 500; ++i) sum += a.allocate(random_input(rng, 6.0, 10.0))->cost;
  EXPECT_EQ(counted::allocations, before);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(TiltSearch, RefusesCandidatesItHasNoLaneFor) {
  for (const int candidates : {0, -1, 9}) {
    const auto a = Allocator::create(omnimorph(), searching(candidates));
    ASSERT_FALSE(a);
    EXPECT_NE(a.error().text().find("tilt_candidates must be 1 to 8"), std::string::npos);
  }
}

}  // namespace
}  // namespace omniflight::allocation
