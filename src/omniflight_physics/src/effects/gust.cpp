// Wind that comes and goes.
#include "effects/table.hpp"
#include "effects/words.hpp"

namespace omniflight::physics {
namespace {

class Gust final : public Effect {
 public:
  const EffectInfo& info() const override {
    static const EffectInfo info{
        .id = "gust",
        .term = "gust (Ornstein-Uhlenbeck, first-order Dryden)",
        .equation = "dw = -w/tau dt + sigma sqrt(2/tau) dW, dF = 1/2 rho C_dA R^T (|w - v| (w - v) + |v| v)",
        .latex =
            R"(dw = -\tfrac{w}{\tau}dt + \sigma\sqrt{2/\tau}\,dW,\quad \Delta F = \tfrac12\rho\,C_dA\,R^T(|w-v|(w-v)+|v|v))",
        .source =
            "exact discretisation of the Ornstein-Uhlenbeck process; longitudinal Dryden spectrum "
            "(MIL-F-8785C) with tau = L/V",
        .parameters = {{"intensity", "sigma", "m/s", 0, 5, 0.3, 0, false},
                       {"time_constant", "tau", "s", 0.05, 20, 1, 1, false},
                       {"area", "C_dA", "m2", 0.001, 0.3, 0.02, 0.02, false}},
        .signals = {"velocity", "attitude"},
        .channels = {"Fx", "Fy", "Fz"},
        .stage = Stage::wrench,
        .aliases = {"wind", "parasitic_drag"},
        .separated_by = "its spectrum, not its mean: hover for a minute",
        .not_asked_for = "its force is random: it counts as noise",
        .words = {{"intensity"},
                  [](const KnownValues& v) { return "gusts of " + two_digits(v("intensity")) + " m/s"; }}};
    return info;
  }

  MemorySize memory_size() const override { return {0, 3}; }
  void add_memory_wrench(const Situation& s, const double* theta, const double* memory,
                         Wrench& out) const override {
    const Vec3& v = s.body.v_WB_W;
    const Vec3 d = Eigen::Map<const Vec3>(memory) - v;
    const Vec3 f_W = 0.5 * s.environment.air_density * theta[2] * (d.norm() * d + v.norm() * v);
    out.force_B += s.R_WB.transpose() * f_W;
  }
  void advance(const Situation&, const double* theta, double step, Random& random,
               double* memory) const override {
    const double keep = std::exp(-step / theta[1]), kick = theta[0] * std::sqrt(1.0 - keep * keep);
    for (int k = 0; k < 3; ++k) memory[k] = keep * memory[k] + kick * random.normal();
  }
};

}  // namespace

const Effect& gust_effect() {
  static const Gust effect;
  return effect;
}

}  // namespace omniflight::physics
