// A rope that pulls once it is stretched, and never pushes.
#include <algorithm>

#include "effects/table.hpp"

namespace omniflight::physics {
namespace {

class TautRope final : public WrenchEffect<TautRope> {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "taut_rope",
        .term = "taut rope",
        .equation =
            "dF = -R^T u max(0, k (l - l0) + d dl/dt) where l > l0, l u = p + R z_a e3 - p_A, at z_a e3",
        .latex =
            R"(\Delta F = -R^Tu\,\big[k(l-l_0)+d\,\dot l\big]_+\;(l>l_0),\quad l\,u = p + R\,z_a e_3 - p_A)",
        .source = "unilateral spring and damper, k = EA/l0",
        .parameters = {{"stiffness", "k", "N/m", 0, 100000, 100, 0, false},
                       {"damping", "d", "N s/m", 0, 1000, 2, 0, false},
                       {"length", "l_0", "m", 0.05, 20, 1.85, 1.85, false},
                       {"anchor_x", "p_Ax", "m", -10, 10, 0, 0, false},
                       {"anchor_y", "p_Ay", "m", -10, 10, 0, 0, false},
                       {"anchor_z", "p_Az", "m", -1, 20, 0, 0, false},
                       {"attachment_z", "z_a", "m", -0.5, 0.5, 0, 0, false}},
        .signals = {"position", "velocity", "attitude", "gyro"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My"},
        .stage = Stage::wrench,
        .aliases = {"lateral_stiffness", "wall_effect", "actuator_saturation"},
        .separated_by = "slow approach to the limit in three directions"};
    return info;
  }

  /// Anchors all around at two radii of the flight, with ropes that come taut in its last fifth and
  /// twentieth.
  std::vector<std::vector<double>> telling_shapes(std::span<const Situation> motion) const override {
    std::vector<std::vector<double>> out;
    if (motion.empty()) return out;
    Vec3 middle = Vec3::Zero();
    for (const Situation& s : motion) middle += s.body.p_WB / static_cast<double>(motion.size());
    double reach = 0.1;
    for (const Situation& s : motion) reach = std::max(reach, (s.body.p_WB - middle).norm());
    std::vector<Vec3> directions{Vec3::UnitZ(), -Vec3::UnitZ()};
    for (int k = 0; k < 8; ++k)
      directions.emplace_back(std::cos(0.25 * kPi * k), std::sin(0.25 * kPi * k), 0);
    std::vector<double> distance(motion.size());
    for (const Vec3& direction : directions) {
      const Vec3 anchor = middle + 2 * reach * direction;
      for (std::size_t i = 0; i < motion.size(); ++i) distance[i] = (motion[i].body.p_WB - anchor).norm();
      std::sort(distance.begin(), distance.end());
      for (const std::size_t share : {80u, 95u})
        out.push_back({0, 0, distance[distance.size() * share / 100], anchor.x(), anchor.y(), anchor.z(), 0});
    }
    return out;
  }

  template <class T>
  void wrench(const Situation& s, const T* theta, WrenchT<T>& out) const {
    using std::sqrt;
    using V = Eigen::Matrix<T, 3, 1>;
    const V at(T(0), T(0), theta[6]);
    const V to = s.body.p_WB.cast<T>() + s.R_WB.cast<T>() * at - V(theta[3], theta[4], theta[5]);
    const T square = to.squaredNorm();
    if (!(square > theta[2] * theta[2])) return;
    const T length = sqrt(square);
    const V u = s.R_WB.transpose().cast<T>() * (to / length);
    const T rate = u.dot(s.v_WB_B.cast<T>() + s.body.w_WB_B.cast<T>().cross(at));
    const T pull = theta[0] * (length - theta[2]) + theta[1] * rate;
    if (pull <= T(0)) return;
    out.force_B -= pull * u;
    out.torque_B -= at.cross(V(pull * u));
  }
};

}  // namespace

const Effect& taut_rope_effect() {
  static const TautRope effect;
  return effect;
}

}  // namespace omniflight::physics
