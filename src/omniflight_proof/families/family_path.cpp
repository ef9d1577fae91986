#include "family_path.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::proof {
namespace {

struct Scale {
  double reach, speed, acceleration, lean, yaw;
};

/// Time of a quintic step of this length that keeps speed and acceleration (peaks 1.875 d / T and 5.77 d /
/// T^2).
double step_time(double distance, const Scale& s) {
  const double d = std::abs(distance);
  return std::max({0.8, 1.875 * d / s.speed, std::sqrt(5.77 * d / s.acceleration)});
}

/// Sines with the given frequencies whose sum stays within reach, and its second derivative within
/// acceleration.
void sines(Coordinate& c, BoxRandom& random, std::vector<double> frequencies, double reach,
           double acceleration, double from, double until) {
  double sum = 0, quick = 0;
  std::vector<double> weights;
  for (double& f : frequencies) {
    f *= random.between(0.9, 1.1);
    weights.push_back(std::pow(f, -1.3));
    sum += weights.back();
    quick += weights.back() * std::pow(2 * kPi * f, 2);
  }
  const double by = std::min(reach / sum, acceleration > 0 ? acceleration / quick : 1e300);
  for (std::size_t k = 0; k < frequencies.size(); ++k)
    c.sines.push_back({by * weights[k], frequencies[k], random.between(0, 2 * kPi)});
  c.sines_from = from;
  c.sines_until = until;
  c.ramp = 2;
}

/// Steps to random places in turns, with pauses.
void wander(Coordinate& c, BoxRandom& random, double reach, const Scale& s, double begin, double end,
            double pause) {
  double t = begin + random.between(0, 2), at = 0;
  while (true) {
    const double to = random.between(-reach, reach), time = step_time(to - at, s);
    if (t + time > end) break;
    c.steps.push_back({t, time, to - at});
    at = to;
    t += time + random.between(0.2, pause);
  }
}

void t1(Path& p, const Scale& s, double begin, double end) {
  const double step = 0.5 * s.reach, time = std::max(2.4, step_time(step, s));
  double t = begin + 3;
  const std::pair<int, double> legs[] = {{1, -step}, {1, step}, {1, step}, {1, -step}, {0, step}, {0, -step}};
  for (int k = 0; t + time < end; ++k, t += time + 3.6)
    p.position[legs[k % 6].first].steps.push_back({t, time, legs[k % 6].second});
}

void t2(Path& p, const FamilyVehicle& v, const Scale& s, double begin, double end) {
  const double rise = 0.9 * s.reach, side = 0.5 * s.reach, up = std::max(4.0, step_time(rise, s));
  const double across = std::max(3.0, step_time(side, s));
  for (double t = begin + 3; t + 2 * up + 2 * across + 14 < end + 1; t += 2 * up + 2 * across + 17) {
    p.position[2].steps.push_back({t, up, rise});
    p.position[0].steps.push_back({t + up + 4, across, side});
    p.position[0].steps.push_back({t + up + across + 9, across, -side});
    if (v.fully_actuated) {
      p.rotation[1].steps.push_back({t + up + 4, across, v.lean});
      p.rotation[1].steps.push_back({t + up + across + 9, across, -v.lean});
    }
    p.position[2].steps.push_back({t + up + 2 * across + 12, up, -rise});
  }
}

void eight(Path& p, BoxRandom& random, const Scale& s, double begin, double end) {
  const double a = 0.8 * s.reach;
  // the crossing is the quickest point: speed 2 pi f a sqrt(2), acceleration at the ends (2 pi f)^2 a 2
  const double f = std::min(s.speed / (2 * kPi * a * 1.5), std::sqrt(s.acceleration / (3 * a)) / (2 * kPi)) *
                   random.between(0.7, 1.0);
  const auto sine = [&](Coordinate& c, double amplitude, double frequency, double phase) {
    c.sines.push_back({amplitude, frequency, phase});
    c.sines_from = begin;
    c.sines_until = end;
    c.ramp = 3;
  };
  sine(p.position[0], a, f, 0);
  sine(p.position[1], 0.6 * a, 2 * f, 0);
  sine(p.position[2], 0.25 * s.reach, 0.5 * f, 1);
  if (random.chance(0.5)) sine(p.rotation[2], s.yaw, f, 0.5);
}

void multisine(Path& p, BoxRandom& random, const FamilyVehicle& v, const Scale& s, double begin, double end) {
  const double each = 0.6 * s.acceleration;
  sines(p.position[0], random, {0.09, 0.21, 0.45, 0.85, 1.5}, 0.7 * s.reach, each, begin, end);
  sines(p.position[1], random, {0.11, 0.25, 0.51, 0.93, 1.4}, 0.7 * s.reach, each, begin, end);
  sines(p.position[2], random, {0.13, 0.29, 0.58, 1.1, 1.9}, 0.5 * s.reach, each, begin, end);
  sines(p.rotation[2], random, {0.08, 0.23, 0.6, 1.0}, s.yaw, 4, begin, end);
  if (!v.fully_actuated) return;
  sines(p.rotation[0], random, {0.1, 0.31, 0.7, 1.3, 2.1}, 0.7 * v.lean, 6, begin, end);
  sines(p.rotation[1], random, {0.12, 0.34, 0.8, 1.2, 2.3}, 0.7 * v.lean, 6, begin, end);
  sines(p.null_space[0], random, {0.2, 0.6, 1.3}, 0.15, 0, begin, end);
  sines(p.null_space[1], random, {0.35, 0.8, 1.7}, 0.15, 0, begin, end);
}

/// Stages of height with pauses, legs to all sides, turns, and quick small sines: made for telling effects
/// apart.
void designed(Path& p, BoxRandom& random, const FamilyVehicle& v, const Scale& s, double begin, double end) {
  const double rise = 0.7 * s.reach, leg = 0.7 * s.reach;
  const double up = step_time(rise, s), across = step_time(leg, s);
  double t = begin + 1;
  double side = 1, level = 0;
  for (int round = 0; t < end - 6; ++round) {
    const double to = level > 0 ? -rise : rise;
    p.position[2].steps.push_back({t, up, to});
    level += to;
    t += up + 1.5;
    for (int k = 0; k < 2 && t < end - across; ++k, t += across + 0.6)
      p.position[round % 2].steps.push_back({t, across, k == 0 ? side * leg : -side * leg});
    if (v.fully_actuated && t < end - 6) {
      p.rotation[round % 2].steps.push_back({t, 1.6, side * v.lean});
      p.rotation[round % 2].steps.push_back({t + 3, 1.6, -side * v.lean});
      t += 5;
    } else if (t < end - 4) {
      p.rotation[2].steps.push_back({t, 2, side * s.yaw});
      p.rotation[2].steps.push_back({t + 2.2, 2, -side * s.yaw});
      t += 4.4;
    }
    if (round % 2 == 1) side = -side;
  }
  const double each = 0.3 * s.acceleration;
  sines(p.position[0], random, {0.37, 0.91, 1.6}, 0.15 * s.reach, each, begin, end);
  sines(p.position[1], random, {0.41, 1.03, 1.5}, 0.15 * s.reach, each, begin, end);
  sines(p.position[2], random, {0.53, 1.21, 1.9}, 0.10 * s.reach, each, begin, end);
  sines(p.rotation[2], random, {0.3, 0.9}, 0.2 * s.yaw, 3, begin, end);
  if (!v.fully_actuated) return;
  sines(p.rotation[0], random, {0.7, 1.6, 2.3}, 0.25 * v.lean, 5, begin, end);
  sines(p.rotation[1], random, {0.8, 1.7, 2.4}, 0.25 * v.lean, 5, begin, end);
  sines(p.null_space[0], random, {0.2, 0.6, 1.3}, 0.2, 0, begin, end);
  sines(p.null_space[1], random, {0.35, 0.8, 1.7}, 0.2, 0, begin, end);
}

void pilot(Path& p, BoxRandom& random, const FamilyVehicle& v, const Scale& s, double begin, double end) {
  for (int axis : {0, 1}) wander(p.position[axis], random, 0.9 * s.reach, s, begin, end, 2.5);
  wander(p.position[2], random, 0.6 * s.reach, s, begin, end, 4);
  const Scale turn{s.yaw, 1.2, 3, 0, 0};
  wander(p.rotation[2], random, s.yaw, turn, begin, end, 6);
  if (!v.fully_actuated) return;
  const Scale lean{v.lean, 0.6, 1.5, 0, 0};
  for (int axis : {0, 1}) wander(p.rotation[axis], random, v.lean, lean, begin, end, 5);
}

/// Circles that rise and fall, nose along the way: no tuning run flies them.
void helix(Path& p, BoxRandom& random, const Scale& s, double begin, double end) {
  const double a = 0.75 * s.reach;
  const double f = std::min(s.speed / (2 * kPi * a), std::sqrt(s.acceleration / a) / (2 * kPi)) *
                   random.between(0.6, 0.95);
  const auto sine = [&](Coordinate& c, double amplitude, double frequency, double phase) {
    c.sines.push_back({amplitude, frequency, phase});
    c.sines_from = begin;
    c.sines_until = end;
    c.ramp = 3;
  };
  sine(p.position[0], a, f, 0);
  sine(p.position[1], a, f, 0.5 * kPi);
  sine(p.position[2], 0.4 * s.reach, f * random.between(0.25, 0.4), 0.3);
  sine(p.rotation[2], s.yaw, 0.7 * f, 0.5 * kPi);
}

}  // namespace

Path family_path(const Coordinates& where, const FamilyVehicle& v, double lead, double vigour,
                 BoxRandom& random) {
  Path p;
  p.name = where.manoeuvre;
  p.duration = lead + where.length;
  const Scale s{v.reach * std::sqrt(vigour), v.speed * vigour, v.acceleration * vigour, v.lean,
                std::min(1.2, 0.8 * vigour)};
  p.position[2].start = 1.0 + 0.9 * v.reach;
  p.alpha.start = to_radians(where.alpha_deg);
  const double begin = where.start == "in flight" ? 1.0 : lead + 0.5, end = p.duration + 4;
  if (where.manoeuvre == "T1" || where.manoeuvre == "T2") {
    if (where.start == "in flight") {  // comes from somewhere: swings before the recording begins
      const double by = 0.6 * s.reach, time = step_time(by, s);
      for (int axis : {0, 1}) {
        p.position[axis].start = -random.sign() * by;
        p.position[axis].steps.push_back({lead - 1.1 * time, time, -p.position[axis].start});
      }
    }
    if (where.manoeuvre == "T1")
      t1(p, s, lead, p.duration);
    else
      t2(p, v, s, lead, p.duration);
  } else if (where.manoeuvre == "eight") {
    eight(p, random, s, begin, end);
  } else if (where.manoeuvre == "multisine") {
    multisine(p, random, v, s, begin, end);
  } else if (where.manoeuvre == "designed") {
    designed(p, random, v, s, begin, end);
  } else if (where.manoeuvre == "helix") {
    helix(p, random, s, begin, end);
  } else {
    pilot(p, random, v, s, begin, end);
  }
  if (where.tilt == "moves") {
    const double by = to_radians(random.between(8, 14));
    for (double t = begin + 2; t + 14 < end; t += 14) {
      p.alpha.steps.push_back({t, 2, by});
      p.alpha.steps.push_back({t + 4.5, 3, -2 * by});
      p.alpha.steps.push_back({t + 10, 2, by});
    }
    sines(p.alpha, random, {0.11, 0.27, 0.6}, to_radians(4), 0, begin, end);
  }
  if (where.low) {
    double lowest = 1e300;
    for (double t = 0; t < p.duration; t += 0.05) lowest = std::min(lowest, p.position[2].at(t).value);
    p.position[2].start -= lowest - (1.2 * v.nominal.rotors[0].radius + 0.1);
  }
  return p;
}

}  // namespace omniflight::proof
