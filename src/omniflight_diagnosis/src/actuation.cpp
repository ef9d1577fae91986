#include "actuation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "omniflight_diagnosis/filter.hpp"

namespace omniflight::diagnosis {
namespace {

struct Block {
  int begin = 0, end = 0;
};

/// One rotor's command (columns: one input, or duty cycle, duty times voltage, voltage) and speed on a grid.
struct Rotor {
  Eigen::MatrixXd input;
  Eigen::VectorXd speed;
};

/// Residual energy of speed against the lagged, delayed input with free gains and constant.
double misfit(const Rotor& r, double dt, double lag, double delay, const Block& block) {
  const double a = lag > 1e-4 ? std::exp(-dt / lag) : 0.0;
  const int n = block.end - block.begin;
  const Eigen::Index columns = r.input.cols();
  const double shift = delay / dt;
  const int whole = static_cast<int>(shift);
  const double part = shift - whole;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(columns + 1, columns + 1);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(columns + 1), z(columns + 1);
  double total = 0;
  const int settle = std::min(n / 3, static_cast<int>(0.5 / dt));
  Eigen::VectorXd state = r.input.row(std::max(0, block.begin - whole)).transpose();
  const Eigen::VectorXd middle = r.input.row((block.begin + block.end) / 2).transpose();
  const double y0 = r.speed[(block.begin + block.end) / 2];
  for (int i = block.begin; i < block.end; ++i) {
    const int k = std::max(0, i - whole), before = std::max(0, k - 1);
    state = a * state + (1 - a) * ((1 - part) * r.input.row(k) + part * r.input.row(before)).transpose();
    if (i - block.begin < settle) continue;
    z.head(columns) = state - middle;
    z[columns] = 1;
    const double y = r.speed[i] - y0;
    H.noalias() += z * z.transpose();
    g += y * z;
    total += y * y;
  }
  Eigen::VectorXd s(columns + 1);
  for (Eigen::Index k = 0; k <= columns; ++k) s[k] = H(k, k) > 0 ? 1.0 / std::sqrt(H(k, k)) : 0.0;
  Eigen::MatrixXd h = s.asDiagonal() * H * s.asDiagonal();
  h.diagonal().array() += 1e-9;
  const Eigen::VectorXd q = s.asDiagonal() * g;
  return total - q.dot(h.ldlt().solve(q));
}

double misfit_all(const std::vector<Rotor>& rotors, double dt, double lag, double delay, const Block& block) {
  double sum = 0;
  for (const Rotor& r : rotors) sum += misfit(r, dt, lag, delay, block);
  return sum;
}

/// Minimum over lag and delay: a coarse grid, then a shrinking cross.
std::pair<double, double> search(const std::vector<Rotor>& rotors, double dt, const Block& block) {
  double lag = 0.03, delay = 0, best = 1e300;
  for (double tau : {0.0, 0.01, 0.02, 0.035, 0.05, 0.07, 0.1, 0.15, 0.25})
    for (double d : {0.0, 0.01, 0.02, 0.04, 0.07}) {
      const double m = misfit_all(rotors, dt, tau, d, block);
      if (m < best) best = m, lag = tau, delay = d;
    }
  for (double step = 0.008; step > 2e-4; step *= 0.5) {
    for (int tries = 0; tries < 6; ++tries) {
      bool better = false;
      const double directions[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};
      for (const auto& d : directions) {
        const double tau = std::max(0.0, lag + step * d[0]), late = std::clamp(delay + step * d[1], 0.0, 0.1);
        const double m = misfit_all(rotors, dt, tau, late, block);
        if (m < best * (1 - 1e-9)) best = m, lag = tau, delay = late, better = true;
      }
      if (!better) break;
    }
  }
  return {lag, delay};
}

}  // namespace

std::vector<ActuationFit> fit_actuation(const recording::Recording& recording,
                                        const vehicle::Vehicle& vehicle, const Flight& flight) {
  std::vector<ActuationFit> out;
  const recording::Signal* speed = recording.find("rotor_speed");
  const recording::Signal* command = recording.find("rotor_command");
  const bool pwm = command == nullptr;
  if (pwm) command = recording.find("pwm");
  if (!speed || !command || speed->width() != command->width() || speed->width() != vehicle.rotor_count())
    return out;
  const recording::Signal* vbat = recording.find("vbat");
  const double dt = std::clamp(std::max(speed->median_period_s(), command->median_period_s()), 0.002, 0.02);
  if (speed->median_period_s() > 0.03 || command->median_period_s() > 0.03) return out;
  // the longest uninterrupted stretch of free flight
  Segment longest;
  for (const Segment& s : flight.segments)
    if (s.end - s.begin > longest.end - longest.begin) longest = s;
  if (longest.end - longest.begin < 3 * flight.rate_hz) return out;
  const double from = flight.t[static_cast<std::size_t>(longest.begin)];
  const double to = std::min(flight.t[static_cast<std::size_t>(longest.end - 1)], from + 60.0);
  std::vector<double> t;
  for (double x = from; x <= to; x += dt) t.push_back(x);
  const Eigen::MatrixXd y = recording::resample(*speed, t, 0.1), u = recording::resample(*command, t, 0.1);
  Eigen::VectorXd volt;
  if (pwm && vbat) volt = recording::resample(*vbat, t).col(0);
  if (!y.allFinite() || !u.allFinite() || !volt.allFinite()) return out;
  const int n = static_cast<int>(t.size());
  std::set<int> boards;
  for (const vehicle::Rotor& r : vehicle.rotors) boards.insert(r.board);
  for (int board : boards) {
    ActuationFit fit;
    fit.board = board;
    fit.from_pwm = pwm;
    std::vector<Rotor> rotors;
    double variance = 0;
    for (Eigen::Index r = 0; r < y.cols(); ++r) {
      const vehicle::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(r)];
      if (rotor.board != board) continue;
      fit.nominal_lag_s = rotor.time_constant;
      Rotor one;
      one.speed = y.col(r);
      if (volt.size() > 0) {
        one.input.resize(n, 3);
        one.input << u.col(r), u.col(r).cwiseProduct(volt), volt;
      } else {
        one.input = u.col(r);
      }
      // what a motor does slowly (warming up, sagging supply) would pass for a longer lag
      if (pwm) {
        one.input -= low_pass(one.input, 1 / dt, 2.0);
        one.speed -= low_pass(one.speed, 1 / dt, 2.0);
      }
      variance += (one.speed.array() - one.speed.mean()).square().sum();
      rotors.push_back(std::move(one));
    }
    const int blocks = std::clamp(static_cast<int>((to - from) / 2.5), 2, 6);
    double lag = 0, delay = 0, lag2 = 0, delay2 = 0;
    for (int b = 0; b < blocks; ++b) {
      const auto [tau, late] = search(rotors, dt, {n * b / blocks, n * (b + 1) / blocks});
      lag += tau / blocks;
      delay += late / blocks;
      lag2 += tau * tau / blocks;
      delay2 += late * late / blocks;
    }
    fit.lag_se = std::sqrt(std::max(0.0, lag2 - lag * lag) / std::max(1, blocks - 1));
    fit.delay_se = std::sqrt(std::max(0.0, delay2 - delay * delay) / std::max(1, blocks - 1));
    std::tie(fit.lag_s, fit.delay_s) = search(rotors, dt, {0, n});
    fit.explained = 1.0 - misfit_all(rotors, dt, fit.lag_s, fit.delay_s, {0, n}) / std::max(1e-12, variance);
    const double count = static_cast<double>(n) * static_cast<double>(rotors.size());
    fit.rms_fitted = std::sqrt(std::max(0.0, misfit_all(rotors, dt, fit.lag_s, fit.delay_s, {0, n})) / count);
    fit.rms_nominal = std::sqrt(std::max(0.0, misfit_all(rotors, dt, fit.nominal_lag_s, 0, {0, n})) / count);
    if (fit.explained > 0.3) out.push_back(fit);
  }
  return out;
}

void add_actuation(const std::vector<std::vector<ActuationFit>>& flights, Diagnosis& diagnosis) {
  std::set<int> boards;
  for (const auto& f : flights)
    for (const ActuationFit& a : f) boards.insert(a.board);
  Finding lag, delay;
  double extra_lag = 0, extra_lag_se = 0;
  const physics::Effect* lag_effect = physics::find_effect("motor_lag");
  const physics::Effect* delay_effect = physics::find_effect("transport_delay");
  physics::ActiveEffect late{delay_effect, {}};
  if (delay_effect) late.theta.assign(static_cast<std::size_t>(delay_effect->parameter_count()), 0.0);
  const auto mismatch = [&](const std::string& where, double p,
                            const std::vector<const ActuationFit*>& fits) {
    Mismatch m;
    for (const ActuationFit* a : fits) {
      m.rms = std::max(m.rms, a->rms_nominal);
      m.noise_rms = std::max(m.noise_rms, a->rms_fitted);
    }
    m.stage = physics::Stage::actuation;
    m.channel = "rotor_speed";
    m.frame = "rotor";
    m.unit = "rad/s";
    m.where = where;
    m.p_value = p;
    diagnosis.mismatch.push_back(m);
  };
  bool lagging = false, delayed = false;
  char text[240];
  for (int board : boards) {
    double tau = 0, d = 0, tau_var = 0, d_var = 0, nominal = 0;
    std::vector<const ActuationFit*> fits;
    for (const auto& f : flights)
      for (const ActuationFit& a : f)
        if (a.board == board) fits.push_back(&a);
    const double count = static_cast<double>(fits.size());
    for (const ActuationFit* a : fits) {
      tau += a->lag_s / count;
      d += a->delay_s / count;
      tau_var += a->lag_se * a->lag_se / (count * count);
      d_var += a->delay_se * a->delay_se / (count * count);
      nominal = a->nominal_lag_s;
    }
    const double tau_se = std::sqrt(tau_var), d_se = std::sqrt(d_var), difference = tau - nominal;
    if (difference > std::max({4 * tau_se, 0.2 * nominal, 0.005})) {
      lagging = true;
      if (difference > extra_lag) extra_lag = difference, extra_lag_se = tau_se;
      std::snprintf(text, sizeof text,
                    "board %d follows its command with %.0f ms lag, the vehicle says %.0f ms", board,
                    1e3 * tau, 1e3 * nominal);
      mismatch(text, std::erfc(difference / std::max(1e-6, tau_se) / std::sqrt(2.0)), fits);
    }
    if (d > std::max(4 * d_se, 0.004) && delay_effect &&
        static_cast<std::size_t>(board) < late.theta.size()) {
      delayed = true;
      late.theta[static_cast<std::size_t>(board)] = d;
      const physics::Parameter& p = delay_effect->info().parameters[static_cast<std::size_t>(board)];
      delay.parameters.push_back(
          {p.name, p.symbol, p.unit, d, std::max(0.0, d - 1.96 * d_se), d + 1.96 * d_se});
      std::snprintf(text, sizeof text, "board %d acts %.0f ms after its command", board, 1e3 * d);
      mismatch(text, std::erfc(d / std::max(1e-6, d_se) / std::sqrt(2.0)), fits);
    }
  }
  const auto complete = [&](Finding& f, const physics::Effect& effect, const std::string& sentence) {
    f.effect = effect.info().id;
    f.probability = 0.99;
    f.stage = physics::Stage::actuation;
    f.channels = effect.info().channels;
    f.equation = effect.info().equation;
    f.latex = effect.info().latex;
    f.sentence = sentence;
    diagnosis.findings.push_back(f);
  };
  if (lagging && lag_effect) {
    const physics::Parameter& p = lag_effect->info().parameters[0];
    lag.parameters.push_back({p.name, p.symbol, p.unit, extra_lag, extra_lag - 1.96 * extra_lag_se,
                              extra_lag + 1.96 * extra_lag_se});
    std::snprintf(text, sizeof text,
                  "The rotors follow their commands %.0f ms more slowly than the vehicle file says.",
                  1e3 * extra_lag);
    complete(lag, *lag_effect, text);
    diagnosis.model.push_back({lag_effect, {extra_lag}});
  }
  if (delayed) {
    complete(delay, *delay_effect, "The rotors answer their commands after a pure delay.");
    diagnosis.model.push_back(late);
  }
}

}  // namespace omniflight::diagnosis
