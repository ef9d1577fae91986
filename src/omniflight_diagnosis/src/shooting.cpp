#include "shooting.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

#include "open_loop.hpp"
#include "whitening.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ActiveEffect;
using Vec12 = Eigen::Matrix<double, 12, 1>;

constexpr double kWindow = 0.5, kNode = 0.1;  // s
constexpr int kNodes = 5, kMostWindows = 150;
constexpr int kState = 12;
constexpr double kMostLost = 2;  // nats

struct Shot {
  const Flight* flight = nullptr;
  int begin = 0, stride = 1;  ///< grid samples; between two nodes
};

std::vector<Shot> shots_of(std::span<const Flight* const> flights) {
  std::vector<Shot> all;
  for (const Flight* f : flights) {
    const int stride = std::max(1, static_cast<int>(std::lround(kNode * f->rate_hz)));
    for (const Segment& s : f->segments)
      for (int i = s.begin; i + kNodes * stride < s.end; i += kNodes * stride) all.push_back({f, i, stride});
  }
  if (all.size() <= kMostWindows) return all;
  std::vector<Shot> out;  // evenly spread
  for (std::size_t k = 0; k < kMostWindows; ++k) out.push_back(all[k * all.size() / kMostWindows]);
  return out;
}

/// Position [m], attitude [rad], velocity [m/s], rate [rad/s] of a above b.
Vec12 difference(const RigidState& a, const RigidState& b) {
  Vec12 out;
  out << a.p_WB - b.p_WB, log_rotation(b.q_WB.conjugate() * a.q_WB), a.v_WB_W - b.v_WB_W, a.w_WB_B - b.w_WB_B;
  return out;
}

RigidState moved(RigidState x, const Vec12& by) {
  x.p_WB += by.head<3>();
  x.q_WB = (x.q_WB * exp_rotation(by.segment<3>(3))).normalized();
  x.v_WB_W += by.segment<3>(6);
  x.w_WB_B += by.tail<3>();
  return x;
}

/// Errors at the nodes, the first of them that of the initial state itself; false when it ran away.
bool errors_of(const Shot& w, const OpenLoopModel& model, const Vec12& initial, Vec12* errors) {
  const auto truth = [&](int node) {
    return w.flight->situation[static_cast<std::size_t>(w.begin + node * w.stride)].body;
  };
  RigidState x = moved(truth(0), initial);
  errors[0] = initial;
  for (int node = 1; node <= kNodes; ++node) {
    for (int k = 0; k < w.stride; ++k)
      if (!advance(*w.flight, w.begin + (node - 1) * w.stride + k, model, 1, x)) return false;
    errors[node] = difference(x, truth(node));
  }
  return true;
}

/// Numbers of the model that may move, in units of their ordinary size.
struct Unit {
  std::size_t effect, parameter;
  double size;
};

OpenLoopModel with(OpenLoopModel model, const std::vector<Unit>& units, const double* x) {
  for (std::size_t k = 0; k < units.size(); ++k)
    model.effects[units[k].effect].theta[units[k].parameter] = x[k] * units[k].size;
  return model;
}

struct Miss {
  Shot window;
  const OpenLoopModel* model;
  const std::vector<Unit>* units;
  Vec12 weight;  ///< one over the errors' ordinary size

  bool operator()(const double* const* x, double* residual) const {
    Vec12 errors[kNodes + 1];
    if (!errors_of(window, with(*model, *units, x[0]),
                   weight.cwiseInverse().cwiseProduct(Eigen::Map<const Vec12>(x[1])), errors))
      return false;
    for (int node = 0; node <= kNodes; ++node)
      Eigen::Map<Vec12>(residual + kState * node) = weight.cwiseProduct(errors[node]);
    return true;
  }
};

class Stopped final : public ceres::IterationCallback {
 public:
  explicit Stopped(const Options& o) : o_(o) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return o_.stopped() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const Options& o_;
};

/// RMS of every kind of error over all nodes of windows flown from the measured state, three axes together.
std::optional<Vec12> ordinary(const std::vector<Shot>& windows, const OpenLoopModel& model) {
  Vec12 sum = Vec12::Zero();
  int count = 0;
  for (const Shot& w : windows) {
    Vec12 errors[kNodes + 1];
    if (!errors_of(w, model, Vec12::Zero(), errors)) continue;
    for (int node = 1; node <= kNodes; ++node) sum += errors[node].cwiseAbs2(), ++count;
  }
  if (count == 0) return std::nullopt;
  Vec12 out;
  for (int kind = 0; kind < 4; ++kind)
    out.segment<3>(3 * kind).setConstant(std::sqrt(sum.segment<3>(3 * kind).mean() / count) + 1e-9);
  return out;
}

/// Mean square of the last errors, each kind by itself in units of `size`.
double last_error(const Shot& w, const OpenLoopModel& model, const Vec12& size) {
  Vec12 errors[kNodes + 1];
  if (!errors_of(w, model, Vec12::Zero(), errors)) return 1e6;
  return errors[kNodes].cwiseQuotient(size).squaredNorm() / kState;
}

}  // namespace

std::optional<Refined> refine_by_shooting(std::span<const Flight* const> flights,
                                          const vehicle::Vehicle& vehicle, const Problem& problem,
                                          const Fit& model, const Options& o) {
  if (model.effects.empty() || o.stopped()) return std::nullopt;
  for (const Flight* f : flights)
    if (!f->has_position || f->thrust_modelled || f->speed_from_command) return std::nullopt;
  OpenLoopModel start{.center_of_mass = vehicle.center_of_mass, .effects = model.effects};
  std::vector<Unit> units;
  std::vector<double> x, lower, upper;
  for (std::size_t e = 0; e < model.effects.size(); ++e) {
    const ActiveEffect& active = model.effects[e];
    if (!active.effect->acts_on_wrench() || active.effect->memory_size().total() > 0) return std::nullopt;
    for (std::size_t k = 0; k < active.theta.size(); ++k) {
      const physics::Parameter& p = active.effect->info().parameters[k];
      const double size = std::max({std::abs(active.theta[k]), std::abs(p.typical), 1e-9});
      const Range range = problem.range(*active.effect, k);
      units.push_back({e, k, size});
      x.push_back(active.theta[k] / size);
      lower.push_back(range.lower / size);
      upper.push_back(range.upper / size);
      x.back() = std::clamp(x.back(), lower.back(), upper.back());
    }
  }
  // what the tolerances of vehicle and sensors took part in stays as it was fitted
  double arm = 1e-3;
  for (const vehicle::Rotor& r : vehicle.rotors) arm = std::max(arm, r.p_BR.norm());
  const double weight = problem.scale(0);
  start.thrust_scale = model.offsets[0];
  start.torque_B = weight * arm * model.offsets.segment<3>(1);
  start.force_W = weight * model.offsets.segment<3>(4);

  const std::vector<Shot> all = shots_of(flights);
  std::vector<Shot> fitted, tested;
  for (std::size_t k = 0; k < all.size(); ++k) (k % 3 == 2 ? tested : fitted).push_back(all[k]);
  constexpr std::size_t kLeast = 8;
  if (tested.size() < kLeast) return std::nullopt;
  const auto size = ordinary(fitted, start);
  if (!size) return std::nullopt;

  ceres::Problem shooting;
  std::vector<Vec12> initial(fitted.size(), Vec12::Zero());  // in units of the ordinary errors
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    auto* cost = new ceres::DynamicNumericDiffCostFunction<Miss, ceres::FORWARD>(
        new Miss{fitted[k], &start, &units, size->cwiseInverse()});
    cost->AddParameterBlock(static_cast<int>(units.size()));
    cost->AddParameterBlock(kState);
    cost->SetNumResiduals(kState * (kNodes + 1));
    shooting.AddResidualBlock(cost, new ceres::HuberLoss(3.0 * std::sqrt(kState)), x.data(),
                              initial[k].data());
    ordering->AddElementToGroup(initial[k].data(), 0);
  }
  ordering->AddElementToGroup(x.data(), 1);
  for (std::size_t k = 0; k < units.size(); ++k) {
    shooting.SetParameterLowerBound(x.data(), static_cast<int>(k), lower[k]);
    shooting.SetParameterUpperBound(x.data(), static_cast<int>(k), upper[k]);
  }
  Stopped stopped(o);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering.reset(ordering);
  options.max_num_iterations = 8;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(&stopped);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &shooting, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;

  const OpenLoopModel refined = with(start, units, x.data());
  double before = 0, after = 0, gain = 0, squares = 0;
  const auto count = static_cast<double>(tested.size());
  for (const Shot& w : tested) {
    const double b = last_error(w, start, *size), a = last_error(w, refined, *size);
    before += b, after += a, gain += b - a, squares += (b - a) * (b - a);
  }
  const double mean = gain / count, se = std::sqrt(std::max(0.0, squares / count - mean * mean) / count);
  if (!(mean > 2 * se)) return std::nullopt;
  Refined out{model,
              {static_cast<int>(fitted.size()), static_cast<int>(tested.size()), std::sqrt(before / count),
               std::sqrt(after / count)}};
  out.fit.effects = refined.effects;
  out.fit.plausible.resize(units.size(), {1e300, -1e300});
  for (std::size_t k = 0; k < units.size(); ++k) {  // both estimates are worth a place in the interval
    auto& [low, high] = out.fit.plausible[k];
    const auto& [e, parameter, one] = units[k];
    for (const auto* effects : {&model.effects, &refined.effects}) {
      low = std::min(low, (*effects)[e].theta[parameter]);
      high = std::max(high, (*effects)[e].theta[parameter]);
    }
  }
  for (const ActiveEffect& e : out.fit.effects)
    if (at_limit(problem, e)) return std::nullopt;
  problem.predict(out.fit.effects, out.fit.offsets, out.fit.residual, nullptr);
  const auto whitened = [&](const Eigen::VectorXd& rest) {
    return problem.noise().apply_vector(problem, rest).squaredNorm();
  };
  const double lost = 0.5 * (whitened(out.fit.residual) - whitened(model.residual));
  if (lost > kMostLost) return std::nullopt;
  out.fit.log_likelihood -= lost;
  return out;
}

}  // namespace omniflight::diagnosis
