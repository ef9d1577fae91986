#include "omniflight_physics/correction.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace omniflight::physics {
namespace {

Vec3 circulation(const Situation& s) {
  Vec3 sum = Vec3::Zero();
  for (const RotorSituation& r : s.all_rotors()) sum += r.spin * r.speed * r.n_B;
  return sum;
}

double thrust(const Situation& s) {
  double sum = 0;
  for (const RotorSituation& r : s.all_rotors()) sum += r.thrust;
  return sum;
}

using S = const Situation&;
using A = Quantity::Axes;
constexpr std::array kQuantities{
    Quantity{"forward_speed", "forward speed", "m/s", "speed", A::body, true,
             [](S s) { return s.v_WB_B.x(); }},
    Quantity{"sideward_speed", "sideward speed", "m/s", "speed", A::body, true,
             [](S s) { return s.v_WB_B.y(); }},
    Quantity{"body_z_speed", "speed along the body's z", "m/s", "speed", A::body, true,
             [](S s) { return s.v_WB_B.z(); }},
    Quantity{"x_speed", "speed along x", "m/s", "speed", A::world, true,
             [](S s) { return s.body.v_WB_W.x(); }},
    Quantity{"y_speed", "speed along y", "m/s", "speed", A::world, true,
             [](S s) { return s.body.v_WB_W.y(); }},
    Quantity{"climb_speed", "climb speed", "m/s", "climb speed", A::world, true,
             [](S s) { return s.body.v_WB_W.z(); }},
    Quantity{"roll_rate", "roll rate", "rad/s", "rate", A::both, true, [](S s) { return s.body.w_WB_B.x(); }},
    Quantity{"pitch_rate", "pitch rate", "rad/s", "rate", A::both, true,
             [](S s) { return s.body.w_WB_B.y(); }},
    Quantity{"yaw_rate", "yaw rate", "rad/s", "rate", A::both, true, [](S s) { return s.body.w_WB_B.z(); }},
    Quantity{"position_x", "position x", "m", "position", A::world, true,
             [](S s) { return s.body.p_WB.x(); }},
    Quantity{"position_y", "position y", "m", "position", A::world, true,
             [](S s) { return s.body.p_WB.y(); }},
    Quantity{"height", "height", "m", "height", A::both, true, [](S s) { return s.body.p_WB.z(); }},
    Quantity{"distance_from_middle", "distance from the middle", "m", "position", A::both, true,
             [](S s) { return s.body.p_WB.head<2>().norm(); }},
    Quantity{"circulation_x", "circulation about x", "rad/s", "rotor speed", A::body, true,
             [](S s) { return circulation(s).x(); }},
    Quantity{"circulation_y", "circulation about y", "rad/s", "rotor speed", A::body, true,
             [](S s) { return circulation(s).y(); }},
    Quantity{"circulation_z", "circulation about z", "rad/s", "rotor speed", A::body, true,
             [](S s) { return circulation(s).z(); }},
    Quantity{"total_thrust", "total thrust", "N", "thrust", A::body, true, [](S s) { return thrust(s); }},
    Quantity{"rotor_tilt", "rotor tilt", "rad", "rotor tilt", A::both, true, [](S s) { return s.alpha; }},
    Quantity{"speed", "speed", "m/s", "speed", A::both, true, [](S s) { return s.v_WB_B.norm(); }},
    Quantity{"attitude_x_along_x", "attitude, x of the body along x", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(0, 0); }},
    Quantity{"attitude_y_along_x", "attitude, y of the body along x", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(0, 1); }},
    Quantity{"attitude_z_along_x", "attitude, z of the body along x", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(0, 2); }},
    Quantity{"attitude_x_along_y", "attitude, x of the body along y", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(1, 0); }},
    Quantity{"attitude_y_along_y", "attitude, y of the body along y", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(1, 1); }},
    Quantity{"attitude_z_along_y", "attitude, z of the body along y", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(1, 2); }},
    Quantity{"attitude_x_along_z", "attitude, x of the body along z", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(2, 0); }},
    Quantity{"attitude_y_along_z", "attitude, y of the body along z", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(2, 1); }},
    Quantity{"attitude_z_along_z", "attitude, z of the body along z", "1", "attitude", A::both, false,
             [](S s) { return s.R_WB(2, 2); }}};

/// Where a correction's numbers stand among the parameters of its effect.
enum Place {
  kChannel,
  kWorld,
  kForm,
  kFirst,
  kSecond,
  kCenter,
  kLength = kCenter + 3,
  kDirection,
  kFrequency,
  kPhase,
  kCoefficient,
  kMean,
  kLow,
  kHigh,
  kCount
};

Correction decode(const double* theta) {
  Correction c;
  c.channel = static_cast<int>(theta[kChannel]);
  c.world = theta[kWorld] != 0;
  c.feature.form = static_cast<Feature::Form>(static_cast<int>(theta[kForm]));
  c.feature.first = static_cast<int>(theta[kFirst]);
  c.feature.second = static_cast<int>(theta[kSecond]);
  c.feature.center = Eigen::Map<const Vec3>(theta + kCenter);
  c.feature.length = theta[kLength];
  c.feature.direction = theta[kDirection];
  c.feature.frequency = theta[kFrequency];
  c.feature.phase = theta[kPhase];
  c.coefficient = theta[kCoefficient];
  c.mean = theta[kMean];
  c.low = theta[kLow];
  c.high = theta[kHigh];
  return c;
}

class SmoothCorrection final : public Effect {
 public:
  const EffectInfo& info() const override { return kInfo; }
  bool acts_on_wrench() const override { return true; }

  void add_wrench(const Situation& s, const double* theta, Wrench& out) const override {
    const Vec6 w = theta[kCoefficient] * per_coefficient(s, theta);
    out.force_B += w.head<3>();
    out.torque_B += w.tail<3>();
  }
  void wrench_with_jacobian(const Situation& s, const double* theta, double* wrench,
                            double* jacobian) const override {
    Eigen::Map<Vec6> value(wrench);
    Eigen::Map<Eigen::Matrix<double, 6, kCount>> derivative(jacobian);
    derivative.setZero();
    derivative.col(kCoefficient) = per_coefficient(s, theta);
    value = theta[kCoefficient] * derivative.col(kCoefficient);
  }

 private:
  static Vec6 per_coefficient(const Situation& s, const double* theta) {
    const Correction c = decode(theta);
    const double value = std::clamp(c.feature.at(s), c.low, c.high) - c.mean;
    Vec6 out = Vec6::Zero();
    if (c.world && c.channel < 3)
      out.head<3>() = value * s.R_WB.row(c.channel).transpose();
    else
      out[c.channel] = value;
    return out;
  }
  static const EffectInfo kInfo;
};

Parameter number(const char* name, const char* symbol, const char* unit, double low, double high) {
  return {name, symbol, unit, low, high, std::clamp(0.0, low, high), std::clamp(0.0, low, high), false};
}

EffectInfo describe() {
  EffectInfo e;
  e.id = "smooth_correction";
  e.term = "what no effect of the library explains";
  e.equation = "F = c (f(state) - mean), f held where it was seen";
  e.latex = "F = c\\,(f(x) - \\bar f)";
  e.source = "fitted";
  e.channels = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};
  const auto last = static_cast<double>(kQuantities.size() - 1);
  e.parameters = {number("channel", "k", "1", 0, 5),
                  number("world", "W", "1", 0, 1),
                  number("form", "f", "1", 0, 3),
                  number("first", "a", "1", 0, last),
                  number("second", "b", "1", -1, last),
                  number("center_x", "x", "m", -1e3, 1e3),
                  number("center_y", "y", "m", -1e3, 1e3),
                  number("center_z", "z", "m", -1e3, 1e3),
                  number("length", "L", "m", 1e-3, 1e3),
                  number("direction", "psi", "rad", -kPi, kPi),
                  number("frequency", "nu", "Hz", 0, 1e3),
                  number("phase", "phi", "rad", -kPi, kPi),
                  number("coefficient", "c", "1", -1e4, 1e4),
                  number("mean", "m", "1", -1e9, 1e9),
                  number("low", "f_0", "1", -1e9, 1e9),
                  number("high", "f_1", "1", -1e9, 1e9)};
  e.parameters[kCoefficient].linear = true;
  return e;
}

const EffectInfo SmoothCorrection::kInfo = describe();
const SmoothCorrection kEffect;

}  // namespace

std::span<const Quantity> quantities() { return kQuantities; }

double Feature::at(const Situation& s) const {
  switch (form) {
    case Form::bump:
      return std::exp(-0.5 * (s.body.p_WB - center).squaredNorm() / (length * length));
    case Form::wave:
      return std::cos(2 * kPi / length *
                          (std::cos(direction) * s.body.p_WB.x() + std::sin(direction) * s.body.p_WB.y()) -
                      phase);
    case Form::pulse:
      return std::cos(2 * kPi * frequency * s.t - phase);
    case Form::product:
      break;
  }
  const double a = kQuantities[static_cast<std::size_t>(first)].value(s);
  return second < 0 ? a : a * kQuantities[static_cast<std::size_t>(second)].value(s);
}

ActiveEffect as_effect(const Correction& c) {
  ActiveEffect out{&kEffect, std::vector<double>(kCount)};
  out.theta[kChannel] = c.channel;
  out.theta[kWorld] = c.world ? 1 : 0;
  out.theta[kForm] = static_cast<int>(c.feature.form);
  out.theta[kFirst] = c.feature.first;
  out.theta[kSecond] = c.feature.second;
  for (int k = 0; k < 3; ++k) out.theta[static_cast<std::size_t>(kCenter + k)] = c.feature.center[k];
  out.theta[kLength] = c.feature.length;
  out.theta[kDirection] = c.feature.direction;
  out.theta[kFrequency] = c.feature.frequency;
  out.theta[kPhase] = c.feature.phase;
  out.theta[kCoefficient] = c.coefficient;
  out.theta[kMean] = c.mean;
  out.theta[kLow] = c.low;
  out.theta[kHigh] = c.high;
  return out;
}

bool is_correction(const ActiveEffect& effect) { return effect.effect == &kEffect; }

Correction correction_of(const ActiveEffect& effect) { return decode(effect.theta.data()); }

}  // namespace omniflight::physics
