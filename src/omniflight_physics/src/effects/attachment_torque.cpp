// A hung cable that is not fixed at the centre of mass: the torque grows with the carried length.
#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class AttachmentTorque final : public WrenchEffect<AttachmentTorque> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "attachment_torque",
        .term = "torque of an off-centre cable attachment",
        .equation = "s = max(0, h - h0), dM = s (lambda r_a) x R^T (-g e3)",
        .latex = R"(\Delta\tau = s\,(\lambda r_a)\times(-g\,R^Te_3),\quad s = \max(0, h-h_0))",
        .source =
            "lever of the carried weight, quasi-static; q = lambda r_a, since only the product of linear "
            "density and attachment shows in the torque",
        .parameters = {{"x", "q_x", "kg", -0.2, 0.2, 0.003, 0, true},
                       {"y", "q_y", "kg", -0.2, 0.2, 0.003, 0, true},
                       {"z", "q_z", "kg", -0.2, 0.2, -0.01, 0, true},
                       {"start_height", "h_0", "m", -1, 3, 0, 0, false}},
        .signals = {"position", "attitude"},
        .channels = {"Mx", "My", "Mz"},
        .stage = Stage::wrench,
        .aliases = {"com_offset"},
        .separated_by =
            "tilt at two heights: the torque of a centre-of-mass offset does not change with height",
        .comes_with = {"hung_cable", "cable_pendulum", "catenary", "overhead_rope"}};
    return info;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    const T carried = T(s.body.p_WB.z()) - theta[3];
    if (carried <= T(0)) return;
    const Eigen::Matrix<T, 3, 1> q(theta[0], theta[1], theta[2]);
    out.torque_B += carried * q.cross(s.g_B.cast<T>());
  }
};

}  // namespace

const Effect& attachment_torque_effect() {
  static const AttachmentTorque effect;
  return effect;
}

}  // namespace omniflight::physics
