#include "dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "state_variables.hpp"
#include "statistics.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kMostTerms = 5;
constexpr double kError = 0.002;  // chance of one false term, all candidates together

struct Feature {
  std::string words, unit;
  std::vector<std::string> variables;
  bool even = false, body = true, world = true;  ///< the axes in which it makes sense
  Eigen::VectorXd x;
};

/// Elementary quantities: a name, its unit, the variable it stands for, and whether it belongs to body or
/// world axes.
struct Base {
  const char *words, *unit, *variable;
  enum class Axes { body, world, both } axes;
  Eigen::VectorXd x;
};

std::vector<Base> elementary(const Problem& problem) {
  using A = Base::Axes;
  std::vector<Base> b{{"forward speed", "m/s", "speed", A::body, {}},
                      {"sideward speed", "m/s", "speed", A::body, {}},
                      {"speed along the body's z", "m/s", "speed", A::body, {}},
                      {"speed along x", "m/s", "speed", A::world, {}},
                      {"speed along y", "m/s", "speed", A::world, {}},
                      {"climb speed", "m/s", "climb speed", A::world, {}},
                      {"roll rate", "rad/s", "rate", A::both, {}},
                      {"pitch rate", "rad/s", "rate", A::both, {}},
                      {"yaw rate", "rad/s", "rate", A::both, {}},
                      {"position x", "m", "position", A::world, {}},
                      {"position y", "m", "position", A::world, {}},
                      {"height", "m", "height", A::both, {}},
                      {"distance from the middle", "m", "position", A::both, {}},
                      {"circulation about x", "rad/s", "rotor speed", A::body, {}},
                      {"circulation about y", "rad/s", "rotor speed", A::body, {}},
                      {"circulation about z", "rad/s", "rotor speed", A::body, {}},
                      {"total thrust", "N", "thrust", A::body, {}},
                      {"rotor tilt", "rad", "rotor tilt", A::both, {}},
                      {"speed", "m/s", "speed", A::both, {}}};
  for (Base& k : b) k.x.resize(problem.samples());
  for (int i = 0; i < problem.samples(); ++i) {
    const physics::Situation& s = problem.situation(i);
    Vec3 circulation = Vec3::Zero();
    double thrust = 0;
    for (const physics::RotorSituation& r : s.all_rotors()) {
      circulation += r.spin * r.speed * r.n_B;
      thrust += r.thrust;
    }
    const Vec3 &v = s.v_WB_B, &u = s.body.v_WB_W, &w = s.body.w_WB_B, &p = s.body.p_WB;
    const double values[] = {v.x(),
                             v.y(),
                             v.z(),
                             u.x(),
                             u.y(),
                             u.z(),
                             w.x(),
                             w.y(),
                             w.z(),
                             p.x(),
                             p.y(),
                             p.z(),
                             p.head<2>().norm(),
                             circulation.x(),
                             circulation.y(),
                             circulation.z(),
                             thrust,
                             s.alpha,
                             v.norm()};
    for (std::size_t k = 0; k < b.size(); ++k) b[k].x[i] = values[k];
  }
  return b;
}

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

std::vector<Feature> features(const Problem& problem) {
  const int n = problem.samples();
  const std::vector<Base> base = elementary(problem);
  std::vector<Feature> out;
  const auto add = [&](Feature f) {
    if (f.x.maxCoeff() - f.x.minCoeff() > 1e-9 && f.x.allFinite()) out.push_back(std::move(f));
  };
  using A = Base::Axes;
  for (const Base& b : base)
    add({b.words, b.unit, {b.variable}, false, b.axes != A::world, b.axes != A::body, b.x});
  for (std::size_t j = 0; j < base.size(); ++j)
    for (std::size_t k = j; k < base.size(); ++k) {
      const Base &a = base[j], &b = base[k];
      if ((a.axes == A::body && b.axes == A::world) || (a.axes == A::world && b.axes == A::body)) continue;
      std::vector<std::string> variables{a.variable};
      if (std::string(b.variable) != a.variable) variables.emplace_back(b.variable);
      const bool body = a.axes != A::world && b.axes != A::world;
      const bool world = a.axes != A::body && b.axes != A::body;
      add({j == k ? std::string(a.words) + " squared" : std::string(a.words) + " times " + b.words,
           j == k ? squared(a.unit) : std::string(a.unit) + " " + b.unit, variables, variables.size() == 1,
           body, world, a.x.cwiseProduct(b.x)});
    }
  static constexpr const char* kAxis[] = {"x", "y", "z"};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      Feature f{std::string("attitude, ") + kAxis[c] + " of the body along " + kAxis[r],
                "1",
                {"attitude"},
                false,
                true,
                true,
                Eigen::VectorXd(n)};
      for (int i = 0; i < n; ++i) f.x[i] = problem.situation(i).R_WB(r, c);
      add(std::move(f));
    }
  for (int c = 0; c < 3; ++c) {
    Feature a{std::string("acceleration along ") + kAxis[c],
              "m/s2",
              {"acceleration"},
              false,
              true,
              false,
              Eigen::VectorXd(n)};
    Feature d{std::string("angular acceleration about ") + kAxis[c],
              "rad/s2",
              {"acceleration"},
              false,
              true,
              false,
              Eigen::VectorXd(n)};
    for (int i = 0; i < n; ++i) {
      a.x[i] = problem.situation(i).a_WB_B[c];
      d.x[i] = problem.situation(i).dw_WB_B[c];
    }
    add(std::move(a));
    add(std::move(d));
  }
  // bumps where the vehicle has been
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
          Feature f{place(width, x, y, z), "1", {"position"}, true, false, true, Eigen::VectorXd(n)};
          for (int i = 0; i < n; ++i)
            f.x[i] = std::exp(-0.5 * (problem.situation(i).body.p_WB - Vec3(x, y, z)).squaredNorm() /
                              (width * width));
          if (f.x.sum() > 1.0 * n / 50) add(std::move(f));
        }
  }
  return out;
}

/// Waves over the floor, two columns a wave, of every direction and of lengths from a tenth of the way flown.
std::vector<Feature> waves(const Problem& problem) {
  std::vector<Feature> out;
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
        Feature f{wave(length, angle, phase), "1", {"position"}, false, false, true, Eigen::VectorXd(n)};
        for (int i = 0; i < n; ++i) {
          const Vec3& p = problem.situation(i).body.p_WB;
          f.x[i] = std::cos(2 * kPi / length * (std::cos(angle) * p.x() + std::sin(angle) * p.y()) - phase);
        }
        out.push_back(std::move(f));
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
  std::vector<Feature> all = features(problem);
  for (Feature& f : waves(problem)) all.push_back(std::move(f));
  const auto count = static_cast<Eigen::Index>(all.size());
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
      Eigen::MatrixXd columns(6 * n, 1 + count);
      columns.col(0).setOnes();
      for (Eigen::Index k = 0; k < count; ++k)
        columns.col(k + 1) = all[static_cast<std::size_t>(k)].x.replicate(6, 1);
      const Eigen::MatrixXd X = white.apply(problem, columns);
      for (int c = 0; c < (world ? 3 : 3 + torques); ++c) {
        const Eigen::VectorXd one = X.col(0).segment(c * n, n).normalized();
        Eigen::VectorXd rest = e.segment(c * n, n);
        rest -= one * one.dot(rest);
        for (Eigen::Index k = 0; k < count; ++k) {
          const Feature& f = all[static_cast<std::size_t>(k)];
          if (!(world ? f.world : f.body)) continue;
          auto x = X.col(k + 1).segment(c * n, n);
          const double off = one.dot(x), size = x.squaredNorm() - off * off;
          if (!(size > 1e-6 * x.squaredNorm())) continue;
          const double along = x.dot(rest), gain = 0.5 * along * along / size;
          if (gain <= best.gain) continue;
          best = {c,    world,        f.words, f.variables, f.even,
                  gain, along / size, f.unit,  0,           f.x.array() - f.x.mean()};
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
          best = {c,
                  world,
                  "time, pulsating",
                  {"time"},
                  false,
                  gain,
                  std::hypot(p, q),
                  "1",
                  frequencies[static_cast<std::size_t>(k)],
                  (p * cosine.col(k) + q * sine.col(k)) / std::hypot(p, q)};
        }
      }
    }
    if (best.value.size() == 0) break;
    best.value *= best.coefficient;
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
    const CorrectionTerm term{t.words, t.coefficient, unit_per(t.channel, t.unit), t.frequency};
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
  return out;
}

}  // namespace omniflight::diagnosis
