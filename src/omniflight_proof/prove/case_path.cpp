#include "case_path.hpp"

#include <cmath>
#include <utility>

namespace omniflight::proof {
namespace {

/// Quintic from 0 to 1 over [0, 1] with zero rate and acceleration at both ends.
Jet2 smooth(double s) {
  if (s <= 0) return {0, 0, 0};
  if (s >= 1) return {1, 0, 0};
  return {s * s * s * (10 + s * (-15 + 6 * s)), 30 * s * s * (1 - s) * (1 - s),
          60 * s * (1 - s) * (1 - 2 * s)};
}
Jet2 smooth(double t, double at, double duration) {
  Jet2 j = smooth((t - at) / duration);
  j.rate /= duration;
  j.acceleration /= duration * duration;
  return j;
}
Jet2 product(const Jet2& a, const Jet2& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate,
          a.acceleration * b.value + 2 * a.rate * b.rate + a.value * b.acceleration};
}

/// Sines with the given frequencies [Hz], amplitudes falling with frequency, drawn phases, peak sum `sum`.
void add_sines(Coordinate& c, Random& random, std::initializer_list<double> frequencies, double sum,
               double fall, double until) {
  double weights = 0;
  for (const double f : frequencies) weights += std::pow(f, -fall);
  for (const double f : frequencies)
    c.sines.push_back({sum * std::pow(f, -fall) / weights, f, random.uniform(0, 2 * kPi)});
  c.sines_from = 2;
  c.sines_until = until;
}

/// The designed flight repeats its stages: turbulence of 0.3 s leaves a constant force known to
/// sqrt(2 * 0.3 s / duration) of its RMS, a tenth after one round, and what is to be told at 0.3 needs half
/// that. Sides are exchanged each round, so that an even number leaves none preferred.
constexpr int kRounds = 4;
constexpr double kRound = 60;  ///< s

}  // namespace

Jet2 Coordinate::at(double t) const {
  Jet2 out{start, 0, 0};
  for (const Step& s : steps) {
    const Jet2 j = smooth(t, s.at, s.duration);
    out.value += s.change * j.value;
    out.rate += s.change * j.rate;
    out.acceleration += s.change * j.acceleration;
  }
  if (sines.empty()) return out;
  const Jet2 in = smooth(t, sines_from, ramp), fade = smooth(t, sines_until - ramp, ramp);
  Jet2 envelope = product(in, {1 - fade.value, -fade.rate, -fade.acceleration});
  for (const Calm& c : calms) {
    const Jet2 down = smooth(t, c.from - calm_ramp, calm_ramp), up = smooth(t, c.until, calm_ramp);
    const double depth = 1 - calm_share;
    envelope = product(envelope, {1 - depth * (down.value - up.value), -depth * (down.rate - up.rate),
                                  -depth * (down.acceleration - up.acceleration)});
  }
  Jet2 sum;
  for (const Sine& s : sines) {
    const double w = 2 * kPi * s.frequency, phase = w * t + s.phase;
    sum.value += s.amplitude * std::sin(phase);
    sum.rate += s.amplitude * w * std::cos(phase);
    sum.acceleration -= s.amplitude * w * w * std::sin(phase);
  }
  const Jet2 j = product(envelope, sum);
  return {out.value + j.value, out.rate + j.rate, out.acceleration + j.acceleration};
}

Reference Path::at(double t) const {
  Reference r;
  Vec3 phi, dphi, ddphi;
  for (int k = 0; k < 3; ++k) {
    const Jet2 p = position[k].at(t), a = rotation[k].at(t);
    r.p_WB[k] = p.value;
    r.v_WB_W[k] = p.rate;
    r.a_WB_W[k] = p.acceleration;
    phi[k] = a.value;
    dphi[k] = a.rate;
    ddphi[k] = a.acceleration;
  }
  r.q_WB = exp_rotation(phi);
  const Mat3 J = right_jacobian(phi);
  r.w_WB_B = J * dphi;
  r.dw_WB_B = J * ddphi + jacobian_rate_times(phi, dphi);
  r.alpha = alpha.at(t).value;
  return r;
}

Path path_t1() {
  Path p;
  p.name = "T1";
  p.position[2].start = 1.3;
  p.alpha.start = to_radians(30);
  double t = 5;
  const auto go = [&](int axis, double by) {
    p.position[axis].steps.push_back({t, 2.4, by});
    t += 2.4 + 3.6;
  };
  for (int round = 0; round < 2 && t < 50; ++round) {
    go(1, -0.3);
    go(1, 0.3);
    go(1, 0.3);
    go(1, -0.3);
    go(0, 0.3);
  }
  return p;
}

Path path_t2() {
  Path p;
  p.name = "T2";
  p.position[2].start = 0.4;
  p.alpha.start = to_radians(30);
  p.position[2].steps = {{5, 4, 0.55}, {13, 4, 0.55}, {40, 4, -0.55}, {49, 4, -0.55}};
  p.position[0].steps = {{21, 3, 0.3}, {31, 3, -0.3}};
  p.rotation[1].steps = {{21, 3, to_radians(20)}, {31, 3, to_radians(-20)}};
  return p;
}

Path path_designed(Random& random, double vigour) {
  Path p;
  p.name = "designed";
  p.duration = kRounds * kRound;
  const double end = p.duration - 1;
  // Stages of height with pauses. In each pause the rotors are tilted further, the vehicle leans as far as it
  // can without reversing a rotor, and comes back; between them quick legs to the side.
  // 33 deg at 59 deg of tilt leaves every rotor 0.15 N above its smallest thrust; beyond 38 deg one reverses.
  const double lean = to_radians(33) * std::min(1.0, vigour), spread = to_radians(28), leg_m = 0.6;
  p.position[2].start = 0.55;
  std::vector<Coordinate::Calm> calms;
  for (int round = 0; round < kRounds; ++round) {
    const double begin = round * kRound, side = round % 2 == 0 ? 1 : -1;
    for (const auto& [at, rise] : {std::pair{8.0, 0.45}, {20.0, 0.45}, {33.0, -0.45}, {45.0, -0.45}})
      p.position[2].steps.push_back({begin + at, 3, rise});
    int k = 0;
    for (const double pause : {11.5, 24.5, 36.5, 49.0}) {
      const double at = begin + pause, half = side * (k < 2 ? 1 : -1);
      p.rotation[k % 2].steps.push_back({at, 2.0, half * lean});
      p.rotation[k % 2].steps.push_back({at + 4.0, 2.0, -half * lean});
      p.alpha.steps.push_back({at - 1.5, 2.0, spread});
      p.alpha.steps.push_back({at + 5.5, 2.0, -spread});
      calms.push_back({at, at + 6.0});
      p.position[1 - k % 2].steps.push_back({at - 4.6, 2.6, half * leg_m});
      ++k;
    }
  }
  add_sines(p.position[0], random, {0.11, 0.23, 0.41, 0.73}, 0.20 * vigour, 1.2, end);
  add_sines(p.position[1], random, {0.13, 0.27, 0.47, 0.83}, 0.20 * vigour, 1.2, end);
  add_sines(p.position[2], random, {0.17, 0.31, 0.53, 0.97}, 0.16 * vigour, 0.9, end);
  add_sines(p.rotation[0], random, {0.10, 0.29, 0.61, 1.13}, to_radians(4.5) * vigour, 0.8, end);
  add_sines(p.rotation[1], random, {0.12, 0.33, 0.67, 1.21}, to_radians(4.5) * vigour, 0.8, end);
  add_sines(p.rotation[2], random, {0.09, 0.25, 0.59, 1.07}, to_radians(15) * vigour, 0.8, end);
  // small and quick: turbulence has little power up there, inertia and lags show; more would reverse rotors
  add_sines(p.position[0], random, {1.37, 1.93}, 0.003 * vigour, 0.8, end);
  add_sines(p.position[1], random, {1.43, 2.03}, 0.003 * vigour, 0.8, end);
  add_sines(p.position[2], random, {1.51, 2.11}, 0.003 * vigour, 0.8, end);
  add_sines(p.rotation[0], random, {1.67, 2.23}, to_radians(1.5) * vigour, 0.8, end);
  add_sines(p.rotation[1], random, {1.79, 2.39}, to_radians(1.5) * vigour, 0.8, end);
  add_sines(p.rotation[2], random, {1.61, 2.47}, to_radians(2) * vigour, 0.8, end);
  p.alpha.start = to_radians(31);
  add_sines(p.alpha, random, {0.07, 0.19}, to_radians(5), 0.3, end);
  add_sines(p.null_space[0], random, {0.21, 0.57, 1.31}, 0.20, 0.2, end);
  add_sines(p.null_space[1], random, {0.35, 0.79, 1.73}, 0.20, 0.2, end);
  for (Coordinate* c : {&p.position[0], &p.position[1], &p.position[2], &p.rotation[0], &p.rotation[1],
                        &p.rotation[2], &p.alpha, &p.null_space[0], &p.null_space[1]}) {
    c->calms = calms;
    c->calm_share = 0.03;
  }
  return p;
}

}  // namespace omniflight::proof
