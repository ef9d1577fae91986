#include "actuation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "../numerics/text.hpp"
#include "omniflight_diagnosis/alignment_report.hpp"
#include "omniflight_diagnosis/filter.hpp"
#include "omniflight_physics/effect_ids.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kSearchedTo = 1e-4;   ///< s, of lags and delays
constexpr double kLeastDelay = 0.004;  ///< s, that is said

/// A stretch of time [s].
struct Block {
  double from = 0, to = 0;
};

/// What a command does between two samples: it rests (as a motor controller sees it), or it went on changing
/// because the log has only some of the commands.
enum class Between { held, straight };

/// One rotor: its command (columns: one input, or duty cycle, duty times voltage, voltage) and its speed,
/// each at its own times.
struct Rotor {
  std::vector<double> command_t, speed_t;  ///< s
  Eigen::MatrixXd input;
  Eigen::VectorXd speed;    ///< rad/s
  std::vector<char> turns;  ///< the speed can be believed: a rotor that nearly stops is measured badly
};

/// Exact first-order answer to one input that is held, or straight, between its samples.
class Lagged {
 public:
  Lagged(const Rotor& r, Between between, double lag, double delay, double from)
      : r_(r), between_(between), lag_(lag), delay_(delay) {
    const auto after = std::upper_bound(r.command_t.begin(), r.command_t.end(), from - delay);
    k_ = after == r.command_t.begin() ? 0 : static_cast<std::size_t>(after - r.command_t.begin()) - 1;
    state_ = r.input.row(static_cast<Eigen::Index>(k_)).transpose();
  }
  /// At time t [s], which must not decrease.
  const Eigen::VectorXd& at(double t) {
    while (k_ + 1 < r_.command_t.size() && r_.command_t[k_ + 1] + delay_ <= t) {
      move(r_.command_t[k_ + 1] - r_.command_t[k_], whole_step_, whole_keep_, state_);
      ++k_;
    }
    now_ = state_;
    move(std::max(0.0, t - delay_ - r_.command_t[k_]), part_step_, part_keep_, now_);
    return now_;
  }

 private:
  void move(double step, double& known_step, double& keep, Eigen::VectorXd& x) const {
    if (std::abs(step - known_step) > 1e-7) {
      known_step = step;
      keep = lag_ > 1e-5 ? std::exp(-step / lag_) : 0.0;
    }
    const auto k = static_cast<Eigen::Index>(k_);
    const bool rises = between_ == Between::straight && k_ + 1 < r_.command_t.size();
    for (Eigen::Index c = 0; c < x.size(); ++c) {
      const double u = r_.input(k, c);
      const double slope =
          rises ? (r_.input(k + 1, c) - u) / std::max(1e-6, r_.command_t[k_ + 1] - r_.command_t[k_]) : 0.0;
      x[c] = u + slope * (step - lag_) + (x[c] - u + slope * lag_) * keep;
    }
  }

  const Rotor& r_;
  Between between_;
  double lag_, delay_;
  std::size_t k_ = 0;
  double whole_step_ = -1, whole_keep_ = 0, part_step_ = -1, part_keep_ = 0;
  Eigen::VectorXd state_, now_;
};

/// Residual energy of speed against the lagged, delayed input with free gains and constant.
double misfit(const Rotor& r, Between between, double lag, double delay, const Block& block) {
  const Eigen::Index columns = r.input.cols();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(columns + 1, columns + 1);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(columns + 1), z(columns + 1);
  double total = 0;
  const double settled = block.from + std::min((block.to - block.from) / 3, 0.5);
  const auto first = std::lower_bound(r.speed_t.begin(), r.speed_t.end(), settled) - r.speed_t.begin();
  const auto last = std::lower_bound(r.speed_t.begin(), r.speed_t.end(), block.to) - r.speed_t.begin();
  if (first >= last) return 0;
  Lagged lagged(r, between, lag, delay, block.from);
  const Eigen::VectorXd middle = r.input.row(r.input.rows() / 2).transpose();
  const double y0 = r.speed[(first + last) / 2];
  for (auto i = first; i < last; ++i) {
    const Eigen::VectorXd& state = lagged.at(r.speed_t[static_cast<std::size_t>(i)]);
    if (!r.turns[static_cast<std::size_t>(i)]) continue;
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

double misfit_all(const std::vector<Rotor>& rotors, Between between, double lag, double delay,
                  const Block& block) {
  double sum = 0;
  for (const Rotor& r : rotors) sum += misfit(r, between, lag, delay, block);
  return sum;
}

/// Minimum over lag and delay: the vehicle's lag and a coarse grid, then a shrinking cross.
std::pair<double, double> search(const std::vector<Rotor>& rotors, Between between, double nominal_lag,
                                 const Block& block) {
  double lag = nominal_lag, delay = 0, best = misfit_all(rotors, between, lag, delay, block);
  for (double tau : {0.0, 0.01, 0.02, 0.035, 0.05, 0.07, 0.1, 0.15, 0.25})
    for (double d : {0.0, 0.01, 0.02, 0.04, 0.07}) {
      const double m = misfit_all(rotors, between, tau, d, block);
      if (m < best) best = m, lag = tau, delay = d;
    }
  for (double step = 0.008; step > kSearchedTo; step *= 0.5) {
    for (int tries = 0; tries < 6; ++tries) {
      bool better = false;
      const double directions[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};
      for (const auto& d : directions) {
        const double tau = std::max(0.0, lag + step * d[0]), late = std::clamp(delay + step * d[1], 0.0, 0.1);
        const double m = misfit_all(rotors, between, tau, late, block);
        if (m < best * (1 - 1e-9)) best = m, lag = tau, delay = late, better = true;
      }
      if (!better) break;
    }
  }
  return {lag, delay};
}

/// Indices of the samples in [from, to], at least `apart` seconds from each other; empty when one gap exceeds
/// 0.1 s.
std::vector<std::size_t> samples_of(const recording::Signal& s, double from, double to, double apart) {
  std::vector<std::size_t> out;
  double before = from;
  for (std::size_t i = 0; i < s.t_s.size(); ++i) {
    const double t = s.t_s[i];
    if (t < from || t > to || (!out.empty() && t < s.t_s[out.back()] + apart)) continue;
    if (!s.values.row(static_cast<Eigen::Index>(i)).allFinite()) continue;
    if (t - before > 0.1) return {};
    before = t;
    out.push_back(i);
  }
  return out;
}

/// Takes out what a motor does slowly (warming up, sagging supply): it would pass for a longer lag.
Eigen::MatrixXd without_slow_part(const std::vector<double>& t, const Eigen::MatrixXd& x, double dt) {
  recording::Signal fine, slow;
  fine.t_s = t;
  fine.values = x;
  for (double at = t.front(); at < t.back(); at += dt) slow.t_s.push_back(at);
  slow.t_s.push_back(t.back());
  slow.values = low_pass(recording::resample(fine, slow.t_s), 1 / dt, 2.0);
  return x - recording::resample(slow, t);
}

/// Whether the clock of the body's sensors, rotor speeds among them, agrees with that of the pose: as
/// commands come from the pose's side, they then have the clock of the speeds as well. Nothing when that
/// cannot be told.
std::optional<bool> clocks_agree(const Flight& flight) {
  for (const Alignment& a : flight.alignment)
    if (a.early == "gyro" && a.late == "attitude")
      return std::abs(a.lag_s) < 0.0015 + 2 * a.lag_se && std::abs(a.skew) < 5e-6 + 3 * a.skew_se;
  return {};
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
  if (speed->median_period_s() > 0.03 || command->median_period_s() > 0.03) return out;
  const double dt = std::clamp(std::max(speed->median_period_s(), command->median_period_s()), 0.002, 0.02);
  // the longest uninterrupted stretch of free flight
  Segment longest;
  for (const Segment& s : flight.segments)
    if (s.end - s.begin > longest.end - longest.begin) longest = s;
  if (longest.end - longest.begin < 3 * flight.rate_hz) return out;
  const double from = flight.t[static_cast<std::size_t>(longest.begin)];
  const double to = std::min({flight.t[static_cast<std::size_t>(longest.end - 1)], from + 60.0,
                              from + 15000 * std::max(1e-3, command->median_period_s())});
  const auto spins = samples_of(*speed, from, to, 0.0015), orders = samples_of(*command, from, to, 0);
  if (spins.size() < 100 || orders.size() < 100) return out;
  std::vector<double> speed_t, command_t;
  for (std::size_t i : spins) speed_t.push_back(speed->t_s[i]);
  for (std::size_t i : orders) command_t.push_back(command->t_s[i]);
  Eigen::VectorXd volt;
  if (pwm && vbat) volt = recording::resample(*vbat, command_t).col(0);
  if (!volt.allFinite()) return out;
  std::set<int> boards;
  for (const vehicle::Rotor& r : vehicle.rotors) boards.insert(r.board);
  for (int board : boards) {
    ActuationFit fit;
    fit.board = board;
    fit.from_pwm = pwm;
    std::vector<Rotor> rotors;
    double variance = 0, count = 0;
    for (Eigen::Index r = 0; r < speed->values.cols(); ++r) {
      const vehicle::Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(r)];
      if (rotor.board != board) continue;
      fit.nominal_lag_s = rotor.time_constant;
      Rotor one;
      one.speed_t = speed_t;
      one.command_t = command_t;
      one.speed.resize(static_cast<Eigen::Index>(spins.size()));
      Eigen::VectorXd u(static_cast<Eigen::Index>(orders.size()));
      for (std::size_t i = 0; i < spins.size(); ++i)
        one.speed[static_cast<Eigen::Index>(i)] = speed->values(static_cast<Eigen::Index>(spins[i]), r);
      for (std::size_t i = 0; i < orders.size(); ++i)
        u[static_cast<Eigen::Index>(i)] = command->values(static_cast<Eigen::Index>(orders[i]), r);
      std::vector<double> sizes(one.speed.data(), one.speed.data() + one.speed.size());
      for (double& x : sizes) x = std::abs(x);
      std::nth_element(sizes.begin(), sizes.begin() + static_cast<long>(sizes.size() / 2), sizes.end());
      const double ordinary = sizes[sizes.size() / 2];
      for (double x : one.speed) one.turns.push_back(std::abs(x) > 0.25 * ordinary ? 1 : 0);
      if (volt.size() > 0) {
        one.input.resize(u.size(), 3);
        one.input << u, u.cwiseProduct(volt), volt;
      } else {
        one.input = u;
      }
      if (pwm) {
        one.input = without_slow_part(command_t, one.input, dt);
        one.speed = without_slow_part(speed_t, one.speed, dt);
      }
      if (!one.input.allFinite() || !one.speed.allFinite()) return out;
      const double mean = one.speed.mean();
      for (std::size_t i = 0; i < spins.size(); ++i)
        if (one.turns[i]) variance += std::pow(one.speed[static_cast<Eigen::Index>(i)] - mean, 2), ++count;
      rotors.push_back(std::move(one));
    }
    const Block all{from, to};
    Between between = Between::held;
    double least = 1e300;
    for (Between way : {Between::held, Between::straight}) {
      const auto [tau, late] = search(rotors, way, fit.nominal_lag_s, all);
      const double left = misfit_all(rotors, way, tau, late, all);
      if (left >= least) continue;
      least = left;
      between = way;
      fit.lag_s = tau;
      fit.delay_s = late;
    }
    const int blocks = std::clamp(static_cast<int>((to - from) / 2.5), 2, 6);
    double lag = 0, delay = 0, lag2 = 0, delay2 = 0;
    for (int b = 0; b < blocks; ++b) {
      const auto [tau, late] =
          search(rotors, between, fit.nominal_lag_s,
                 {from + (to - from) * b / blocks, from + (to - from) * (b + 1) / blocks});
      lag += tau / blocks;
      delay += late / blocks;
      lag2 += tau * tau / blocks;
      delay2 += late * late / blocks;
    }
    fit.lag_se = std::sqrt(std::max(0.0, lag2 - lag * lag) / std::max(1, blocks - 1));
    fit.delay_se = std::sqrt(std::max(0.0, delay2 - delay * delay) / std::max(1, blocks - 1));
    // blocks that agree do so within the search's last step, and between two samples a command neither rests
    // nor runs straight
    const double floor = std::hypot(kSearchedTo, 0.04 * dt);
    fit.lag_se = std::hypot(fit.lag_se, floor);
    fit.delay_se = std::hypot(fit.delay_se, floor);
    fit.explained = 1.0 - least / std::max(1e-12, variance);
    fit.rms_fitted = std::sqrt(std::max(0.0, least) / std::max(1.0, count));
    fit.rms_nominal = std::sqrt(std::max(0.0, misfit_all(rotors, between, fit.nominal_lag_s, 0, all)) /
                                std::max(1.0, count));
    if (fit.explained > 0.3) out.push_back(fit);
  }
  // all boards late by the same time: that is the clock of the speeds, unless the clocks are seen to agree;
  // a single board has no second one to tell it by
  double common = 1;
  for (const ActuationFit& f : out) common = std::min(common, f.delay_s);
  constexpr double kStamps = 0.008;  // s: what stamps of telemetry and command may differ by, on all boards
  const bool stamps = boards.size() > 1 && out.size() == boards.size() && common < kStamps;
  if (!out.empty() && (stamps || !clocks_agree(flight).value_or(boards.size() == 1)))
    for (ActuationFit& f : out) f.delay_s -= common, f.shared_s = common;
  return out;
}

std::string on_shared_delay(const std::vector<ActuationFit>& fits) {
  for (const ActuationFit& f : fits) {
    const double shorter = std::min(0.0, f.lag_s - f.nominal_lag_s);  // which a delay pays for
    if (!(f.shared_s + shorter > std::max(4 * f.delay_se, kLeastDelay))) return {};
  }
  if (fits.empty()) return {};
  return format(
      "On all boards rotor speeds are another %.0f ms later than their commands: a delay of the motors or "
      "other "
      "stamps. This recording does not tell them apart, and the model has neither; stamping both by one "
      "clock "
      "would tell.",
      1e3 * fits.front().shared_s);
}

void add_actuation(const std::vector<std::vector<ActuationFit>>& flights, Diagnosis& diagnosis) {
  std::set<int> boards;
  for (const auto& f : flights)
    for (const ActuationFit& a : f) boards.insert(a.board);
  Finding lag, delay;
  double extra_lag = 0, extra_lag_se = 0;
  const physics::Effect* lag_effect = physics::find_effect(physics::effect_id::motor_lag);
  const physics::Effect* delay_effect = physics::find_effect(physics::effect_id::transport_delay);
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
    // a shorter lag that a delay pays for is none
    const double seen = difference > 0 ? difference : std::max(0.0, -difference - std::max(0.0, d));
    if (seen > std::max({4 * tau_se, 0.2 * nominal, 0.005})) {
      lagging = true;
      if (std::abs(difference) > std::abs(extra_lag)) extra_lag = difference, extra_lag_se = tau_se;
      std::snprintf(text, sizeof text,
                    "board %d follows its command with %.0f ms lag, the vehicle says %.0f ms", board,
                    1e3 * tau, 1e3 * nominal);
      mismatch(text, std::erfc(seen / std::max(1e-6, tau_se) / std::sqrt(2.0)), fits);
    }
    // nor is a delay that a shorter lag pays for
    if (d + std::min(0.0, difference) > std::max(4 * d_se, kLeastDelay) && delay_effect &&
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
                  "The rotors follow their commands %.0f ms more %s than the vehicle file says.",
                  1e3 * std::abs(extra_lag), extra_lag > 0 ? "slowly" : "quickly");
    complete(lag, *lag_effect, text);
    diagnosis.model.push_back({lag_effect, {extra_lag}});
  }
  if (delayed) {
    complete(delay, *delay_effect, "The rotors answer their commands after a pure delay.");
    diagnosis.model.push_back(late);
  }
}

}  // namespace omniflight::diagnosis
