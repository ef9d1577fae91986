// Only here is a number of the thesis typed. The places are those of the document; figures that print no
// number have no line.
#include "omniflight_reproduction/printed.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::reproduction {
namespace {

constexpr const char* kWholePercent =
    "printed in whole per cent, read off a set whose limit has two decimals";
constexpr const char* kLastDigit = "half a unit of the last printed digit";
constexpr const char* kFittedTorque = "one point: printed in whole per cent, spins and drag torque not given";
constexpr const char* kTracking =
    "a factor of two: neither gains nor speeds of the motion nor noise are printed";
constexpr const char* kPowerRatio = "5 points: printed as means over windows that are not given";
constexpr const char* kPower =
    "a factor of 1.15: inertia, speeds and the unit of the drag coefficient are not given";
constexpr const char* kScenario = "a factor of two: trajectory and attitude gains are not printed";

}  // namespace

const std::vector<Printed>& printed_numbers() {
  static const std::vector<Printed> table{
      {"4.1/mass", "total mass", "kg", 1.595, 5e-4, false, kLastDigit, "Table 4.1"},
      {"4.1/f_max", "largest thrust of a rotor", "N", 6.25, 0.005, false, kLastDigit, "Table 4.1"},
      {"4.1/efficiency", "thrust left at 0 deg of tilt", "%", 35, 1.5, false,
       "1.5 points: given as 34 %, as 35 %, lost in one place and left in another", "sections 5.3 and 6.1"},

      {"5.3/force_30", "uniformity of forces at 30 deg", "%", 41, 1, false, kWholePercent, "Figure 5.3"},
      {"5.3/force_45", "uniformity of forces at 45 deg", "%", 70, 1, false, kWholePercent, "Figure 5.3"},
      {"5.3/force_55", "uniformity of forces at 54.73 deg", "%", 87, 1, false, kWholePercent, "Figure 5.3"},
      {"5.3/force_omnicopter", "uniformity of forces, omnicopter", "%", 87, 1, false, kWholePercent,
       "section 5.2"},
      {"5.4/torque_30", "uniformity of torques at 30 deg", "%", 44, 1, false, kFittedTorque, "section 5.2"},
      {"5.4/torque_45", "uniformity of torques at 45 deg", "%", 62, 1, false, kFittedTorque, "section 5.2"},
      {"5.4/torque_55", "uniformity of torques at 54.73 deg", "%", 65, 1, false, kFittedTorque,
       "section 5.2"},
      {"5.4/torque_omnicopter", "uniformity of torques, omnicopter", "%", 74, 1, false, kFittedTorque,
       "section 5.2"},
      {"5.5/orthogonal", "largest |n.p|/|p| at 45 deg", "", 0, 1e-9, false,
       "the text says orthogonal; rounding of doubles", "section 5.2"},
      {"5.6/equivalent", "tilt at which OmniMorph is an omnicopter", "deg", 54.73, 0.01, false,
       "the last printed digit", "section 5.2"},
      {"5.7/inradius", "force in the weakest direction at 54.73 deg", "N", 19.4, 0.05, false, kLastDigit,
       "section 5.2"},
      {"5.7/inradius_omnicopter", "force in the weakest direction, omnicopter", "N", 19.4, 0.05, false,
       kLastDigit, "section 5.2"},
      {"5.7/mass_30", "mass that hovers in every attitude at 30 deg", "g", 1213, 0.5, false, kLastDigit,
       "section 5.2"},
      {"5.7/omnidirectional", "first whole degree at which it hovers in every attitude", "deg", 42, 0, false,
       "printed as 'about 42': a whole degree", "section 5.2"},
      {"5.8/torque", "torque in the weakest direction, omnicopter", "Nm", 3.4, 0.05, false, kLastDigit,
       "section 5.2"},
      {"5.8/less", "torque of OmniMorph at 54.73 deg against the omnicopter's", "%", -6, 0.5, false,
       kLastDigit, "section 5.2"},

      {"6.2/mean_error", "mean position error, case A under the mismatch", "m", 0.011, 2, true, kScenario,
       "section 6.2"},
      {"6.1/survives_a", "case A with the right model survives (1 yes)", "", 1, 0, false, "yes or no",
       "section 6.2"},
      {"6.1/survives_b", "case B with the right model survives (1 yes)", "", 1, 0, false, "yes or no",
       "section 6.2"},
      {"6.2/survives_a", "case A under the mismatch survives (1 yes)", "", 1, 0, false, "yes or no",
       "section 6.2"},
      {"6.3/survives_b", "case B under the constant mismatch survives (1 yes)", "", 0, 0, false, "yes or no",
       "Figure 6.3"},
      {"6.3/survives_a", "case A under the constant mismatch survives (1 yes)", "", 1, 0, false, "yes or no",
       "Figure 6.3"},
      {"6.4/survives_b", "case B under the mismatch over the tilt survives (1 yes)", "", 0, 0, false,
       "yes or no", "section 6.2"},
      {"6.4/survives_dynamic", "case B with dynamic weights survives (1 yes)", "", 1, 0, false, "yes or no",
       "section 6.2"},

      {"7.1/t1/sim/x", "T1 simulated, RMSE x", "m", 0.002, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/sim/y", "T1 simulated, RMSE y", "m", 0.005, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/sim/z", "T1 simulated, RMSE z", "m", 0.011, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/sim/roll", "T1 simulated, RMSE roll", "deg", 0.010, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/sim/pitch", "T1 simulated, RMSE pitch", "deg", 0.011, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/sim/yaw", "T1 simulated, RMSE yaw", "deg", 0.011, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/real/x", "T1 real, RMSE x", "m", 0.049, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/real/y", "T1 real, RMSE y", "m", 0.070, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/real/z", "T1 real, RMSE z", "m", 0.013, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/real/roll", "T1 real, RMSE roll", "deg", 0.024, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/real/pitch", "T1 real, RMSE pitch", "deg", 0.021, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/real/yaw", "T1 real, RMSE yaw", "deg", 0.68, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/sim/x", "T2 simulated, RMSE x", "m", 0.003, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/sim/y", "T2 simulated, RMSE y", "m", 0.020, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/sim/z", "T2 simulated, RMSE z", "m", 0.004, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/sim/roll", "T2 simulated, RMSE roll", "deg", 0.015, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/sim/pitch", "T2 simulated, RMSE pitch", "deg", 0.015, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/sim/yaw", "T2 simulated, RMSE yaw", "deg", 0.018, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/real/x", "T2 real, RMSE x", "m", 0.11, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/real/y", "T2 real, RMSE y", "m", 0.26, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/real/z", "T2 real, RMSE z", "m", 0.20, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/real/roll", "T2 real, RMSE roll", "deg", 0.12, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/real/pitch", "T2 real, RMSE pitch", "deg", 0.059, 2, true, kTracking, "Table 7.1"},
      {"7.1/t2/real/yaw", "T2 real, RMSE yaw", "deg", 1.49, 2, true, kTracking, "Table 7.1"},
      {"7.1/t1/sim/power", "T1 simulated, mean power as printed", "W", 24.73, 1.15, true, kPower,
       "Table 7.1"},
      {"7.1/t2/sim/power", "T2 simulated, mean power as printed", "W", 25.36, 1.15, true, kPower,
       "Table 7.1"},
      {"7.1/t1/real/power", "T1 real, mean power as printed", "W", 32.97, 1.15, true, kPower, "Table 7.1"},
      {"7.1/t2/real/power", "T2 real, mean power as printed", "W", 41.06, 1.15, true, kPower, "Table 7.1"},
      {"7.1/t1/more", "T1, power of real over simulated", "%", 33.4, 5, false, kPowerRatio, "Table 7.1"},
      {"7.1/t2/more", "T2, power of real over simulated", "%", 61.9, 5, false, kPowerRatio, "Table 7.1"},

      {"A.2/force_30", "uniformity of forces at 30 deg", "%", 35, 1, false, kWholePercent, "Figure A.2"},
      {"A.2/force_45", "uniformity of forces at 45 deg", "%", 60, 1, false, kWholePercent, "Figure A.2"},
      {"A.2/force_55", "uniformity of forces at 54.73 deg", "%", 75, 1, false, kWholePercent, "Figure A.2"},
      {"A.3/torque_30", "uniformity of torques at 30 deg", "%", 44, 1, false, kWholePercent, "Figure A.3"},
      {"A.3/torque_45", "uniformity of torques at 45 deg", "%", 60, 1, false, kWholePercent, "Figure A.3"},
      {"A.3/torque_55", "uniformity of torques at 54.73 deg", "%", 58, 1, false, kWholePercent, "Figure A.3"},
      {"A.4/inradius_50", "force in the weakest direction at 50 deg", "N", 18.67, 0.005, false, kLastDigit,
       "Figure A.4"},
  };
  return table;
}

const Printed* find_printed(std::string_view key) {
  const auto& table = printed_numbers();
  const auto at = std::find_if(table.begin(), table.end(), [&](const Printed& p) { return key == p.key; });
  return at == table.end() ? nullptr : &*at;
}

bool agrees(const Printed& printed, double ours) {
  if (!std::isfinite(ours)) return false;
  if (!printed.factor) return std::abs(ours - printed.value) <= printed.tolerance;
  return ours > 0 && std::max(ours / printed.value, printed.value / ours) <= printed.tolerance;
}

}  // namespace omniflight::reproduction
