#include "omniflight_identification/fit.hpp"

#include <ceres/ceres.h>

#include "omniflight_identification/residual_tests.hpp"
#include "prediction_error.hpp"
#include "robust_covariance.hpp"
#include "starts.hpp"
#include "stopper.hpp"

namespace omniflight::identification {
namespace {

constexpr Eigen::Index kSamplesAParameter = 5;
constexpr int kMostOrder = 12, kMostDelay = 1000;
constexpr double kCorrelatedBelow = 0.01;  // p-value of whiteness below which residuals count as correlated

Status check_orders(const Orders& o, const Dataset& data, Eigen::Index skip) {
  const auto refuse = [](const std::string& field, int value, const std::string& range) {
    return bad_input("is " + std::to_string(value) + ", " + range + " is possible", field);
  };
  for (const auto& [field, value] :
       {std::pair{"order of A", o.a}, {"order of C", o.c}, {"order of D", o.d}, {"order of F", o.f}})
    if (value < 0 || value > kMostOrder) return refuse(field, value, "0 to 12");
  if (o.b < 1 || o.b > kMostOrder) return refuse("coefficients of B", o.b, "1 to 12");
  if (static_cast<Eigen::Index>(o.delay.size()) != data.inputs())
    return bad_input("there must be one for each input", "delay");
  for (const int d : o.delay)
    if (d < 0 || d > kMostDelay) return refuse("delay [samples]", d, "0 to 1000");
  Eigen::Index counted = 0;
  for (const Experiment& e : data.experiments) {
    if (e.y.size() < skip + kSamplesAParameter * o.count(data.inputs()))
      return bad_input("an experiment has " + std::to_string(e.y.size()) + " samples, of which " +
                           std::to_string(skip) + " wait for the initial state to fade",
                       "samples", "Record longer, or choose lower orders or a shorter transient");
    counted += e.y.size() - skip;
  }
  return {};
}

struct Search {
  Eigen::VectorXd theta;
  double cost = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool converged = false;
};

Search minimise(const PolynomialModel& start, const Dataset& data, Eigen::Index skip, double scale,
                const FitOptions& options) {
  Search out;
  out.theta = start.parameters();
  if (!out.theta.allFinite()) return out;
  ceres::Problem::Options own;
  own.cost_function_ownership = ceres::TAKE_OWNERSHIP;
  ceres::Problem problem(own);
  problem.AddResidualBlock(new PredictionError(start, data, skip, scale), nullptr, out.theta.data());
  Stopper stopper(options.stop);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-10;
  solver.parameter_tolerance = 1e-10;
  solver.gradient_tolerance = 1e-14;
  solver.logging_type = ceres::SILENT;
  solver.num_threads = 1;
  solver.callbacks.push_back(&stopper);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) return out;
  out.cost = summary.final_cost;
  out.iterations = static_cast<int>(summary.iterations.size());
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  return out;
}

/// Starts for a structure; the error is that of the last way that failed when none worked.
Result<std::vector<PolynomialModel>> starts(Structure structure, const Orders& o, const Dataset& data,
                                            Eigen::Index skip) {
  std::vector<PolynomialModel> out;
  Error last;
  const auto keep = [&](Result<PolynomialModel> m) {
    if (m)
      out.push_back(std::move(*m));
    else
      last = m.error();
  };
  if (structure == Structure::arx) {
    keep(least_squares_arx(o, data, skip));
  } else if (structure == Structure::armax) {
    keep(hannan_rissanen(o, data, skip));
    auto arx = least_squares_arx(o, data, skip);
    if (arx) arx->c.setZero(o.c);
    keep(arx);
  } else if (structure == Structure::state_space) {
    const auto denominator = subspace_denominator(o.a, o.delay, data);
    if (denominator)
      keep(hannan_rissanen(o, data, skip, &*denominator));
    else
      last = denominator.error();
    keep(hannan_rissanen(o, data, skip));
  } else {
    auto plant = steiglitz_mcbride(o, data, skip);
    if (plant && structure == Structure::box_jenkins) {
      Dataset noise = data;  // what the plant leaves, as ARMA(d, c)
      for (Experiment& e : noise.experiments) e.y -= simulated(*plant, e);
      Orders arma = o;
      arma.a = o.d;
      arma.b = arma.f = 0;
      auto without = plant;
      if (const auto model = hannan_rissanen(arma, noise, skip)) {
        plant->c = model->c;
        plant->d = model->a;
        keep(plant);
      }
      keep(without);
    } else {
      keep(plant);
    }
  }
  if (out.empty()) return Failure(last);
  return out;
}

/// Covariance of the parameters, and whether the residuals are correlated.
void judge(FittedModel& fitted, const Dataset& data, Eigen::Index skip) {
  const PredictionError cost(fitted.model, data, skip, 1.0);
  Eigen::VectorXd e;
  Eigen::MatrixXd J;
  const Eigen::Index p = fitted.model.parameters().size();
  fitted.covariance = Eigen::MatrixXd::Constant(p, p, std::numeric_limits<double>::quiet_NaN());
  if (!cost.evaluate(fitted.model.parameters(), e, &J)) return;
  const Eigen::Index n = e.size();
  fitted.samples = n;
  fitted.variance = e.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, n - p));
  fitted.covariance = fitted.variance * inverse_information(J);

  constexpr int kLags = 25;
  const Eigen::VectorXd r = autocorrelation(e, kLags);
  const double statistic = static_cast<double>(n) * r.tail(kLags).squaredNorm();
  fitted.correlated_residuals = chi_squared_tail(statistic, kLags) < kCorrelatedBelow;
  if (!fitted.correlated_residuals) return;
  // at least as long as an initial state takes to fade
  const Eigen::Index window = std::min(n / 4, std::max(skip, correlation_window(n, 2)));
  fitted.covariance = robust_covariance(J, e, window);
}

}  // namespace

Result<FittedModel> fit(Structure structure, const Orders& orders, const Dataset& data,
                        const FitOptions& options) {
  if (auto ok = check(data); !ok) return Failure(ok.error());
  Eigen::Index skip =
      std::max<Eigen::Index>(options.transient_samples, orders.a + orders.c + orders.d + orders.f);
  for (const int d : orders.delay) skip = std::max<Eigen::Index>(skip, d + orders.b);
  if (auto ok = check_orders(orders, data, skip); !ok) return Failure(ok.error());
  const auto begins = starts(structure, orders, data, skip);
  if (!begins) return Failure(begins.error());

  FittedModel fitted;
  fitted.structure = structure;
  fitted.model = begins->front();
  fitted.converged = true;
  if (structure != Structure::arx) {
    double square = 0;
    for (const Experiment& e : data.experiments) square += e.y.squaredNorm();
    const double scale = std::max(1e-300, std::sqrt(square / static_cast<double>(data.samples())));
    Search best;
    PolynomialModel shape = zero_model(orders, data);
    for (const PolynomialModel& begin : *begins) {
      if (options.stop && options.stop()) break;
      shape.set_parameters(begin.parameters());
      const Search found = minimise(shape, data, skip, scale, options);
      if (found.cost < best.cost) best = found;
    }
    if (!std::isfinite(best.cost))
      return fail(ErrorCode::incomplete, "the search for a model did not begin or ended nowhere",
                  name_of(structure), "Give more time, or choose other orders");
    shape.set_parameters(best.theta);
    fitted.model = shape;
    fitted.iterations = best.iterations;
    fitted.converged = best.converged;
  }
  if (!fitted.model.stable()) {
    double largest = 0;
    for (const auto& pole : fitted.model.poles()) largest = std::max(largest, std::abs(pole));
    return bad_input("the identified model is unstable, its largest pole has a magnitude of " +
                         std::to_string(largest) + " and a motor's are below 1",
                     std::string(name_of(structure)) + ", A",
                     "Remove drift (trend), record longer, or choose another order or structure");
  }
  judge(fitted, data, skip);
  return fitted;
}

}  // namespace omniflight::identification
