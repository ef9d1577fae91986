#include "effect_testing.hpp"

namespace omniflight::physics::testing {
namespace {

constexpr const char* kId = "attachment_torque";

TEST(AttachmentTorque, IsTheHandFormulaInEveryFrame) {
  for (const Situation& s : six_states()) {
    const Vec3 weight = Vec3(0, 0, -kGravity) * std::max(0.0, s.body.p_WB.z() - 0.4);
    const Vec3 q(0.004, -0.003, -0.02);
    Vec6 expected;
    expected << Vec3::Zero(), s.R_WB.transpose() * (s.R_WB * q).cross(weight);
    EXPECT_LT((wrench_of(kId, s, {q.x(), q.y(), q.z(), 0.4}) - expected).norm(), 1e-12);
    EXPECT_EQ(wrench_of(kId, s, neutral_of(kId)).norm(), 0.0);
  }
}

TEST(AttachmentTorque, IsTheTorqueOfAHungCableAtItsAttachment) {
  const Situation s = six_states()[1];
  const Vec3 arm(0.05, 0.02, -0.1);
  const Vec3 weight = wrench_of("hung_cable",
                                [&] {
                                  Situation still = s;
                                  still.a_WB_B.setZero();
                                  still.body.v_WB_W.setZero();  // weight alone, nothing is being lifted
                                  return still;
                                }(),
                                {0.2, 0.3, 5.0})
                          .head<3>();
  const Vec6 w = wrench_of(kId, s, {0.2 * arm.x(), 0.2 * arm.y(), 0.2 * arm.z(), 0.3});
  EXPECT_LT((w.tail<3>() - arm.cross(weight)).norm(), 1e-12);
}

TEST(AttachmentTorque, UprightsAVehicleThatHangsItsCableLow) {
  RigidState rolled;
  rolled.p_WB.z() = 1.0;
  rolled.q_WB = exp_rotation(Vec3(0.3, 0, 0));
  const Situation s = situation(cube(), rolled, 0, std::vector<double>(8, 700.0));
  EXPECT_LT(wrench_of(kId, s, {0, 0, -0.01, 0})[3], 0.0);
}

}  // namespace
}  // namespace omniflight::physics::testing
