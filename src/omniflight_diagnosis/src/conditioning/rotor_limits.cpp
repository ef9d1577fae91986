#include "rotor_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "../numerics/statistics.hpp"
#include "omniflight_diagnosis/residual.hpp"

namespace omniflight::diagnosis {
namespace {

using recording::Signal;

// Chosen, not measured.
constexpr double kLasts = 0.1;       // s, duration of a state before it counts; longer than motor lags
constexpr double kAtLeast = 0.2;     // s, least time at a limit, summed over the rotors
constexpr double kBeyond = 1.01;     // command over speed above which the rotor is at a ceiling
constexpr double kAtRest = 0.05;     // speed over command below which the rotor rests
constexpr double kTurns = 0.5;       // speed over command above which the rotor follows
constexpr double kLeastDead = 10;    // rad/s, least dead zone
constexpr double kInPassing = 0.85;  // of a dead zone; slower readings show that the telemetry resolves them
constexpr Eigen::Index kReadings = 10;  // least number of such readings

enum class Does { else_, beyond, rests, follows };

/// State of a rotor with command u and speed w [rad/s].
Does doing(double u, double w) {
  if (!std::isfinite(u) || !std::isfinite(w) || u == 0) return Does::else_;
  if (std::abs(w) <= kAtRest * std::abs(u)) return Does::rests;
  if (u * w < 0 || std::abs(w) < kTurns * std::abs(u)) return Does::else_;
  return std::abs(u) > kBeyond * std::abs(w) ? Does::beyond : Does::follows;
}

struct Sample {
  Eigen::Index row, since, rotor;  ///< in this state since row `since`
  double command, speed;           ///< magnitudes, rad/s
};

/// Samples whose rotor has been in a state for longer than kLasts.
struct Lasting {
  std::vector<Sample> beyond, rests, turns;
};

Lasting lasting(const Signal& speed, const Eigen::MatrixXd& ordered) {
  Lasting out;
  for (Eigen::Index r = 0; r < speed.width(); ++r) {
    Does last = Does::else_, last_turning = Does::else_;
    Eigen::Index since = 0, turns_since = 0, ago = 0;
    const auto lasts = [&](Eigen::Index from, Eigen::Index to) {
      return speed.t_s[static_cast<std::size_t>(to)] - speed.t_s[static_cast<std::size_t>(from)] > kLasts;
    };
    for (Eigen::Index i = 0; i < speed.size(); ++i) {
      Sample s{i, i, r, std::abs(ordered(i, r)), std::abs(speed.values(i, r))};
      const Does now = doing(ordered(i, r), speed.values(i, r));
      const Does turning = now == Does::beyond || now == Does::follows ? Does::follows : now;
      if (now != last) last = now, since = i;
      if (turning != last_turning) last_turning = turning, turns_since = i;
      s.since = since;
      while (lasts(ago + 1, i)) ++ago;
      // a rotor that still accelerates is at no ceiling
      const bool stands = std::abs(speed.values(i, r) - speed.values(ago, r)) < kPlateau * s.speed;
      if (now == Does::beyond && lasts(since, i) && stands) out.beyond.push_back(s);
      if (now == Does::rests && lasts(since, i)) out.rests.push_back(s);
      if (turning == Does::follows && lasts(turns_since, i)) out.turns.push_back(s);
    }
  }
  return out;
}

double quantile(const std::vector<Sample>& samples, double Sample::*of, double share) {
  std::vector<double> x;
  for (const Sample& s : samples) x.push_back(s.*of);
  return diagnosis::quantile(std::move(x), share);
}

std::optional<LimitSpeed> ceiling_of(const Lasting& l, double period) {
  if (static_cast<double>(l.beyond.size()) * period < kAtLeast) return {};
  const double from = quantile(l.beyond, &Sample::speed, 0.1), to = quantile(l.beyond, &Sample::speed, 0.9),
               middle = quantile(l.beyond, &Sample::speed, 0.5);
  const double highest = std::max(to, quantile(l.turns, &Sample::speed, 0.999));
  if (to - from > kPlateau * middle || highest > (1 + kPlateau) * middle) return {};
  constexpr double kKnown = 0.5 * kPlateau;
  return LimitSpeed{middle, (1 - kKnown) * from, (1 + kKnown) * to};
}

std::optional<LimitSpeed> dead_of(const Lasting& l, double period) {
  if (static_cast<double>(l.rests.size()) * period < kAtLeast || l.turns.empty()) return {};
  const double most = quantile(l.rests, &Sample::command, 0.98),
               least = quantile(l.turns, &Sample::command, 0.02);
  if (most < kLeastDead || least < 0.9 * most) return {};
  const double beyond = std::max(most, least);
  constexpr double kKnown = 0.02;  // relative error of a command between two samples; chosen
  return LimitSpeed{0.5 * (most + beyond), (1 - kKnown) * most, (1 + kKnown) * beyond};
}

}  // namespace

RotorLimits rotor_limits(const recording::Recording& r) {
  RotorLimits out;
  const Signal *speed = r.find("rotor_speed"), *command = r.find("rotor_command");
  if (!speed || !command || speed->size() < 100 || command->empty() || speed->width() != command->width())
    return out;
  const Lasting l = lasting(*speed, recording::resample(*command, speed->t_s, 0.1));
  out.ceiling = ceiling_of(l, speed->median_period_s());
  out.dead = dead_of(l, speed->median_period_s());
  if (out.dead) {
    const auto slow = [&](double w) {
      return w > kAtRest * out.dead->from && w < kInPassing * out.dead->from;
    };
    out.reads_slower = speed->values.array().abs().unaryExpr(slow).count() >= kReadings;
  }
  out.held.assign(static_cast<std::size_t>(speed->width()),
                  std::vector<char>(static_cast<std::size_t>(speed->size()), 0));
  const auto hold = [&](const std::vector<Sample>& samples) {
    for (const Sample& s : samples) {
      auto& held = out.held[static_cast<std::size_t>(s.rotor)];
      for (Eigen::Index i = s.row; i >= s.since && !held[static_cast<std::size_t>(i)]; --i)
        held[static_cast<std::size_t>(i)] = 1;
    }
  };
  if (out.ceiling) hold(l.beyond);
  if (out.dead) hold(l.rests);
  return out;
}

std::optional<double> fill_slow_readings(const recording::Recording& r, const vehicle::Vehicle& vehicle,
                                         Signal& speed) {
  const RotorLimits limits = rotor_limits(r);
  if (!limits.dead || limits.reads_slower) return {};
  Signal turning = *r.find("rotor_command");
  for (Eigen::Index k = 0; k < turning.width(); ++k) {
    const double tau = vehicle.rotors[static_cast<std::size_t>(k)].time_constant;
    double asked = turning.values(0, k), turns = asked;
    for (Eigen::Index i = 1; i < turning.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (!std::isfinite(turns)) turns = asked;
      if (std::isfinite(asked))
        turns = lagged_speed(turns, asked, tau, turning.t_s[at] - turning.t_s[at - 1]);
      asked = turning.values(i, k);
      turning.values(i, k) = turns;
    }
  }
  const Eigen::MatrixXd ordered = recording::resample(turning, speed.t_s, 0.1);
  double slowest = std::numeric_limits<double>::infinity();
  for (const double w : speed.values.reshaped())
    if (std::abs(w) > 0) slowest = std::min(slowest, std::abs(w));
  for (Eigen::Index k = 0; k < speed.width(); ++k)
    for (Eigen::Index i = 0; i < speed.size(); ++i)
      if (speed.values(i, k) == 0 && std::isfinite(ordered(i, k)))
        speed.values(i, k) = std::clamp(ordered(i, k), -slowest, slowest);
  return slowest;
}

}  // namespace omniflight::diagnosis
