#include "fit.hpp"

#include <algorithm>
#include <cmath>

#include "statistics.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::Effect;
using physics::Parameter;

/// All unknowns in one vector: effect parameters in order, then offsets, with bounds and priors.
struct Unknowns {
  Eigen::VectorXd x, lower, upper, weight;  ///< weight: 1/sigma^2 of the prior about zero

  Unknowns(const Problem& problem, const std::vector<ActiveEffect>& effects, const Eigen::VectorXd* offsets) {
    std::vector<double> v, lo, hi;
    for (const ActiveEffect& e : effects) {
      for (std::size_t k = 0; k < e.theta.size(); ++k) {
        const Range range = problem.range(*e.effect, k);
        lo.push_back(range.lower);
        hi.push_back(range.upper);
        v.push_back(std::clamp(e.theta[k], lo.back(), hi.back()));
      }
    }
    const auto m = static_cast<Eigen::Index>(v.size());
    const Eigen::Index offset_count = problem.offset_sigma().size();
    x = Eigen::VectorXd::Zero(m + offset_count);
    lower = Eigen::VectorXd::Constant(m + offset_count, -1e9);
    upper = -lower;
    weight = Eigen::VectorXd::Zero(m + offset_count);
    for (Eigen::Index k = 0; k < m; ++k) {
      x[k] = v[static_cast<std::size_t>(k)];
      lower[k] = lo[static_cast<std::size_t>(k)];
      upper[k] = hi[static_cast<std::size_t>(k)];
    }
    limit_offsets(problem.offset_sigma());
    if (offsets && offsets->size() == offset_count)
      x.tail(offset_count) = offsets->cwiseMax(lower.tail(offset_count)).cwiseMin(upper.tail(offset_count));
  }

  /// Prior and hard limit of three standard deviations: no amount of data turns a tolerance into an effect.
  void limit_offsets(const Eigen::VectorXd& sigma) {
    weight.tail(sigma.size()) = sigma.cwiseAbs2().cwiseInverse();
    lower.tail(sigma.size()) = -3 * sigma;
    upper.tail(sigma.size()) = 3 * sigma;
  }
};

}  // namespace

bool at_limit(const Problem& problem, const ActiveEffect& e) {
  if (contradicts_itself(e, problem.vehicle_scale())) return true;
  for (std::size_t k = 0; k < e.theta.size(); ++k) {
    if (!std::isfinite(e.theta[k])) return true;
    const Parameter& p = e.effect->info().parameters[k];
    if (is_shape(p)) continue;  // the bend of a law may lie outside the flight
    const auto [low, high] = problem.range(*e.effect, k);
    const double near = 1e-3 * (high - low);
    if (high != p.neutral && e.theta[k] > high - near) return true;
    if (low != p.neutral && e.theta[k] < low + near) return true;
  }
  return false;
}

namespace {

void take(const Eigen::VectorXd& x, std::vector<ActiveEffect>& effects) {
  Eigen::Index k = 0;
  for (ActiveEffect& e : effects)
    for (double& t : e.theta) t = x[k++];
}

/// What remains, and the columns, at x.
void predict(const Problem& problem, std::vector<ActiveEffect>& effects, const Eigen::VectorXd& x,
             Eigen::VectorXd& rest, Eigen::MatrixXd* jacobian) {
  take(x, effects);
  problem.predict(effects, x.tail(problem.offset_sigma().size()), rest, jacobian);
}

/// Minimises 1/2 d'Hd - g'd with x + d inside the bounds, by fixing violated bounds one after another.
Eigen::VectorXd bounded_step(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Unknowns& u) {
  const Eigen::Index m = g.size();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(m);
  std::vector<char> fixed(static_cast<std::size_t>(m), 0);
  for (Eigen::Index round = 0; round <= m; ++round) {
    std::vector<Eigen::Index> open;
    for (Eigen::Index k = 0; k < m; ++k)
      if (!fixed[static_cast<std::size_t>(k)]) open.push_back(k);
    const auto size = static_cast<Eigen::Index>(open.size());
    if (size == 0) break;
    Eigen::MatrixXd h(size, size);
    Eigen::VectorXd r(size), scale(size);
    for (Eigen::Index a = 0; a < size; ++a) {
      r[a] = g[open[static_cast<std::size_t>(a)]];
      for (Eigen::Index k = 0; k < m; ++k)
        if (fixed[static_cast<std::size_t>(k)]) r[a] -= H(open[static_cast<std::size_t>(a)], k) * step[k];
      for (Eigen::Index b = 0; b < size; ++b)
        h(a, b) = H(open[static_cast<std::size_t>(a)], open[static_cast<std::size_t>(b)]);
      scale[a] = h(a, a) > 0 ? 1.0 / std::sqrt(h(a, a)) : 0.0;
    }
    h = scale.asDiagonal() * h * scale.asDiagonal();
    h.diagonal().array() += 1e-10;
    const Eigen::VectorXd d = scale.asDiagonal() * h.ldlt().solve(scale.asDiagonal() * r);
    bool violated = false;
    for (Eigen::Index a = 0; a < size; ++a) {
      const Eigen::Index k = open[static_cast<std::size_t>(a)];
      step[k] = d[a];
      const double to = u.x[k] + d[a];
      if (to < u.lower[k] - 1e-12 || to > u.upper[k] + 1e-12) {
        step[k] = std::clamp(to, u.lower[k], u.upper[k]) - u.x[k];
        fixed[static_cast<std::size_t>(k)] = 1;
        violated = true;
      }
    }
    if (!violated) break;
  }
  return step;
}

double cost(const Eigen::VectorXd& whitened, const Unknowns& u, const Eigen::VectorXd& x) {
  return 0.5 * whitened.squaredNorm() + 0.5 * u.weight.dot(x.cwiseAbs2());
}

/// Gauss-Newton with step halving under a fixed whitening; returns what remains of the residual.
Eigen::VectorXd minimise(const Problem& problem, std::vector<ActiveEffect>& effects, Unknowns& u,
                         const Whitening& whitening, int iterations) {
  bool linear = true;
  for (const ActiveEffect& e : effects) linear = linear && has_constant_columns(*e.effect);
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd rest, left;
  for (int iteration = 0; iteration < (linear ? 1 : iterations); ++iteration) {
    predict(problem, effects, u.x, rest, &jacobian);
    const Eigen::VectorXd r = whitening.apply_vector(problem, rest);
    const Eigen::MatrixXd X = whitening.apply(problem, jacobian);
    Eigen::MatrixXd H = X.transpose() * X;
    H.diagonal() += u.weight;
    const Eigen::VectorXd g = X.transpose() * r - u.weight.cwiseProduct(u.x);
    const Eigen::VectorXd step = bounded_step(H, g, u);
    if (linear) {
      u.x += step;
      rest -= jacobian * step;
      break;
    }
    const double now = cost(r, u, u.x);
    double size = 1.0, best = now;
    Eigen::VectorXd to = u.x;
    for (int halving = 0; halving < 6; ++halving, size *= 0.4) {
      const Eigen::VectorXd trial = (u.x + size * step).cwiseMax(u.lower).cwiseMin(u.upper);
      predict(problem, effects, trial, left, nullptr);
      const double c = cost(whitening.apply_vector(problem, left), u, trial);
      if (c < best) {
        best = c;
        to = trial;
        rest = left;
        break;
      }
    }
    const bool settled = now - best < 0.01 + 1e-7 * now;
    u.x = to;
    if (settled) break;
  }
  take(u.x, effects);
  return rest;
}

}  // namespace

namespace {

Fit fit_under(const Problem& problem, const std::vector<ActiveEffect>& start, int iterations,
              const Eigen::VectorXd* offset_sigma = nullptr) {
  Fit fit;
  fit.effects = start;
  Unknowns u(problem, start, nullptr);
  if (offset_sigma) u.limit_offsets(*offset_sigma);
  fit.residual = minimise(problem, fit.effects, u, problem.noise(), iterations);
  fit.offsets = u.x.tail(problem.offset_sigma().size());
  fit.log_likelihood = -cost(problem.noise().apply_vector(problem, fit.residual), u, u.x);
  for (const ActiveEffect& e : fit.effects) fit.parameters += e.effect->parameter_count();
  return fit;
}

/// The base's effects and one more, its shape parameters at their best on a grid.
/// With a hint the shapes are taken from it and only the amplitudes are solved for.
std::vector<ActiveEffect> start_with(const Problem& problem, const Fit& base, const Effect& effect,
                                     const std::vector<double>* hint) {
  const auto& parameters = effect.info().parameters;
  std::vector<double> theta;
  std::vector<std::size_t> shapes;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    theta.push_back(parameters[k].linear ? parameters[k].neutral : parameters[k].typical);
    if (is_shape(parameters[k])) shapes.push_back(k);
  }
  std::vector<ActiveEffect> start = base.effects;
  start.push_back({&effect, theta});
  // amplitudes are free in the search, shapes are profiled one after another, everything else linearised
  const auto amplitude = [&](std::size_t k) { return !is_shape(parameters[k]); };
  const Whitening& whitening = problem.noise();
  if (!shapes.empty()) {
    std::vector<Eigen::Index> free;
    for (std::size_t c = 0; c < parameters.size(); ++c)
      if (amplitude(c)) free.push_back(static_cast<Eigen::Index>(c));
    const auto own = static_cast<Eigen::Index>(free.size());
    // unknowns: the effect's amplitudes first, then everything else, linearised once
    Unknowns others(problem, base.effects, &base.offsets), u = others;
    const Eigen::Index rest_size = others.x.size();
    for (Eigen::VectorXd* v : {&u.x, &u.lower, &u.upper, &u.weight}) v->resize(own + rest_size);
    u.x << Eigen::VectorXd::Zero(own), others.x;
    u.weight << Eigen::VectorXd::Zero(own), others.weight;
    u.lower.tail(rest_size) = others.lower;
    u.upper.tail(rest_size) = others.upper;
    for (Eigen::Index c = 0; c < own; ++c) {
      u.x[c] = parameters[static_cast<std::size_t>(free[static_cast<std::size_t>(c)])].neutral;
      const Range range = problem.range(effect, static_cast<std::size_t>(free[static_cast<std::size_t>(c)]));
      u.lower[c] = range.lower;
      u.upper[c] = range.upper;
    }
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(base.offsets.size());
    Eigen::MatrixXd jacobian = jacobian_of(problem, base);
    Eigen::VectorXd rest;
    const Eigen::MatrixXd Z = whitening.apply(problem, jacobian);
    const Eigen::VectorXd target = whitening.apply_vector(problem, base.residual);
    Eigen::MatrixXd H(own + rest_size, own + rest_size);
    Eigen::VectorXd g(own + rest_size);
    H.bottomRightCorner(rest_size, rest_size) = Z.transpose() * Z;
    H.bottomRightCorner(rest_size, rest_size).diagonal() += others.weight;
    g.tail(rest_size) = Z.transpose() * target - others.weight.cwiseProduct(others.x);
    std::vector<ActiveEffect> alone{start.back()};
    std::vector<double>& theta_now = alone[0].theta;
    for (std::size_t c = 0; c < parameters.size(); ++c)
      if (amplitude(c)) theta_now[c] = parameters[c].neutral;
    std::vector<double> amplitudes(parameters.size(), 0.0);
    if (hint)
      for (std::size_t shape : shapes) theta_now[shape] = (*hint)[shape];
    const bool heavy = adds_inertia(effect);
    if (hint) shapes.resize(1);
    for (std::size_t shape : shapes) {
      const Parameter& p = parameters[shape];
      double best = -1, chosen = theta_now[shape];
      const int points = hint ? 0 : 24;
      for (int k = 0; k <= points; ++k) {
        const double share = k / 24.0;
        if (!hint)
          theta_now[shape] = p.lower > 0 ? p.lower * std::pow(p.upper / p.lower, share)
                                         : p.lower + share * (p.upper - p.lower);
        Eigen::MatrixXd columns;
        if (heavy) {
          problem.predict(alone, none, rest, &jacobian);
          columns.resize(jacobian.rows(), own);
          for (Eigen::Index c = 0; c < own; ++c)
            columns.col(c) = jacobian.col(free[static_cast<std::size_t>(c)]);
        } else {
          problem.amplitude_columns(effect, theta_now, free, columns);
        }
        const Eigen::MatrixXd X = whitening.apply(problem, columns);
        H.topLeftCorner(own, own) = X.transpose() * X;
        H.topRightCorner(own, rest_size) = X.transpose() * Z;
        H.bottomLeftCorner(rest_size, own) = H.topRightCorner(own, rest_size).transpose();
        g.head(own) = X.transpose() * target;
        const Eigen::VectorXd step = bounded_step(H, g, u);
        const double gain = g.dot(step) - 0.5 * step.dot(H * step);
        if (gain <= best * (1 + 1e-9) + 1e-9) continue;
        best = gain;
        chosen = theta_now[shape];
        for (Eigen::Index c = 0; c < own; ++c)
          amplitudes[static_cast<std::size_t>(free[static_cast<std::size_t>(c)])] = u.x[c] + step[c];
      }
      theta_now[shape] = chosen;
    }
    for (std::size_t c = 0; c < parameters.size(); ++c)
      start.back().theta[c] =
          amplitude(c) ? std::clamp(amplitudes[c], parameters[c].lower, parameters[c].upper) : theta_now[c];
  }
  for (std::size_t c = 0; c < parameters.size(); ++c)
    if (!parameters[c].linear && amplitude(c) && std::abs(start.back().theta[c]) < 1e-12)
      start.back().theta[c] = 1e-3 * parameters[c].typical;  // leave the stationary point of a product
  return start;
}

}  // namespace

Fit fit_effects(const Problem& problem, const std::vector<ActiveEffect>& start, const Options&) {
  return fit_under(problem, start, 12);
}

Fit fit_with(const Problem& problem, const Fit& base, const Effect& effect, const Options&) {
  return fit_under(problem, start_with(problem, base, effect, nullptr), 12);
}

Fit profile_shapes(const Problem& problem, const Fit& fit, const Options&) {
  std::vector<Fit> met{fit};
  for (std::size_t e = 0; e < fit.effects.size(); ++e) {
    const auto& parameters = fit.effects[e].effect->info().parameters;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const Parameter& p = parameters[k];
      if (!is_shape(p)) continue;
      const double step = (p.upper - p.lower) / 150;
      for (int n = -5; n <= 5; ++n) {
        std::vector<ActiveEffect> start = fit.effects;
        start[e].theta[k] += n * step;
        if (n != 0 && start[e].theta[k] > p.lower && start[e].theta[k] < p.upper)
          met.push_back(fit_under(problem, start, 6));
      }
    }
  }
  Fit best = *std::max_element(
      met.begin(), met.end(), [](const Fit& a, const Fit& b) { return a.log_likelihood < b.log_likelihood; });
  for (const Fit& f : met) {
    if (f.log_likelihood < best.log_likelihood - 1.92) continue;
    std::size_t at = 0;
    for (const ActiveEffect& e : f.effects)
      for (double value : e.theta) {
        if (at == best.plausible.size()) best.plausible.emplace_back(value, value);
        auto& [low, high] = best.plausible[at++];
        low = std::min(low, value);
        high = std::max(high, value);
      }
  }
  return best;
}

Eigen::VectorXd settled_offsets(const Problem& problem, const Fit& fit) {
  bool pitches = false, lifts = false;
  for (const ActiveEffect& e : fit.effects) {
    const auto& channels = e.effect->info().channels;
    const auto moves = [&](const char* c) {
      return std::find(channels.begin(), channels.end(), c) != channels.end();
    };
    pitches = pitches || moves("Mx") || moves("My") || moves("Mz");
    lifts = lifts || moves("Fz");
  }
  Eigen::VectorXd sigma = problem.offset_sigma();
  if (lifts && sigma[0] < 0.1) {  // a scale that nobody knows stays free
    sigma[0] *= 0.05;
    sigma.segment(4, 3) *= 0.05;
  }
  if (pitches && sigma[1] < 0.1) sigma.segment(1, 3) *= 0.05;
  return sigma;
}

Fit settle(const Problem& problem, const Fit& fit, const Options&) {
  const Eigen::VectorXd sigma = settled_offsets(problem, fit);
  Fit out = fit_under(problem, fit.effects, 12, &sigma);
  out.plausible = fit.plausible;
  return out;
}

Fit quick_with(const Problem& problem, const Fit& base, const Effect& effect, const Options&,
               const std::vector<double>* hint) {
  // the change of a mass is far from linear
  return fit_under(problem, start_with(problem, base, effect, hint), adds_inertia(effect) ? 4 : 1);
}

Eigen::MatrixXd jacobian_of(const Problem& problem, const Fit& fit) {
  std::vector<ActiveEffect> effects = fit.effects;
  Unknowns u(problem, fit.effects, &fit.offsets);
  Eigen::VectorXd rest;
  Eigen::MatrixXd jacobian;
  predict(problem, effects, u.x, rest, &jacobian);
  return jacobian;
}

Eigen::VectorXd contribution_of(const Problem& problem, const Fit& fit, std::size_t index) {
  std::vector<ActiveEffect> others = fit.effects;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(index));
  Eigen::VectorXd rest;
  problem.predict(others, fit.offsets, rest, nullptr);
  return rest - fit.residual;
}

namespace {

/// Blocks of a second or more, about twenty a flight; rows of one block share an index.
std::vector<int> blocks_of(const Problem& problem, int& count) {
  std::vector<int> block(static_cast<std::size_t>(problem.samples()), 0);
  const int length = std::max(40, problem.samples() / (20 * std::max(1, problem.flights())));
  count = 0;
  for (const Run& run : problem.runs()) {
    const int parts = std::max(1, (run.end - run.begin + length / 2) / length);
    for (int i = run.begin; i < run.end; ++i)
      block[static_cast<std::size_t>(i)] =
          count + static_cast<int>(static_cast<long>(i - run.begin) * parts / (run.end - run.begin));
    count += parts;
  }
  return block;
}

/// As many equal blocks as these are worth by their information.
double worth_of(const std::vector<double>& information) {
  double sum = 1e-300, squares = 0;
  for (double v : information) sum += v;
  for (double v : information) squares += std::pow(v / sum, 2);
  return squares > 0 ? 1 / squares : 0.0;
}

/// Mean of the gains in its standard errors. Where blocks differ much in how strongly the effect acts, their
/// gains spread for that reason alone: then the gain per information (ratio estimator) is asked as well, as a
/// normal score; two stands for an error rate of one per cent.
double standard_errors_above_zero(const std::vector<double>& gains, const std::vector<double>& information) {
  const auto count = static_cast<double>(gains.size());
  double mean = 0, all = 1e-300, variance = 0, off = 0;
  for (double v : gains) mean += v / count;
  for (double v : information) all += v;
  for (std::size_t k = 0; k < gains.size(); ++k) {
    const double share = information[k] / all;
    variance += std::pow(gains[k] - mean, 2) / std::max(1.0, count - 1);
    off += std::pow(gains[k] - count * mean * share, 2);
  }
  if (!(variance > 0)) return mean > 0 ? 1e9 : 0.0;
  const double plain = mean / std::sqrt(variance / count);
  const double worth = worth_of(information), freedom = worth - 1;
  if (freedom < 1 || !(off > 0)) return plain;
  const double t = count * mean / std::sqrt(off / (1 - 1 / worth));
  const double score = t * (1 - 0.25 / freedom) / std::sqrt(1 + 0.5 * t * t / freedom);
  constexpr double kOnePercent = 2.326;
  return std::max(plain, 2 / kOnePercent * score);
}

}  // namespace

namespace {

/// Of the effects' parameters: as the noise model has it, and by the scatter of blocks (sandwich).
struct Covariance {
  Eigen::MatrixXd model, robust;
  Eigen::VectorXd scale;  ///< 0 where the data say nothing
};

Covariance covariance_of(const Problem& problem, const Fit& fit) {
  const Eigen::MatrixXd X = problem.noise().apply(problem, jacobian_of(problem, fit));
  const Eigen::VectorXd e = problem.noise().apply_vector(problem, fit.residual);
  Eigen::MatrixXd H = X.transpose() * X;
  const Eigen::Index offset_count = problem.offset_sigma().size(), m = H.rows() - offset_count;
  H.diagonal().tail(offset_count) += problem.offset_sigma().cwiseAbs2().cwiseInverse();
  Eigen::VectorXd scale(H.rows());
  for (Eigen::Index k = 0; k < H.rows(); ++k) scale[k] = H(k, k) > 0 ? 1.0 / std::sqrt(H(k, k)) : 0.0;
  Eigen::MatrixXd h = scale.asDiagonal() * H * scale.asDiagonal();
  h.diagonal().array() += 1e-12;
  const Eigen::MatrixXd inverse =
      scale.asDiagonal() * h.ldlt().solve(Eigen::MatrixXd::Identity(h.rows(), h.rows())) * scale.asDiagonal();
  int count = 0;
  const std::vector<int> block = blocks_of(problem, count);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(H.rows(), count);
  const int n = problem.samples();
  for (int c = 0; c < 6; ++c)
    for (int i = 0; i < n; ++i)
      scores.col(block[static_cast<std::size_t>(i)]) += e[c * n + i] * X.row(c * n + i).transpose();
  const double small_sample = count > 1 ? static_cast<double>(count) / (count - 1) : 1.0;
  const Eigen::MatrixXd robust = small_sample * inverse * (scores * scores.transpose()) * inverse;
  return {inverse.topLeftCorner(m, m), robust.topLeftCorner(m, m), scale.head(m)};
}

}  // namespace

Eigen::VectorXd standard_errors(const Problem& problem, const Fit& fit, const Options&) {
  const Covariance c = covariance_of(problem, fit);
  Eigen::VectorXd se(c.model.rows());
  for (Eigen::Index k = 0; k < se.size(); ++k) {
    se[k] = std::sqrt(std::max({c.model(k, k), c.robust(k, k), 0.0}));
    if (c.scale[k] == 0.0) se[k] = 1e9;  // the data say nothing about it
  }
  return se;
}

std::vector<double> distances_from_nothing(const Problem& problem, const Fit& fit, const Options&) {
  const Covariance c = covariance_of(problem, fit);
  std::vector<double> out;
  Eigen::Index at = 0;
  for (const ActiveEffect& e : fit.effects) {
    std::vector<Eigen::Index> own;
    std::vector<double> off;
    for (std::size_t k = 0; k < e.theta.size(); ++k, ++at) {
      const Parameter& p = e.effect->info().parameters[k];
      if (is_shape(p) || c.scale[at] == 0.0) continue;
      own.push_back(at);
      off.push_back(e.theta[k] - p.neutral);
    }
    const auto m = static_cast<Eigen::Index>(own.size());
    const Eigen::Map<const Eigen::VectorXd> d(off.data(), m);
    double least = m > 0 ? 1e300 : 0.0;
    for (const Eigen::MatrixXd* whole : {&c.model, &c.robust}) {
      Eigen::MatrixXd C(m, m);
      Eigen::VectorXd size(m);
      for (Eigen::Index i = 0; i < m; ++i) size[i] = std::sqrt(std::max(c.model(own[i], own[i]), 1e-300));
      for (Eigen::Index i = 0; i < m; ++i)
        for (Eigen::Index k = 0; k < m; ++k) C(i, k) = (*whole)(own[i], own[k]) / (size[i] * size[k]);
      C.diagonal().array() += 1e-9;
      const Eigen::VectorXd scaled = d.cwiseQuotient(size);
      if (m > 0) least = std::min(least, scaled.dot(C.ldlt().solve(scaled)));
    }
    out.push_back(m > 0 ? std::sqrt(chi_squared_quantile(
                              std::clamp(chi_squared_tail(least, static_cast<double>(m)), 1e-300, 1.0), 1))
                        : 0.0);
  }
  return out;
}

Gate gate_effect(const Problem& problem, const Fit& full, std::size_t index, const Options& options) {
  const Eigen::MatrixXd raw = jacobian_of(problem, full);
  const Eigen::MatrixXd X = problem.noise().apply(problem, raw);
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < index; ++k) first += full.effects[k].effect->parameter_count();
  const Eigen::Index width = full.effects[index].effect->parameter_count();
  // shapes of the others stay as they are: linearised, they would run away on the blocks left out
  std::vector<Eigen::Index> kept;
  Eigen::Index column = 0;
  for (const ActiveEffect& e : full.effects)
    for (const Parameter& p : e.effect->info().parameters) {
      if (!is_shape(p) && (column < first || column >= first + width)) kept.push_back(column);
      ++column;
    }
  for (; column < X.cols(); ++column) kept.push_back(column);
  // the contribution to be predicted: what remains plus what the effect explains
  const Eigen::VectorXd value = contribution_of(problem, full, index);
  const Eigen::VectorXd without = problem.noise().apply_vector(problem, full.residual + value);
  const Eigen::VectorXd own = problem.noise().apply_vector(problem, value);
  Eigen::MatrixXd R(X.rows(), static_cast<Eigen::Index>(kept.size())), raw_R(X.rows(), R.cols());
  for (std::size_t k = 0; k < kept.size(); ++k) {
    R.col(static_cast<Eigen::Index>(k)) = X.col(kept[k]);
    raw_R.col(static_cast<Eigen::Index>(k)) = raw.col(kept[k]);
  }
  Eigen::MatrixXd F(X.rows(), R.cols() + 1);
  F << R, own;  // shape kept, amplitude free
  int count = 0;
  const std::vector<int> block = blocks_of(problem, count);
  const int n = problem.samples();
  std::vector<Eigen::MatrixXd> H(static_cast<std::size_t>(count), Eigen::MatrixXd::Zero(F.cols(), F.cols()));
  std::vector<Eigen::VectorXd> g(static_cast<std::size_t>(count), Eigen::VectorXd::Zero(F.cols()));
  // per block sums; rows of a block are contiguous in each channel
  for (int c = 0; c < 6; ++c) {
    for (int i = 0; i < n;) {
      int j = i;
      while (j < n && block[static_cast<std::size_t>(j)] == block[static_cast<std::size_t>(i)]) ++j;
      const auto rows = F.middleRows(c * n + i, j - i);
      const auto b = static_cast<std::size_t>(block[static_cast<std::size_t>(i)]);
      H[b] += rows.transpose() * rows;
      g[b] += rows.transpose() * without.segment(c * n + i, j - i);
      i = j;
    }
  }
  Eigen::MatrixXd H_all = Eigen::MatrixXd::Zero(F.cols(), F.cols());
  Eigen::VectorXd g_all = Eigen::VectorXd::Zero(F.cols());
  for (int b = 0; b < count; ++b) {
    H_all += H[static_cast<std::size_t>(b)];
    g_all += g[static_cast<std::size_t>(b)];
  }
  // changes of the offsets stay inside their tolerances, all other coefficients are free
  const Eigen::Index offset_count = problem.offset_sigma().size();
  Unknowns bounds(problem, {}, nullptr);
  bounds.x = Eigen::VectorXd::Zero(F.cols());
  bounds.lower = Eigen::VectorXd::Constant(F.cols(), -1e12);
  bounds.upper = Eigen::VectorXd::Constant(F.cols(), 1e12);
  const Eigen::Index from = R.cols() - offset_count;
  // the tolerances say how much an offset may do for free, with and without the effect
  Eigen::VectorXd tolerances = Eigen::VectorXd::Zero(F.cols()), found = tolerances;
  tolerances.segment(from, offset_count) = problem.offset_sigma().cwiseAbs2().cwiseInverse();
  found.segment(from, offset_count) = full.offsets;
  // where feedback colours the state, a law with a bend of its own must beat whatever their limits allow
  const Eigen::VectorXd prior =
      problem.instrumented() || width == 1 ? tolerances : Eigen::VectorXd::Zero(F.cols());
  bounds.lower.segment(from, offset_count) = (-3 * problem.offset_sigma() - full.offsets).cwiseMin(0.0);
  bounds.upper.segment(from, offset_count) = (3 * problem.offset_sigma() - full.offsets).cwiseMax(0.0);
  const auto solve = [&](const Eigen::MatrixXd& h, const Eigen::VectorXd& r, Eigen::Index size,
                         const Eigen::VectorXd& weight) {
    Unknowns u = bounds;
    u.x.conservativeResize(size);
    u.lower.conservativeResize(size);
    u.upper.conservativeResize(size);
    Eigen::MatrixXd with_prior = h.topLeftCorner(size, size);
    with_prior.diagonal() += weight.head(size);
    return bounded_step(with_prior, (r - weight.cwiseProduct(found)).head(size), u);
  };
  const auto cost_of_offsets = [&](const Eigen::VectorXd& x) {
    return prior.head(x.size()).dot((0.5 * x + found.head(x.size())).cwiseProduct(x));
  };
  // An effect that acts in bursts leaves most blocks to the offsets. Free ones that the other blocks hardly
  // tell apart are carried into the one left out at their limits, and that error is then all it shows. Of
  // fewer than five bursts none can vouch for the others: a take-off or two.
  std::vector<double> gains, information;
  for (const Eigen::MatrixXd& h : H) information.push_back(h(F.cols() - 1, F.cols() - 1));
  const double worth = worth_of(information);
  const bool bursts = worth > 5 && worth < 0.5 * count;
  const Eigen::VectorXd& held = bursts ? tolerances : prior;
  for (int b = 0; b < count; ++b) {
    const auto k = static_cast<std::size_t>(b);
    const Eigen::VectorXd x1 = solve(H_all - H[k], g_all - g[k], F.cols(), held);
    const Eigen::VectorXd x0 = solve(H_all - H[k], g_all - g[k], R.cols(), held);
    const double loss1 = 0.5 * x1.dot(H[k] * x1) - x1.dot(g[k]);
    const auto H0 = H[k].topLeftCorner(R.cols(), R.cols());
    const double loss0 = 0.5 * x0.dot(H0 * x0) - x0.dot(g[k].head(R.cols()));
    gains.push_back(loss0 - loss1);
  }
  Gate gate;
  gate.cross_validated_se = standard_errors_above_zero(gains, information);
  const Eigen::VectorXd x0 = solve(H_all, g_all, R.cols(), prior), x1 = solve(H_all, g_all, F.cols(), prior);
  const Eigen::VectorXd all0 = without - R * x0, all1 = without - F * x1;
  const Eigen::VectorXd raw0 = full.residual + value - raw_R * x0;
  {  // the same question asked with a whitening fitted to what the full model leaves
    const Whitening own_noise = Whitening::autoregressive(problem, full.residual, options.ar_order);
    Eigen::MatrixXd raw_F(raw.rows(), F.cols());
    raw_F << raw_R, value;
    const Eigen::MatrixXd Fw = own_noise.apply(problem, raw_F);
    const Eigen::VectorXd yw = own_noise.apply_vector(problem, full.residual + value);
    const Eigen::MatrixXd Hw = Fw.transpose() * Fw;
    const Eigen::VectorXd gw = Fw.transpose() * yw;
    const Eigen::VectorXd z0 = solve(Hw, gw, R.cols(), prior), z1 = solve(Hw, gw, F.cols(), prior);
    const auto H0 = Hw.topLeftCorner(R.cols(), R.cols());
    gate.gain = gw.dot(z1) - 0.5 * z1.dot(Hw * z1) - cost_of_offsets(z1) -
                (gw.head(R.cols()).dot(z0) - 0.5 * z0.dot(H0 * z0) - cost_of_offsets(z0));
  }
  for (int c = 0; c < 6; ++c) {
    const double before = all0.segment(c * n, n).squaredNorm(), after = all1.segment(c * n, n).squaredNorm();
    if (before > 0) gate.energy_share = std::max(gate.energy_share, (before - after) / before);
    const double raw_before = raw0.segment(c * n, n).squaredNorm();
    const double raw_after = full.residual.segment(c * n, n).squaredNorm();
    if (raw_before > 0)
      gate.energy_share = std::max(gate.energy_share, (raw_before - raw_after) / raw_before);
    gate.magnitude =
        std::max(gate.magnitude, std::sqrt(value.segment(c * n, n).squaredNorm() / n) / problem.scale(c));
  }
  return gate;
}

}  // namespace omniflight::diagnosis
