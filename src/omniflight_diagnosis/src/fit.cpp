#include "fit.hpp"

#include <algorithm>
#include <cmath>

#include "bounded_step.hpp"
#include "unknowns.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using physics::Effect;
using physics::Parameter;

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
    const Eigen::MatrixXd X = problem.whitened(effects, jacobian);
    Eigen::MatrixXd H = X.transpose() * X;
    H.diagonal() += u.weight;
    const Eigen::VectorXd g = X.transpose() * r - u.weight.cwiseProduct(u.x);
    const Eigen::VectorXd step = bounded_step(H, g, u.down(), u.up());
    if (linear) {
      u.x += step;
      rest -= jacobian * step;
      break;
    }
    const double now = cost(r, u, u.x);
    double best = now;
    Eigen::VectorXd to = u.x;
    const auto improves = [&](const Eigen::VectorXd& by) {
      const Eigen::VectorXd trial = (u.x + by).cwiseMax(u.lower).cwiseMin(u.upper);
      predict(problem, effects, trial, left, nullptr);
      const double c = cost(whitening.apply_vector(problem, left), u, trial);
      if (!(c < best)) return false;
      best = c;
      to = trial;
      rest = left;
      return true;
    };
    bool found = false;
    double size = 1.0;
    for (int halving = 0; halving < 6 && !found; ++halving, size *= 0.4) found = improves(size * step);
    // a law with a kink, the end of a rope say, may have no way ahead but a turned one (Levenberg, Marquardt)
    for (double damping = 0.01; damping < 1e3 && !found; damping *= 10) {
      Eigen::MatrixXd damped = H;
      damped.diagonal() *= 1 + damping;
      found = improves(bounded_step(damped, g, u.down(), u.up()));
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
    const Eigen::MatrixXd Z = problem.whitened(base.effects, jacobian);
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
        const auto known = problem.memory().at(effect, theta_now, [&] {
          Eigen::MatrixXd columns;
          if (heavy) {
            problem.predict(alone, none, rest, &jacobian);
            columns.resize(jacobian.rows(), own);
            for (Eigen::Index c = 0; c < own; ++c)
              columns.col(c) = jacobian.col(free[static_cast<std::size_t>(c)]);
          } else {
            problem.amplitude_columns(effect, theta_now, free, columns);
          }
          return whitening.apply(problem, columns);
        });
        const Eigen::MatrixXd& X = *known;
        H.topLeftCorner(own, own) = X.transpose() * X;
        H.topRightCorner(own, rest_size) = X.transpose() * Z;
        H.bottomLeftCorner(rest_size, own) = H.topRightCorner(own, rest_size).transpose();
        g.head(own) = X.transpose() * target;
        const Eigen::VectorXd step = bounded_step(H, g, u.down(), u.up());
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

}  // namespace omniflight::diagnosis
