#include "dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gate.hpp"
#include "state_variables.hpp"
#include "statistics.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kMostTerms = 5;
constexpr double kError = 0.002;  // chance of one false term, all candidates together

using physics::Feature;
using physics::Quantity;

/// Something that the rest may follow.
struct Candidate {
  std::string words, unit;
  std::vector<std::string> variables;
  bool even = false, body = true, world = true;  ///< the axes in which it makes sense
  Eigen::VectorXd x;
  std::optional<Feature> feature;  ///< as a simulator evaluates it
};

std::string squared(const std::string& unit) {
  return unit.find('/') == std::string::npos ? unit + "2" : "(" + unit + ")2";
}

std::string place(double width, double x, double y, double z) {
  char text[96];
  std::snprintf(text, sizeof text, "nearness, within %.2f m, to (%.2f, %.2f, %.2f) m", width, x, y, z);
  return text;
}

std::string wave(double length, double angle, double phase) {
  char text[96];
  std::snprintf(text, sizeof text, "%s of position, a wave of %.2f m along %.0f deg from x",
                phase > 0 ? "sine" : "cosine", length, angle * 180 / kPi);
  return text;
}

Eigen::VectorXd over(const Problem& problem, const auto& value_at) {
  Eigen::VectorXd x(problem.samples());
  for (int i = 0; i < problem.samples(); ++i) x[i] = value_at(problem.situation(i));
  return x;
}

Candidate of_quantities(const std::vector<Eigen::VectorXd>& values, int j, int k) {
  const Quantity& a = physics::quantities()[static_cast<std::size_t>(j)];
  Candidate out{a.words,
                a.unit,
                {a.variable},
                false,
                a.axes != Quantity::Axes::world,
                a.axes != Quantity::Axes::body,
                values[static_cast<std::size_t>(j)],
                Feature{.first = j, .second = k}};
  if (k < 0) return out;
  const Quantity& b = physics::quantities()[static_cast<std::size_t>(k)];
  out.x = out.x.cwiseProduct(values[static_cast<std::size_t>(k)]);
  out.words = j == k ? out.words + " squared" : out.words + " times " + b.words;
  out.unit = j == k ? squared(out.unit) : out.unit + " " + b.unit;
  if (std::string(b.variable) != a.variable) out.variables.emplace_back(b.variable);
  out.even = out.variables.size() == 1;
  out.body = out.body && b.axes != Quantity::Axes::world;
  out.world = out.world && b.axes != Quantity::Axes::body;
  return out;
}

std::vector<Candidate> candidates_of(const Problem& problem) {
  std::vector<Candidate> out;
  const auto add = [&](Candidate f) {
    if ((f.body || f.world) && f.x.maxCoeff() - f.x.minCoeff() > 1e-9 && f.x.allFinite())
      out.push_back(std::move(f));
  };
  const auto all = physics::quantities();
  const auto count = static_cast<int>(all.size());
  std::vector<Eigen::VectorXd> values;  // once for all their products
  for (const Quantity& q : all) values.push_back(over(problem, q.value));
  for (int j = 0; j < count; ++j) add(of_quantities(values, j, -1));
  for (int j = 0; j < count; ++j)
    for (int k = j; k < count; ++k)
      if (all[static_cast<std::size_t>(j)].pairs && all[static_cast<std::size_t>(k)].pairs)
        add(of_quantities(values, j, k));
  static constexpr const char* kAxis[] = {"x", "y", "z"};
  for (int c = 0; c < 3; ++c) {
    add({std::string("acceleration along ") + kAxis[c],
         "m/s2",
         {"acceleration"},
         false,
         true,
         false,
         over(problem, [&](const physics::Situation& s) { return s.a_WB_B[c]; }),
         {}});
    add({std::string("angular acceleration about ") + kAxis[c],
         "rad/s2",
         {"acceleration"},
         false,
         true,
         false,
         over(problem, [&](const physics::Situation& s) { return s.dw_WB_B[c]; }),
         {}});
  }
  // bumps where the vehicle has been
  const int n = problem.samples();
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
  for (int i = 0; i < n; ++i) {
    low = low.cwiseMin(problem.situation(i).body.p_WB);
    high = high.cwiseMax(problem.situation(i).body.p_WB);
  }
  for (const double width : {0.12, 0.25}) {
    const Vec3 step = ((high - low) / 4).cwiseMax(Vec3::Constant(1.5 * width));
    for (double x = low.x(); x <= high.x(); x += step.x())
      for (double y = low.y(); y <= high.y(); y += step.y())
        for (double z = low.z(); z <= high.z(); z += step.z()) {
          const Feature bump{.form = Feature::Form::bump, .center = {x, y, z}, .length = width};
          Candidate f{place(width, x, y, z),
                      "1",
                      {"position"},
                      true,
                      false,
                      true,
                      over(problem, [&](const physics::Situation& s) { return bump.at(s); }),
                      bump};
          if (f.x.sum() > 1.0 * n / 50) add(std::move(f));
        }
  }
  return out;
}

/// Waves over the floor, two columns a wave, of every direction and of lengths from a tenth of the way flown.
std::vector<Candidate> waves(const Problem& problem) {
  std::vector<Candidate> out;
  const int n = problem.samples();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (int i = 0; i < n; ++i) {
    low = low.cwiseMin(problem.situation(i).body.p_WB.head<2>());
    high = high.cwiseMax(problem.situation(i).body.p_WB.head<2>());
  }
  const double width = (high - low).maxCoeff();
  if (!(width > 0.2)) return out;
  constexpr int kDirections = 12;
  for (int d = 0; d < kDirections; ++d) {
    const double angle = kPi * d / kDirections;
    for (double length = std::max(0.1, width / 10); length < width; length *= 1.15)
      for (const double phase : {0.0, 0.5 * kPi}) {
        const Feature ripple{
            .form = Feature::Form::wave, .length = length, .direction = angle, .phase = phase};
        out.push_back({wave(length, angle, phase),
                       "1",
                       {"position"},
                       false,
                       false,
                       true,
                       over(problem, [&](const physics::Situation& s) { return ripple.at(s); }),
                       ripple});
      }
  }
  return out;
}

Eigen::VectorXd turned(const Problem& problem, const Eigen::VectorXd& residual, bool to_world) {
  Eigen::VectorXd out = residual;
  const int n = problem.samples();
  for (int i = 0; i < n; ++i) {
    const Mat3& R = problem.situation(i).R_WB;
    const Vec3 f(residual[i], residual[n + i], residual[2 * n + i]);
    const Vec3 g = to_world ? Vec3(R * f) : Vec3(R.transpose() * f);
    for (int c = 0; c < 3; ++c) out[c * n + i] = g[c];
  }
  return out;
}

/// Of a channel, its mean left out, under a noise model of its own.
double likelihood(const Problem& problem, const Eigen::VectorXd& y, int channel, const Options& o) {
  const int n = problem.samples();
  Eigen::VectorXd centred = y;
  centred.segment(channel * n, n).array() -= y.segment(channel * n, n).mean();
  return Whitening::autoregressive(problem, centred, o.ar_order)
      .channel_log_likelihood()[static_cast<std::size_t>(channel)];
}

/// Mean level of a spectrum around each line, from the median of its neighbours.
Eigen::VectorXd background(const Eigen::VectorXd& power) {
  constexpr Eigen::Index kSide = 24;
  Eigen::VectorXd out(power.size());
  for (Eigen::Index k = 0; k < power.size(); ++k) {
    const Eigen::Index from = std::max<Eigen::Index>(0, k - kSide),
                       to = std::min(power.size(), k + kSide + 1);
    std::vector<double> near(power.data() + from, power.data() + to);
    const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
    std::nth_element(near.begin(), middle, near.end());
    out[k] = std::max(*middle / std::log(2.0), 1e-300);
  }
  return out;
}

}  // namespace

std::vector<Term> select_terms(const Problem& problem, const Eigen::VectorXd& residual, const Options& o) {
  std::vector<Term> out;
  const int n = problem.samples();
  std::vector<Candidate> all = candidates_of(problem);
  for (Candidate& f : waves(problem)) all.push_back(std::move(f));
  const auto count = static_cast<Eigen::Index>(all.size());
  Eigen::VectorXd spreads(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& x = all[static_cast<std::size_t>(k)].x;
    spreads[k] = (x.array() - x.mean()).matrix().norm() / std::sqrt(static_cast<double>(n));
  }
  // sines: half a line apart, up to a fifth of the sampling rate
  double duration = 0;
  for (const Run& run : problem.runs()) duration = std::max(duration, (run.end - run.begin) / o.grid_hz);
  std::vector<double> frequencies;
  for (double f = 6 / std::max(1.0, duration); f < std::min(8.0, 0.2 * o.grid_hz);
       f += 0.5 / std::max(1.0, duration))
    frequencies.push_back(f);
  Eigen::MatrixXd cosine(n, static_cast<Eigen::Index>(frequencies.size())), sine(n, cosine.cols());
  for (Eigen::Index k = 0; k < cosine.cols(); ++k)
    for (int i = 0; i < n; ++i) {
      const double phase = 2 * kPi * frequencies[static_cast<std::size_t>(k)] * problem.situation(i).t;
      cosine(i, k) = std::cos(phase);
      sine(i, k) = std::sin(phase);
    }
  const int torques = problem.forces_only() ? 0 : 3;
  const double candidates = static_cast<double>(all.size()) * (6 + torques) +
                            static_cast<double>(frequencies.size()) * (6 + torques);
  const double entry = std::log(candidates / kError);
  const std::vector<StateVariable> state = state_variables(problem);
  Eigen::VectorXd body = residual;
  while (static_cast<int>(out.size()) < kMostTerms) {
    Term best;
    best.gain = entry;
    for (const bool world : {false, true}) {
      const Eigen::VectorXd y = world ? turned(problem, body, true) : body;
      int dof =
          0;  // the noise is what no state variable explains: what is slow would pass for noise otherwise
      const Whitening white =
          Whitening::autoregressive(problem, without_variables(problem, y, state, dof), o.ar_order);
      const Eigen::VectorXd e = white.apply_vector(problem, y);
      const Eigen::VectorXd level_out = Whitening::autoregressive(problem, y, 2).apply_vector(problem, y);
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
      Eigen::VectorXd one(n), x(n);
      for (int c = 0; c < (world ? 3 : 3 + torques); ++c) {
        white.apply_channel(problem, c, ones, one);
        one.normalize();
        Eigen::VectorXd rest = e.segment(c * n, n);
        rest -= one * one.dot(rest);
        for (Eigen::Index k = 0; k < count; ++k) {
          const Candidate& f = all[static_cast<std::size_t>(k)];
          if (!(world ? f.world : f.body)) continue;
          white.apply_channel(problem, c, f.x, x);
          const double off = one.dot(x), size = x.squaredNorm() - off * off;
          if (!(size > 1e-6 * x.squaredNorm())) continue;
          const double along = x.dot(rest), gain = 0.5 * along * along / size;
          if (gain <= best.gain) continue;
          if (std::abs(along / size) * spreads[k] < kLeastUnknown * problem.scale(c)) continue;
          best = {c,    world,        f.words, f.variables, f.even,
                  gain, along / size, f.unit,  0,           f.x.array() - f.x.mean(),
                  {}};
          if (f.feature) best.model = {c, world, *f.feature, 0, f.x.mean(), f.x.minCoeff(), f.x.maxCoeff()};
        }
        // a line against its neighbourhood in a flattened spectrum: a whitening of high order follows the
        // line
        const Eigen::VectorXd raw = y.segment(c * n, n), flat = level_out.segment(c * n, n);
        const Eigen::VectorXd a = cosine.transpose() * flat, b = sine.transpose() * flat;
        const Eigen::VectorXd level = background(a.cwiseAbs2() + b.cwiseAbs2());
        for (Eigen::Index k = 0; k < a.size(); ++k) {
          const double gain = (a[k] * a[k] + b[k] * b[k]) / level[k] - 1;  // two numbers
          if (gain <= best.gain) continue;
          const double p = 2.0 / n * cosine.col(k).dot(raw), q = 2.0 / n * sine.col(k).dot(raw);
          if (std::hypot(p, q) / std::sqrt(2.0) < kLeastUnknown * problem.scale(c)) continue;
          best = {c,
                  world,
                  "time, pulsating",
                  {"time"},
                  false,
                  gain,
                  std::hypot(p, q),
                  "1",
                  frequencies[static_cast<std::size_t>(k)],
                  (p * cosine.col(k) + q * sine.col(k)) / std::hypot(p, q),
                  {}};
          best.model = {
              .channel = c,
              .world = world,
              .feature = {
                  .form = Feature::Form::pulse, .frequency = best.frequency, .phase = std::atan2(q, p)}};
        }
      }
    }
    if (best.value.size() == 0) break;
    best.value *= best.coefficient;
    if (best.model) best.model->coefficient = best.coefficient;
    Eigen::VectorXd y = best.world ? turned(problem, body, true) : body;
    const double before = likelihood(problem, y, best.channel, o);
    y.segment(best.channel * n, n) -= best.value;
    // the noise before may have been made of the term, and the noise after of too many of them: ask both
    if (best.frequency == 0 && likelihood(problem, y, best.channel, o) - before < entry) break;
    body = best.world ? turned(problem, y, false) : y;
    out.push_back(std::move(best));
  }
  return out;
}

std::vector<Unexplained> as_unexplained(const Problem& problem, const std::vector<Term>& terms,
                                        const Eigen::VectorXd& residual) {
  std::vector<Unexplained> out;
  const int n = problem.samples();
  for (const Term& t : terms) {
    const std::string frame = t.world ? "world" : "body",
                      channel = kChannels[static_cast<std::size_t>(t.channel)];
    const Eigen::VectorXd all = t.world ? turned(problem, residual, true) : residual;
    const Eigen::VectorXd y = all.segment(t.channel * n, n);
    const CorrectionTerm term{t.words, t.coefficient, unit_per(t.channel, t.unit), t.frequency, t.model};
    const double share = 1 - (y - t.value).squaredNorm() / std::max(1e-300, y.squaredNorm());
    const auto known = std::find_if(out.begin(), out.end(), [&](const Unexplained& u) {
      return u.frame == frame && u.channel == channel;
    });
    if (known != out.end()) {
      for (const std::string& v : t.variables)
        if (std::find(known->depends_on.begin(), known->depends_on.end(), v) == known->depends_on.end())
          known->depends_on.push_back(v);
      known->share_of_residual += std::max(0.0, share);
      known->correction.push_back(term);
      continue;
    }
    Unexplained u;
    u.channel = channel;
    u.unit = channel_unit(t.channel);
    u.frame = frame;
    u.parity = t.even ? "even" : "odd";
    u.depends_on = t.variables;
    u.correction = {term};
    u.share_of_residual = std::max(0.0, share);
    double power = 0, turnover = 1e-300;
    for (int i = 0; i < n; ++i) {
      const physics::Situation& s = problem.situation(i);
      const double speed = t.channel >= 3 ? s.body.w_WB_B[t.channel - 3]
                           : t.world      ? s.body.v_WB_W[t.channel]
                                          : s.v_WB_B[t.channel];
      power += t.value[i] * speed;
      turnover += std::abs(t.value[i] * speed);
    }
    u.energy = power < -0.5 * turnover ? "dissipative" : power > 0.5 * turnover ? "driving" : "conservative";
    const std::string& v = t.variables.front();
    u.nearest = v == "speed" || v == "climb speed" || v == "rotor speed" ? "aerodynamics"
                : v == "height" || v == "position"                       ? "tether, load, contact"
                                                                         : "rigid body";
    out.push_back(std::move(u));
  }
  constexpr double kLeastShare = 0.03;
  std::erase_if(out, [](const Unexplained& u) { return u.share_of_residual < kLeastShare; });
  return out;
}

}  // namespace omniflight::diagnosis
