// A cable of twenty links that hangs to the floor: the finest of three fidelities.
#include "omniflight_physics/cable_chain.hpp"

#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

constexpr int kNodes = 20;
constexpr int kArrayNumbers = kCableArrays * (kNodes + 1);

class CableChainEffect final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "cable_chain",
        .term = "hung cable as a chain of point masses",
        .equation =
            "m_i a_i = m_i g + T_(i+1) n_(i+1) - T_i n_i + floor, |p_i - p_(i-1)| <= l, T_i >= 0, dF = "
            "R^T (T_1 n_1 - m_0 (a - g)) at r_z e3",
        .latex =
            R"(m_i\ddot p_i = m_ig + T_{i+1}n_{i+1} - T_in_i + f_i,\quad 0\le T_i\perp |p_i-p_{i-1}|\le l,\quad \Delta F = R^T(T_1n_1 - m_0(a-g)))",
        .source =
            "lumped masses on inextensible links; length constraints solved directly as in Deul et al. 2018",
        .parameters = {{"linear_density", "lambda", "kg/m", 0, 1.5, 0.1, 0, true},
                       {"length", "L", "m", 0.05, 10, 2, 2, false},
                       {"attachment_z", "r_z", "m", -0.5, 0.5, 0, 0, false},
                       {"friction", "mu", "1", 0, 2, 0.5, 0.5, false},
                       {"damping", "c", "1/s", 0, 5, 0.2, 0.2, false}},
        .signals = {"position", "attitude", "acc"},
        .channels = {"Fx", "Fy", "Fz", "Mx", "My"},
        .stage = Stage::wrench,
        .aliases = {"hung_cable", "cable_pendulum"},
        .separated_by = "as hung_cable; its forces differ while the cable swings, lands or is lifted",
        .not_asked_for = "hung_cable and cable_pendulum are asked for in its place",
        .words = {{"linear_density"}, [](const KnownValues& v) {
                    return "a swinging cable of " + hundredths(v("linear_density")) + " kg/m";
                  }}};
    return info;
  }

  // The chain moves the same for every density: it is stepped with 1 kg/m, and its forces are scaled.
  MemorySize memory_size() const override { return {0, kArrayNumbers + 6}; }
  void start_memory(const Situation& s, const double* theta, double* memory) const override {
    const CableArrays a = arrays(memory);
    hang_cable(config(s, theta), a, upper_end(s, theta));
    for (int i = 0; i <= kNodes; ++i) {
      a.vx[i] = s.body.v_WB_W.x();
      a.vy[i] = s.body.v_WB_W.y();
    }
    double mass = 0;
    for (int i = 1; i <= kNodes && a.tension[i] > 0; ++i) mass = a.tension[1] / s.environment.gravity;
    keep({-Vec3::UnitZ(), mass * s.environment.gravity, mass, a.split[1]}, memory);
  }
  void advance(const Situation& s, const double* theta, double step, Random&, double* memory) const override {
    double work[cable_work_size(kNodes)];
    keep(step_cable(config(s, theta), arrays(memory), upper_end(s, theta), step, work), memory);
  }
  void add_memory_wrench(const Situation& s, const double* theta, const double* memory,
                         Wrench& out) const override {
    const double* answer = memory + kArrayNumbers;
    const Vec3 n = s.R_WB.transpose() * Eigen::Map<const Vec3>(answer);
    const double pull = theta[0] * answer[3], mass = theta[0] * answer[4], end = theta[0] * answer[5];
    const Vec3 r(0, 0, theta[2]);
    const Vec3 centripetal = s.body.w_WB_B.cross(s.body.w_WB_B.cross(r));
    out.add_at(r, Vec3((pull - mass * n.dot(centripetal)) * n + end * (s.g_B - centripetal)));
    // inertia K at the attachment, whose acceleration is [I, -S] times that of the body
    const Mat3 K = mass * n * n.transpose() + end * Mat3::Identity();
    out.has_inertia = true;
    out.inertia.topLeftCorner<3, 3>() += K;
    if (theta[2] == 0) return;
    const Mat3 S = skew(r), SK = S * K;
    out.inertia.topRightCorner<3, 3>() += SK.transpose();
    out.inertia.bottomLeftCorner<3, 3>() += SK;
    out.inertia.bottomRightCorner<3, 3>() -= SK * S;
  }

 private:
  static CableArrays arrays(double* memory) {
    const auto a = [memory](int k) { return memory + k * (kNodes + 1); };
    return {a(0), a(1), a(2), a(3), a(4), a(5), a(6), a(7)};
  }
  static CableConfig config(const Situation& s, const double* theta) {
    return {kNodes, theta[1], 1.0, theta[4], theta[3], s.environment.floor_z, s.environment.gravity, false};
  }
  static Vec3 upper_end(const Situation& s, const double* theta) {
    return s.body.p_WB + s.R_WB * Vec3(0, 0, theta[2]);
  }
  static void keep(const CableAnswer& a, double* memory) {
    double* answer = memory + kArrayNumbers;
    Eigen::Map<Vec3>{answer} = a.direction;
    answer[3] = a.pull;
    answer[4] = a.mass;
    answer[5] = a.end_mass;
  }
};

}  // namespace

const Effect& cable_chain_effect() {
  static const CableChainEffect effect;
  return effect;
}

}  // namespace omniflight::physics
