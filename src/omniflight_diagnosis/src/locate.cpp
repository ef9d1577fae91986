#include "locate.hpp"

#include <algorithm>
#include <cmath>

#include "state_variables.hpp"
#include "statistics.hpp"
#include "text.hpp"

namespace omniflight::diagnosis {
namespace {

/// Force rows turned into the world; torque rows untouched.
Eigen::VectorXd in_world(const Problem& problem, const Eigen::VectorXd& residual) {
  Eigen::VectorXd out = residual;
  const int n = problem.samples();
  for (int i = 0; i < n; ++i) {
    const Vec3 f(residual[i], residual[n + i], residual[2 * n + i]);
    const Vec3 w = problem.situation(i).R_WB * f;
    for (int c = 0; c < 3; ++c) out[c * n + i] = w[c];
  }
  return out;
}

/// "grows with height above 0.62 m: -2.45 N per m" for the variable that explains most.
std::string describe(const Eigen::VectorXd& y, const std::vector<StateVariable>& v, const char* unit,
                     double noise) {
  std::string text;
  if (std::abs(y.mean()) > 2 * noise) text = format("present throughout, mean %+.3g %s", y.mean(), unit);
  double best = 0.25;
  std::string dependence;
  for (const StateVariable& x : v) {
    if (spread(x.x) < 1e-3) continue;
    Eigen::VectorXd b;
    const double linear = explained_share(x.x, y, &b);
    if (linear > best) {
      best = linear;
      dependence = format("%s with %s: %+.3g %s per %s", b[0] * y.mean() >= 0 ? "grows" : "changes",
                          x.name.c_str(), b[0], unit, x.unit.c_str());
    }
    if (!x.hinge) continue;
    for (int k = 1; k < 30; ++k) {  // a kink counts when it beats the straight line clearly
      const double from = x.x.minCoeff() + k / 30.0 * spread(x.x);
      const Eigen::VectorXd above = (x.x.array() - from).max(0.0).matrix();
      const double share = explained_share(above, y, &b);
      if (share <= best + 0.002) continue;
      best = share;
      dependence = format("%s with %s above %.2f m: %+.3g %s per m",
                          b[0] * y.mean() >= 0 ? "grows" : "changes", x.name.c_str(), from, b[0], unit);
    }
  }
  if (text.empty()) return dependence;
  return dependence.empty() ? text : text + "; " + dependence;
}

/// Times of the first flight in which the half-second mean stays beyond the noise.
std::vector<std::pair<double, double>> windows(const Problem& problem, const Eigen::VectorXd& y,
                                               const Flight& flight, double threshold) {
  std::vector<std::pair<double, double>> out;
  const int half = std::max(1, static_cast<int>(0.25 * flight.rate_hz));
  for (const Run& run : problem.runs()) {
    if (run.flight != 0) continue;
    for (int i = run.begin; i < run.end; ++i) {
      const int a = std::max(run.begin, i - half), b = std::min(run.end, i + half + 1);
      if (std::sqrt(y.segment(a, b - a).squaredNorm() / (b - a)) < threshold) continue;
      const double t = problem.situation(i).t;
      if (!out.empty() && t - out.back().second < 0.5)
        out.back().second = t;
      else
        out.emplace_back(t, t);
    }
  }
  std::erase_if(out, [](const auto& w) { return w.second - w.first < 0.25; });
  return out;
}

}  // namespace

std::vector<Mismatch> locate_wrench(const Problem& problem, const Fit& before, const Fit& after,
                                    std::span<const Flight* const> flights, const Options& o) {
  std::vector<Mismatch> out;
  const int n = problem.samples();
  const std::vector<StateVariable> v = state_variables(problem);
  const std::array<Eigen::VectorXd, 2> frames{before.residual, in_world(problem, before.residual)};
  const Eigen::VectorXd raw_world = in_world(problem, problem.residual());
  const Eigen::VectorXd rest_world = in_world(problem, after.residual);
  const Whitening own_before = Whitening::autoregressive(problem, before.residual, o.ar_order);
  const Whitening own_after = Whitening::autoregressive(problem, after.residual, o.ar_order);
  std::array<std::array<double, 6>, 2> gain{};
  int dof = 0;
  for (std::size_t f = 0; f < 2; ++f) {
    const Whitening null = Whitening::autoregressive(problem, frames[f], o.ar_order);
    const Whitening full =
        Whitening::autoregressive(problem, without_variables(problem, frames[f], v, dof), o.ar_order);
    for (std::size_t c = 0; c < 6; ++c)
      gain[f][c] = full.channel_log_likelihood()[c] - null.channel_log_likelihood()[c];
  }
  for (int c = 0; c < 6; ++c) {
    const bool world = c == 2;
    const Eigen::VectorXd y = (world ? raw_world : problem.residual()).segment(c * n, n);
    const Eigen::VectorXd rest = (world ? rest_world : after.residual).segment(c * n, n);
    // what the model explains counts as well: a hypothesis may see what no state variable shows
    const auto k = static_cast<std::size_t>(c);
    const double by_model = own_after.channel_log_likelihood()[k] - own_before.channel_log_likelihood()[k];
    const double p_state = chi_squared_tail(2 * gain[world ? 1 : 0][k], dof);
    const double p_model = after.parameters > 0 ? chi_squared_tail(2 * by_model, after.parameters) : 1.0;
    const double p = std::min(1.0, 12 * std::min(p_state, p_model));
    const double size = rms(y), noise = rms(rest);
    if (p > 1e-3 || size * size - noise * noise < o.min_share * size * size ||
        std::sqrt(std::max(0.0, size * size - noise * noise)) < o.min_magnitude * problem.scale(c))
      continue;
    Mismatch m;
    m.channel = kChannels[k];
    m.frame = world ? "world" : "body";
    m.unit = channel_unit(c);
    m.p_value = p;
    m.rms = size;
    m.noise_rms = noise;
    m.where = describe(y, v, channel_unit(c), noise);
    m.windows_s = windows(problem, y, *flights[0], 2.0 * noise);
    out.push_back(std::move(m));
  }
  return out;
}

std::vector<Unexplained> locate_unexplained(const Problem& problem, const Fit& after, const Options& o) {
  std::vector<Unexplained> out;
  const int n = problem.samples();
  const std::vector<StateVariable> v = state_variables(problem);
  int dof = 0;
  const Eigen::VectorXd world = in_world(problem, after.residual);
  const Whitening null = Whitening::autoregressive(problem, world, o.ar_order);
  const Eigen::VectorXd left = without_variables(problem, world, v, dof);
  const Whitening full = Whitening::autoregressive(problem, left, o.ar_order);
  for (int c = 0; c < 6; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double p =
        chi_squared_tail(2 * (full.channel_log_likelihood()[k] - null.channel_log_likelihood()[k]), dof);
    const Eigen::VectorXd y = world.segment(c * n, n);
    const double share = 1.0 - left.segment(c * n, n).squaredNorm() / std::max(1e-300, y.squaredNorm());
    if (6 * p > 1e-6 || share < 0.3 || rms(y) * std::sqrt(share) < 5 * o.min_magnitude * problem.scale(c))
      continue;
    Unexplained u;
    u.channel = kChannels[k];
    u.unit = channel_unit(c);
    u.frame = c < 3 ? "world" : "body";
    u.share_of_residual = share;
    double best = 0;
    for (const StateVariable& x : v) {
      if (spread(x.x) < 1e-3) continue;
      Eigen::VectorXd b;
      const double s = explained_share(x.x, y, &b);
      if (s > 0.1) u.depends_on.push_back(x.name);
      if (s < best) continue;
      best = s;
      u.correction = {{x.name, b[0], unit_per(c, x.unit), 0, {}}};
      const Eigen::VectorXd centred = (x.x.array() - x.x.mean()).matrix();
      const double even = explained_share(centred.cwiseAbs2(), y);
      u.parity = even > s ? "even" : "odd";
      const bool speed = x.unit == "m/s" || x.unit == "rad/s";
      u.energy =
          speed ? (b[0] < 0 ? "dissipative" : "unknown") : (x.unit == "m" ? "conservative" : "unknown");
      u.nearest = speed ? "aerodynamics" : (x.name == "height" ? "tether, load, contact" : "rigid body");
    }
    out.push_back(std::move(u));
  }
  return out;
}

std::vector<Mismatch> locate_allocation(const recording::Recording& recording) {
  constexpr double kBlock = 0.5;  // s
  std::vector<Mismatch> out;
  const recording::Signal* desired = recording.find("qddr");
  const recording::Signal* allocated = recording.find("qdd");
  if (!desired || !allocated || desired->width() != 6 || allocated->width() != 6) return out;
  // an answer that is logged with the stamp of the next question is late, not short
  const double period = desired->median_period_s();
  std::vector<double> later = desired->t_s;
  for (double& t : later) t += period;
  const Eigen::MatrixXd now = recording::resample(*allocated, desired->t_s, 0.1),
                        next = recording::resample(*allocated, later, 0.1);
  static constexpr const char* names[] = {"ax", "ay", "az", "dwx", "dwy", "dwz"};
  for (Eigen::Index c = 0; c < 6; ++c) {
    Eigen::VectorXd miss(now.rows());
    double difference = 0, size = 0;
    int count = 0;
    for (Eigen::Index i = 0; i < now.rows(); ++i) {
      const double asked = desired->values(i, c), a = now(i, c) - asked, b = next(i, c) - asked;
      miss[i] = std::abs(a) <= std::abs(b) || !std::isfinite(b) ? a : b;
      if (!std::isfinite(miss[i])) continue;
      difference += miss[i] * miss[i];
      size += asked * asked;
      ++count;
    }
    if (count < 50) continue;
    const double off = std::sqrt(difference / count), limit = 0.05 + 0.1 * std::sqrt(size / count);
    if (off < limit) continue;
    Mismatch m;
    m.stage = physics::Stage::allocation;
    m.channel = names[c];
    m.frame = c < 3 ? "world" : "body";
    m.unit = c < 3 ? "m/s2" : "rad/s2";
    int missed = 0;
    for (Eigen::Index i = 0; i < miss.size(); ++i) {
      if (!(std::abs(miss[i]) > limit)) continue;
      ++missed;
      const double t = desired->t_s[static_cast<std::size_t>(i)];
      if (!m.windows_s.empty() && t - m.windows_s.back().second < kBlock)
        m.windows_s.back().second = t;
      else
        m.windows_s.emplace_back(t, t);
    }
    m.where = format(
        "what the allocator could not give of what the controller asked, by more than %.2g %s for %.0f %% of "
        "the time; both are computed, so that this is a comparison without noise and its p-value is 0 by "
        "definition",
        limit, m.unit.c_str(), 100.0 * missed / count);
    m.p_value = 0;
    m.rms = off;
    out.push_back(std::move(m));
  }
  return out;
}

}  // namespace omniflight::diagnosis
