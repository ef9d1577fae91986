// Thrust and torque curves from sweeps of known rotors (synthetic), and hostile tables.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "omniflight_core/random.hpp"
#include "omniflight_identification/thrust_curve.hpp"

namespace omniflight::identification {
namespace {

constexpr double kScale = 3.0e-8, kExponent = 2.1, kOffset = 0.004, kKappa = 0.006;

std::string sweep(Random& random, int rows, double noise_N, const char* header, int rotors, bool torque) {
  std::string out = std::string(header) + "\n";
  char cell[64];
  for (int k = 0; k < rows; ++k) {
    const double level = 300.0 + 2200.0 * k / (rows - 1);
    double thrust = kOffset, moment = 0;
    for (int i = 0; i < rotors; ++i) {
      const double speed = level * (1 + 0.02 * i);
      thrust += kScale * std::pow(speed, kExponent);
      moment += kKappa * kScale * std::pow(speed, kExponent);
      std::snprintf(cell, sizeof cell, "%.9g,", speed * 30 / 3.14159265358979);
      out += cell;
    }
    std::snprintf(cell, sizeof cell, "%.9g", (thrust + noise_N * random.normal()) / 9.80665e-3);
    out += cell;
    if (torque) {
      std::snprintf(cell, sizeof cell, ",%.9g", moment + kKappa * noise_N * random.normal());
      out += cell;
    }
    out += "\n";
  }
  return out;
}

TEST(ThrustCurve, ScaleExponentAndOffsetLieWithinTheirIntervals) {
  int within = 0;
  for (int draw = 0; draw < 100; ++draw) {
    Random random(static_cast<std::uint64_t>(draw) + 1, "sweep");
    const auto data =
        read_sweep(sweep(random, 200, 0.004, "rpm1,rpm2,rpm3,rpm4,thrust[g],torque (Nm)", 4, true), "s.csv");
    ASSERT_TRUE(data) << data.error().text();
    const auto curves = fit_thrust_curves({*data});
    ASSERT_TRUE(curves) << curves.error().text();
    const auto near = [](const Estimate& e, double truth) {
      return std::abs(e.value - truth) <= 3 * e.sigma;
    };
    within += near(curves->thrust.exponent, kExponent) && near(curves->thrust.scale, kScale) &&
              near(curves->thrust.offset, kOffset) && near(curves->torque.exponent, kExponent);
    EXPECT_NEAR(curves->thrust.exponent.value, kExponent, 0.05);
    EXPECT_NEAR(curves->drag_ratio.value, kKappa, 0.03 * kKappa);
    EXPECT_LT(curves->thrust.exponent.sigma, 0.02);
  }
  EXPECT_GE(within, 95);
}

TEST(ThrustCurve, UnitsAndSeparatorsAreThoseOfTheHeader) {
  const std::string newtons =
      "\xef\xbb\xbfTime (s);Torque (N\xc2\xb7m);Thrust (N);Motor Electrical Speed (RPM)\n"
      "0;-0.1;-1;3000\n1;-0.15;-1.5;3700\n2;-0.2;-2;4243\n3;-0.3;-3;5196\n4;-0.4;-4;6000\n5;;;\n";
  const auto sweep = read_sweep(newtons, "s.csv");
  ASSERT_TRUE(sweep) << sweep.error().text();
  EXPECT_EQ(sweep->thrust_N.size(), 5);
  EXPECT_EQ(sweep->dropped, 1);
  EXPECT_DOUBLE_EQ(sweep->thrust_N[4], 4.0);
  EXPECT_DOUBLE_EQ(sweep->torque_Nm[4], 0.4);
  EXPECT_NEAR(sweep->speed_radps(0, 0), 314.159, 1e-3);
  EXPECT_EQ(sweep->time_s.size(), 5);
  const auto curves = fit_thrust_curves({*sweep});
  ASSERT_TRUE(curves) << curves.error().text();
  EXPECT_NEAR(curves->thrust.coefficient.value, 1.0 / (314.159 * 314.159), 2e-7);
  EXPECT_NEAR(curves->drag_ratio.value, 0.1, 1e-3);
}

TEST(ThrustCurve, RefusesWithFileColumnAndNextStep) {
  const auto refused = [](const std::string& text, const char* word) {
    const auto data = read_sweep(text, "s.csv");
    ASSERT_FALSE(data);
    EXPECT_NE(data.error().text().find(word), std::string::npos) << data.error().text();
    EXPECT_NE(data.error().text().find("s.csv"), std::string::npos) << data.error().text();
    EXPECT_FALSE(data.error().next_step.empty());
  };
  refused("", "speed");
  refused("pwm,weight[g]\n1,2\n", "speed");
  refused("rpm,pwm\n1,2\n", "thrust");
  refused("rpm,weight\n1000,2\n", "no unit");
  refused("rpm,thrust[lb]\n1000,2\n", "no force");
  refused("rpm,thrust[g]\n1000,x\n2000,nan\n3000,\n", "0 usable rows");
  refused("rpm1,rpm2,thrust[g]\n1000,0,5\n2000,0,9\n3000,0,20\n4000,0,30\n5000,0,50\n6000,0,80\n",
          "differ by more");
  EXPECT_TRUE(
      read_sweep("rpm,weight\n1000,2\n2000,8\n3000,18\n4000,32\n5000,50\n", "s.csv", {.thrust_unit = "g"}));
  const auto flat = read_sweep("rpm,thrust[g]\n5000,1\n5010,2\n5020,3\n5030,4\n5040,5\n", "s.csv");
  ASSERT_TRUE(flat);
  const auto curves = fit_thrust_curves({*flat});
  ASSERT_FALSE(curves);
  EXPECT_NE(curves.error().text().find("span"), std::string::npos);
}

TEST(ThrustCurve, DamagedTablesAreReadOrRefusedButNothingElse) {
  Random random(7);
  const std::string whole = sweep(random, 60, 0.004, "rpm1,rpm2,thrust[g]", 2, false);
  for (int k = 0; k < 400; ++k) {
    std::string text =
        whole.substr(0, static_cast<std::size_t>(random.uniform(0, static_cast<double>(whole.size()))));
    for (int flips = 0; flips < 4 && !text.empty(); ++flips)
      text[static_cast<std::size_t>(random.uniform(0, static_cast<double>(text.size())))] ^=
          static_cast<char>(1 << static_cast<int>(random.uniform(0, 8)));
    const auto data = read_sweep(text, "s.csv");
    if (!data) {
      EXPECT_EQ(data.error().code, ErrorCode::bad_input);
      continue;
    }
    EXPECT_TRUE(data->speed_radps.allFinite() && data->thrust_N.allFinite());
    const auto curves = fit_thrust_curves({*data});
    EXPECT_TRUE(curves || curves.error().code == ErrorCode::bad_input);
  }
}

Result<ThrustCurves> real(const char* file, const char* unit = "") {
  const char* data = std::getenv("OMNIFLIGHT_REAL_DATA");
  std::ifstream in(std::filesystem::path(data) / "bench" / file);
  std::stringstream text;
  text << in.rdbuf();
  const auto sweep = read_sweep(text.str(), file, {.thrust_unit = unit});
  if (!sweep) return Failure(sweep.error());
  return fit_thrust_curves({*sweep});
}

TEST(ThrustCurve, RealStands) {
  const char* data = std::getenv("OMNIFLIGHT_REAL_DATA");
  if (data == nullptr || !std::filesystem::exists(std::filesystem::path(data) / "bench"))
    GTEST_SKIP() << "no bench data (OMNIFLIGHT_REAL_DATA)";
  struct Known {
    const char *file, *unit;
    double coefficient, within;
  };
  for (const Known& k : {Known{"crazyflie_thrust_stand/cf21_eckart1_data.csv", "g", 2.02e-8, 0.06},
                         {"crazyflie_thrust_stand/cf21_bitcraze2021_cf21_stock2.csv", "", 1.90e-8, 0.06},
                         {"crazyflie_thrust_stand/cf21bl_guards_feb25_2026_0.csv", "", 3.91e-8, 0.06},
                         {"xnova_thrust_stand/single_rotor/xNova-SR-steps.csv", "", 9.1e-6, 0.06},
                         {"xnova_thrust_stand/multirotor/xNova-MR-steps.csv", "", 9.3e-6, 0.06}}) {
    const auto curves = real(k.file, k.unit);
    ASSERT_TRUE(curves) << curves.error().text();
    EXPECT_NEAR(curves->thrust.coefficient.value, k.coefficient, k.within * k.coefficient) << k.file;
    // nothing tells the exponents of these; momentum theory says 2, Reynolds numbers and a stand's offset add
    // to it
    EXPECT_GT(curves->thrust.exponent.value, 1.8) << k.file;
    EXPECT_LT(curves->thrust.exponent.value, 2.4) << k.file;
    EXPECT_LT(curves->thrust.exponent.sigma, 0.1) << k.file;
  }
  EXPECT_TRUE(real("xnova_thrust_stand/single_rotor/xNova-SR-steps.csv")->has_torque);
}

}  // namespace
}  // namespace omniflight::identification
