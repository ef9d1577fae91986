// Weights and limits that cannot be flown are refused by name, before an allocator exists.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "omniflight_allocation/allocator.hpp"
#include "omnimorph.hpp"

namespace omniflight::allocation {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity(),
                 kNaN = std::numeric_limits<double>::quiet_NaN();

void expect_refused(const AllocatorConfig& config, const std::string& field) {
  const Status status = validate(config);
  ASSERT_FALSE(status) << field;
  EXPECT_EQ(status.error().code, ErrorCode::bad_input);
  EXPECT_EQ(status.error().where, "allocator." + field);
  EXPECT_NE(status.error().message.find(field), std::string::npos) << status.error().message;
}

TEST(AllocatorConfig, ShippedOnesAreAccepted) {
  for (AllocatorConfig config : {AllocatorConfig(), AllocatorConfig::case_a(), AllocatorConfig::case_b()}) {
    EXPECT_TRUE(validate(config));
    config.dynamic_weights.enabled = true;
    EXPECT_TRUE(validate(config));
    config.w_rate = 0;  // one of the two makes the inputs unique
    EXPECT_TRUE(validate(config));
  }
}

TEST(AllocatorConfig, EachFieldOutOfItsRangeIsRefusedByName) {
  const struct {
    const char* field;
    double AllocatorConfig::*member;
    std::vector<double> bad;
  } numbers[] = {
      {"w_input", &AllocatorConfig::w_input, {-1e-9, kNaN, kInf}},
      {"w_rate", &AllocatorConfig::w_rate, {-1e-9, kNaN, kInf}},
      {"w_linear", &AllocatorConfig::w_linear, {0, -1, kNaN, kInf}},
      {"w_angular", &AllocatorConfig::w_angular, {0, -1, kNaN, kInf}},
      {"tilt_step", &AllocatorConfig::tilt_step, {-1e-9, kNaN, kInf}},
      {"initial_tilt", &AllocatorConfig::initial_tilt, {kNaN, kInf, -kInf}},
      {"mass", &AllocatorConfig::mass, {-1, kNaN, kInf}},
  };
  for (const auto& n : numbers)
    for (const double bad : n.bad) {
      AllocatorConfig config;
      config.*n.member = bad;
      expect_refused(config, n.field);
    }
  AllocatorConfig config;
  config.w_input = config.w_rate = 0;
  expect_refused(config, "w_input");
  for (const int bad : {0, -1, 9}) {
    config = {};
    config.tilt_candidates = bad;
    expect_refused(config, "tilt_candidates");
  }
  config = {};
  config.inertia(1, 1) = kNaN;
  expect_refused(config, "inertia");
}

TEST(AllocatorConfig, DynamicWeightsAreJudgedWhereTheyAreOn) {
  const struct {
    const char* field;
    double DynamicWeights::*member;
    std::vector<double> bad;
  } numbers[] = {
      {"dynamic_weights.threshold", &DynamicWeights::threshold, {-1e-9, kNaN, kInf}},
      {"dynamic_weights.growth", &DynamicWeights::growth, {0.999, kNaN, kInf}},
      {"dynamic_weights.shrink", &DynamicWeights::shrink, {0, -1, 1.001, kNaN}},
      {"dynamic_weights.floor", &DynamicWeights::floor, {0, -1, kNaN, kInf}},
      {"dynamic_weights.floor", &DynamicWeights::ceiling, {0, kNaN, kInf}},
  };
  for (const auto& n : numbers)
    for (const double bad : n.bad) {
      AllocatorConfig config;
      config.dynamic_weights.*n.member = bad;
      EXPECT_TRUE(validate(config)) << n.field << " is not used";
      config.dynamic_weights.enabled = true;
      expect_refused(config, n.field);
    }
}

TEST(AllocatorConfig, AnInertiaOfNoBodyIsRefusedAndABelievedOneIsUsed) {
  AllocatorConfig config;
  config.inertia = Vec3(1, 1, -1).asDiagonal();
  const auto refused = Allocator::create(omnimorph(), config);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "allocator.inertia");
  // the same demand of twice the inertia asks for twice the torque
  config = {};
  config.tilt_mode = TiltMode::fixed;
  AllocationInput in;
  in.qdd_ref.tail<3>() = Vec3(0.1, 0, 0);
  const auto torque = [&](double times) {
    config.inertia = times * omnimorph().inertia;
    auto allocator = Allocator::create(omnimorph(), config);
    const auto found = allocator.value().allocate(in);
    return (omnimorph().allocation_matrix(to_radians(30)) * found.value().u)[3];
  };
  EXPECT_NEAR(torque(2.0), 2.0 * torque(1.0), 1e-3 * torque(1.0));
}

}  // namespace
}  // namespace omniflight::allocation
