#include "fit.hpp"

#include <algorithm>
#include <cmath>

#include "bounded_step.hpp"
#include "shape_search.hpp"
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

/// Gauss-Newton with step halving under a fixed whitening; returns what remains of the residual. Gives up
/// where `enough` is out of reach of steps that bring as much as the last one.
Eigen::VectorXd minimise(const Problem& problem, std::vector<ActiveEffect>& effects, Unknowns& u,
                         const Whitening& whitening, int iterations, double enough) {
  bool linear = true;
  for (const ActiveEffect& e : effects) linear = linear && problem.has_constant_columns(*e.effect);
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd rest, left;
  for (int iteration = 0; iteration < (linear ? 1 : iterations); ++iteration) {
    predict(problem, effects, u.x, rest, &jacobian);
    const Eigen::VectorXd r = whitening.apply_vector(problem, rest);
    auto [H, g] = problem.normal_equations(effects, jacobian, r);
    H.diagonal() += u.weight;
    g -= u.weight.cwiseProduct(u.x);
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
    const bool hopeless = best - 3 * (iterations - 1 - iteration) * (now - best) > enough;
    if (settled || hopeless) break;
  }
  take(u.x, effects);
  return rest;
}

}  // namespace

namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();

Fit fit_under(const Problem& problem, const std::vector<ActiveEffect>& start, int iterations,
              const Eigen::VectorXd* offset_sigma = nullptr, double least = -kAny) {
  Fit fit;
  fit.effects = start;
  Unknowns u(problem, start, nullptr);
  if (offset_sigma) u.limit_offsets(*offset_sigma);
  fit.residual = minimise(problem, fit.effects, u, problem.noise(), iterations, -least);
  fit.offsets = u.x.tail(problem.offset_sigma().size());
  fit.log_likelihood = -cost(problem.noise().apply_vector(problem, fit.residual), u, u.x);
  for (const ActiveEffect& e : fit.effects) fit.parameters += e.effect->parameter_count();
  return fit;
}

/// The base's effects and one more, its shape parameters where `search` ends.
template <class SearchShapes>
std::vector<ActiveEffect> start_with(const Problem& problem, const Fit& base, const Effect& effect,
                                     const SearchShapes& search) {
  const auto& parameters = effect.info().parameters;
  std::vector<double> theta;
  for (const Parameter& p : parameters) theta.push_back(p.linear ? p.neutral : p.typical);
  if (std::any_of(parameters.begin(), parameters.end(), is_shape)) {
    ShapeSearch shapes(problem, base, effect);
    search(shapes);
    theta = shapes.best();
  }
  for (std::size_t c = 0; c < parameters.size(); ++c)
    if (!parameters[c].linear && !is_shape(parameters[c]) && std::abs(theta[c]) < 1e-12)
      theta[c] = 1e-3 * parameters[c].typical;  // leave the stationary point of a product
  std::vector<ActiveEffect> start = base.effects;
  start.push_back({&effect, theta});
  return start;
}

void search_all(ShapeSearch& shapes) {
  shapes.over_bounds();
  shapes.nearby();
}

}  // namespace

Fit fit_effects(const Problem& problem, const std::vector<ActiveEffect>& start, const Options&) {
  return fit_under(problem, start, 12);
}

Fit fit_with(const Problem& problem, const Fit& base, const Effect& effect, const Options&, double least) {
  return fit_under(problem, start_with(problem, base, effect, search_all), 12, nullptr, least);
}

Fit fit_on_grid(const Problem& problem, const Fit& base, const Effect& effect, const Options&,
                const std::vector<double>* found) {
  const auto search = [&](ShapeSearch& shapes) { found ? shapes.around(*found) : shapes.over_bounds(); };
  return fit_under(problem, start_with(problem, base, effect, search), 12);
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
  const auto search = [&](ShapeSearch& shapes) { hint ? shapes.take(*hint) : search_all(shapes); };
  // the change of a mass is far from linear
  return fit_under(problem, start_with(problem, base, effect, search), adds_inertia(effect) ? 4 : 1);
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
