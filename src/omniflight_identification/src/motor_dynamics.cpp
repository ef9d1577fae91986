#include "omniflight_identification/motor_dynamics.hpp"

#include <ceres/ceres.h>

#include "omniflight_identification/residual_tests.hpp"
#include "robust_covariance.hpp"
#include "stopper.hpp"

namespace omniflight::identification {
namespace {

/// Parameters: gain of every input, then log(lag_up), log(lag_down), delay; lags stay positive by themselves.
struct Shape {
  Eigen::Index inputs = 1;
  Eigen::Index size() const { return inputs + 3; }
};

/// Input 0 over the step that ends at sample t is u(t - 1 - whole) for `part` of a period, then one sample
/// newer.
template <class T>
void simulate(const Shape& shape, const T* p, double period_s, const Experiment& e, const T& offset, T* y) {
  using std::exp;
  const T late = p[shape.inputs + 2] / period_s;
  int whole = 0;
  if constexpr (std::is_same_v<T, double>)
    whole = static_cast<int>(std::floor(late));
  else
    whole = static_cast<int>(std::floor(late.a));
  const T part = late - static_cast<double>(whole);
  const T lag[2] = {exp(p[shape.inputs]), exp(p[shape.inputs + 1])};
  const T first[2] = {exp(-period_s * part / lag[0]), exp(-period_s * part / lag[1])};
  const T second[2] = {exp(-period_s * (1.0 - part) / lag[0]), exp(-period_s * (1.0 - part) / lag[1])};
  const auto command = [&](Eigen::Index t) { return e.u(std::max<Eigen::Index>(t, 0), 0); };
  T speed = T(e.y[0]);
  y[0] = speed;
  for (Eigen::Index t = 1; t < e.y.size(); ++t) {
    T others = offset;
    for (Eigen::Index i = 1; i < shape.inputs; ++i) others += p[i] * e.u(t - 1, i);
    const T old = p[0] * command(t - 2 - whole) + others, now = p[0] * command(t - 1 - whole) + others;
    speed = old + first[old < speed ? 1 : 0] * (speed - old);
    speed = now + second[now < speed ? 1 : 0] * (speed - now);
    y[t] = speed;
  }
}

/// Offset of an experiment: the mean of what the rest leaves. The model is linear in it up to which of the
/// two lags acts, so that a second round is exact enough.
double best_offset(const Shape& shape, const double* p, double period_s, const Experiment& e,
                   Eigen::Index skip) {
  std::vector<double> y(static_cast<std::size_t>(e.y.size()));
  double offset = e.y.mean();
  for (Eigen::Index i = 0; i < shape.inputs; ++i) offset -= p[i] * e.u.col(i).mean();
  for (int round = 0; round < 2; ++round) {
    simulate(shape, p, period_s, e, offset, y.data());
    double sum = 0;
    for (Eigen::Index t = skip; t < e.y.size(); ++t) sum += e.y[t] - y[static_cast<std::size_t>(t)];
    offset += sum / static_cast<double>(e.y.size() - skip);
  }
  return offset;
}

struct Cost {
  Shape shape;
  const Experiment& e;
  double period_s, scale;
  Eigen::Index skip;

  template <class T>
  bool operator()(T const* const* p, T* out) const {
    std::vector<T> y(static_cast<std::size_t>(e.y.size()));
    simulate(shape, p[0], period_s, e, p[1][0], y.data());
    for (Eigen::Index t = skip; t < e.y.size(); ++t)
      out[t - skip] = (e.y[t] - y[static_cast<std::size_t>(t)]) / scale;
    return true;
  }
};

struct Solved {
  Eigen::VectorXd p;
  std::vector<double> offsets;
  double cost = std::numeric_limits<double>::infinity();
  bool converged = false;
  Eigen::MatrixXd covariance;
};

Solved search(const Shape& shape, Eigen::VectorXd p, const Dataset& data, double scale, Eigen::Index skip,
              const DynamicsOptions& options, bool with_covariance) {
  Solved out;
  for (const Experiment& e : data.experiments)
    out.offsets.push_back(best_offset(shape, p.data(), data.period_s, e, skip));
  ceres::Problem problem;
  for (std::size_t k = 0; k < data.experiments.size(); ++k) {
    const Experiment& e = data.experiments[k];
    auto* cost =
        new ceres::DynamicAutoDiffCostFunction<Cost, 8>(new Cost{shape, e, data.period_s, scale, skip});
    cost->AddParameterBlock(static_cast<int>(shape.size()));
    cost->AddParameterBlock(1);
    cost->SetNumResiduals(static_cast<int>(e.y.size() - skip));
    problem.AddResidualBlock(cost, nullptr, p.data(), &out.offsets[k]);
  }
  const int lag = static_cast<int>(shape.inputs), delay = lag + 2;
  for (int k = lag; k < delay; ++k) {
    problem.SetParameterLowerBound(p.data(), k, std::log(0.05 * data.period_s));
    problem.SetParameterUpperBound(p.data(), k, std::log(options.max_lag_s));
  }
  problem.SetParameterLowerBound(p.data(), delay, 0.0);
  problem.SetParameterUpperBound(p.data(), delay, options.max_delay_s);
  Stopper stopper(options.stop);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = 60;
  solver.function_tolerance = 1e-8;
  solver.logging_type = ceres::SILENT;
  solver.num_threads = 1;
  solver.callbacks.push_back(&stopper);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  out.p = p;
  if (!summary.IsSolutionUsable()) return out;
  out.cost = summary.final_cost;
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  if (!with_covariance) return out;
  std::vector<double> residual;
  ceres::CRSMatrix sparse;
  problem.Evaluate({}, nullptr, &residual, nullptr, &sparse);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int row = 0; row < sparse.num_rows; ++row)
    for (int k = sparse.rows[static_cast<std::size_t>(row)];
         k < sparse.rows[static_cast<std::size_t>(row) + 1]; ++k)
      J(row, sparse.cols[static_cast<std::size_t>(k)]) = sparse.values[static_cast<std::size_t>(k)];
  // residuals of an output-error fit are correlated over about the lag; the window reaches beyond it
  const Eigen::MatrixXd all = robust_covariance(
      J, Eigen::Map<const Eigen::VectorXd>(residual.data(), J.rows()), correlation_window(J.rows(), 4));
  out.covariance = all.topLeftCorner(shape.size(), shape.size());
  return out;
}

/// The two best of a grid of lags and delays, by what they leave of the data.
std::vector<Eigen::VectorXd> starts(const Shape& shape, const Eigen::VectorXd& gain, const Dataset& data,
                                    Eigen::Index skip, const DynamicsOptions& options) {
  std::vector<std::pair<double, Eigen::VectorXd>> tried;
  for (const double lag : {3.0, 10.0, 30.0, 90.0})
    for (const double delay : {0.5, 3.5, 10.5}) {
      Eigen::VectorXd p(shape.size());
      const double lag_s = std::min(lag * data.period_s, 0.5 * options.max_lag_s);
      p << gain, std::log(lag_s), std::log(lag_s), std::min(delay * data.period_s, 0.9 * options.max_delay_s);
      double loss = 0;
      for (const Experiment& e : data.experiments) {
        Eigen::VectorXd y(e.y.size());
        simulate(shape, p.data(), data.period_s, e, best_offset(shape, p.data(), data.period_s, e, skip),
                 y.data());
        loss += (e.y - y).tail(e.y.size() - skip).squaredNorm();
      }
      tried.emplace_back(loss, p);
    }
  std::sort(tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return {tried[0].second, tried[1].second};
}

Status inside(const MotorDynamics& m, const DynamicsOptions& options, double period_s) {
  const auto words = [](double s) { return std::to_string(1000 * s) + " ms"; };
  for (const auto& [name, lag] : {std::pair{"lag up", m.lag_up}, {"lag down", m.lag_down}})
    if (lag > 0.99 * options.max_lag_s || lag < 0.06 * period_s)
      return bad_input("came out at " + words(lag) + ", the end of what can be found between samples of " +
                           words(period_s) + " and " + words(options.max_lag_s),
                       name, "Look whether command and speed belong to the same rotor, and sample faster");
  if (m.delay > 0.999 * options.max_delay_s)
    return bad_input("came out at its limit of " + words(options.max_delay_s), "delay",
                     "Align the clocks of command and speed");
  return {};
}

}  // namespace

double MotorDynamics::sigma_lag_up() const {
  const Eigen::Index k = gain.size();
  return std::sqrt(covariance(k, k));
}
double MotorDynamics::sigma_lag_down() const {
  const Eigen::Index k = gain.size() + 1;
  return std::sqrt(covariance(k, k));
}
double MotorDynamics::sigma_delay() const {
  const Eigen::Index k = gain.size() + 2;
  return std::sqrt(covariance(k, k));
}

Result<MotorDynamics> fit_dynamics(const Dataset& data, const DynamicsOptions& options) {
  if (auto ok = check(data); !ok) return Failure(ok.error());
  if (data.inputs() > 4) return bad_input("more than four inputs", "inputs");
  const Shape shape{data.inputs()};
  Eigen::Index shortest = data.samples();
  double square = 0;
  for (const Experiment& e : data.experiments) {
    shortest = std::min(shortest, e.y.size());
    square += (e.y.array() - e.y.mean()).matrix().squaredNorm();
  }
  const Eigen::Index skip = std::min(options.transient_samples, shortest / 2);
  const double scale = std::max(1e-300, std::sqrt(square / static_cast<double>(data.samples())));
  // gains from the static regression
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(shape.inputs, shape.inputs);
  Eigen::VectorXd moment = Eigen::VectorXd::Zero(shape.inputs);
  for (const Experiment& e : data.experiments) {
    const Eigen::MatrixXd u = e.u.rowwise() - e.u.colwise().mean();
    information += u.transpose() * u;
    moment += u.transpose() * (e.y.array() - e.y.mean()).matrix();
  }
  const Eigen::VectorXd gain = information.completeOrthogonalDecomposition().solve(moment);
  Solved best;
  for (const Eigen::VectorXd& start : starts(shape, gain, data, skip, options)) {
    if (options.stop && options.stop()) break;
    Solved found = search(shape, start, data, scale, skip, options, false);
    if (found.cost < best.cost) best = std::move(found);
  }
  if (!std::isfinite(best.cost))
    return fail(ErrorCode::incomplete, "no lag and delay were found", "motor", "Give more time");
  best = search(shape, best.p, data, scale, skip, options, true);
  MotorDynamics out;
  out.gain = best.p.head(shape.inputs);
  out.lag_up = std::exp(best.p[shape.inputs]);
  out.lag_down = std::exp(best.p[shape.inputs + 1]);
  out.delay = best.p[shape.inputs + 2];
  out.converged = best.converged;
  Eigen::VectorXd unlog = Eigen::VectorXd::Ones(shape.size());  // d lag / d log(lag) = lag
  unlog[shape.inputs] = out.lag_up;
  unlog[shape.inputs + 1] = out.lag_down;
  out.covariance = unlog.asDiagonal() * best.covariance * unlog.asDiagonal();
  if (auto ok = inside(out, options, data.period_s); !ok) return Failure(ok.error());
  out.fit_percent = fit_percent(out, data);
  return out;
}

Eigen::VectorXd simulated(const MotorDynamics& m, double period_s, const Experiment& e) {
  const Shape shape{m.gain.size()};
  Eigen::VectorXd p(shape.size()), y(e.y.size());
  p << m.gain, std::log(m.lag_up), std::log(m.lag_down), m.delay;
  const double offset = best_offset(shape, p.data(), period_s, e, 0);
  simulate(shape, p.data(), period_s, e, offset, y.data());
  return y;
}

double fit_percent(const MotorDynamics& m, const Dataset& data) {
  double sum = 0;
  for (const Experiment& e : data.experiments)
    sum += static_cast<double>(e.y.size()) * fit_percent(e.y, simulated(m, data.period_s, e));
  return sum / static_cast<double>(data.samples());
}

std::complex<double> response(const MotorDynamics& m, double w) {
  const std::complex<double> i(0, 1);
  return m.gain[0] / (1.0 + i * w * m.lag()) * std::exp(-i * w * m.delay);
}

}  // namespace omniflight::identification
