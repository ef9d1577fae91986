#include "laplace.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "first_stage.hpp"
#include "inner_products.hpp"

namespace omniflight::diagnosis {
namespace {

using physics::ParameterPrior;
using Law = ParameterPrior::Law;

constexpr int kIterations = 8;
constexpr double kConverged = 0.1;  ///< nat: the objective may still fall by less
constexpr double kFar = 1e6;        ///< standard deviations: no bound
constexpr double kLawKnot = 2.0;    ///< s, least correlation time of a law's relative error
constexpr int kLawKnots = 8;        ///< at most, a flight
/// RMS errors of laws over Options::law_error that are equally likely.
constexpr std::array<double, 4> kLawErrors{1, 0.3, 0.1, 0.03};

double log_determinant(const Eigen::LLT<Eigen::MatrixXd>& llt) {
  return 2 * llt.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

Eigen::VectorXd expected_wrench(const RegressionProblem& problem, const Hypothesis& h,
                                const SetMember& member) {
  if (h.pattern) return h.pattern->raw * member.weights;
  EffectTerm term{h.effect, member.theta, member.start};
  for (std::size_t k = 0; h.is_linear() && k < term.theta.size(); ++k)
    term.theta[k] *= h.first_stage[static_cast<Eigen::Index>(k)];
  Eigen::VectorXd value;
  problem.wrench_of(term, value, nullptr, nullptr);
  return h.is_linear() ? value : Eigen::VectorXd(member.first_stage.value_or(1.0) * value);
}

/// Which coordinate is what.
struct Evidence::Layout {
  struct Coordinate {
    ParameterPrior prior;  ///< of a parameter
    bool half = false;     ///< only u >= 0
    double low = -1e9, high = 1e9;
  };
  Eigen::Index calibration = 0, total = 0;
  std::vector<Eigen::Index> first;             ///< a member
  std::vector<std::vector<Coordinate>> theta;  ///< a member
  std::vector<Coordinate> all;

  /// 1 and -1 at the lower and the upper bound of a coordinate, 0 between.
  int inward(Eigen::Index k, double u) const {
    const Coordinate& c = all[static_cast<std::size_t>(k)];
    return u <= c.low ? 1 : u >= c.high ? -1 : 0;
  }
};

double log_density_of_totals(const Calibration& calibration, const Eigen::VectorXd& deviations) {
  const Eigen::MatrixXd scaled = calibration.totals * deviations.asDiagonal();
  Mat6 covariance = scaled * scaled.transpose();
  covariance.diagonal().array() += 1;
  return -covariance.llt().matrixLLT().diagonal().array().log().sum();
}

FittedAmplitudes::FittedAmplitudes(const RegressionProblem& problem)
    : residual(cosine_amplitudes(problem, problem.residual())),
      calibration(cosine_amplitudes(problem, problem.calibration().columns)) {}

Evidence::Evidence(const RegressionProblem& problem, const NoiseModel& noise,
                   const std::vector<Hypothesis>& hypotheses, double law_error,
                   const Eigen::VectorXd& tolerances)
    : Evidence(problem, FittedAmplitudes(problem), noise, hypotheses, law_error, tolerances) {}

Evidence::Evidence(const RegressionProblem& problem, const FittedAmplitudes& fitted, const NoiseModel& noise,
                   const std::vector<Hypothesis>& hypotheses, double law_error,
                   const Eigen::VectorXd& tolerances)
    : problem_(problem),
      noise_(noise),
      hypotheses_(hypotheses),
      law_error_(law_error),
      tolerances_(tolerances),
      deviations_(problem.calibration().deviations(tolerances)),
      z_(noise.scale(fitted.residual)),
      log_totals_(log_density_of_totals(problem.calibration(), deviations_)) {
  Eigen::MatrixXd whitened = noise.scale(fitted.calibration);
  whitened.bottomRows(NoiseModel::kBeside) = problem_.calibration().totals;
  whitened = whitened * deviations_.asDiagonal();
  bb_ = inner_products(whitened);
  b_ = std::make_shared<const Eigen::MatrixXd>(std::move(whitened));
}

Evidence Evidence::with(const Eigen::VectorXd& tolerances) const {
  Evidence out = *this;
  out.tolerances_ = tolerances;
  out.deviations_ = problem_.calibration().deviations(tolerances);
  const Eigen::VectorXd change = out.deviations_.cwiseQuotient(deviations_);
  out.b_ = std::make_shared<const Eigen::MatrixXd>(*b_ * change.asDiagonal());
  out.bb_ = change.asDiagonal() * bb_ * change.asDiagonal();
  out.log_totals_ = log_density_of_totals(problem_.calibration(), out.deviations_);
  return out;
}

void Evidence::evaluate(const Layout& layout, const Eigen::VectorXd& u, std::vector<SetMember>& members,
                        Eigen::VectorXd& rest, Eigen::MatrixXd* columns) const {
  rest = z_ - *b_ * u.head(layout.calibration);
  if (columns) columns->resize(z_.size(), layout.total - layout.calibration);
  Eigen::VectorXd value;
  Eigen::MatrixXd by_theta, by_start;
  for (std::size_t m = 0; m < members.size(); ++m) {
    SetMember& member = members[m];
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
    const Eigen::Index first = layout.first[m], column = first - layout.calibration;
    if (h.pattern) {
      member.weights = u.segment(first, h.pattern->whitened.cols());
      rest -= h.pattern->whitened * member.weights;
      if (columns) columns->middleCols(column, h.pattern->whitened.cols()) = h.pattern->whitened;
      continue;
    }
    const auto& coordinates = layout.theta[m];
    const auto parameters = static_cast<Eigen::Index>(coordinates.size());
    for (Eigen::Index k = 0; k < parameters; ++k)
      member.theta[static_cast<std::size_t>(k)] =
          coordinates[static_cast<std::size_t>(k)].prior.value(u[first + k]);
    if (h.is_linear()) {
      rest -= h.linear * Eigen::Map<const Eigen::VectorXd>(member.theta.data(), parameters);
      if (columns)
        for (Eigen::Index k = 0; k < parameters; ++k)
          columns->col(column + k) =
              coordinates[static_cast<std::size_t>(k)].prior.slope(u[first + k]) * h.linear.col(k);
      continue;
    }
    const std::vector<double> spread = h.effect->start_spread(member.theta.data());
    const Eigen::Index states = member.start.size();
    for (Eigen::Index k = 0; k < states; ++k)
      member.start[k] = u[first + parameters + k] * spread[static_cast<std::size_t>(k) % spread.size()];
    problem_.wrench_of({h.effect, member.theta, member.start}, value, columns ? &by_theta : nullptr,
                       columns && states > 0 ? &by_start : nullptr);
    const double predictable = member.first_stage.value_or(1.0);
    rest -= predictable * noise_.apply(value);
    if (!columns) continue;
    for (Eigen::Index k = 0; k < parameters; ++k)
      by_theta.col(k) *= predictable * coordinates[static_cast<std::size_t>(k)].prior.slope(u[first + k]);
    columns->middleCols(column, parameters) = noise_.apply(by_theta);
    if (states == 0) continue;
    for (Eigen::Index k = 0; k < states; ++k)
      by_start.col(k) *= predictable * spread[static_cast<std::size_t>(k) % spread.size()];
    columns->middleCols(column + parameters, states) = noise_.apply(by_start);
  }
}

/// Where its amplitudes are nothing: of one standard deviation each.
double Evidence::first_stage_of(const SetMember& member) const {
  const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
  EffectTerm term{h.effect, member.theta, {}};
  Eigen::VectorXd predicted, measured;
  problem_.wrench_of(term, predicted, nullptr, nullptr);
  if (predicted.isZero(0)) {
    for (std::size_t k = 0; k < term.theta.size(); ++k)
      if (physics::is_amplitude(h.effect->info().parameters[k]))
        term.theta[k] = problem_.prior(*h.effect, k).value(1);
    problem_.wrench_of(term, predicted, nullptr, nullptr);
  }
  problem_.wrench_of(term, measured, nullptr, nullptr, States::measured);
  return first_stage(noise_.apply(predicted), noise_.apply(measured));
}

/// A law is right up to a relative error that drifts: its wrench times hats of time, forces and torques
/// apart.
Eigen::MatrixXd Evidence::law_error_columns(const std::vector<SetMember>& members) const {
  std::vector<Eigen::VectorXd> raw;
  const int n = problem_.samples();
  for (const SetMember& member : members) {
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
    if (h.pattern || law_error_ <= 0) continue;
    const Eigen::VectorXd value = expected_wrench(problem_, h, member);
    const int knots = std::clamp(static_cast<int>(n * problem_.period() / kLawKnot), 2, kLawKnots);
    const double distance = static_cast<double>(n) / (knots - 1);
    for (int half = 0; half < 2; ++half) {
      if (value.segment(3 * half * n, 3 * n).norm() < 1e-12) continue;
      for (int k = 0; k < knots; ++k) {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(problem_.rows());
        for (int i = 0; i < n; ++i) {
          const double hat = 1 - std::abs(i - k * distance) / distance;
          if (hat <= 0) continue;
          for (int c = 3 * half; c < 3 * half + 3; ++c) x[c * n + i] = law_error_ * hat * value[c * n + i];
        }
        raw.push_back(std::move(x));
      }
    }
  }
  Eigen::MatrixXd columns(problem_.rows(), static_cast<Eigen::Index>(raw.size()));
  for (std::size_t k = 0; k < raw.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = raw[k];
  return noise_.apply(columns);
}

/// ln of the posterior's integral over its density at u, by its quadratic there: over all of the coordinates
/// between bounds, then over one side of those at a bound, each by itself. Less ln of the prior's mass within
/// bounds: what would have to lie beyond them to explain the residual is no evidence.
double Evidence::log_integral(const Layout& layout, const Eigen::VectorXd& u,
                              const Eigen::MatrixXd& precision, const Eigen::VectorXd& gradient) {
  std::vector<Eigen::Index> free, held;
  for (Eigen::Index k = 0; k < u.size(); ++k) (layout.inward(k, u[k]) == 0 ? free : held).push_back(k);
  const Eigen::LLT<Eigen::MatrixXd> factor(precision(free, free));
  const Eigen::VectorXd step = factor.solve(Eigen::VectorXd(gradient(free)));
  double sum = 0.5 * step.dot(Eigen::VectorXd(gradient(free))) - 0.5 * log_determinant(factor);
  const Eigen::MatrixXd half =
      factor.matrixL().solve(Eigen::MatrixXd::Identity(factor.rows(), factor.cols()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto& c = layout.all[static_cast<std::size_t>(free[i])];
    if (c.low < -kFar && c.high > kFar) continue;
    const auto at = static_cast<Eigen::Index>(i);
    const double deviation = half.col(at).norm(), optimum = u[free[i]] + step[at];
    sum += log_normal_between((c.low - optimum) / deviation, (c.high - optimum) / deviation) -
           log_normal_between(c.low, c.high);
  }
  for (const Eigen::Index k : held) {
    const auto& c = layout.all[static_cast<std::size_t>(k)];
    const Eigen::VectorXd with = precision(free, std::vector<Eigen::Index>{k});
    const double curvature = std::sqrt(precision(k, k) - with.dot(factor.solve(with)));
    // inwards it could only rise by a step that the fit has refused
    const double slope = std::min(0.0, layout.inward(k, u[k]) * (gradient[k] - with.dot(step)) / curvature);
    sum +=
        0.5 * slope * slope + log_normal_cdf(slope) - std::log(curvature) - log_normal_between(c.low, c.high);
  }
  return sum;
}

/// How wrong a law is, is unknown itself: a mass is exact, a wake is not. The mean over RMS errors that are
/// equally likely. Deviations are with the largest of them: an estimate is not surer than its law.
double Evidence::log_integral_over_law_errors(const Layout& layout, const Eigen::VectorXd& u,
                                              const Eigen::MatrixXd& precision,
                                              const Eigen::VectorXd& gradient, Eigen::Index law) {
  if (law == 0) return log_integral(layout, u, precision, gradient);
  std::array<double, kLawErrors.size()> value{};
  for (std::size_t k = 0; k < kLawErrors.size(); ++k) {
    const double share = kLawErrors[k];
    Eigen::MatrixXd scaled = precision;
    scaled.bottomRows(law) *= share;
    scaled.rightCols(law) *= share;
    scaled.diagonal().tail(law).array() += 1 - share * share;  // the prior stays one
    Eigen::VectorXd slope = gradient;
    slope.tail(law) *= share;
    value[k] = log_integral(layout, u, scaled, slope);
  }
  const double best = *std::max_element(value.begin(), value.end());
  double sum = 0;
  for (const double v : value) sum += std::exp(v - best);
  return best + std::log(sum / static_cast<double>(value.size()));
}

SetFit Evidence::fit(std::vector<SetMember> members) const {
  Layout layout;
  layout.calibration = layout.total = b_->cols();
  layout.all.resize(static_cast<std::size_t>(layout.total));
  for (SetMember& member : members) {
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
    layout.first.push_back(layout.total);
    layout.theta.emplace_back();
    if (h.pattern) {
      layout.total += h.pattern->whitened.cols();
      layout.all.resize(static_cast<std::size_t>(layout.total));
      continue;
    }
    for (std::size_t k = 0; k < member.theta.size(); ++k) {
      Layout::Coordinate c;
      c.prior = problem_.prior(*h.effect, k);
      c.half = c.prior.law == Law::half_normal;
      c.low = c.half ? 0.0 : c.prior.coordinate(c.prior.lower);
      c.high = c.prior.coordinate(c.prior.upper);
      layout.theta.back().push_back(c);
      layout.all.push_back(c);
    }
    layout.total += static_cast<Eigen::Index>(member.theta.size());
    const std::vector<double> spread = h.effect->start_spread(member.theta.data());
    const auto states = static_cast<Eigen::Index>(spread.size() * problem_.memory_windows().size());
    if (member.start.size() != states) member.start = Eigen::VectorXd::Zero(states);
    if (!h.is_linear() && !member.first_stage) member.first_stage = first_stage_of(member);
    layout.total += states;
    layout.all.resize(static_cast<std::size_t>(layout.total));
  }
  Eigen::VectorXd u = Eigen::VectorXd::Zero(layout.total);
  for (std::size_t m = 0; m < members.size(); ++m) {
    const SetMember& member = members[m];
    const Eigen::Index first = layout.first[m];
    const auto& coordinates = layout.theta[m];
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      u[first + static_cast<Eigen::Index>(k)] = std::clamp(coordinates[k].prior.coordinate(member.theta[k]),
                                                           coordinates[k].low, coordinates[k].high);
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
    if (h.pattern) {
      if (member.weights.size() > 0) u.segment(first, member.weights.size()) = member.weights;
      continue;
    }
    const std::vector<double> spread = h.effect->start_spread(member.theta.data());
    for (Eigen::Index k = 0; k < member.start.size(); ++k) {
      const double s = spread[static_cast<std::size_t>(k) % spread.size()];
      u[first + static_cast<Eigen::Index>(coordinates.size()) + k] = s > 0 ? member.start[k] / s : 0.0;
    }
  }

  SetFit out;
  Eigen::VectorXd rest, trial_rest;
  evaluate(layout, u, members, rest, &out.columns);
  double objective = 0.5 * (rest.squaredNorm() + u.squaredNorm());
  Eigen::LLT<Eigen::MatrixXd> factor;
  Eigen::VectorXd gradient;
  const auto linearise = [&] {
    const Eigen::Index shared = layout.calibration, own = out.columns.cols();
    out.precision.resize(shared + own, shared + own);
    out.precision.topLeftCorner(shared, shared) = bb_;
    out.precision.topRightCorner(shared, own) = inner_products(*b_, out.columns);
    out.precision.bottomLeftCorner(own, shared) = out.precision.topRightCorner(shared, own).transpose();
    out.precision.bottomRightCorner(own, own) = inner_products(out.columns);
    out.precision.diagonal().array() += 1;
    factor.compute(out.precision);
    out.moment.resize(shared + own);
    out.moment << b_->transpose() * rest, out.columns.transpose() * rest;
    gradient = out.moment - u;
  };
  linearise();
  const bool linear = std::all_of(members.begin(), members.end(), [&](const SetMember& m) {
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(m.hypothesis)];
    return h.pattern || h.is_linear();
  });
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    // coordinates at a bound that the step would cross are held
    std::vector<char> held(static_cast<std::size_t>(layout.total), 0);
    Eigen::VectorXd step;
    for (int round = 0; round < 4; ++round) {
      Eigen::MatrixXd H = out.precision;
      Eigen::VectorXd g = gradient;
      for (Eigen::Index k = 0; k < layout.total; ++k)
        if (held[static_cast<std::size_t>(k)]) {
          H.row(k).setZero();
          H.col(k).setZero();
          H(k, k) = 1;
          g[k] = 0;
        }
      step = round == 0 ? Eigen::VectorXd(factor.solve(g)) : Eigen::VectorXd(H.llt().solve(g));
      bool more = false;
      for (Eigen::Index k = 0; k < layout.total; ++k) {
        const auto& c = layout.all[static_cast<std::size_t>(k)];
        const bool out_of_bounds = (u[k] <= c.low && step[k] < 0) || (u[k] >= c.high && step[k] > 0);
        if (out_of_bounds && !held[static_cast<std::size_t>(k)]) {
          held[static_cast<std::size_t>(k)] = 1;
          more = true;
        }
      }
      if (!more) break;
    }
    double length = 1, fell = 0;
    bool clipped = false;  // what is free is not at its optimum beside what met its bound
    for (int halving = 0; halving < 6; ++halving, length *= 0.4) {
      Eigen::VectorXd trial = u + length * step;
      for (Eigen::Index k = 0; k < layout.total; ++k) {
        const auto& c = layout.all[static_cast<std::size_t>(k)];
        trial[k] = std::clamp(trial[k], c.low, c.high);
      }
      clipped = trial != u + length * step;
      evaluate(layout, trial, members, trial_rest, nullptr);
      const double value = 0.5 * (trial_rest.squaredNorm() + trial.squaredNorm());
      if (!(value < objective)) continue;
      fell = objective - value;
      objective = value;
      u = trial;
      break;
    }
    if (fell > 0) {
      evaluate(layout, u, members, rest, &out.columns);
      linearise();
    } else {
      evaluate(layout, u, members, rest, nullptr);
    }
    if (fell < kConverged || (linear && length == 1 && !clipped)) break;
  }

  // A free coordinate has no gradient at the optimum. What is left of one where a law has a kink (a rope that
  // comes taut), or where the iterations ended before, is no gain, and none of the law's error either.
  const Eigen::Index own = layout.total;
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < own; ++k)
    if (layout.inward(k, u[k]) == 0) free.push_back(k);
  // relative law errors are integrated over at the optimum
  const Eigen::MatrixXd law = law_error_columns(members);
  if (law.cols() > 0) {
    Eigen::VectorXd left = Eigen::VectorXd::Zero(own);
    left(free) = Eigen::VectorXd(
        Eigen::MatrixXd(out.precision(free, free)).llt().solve(Eigen::VectorXd(gradient(free))));
    const Eigen::Index members_own = out.columns.cols();
    const Eigen::VectorXd beyond =
        rest - *b_ * left.head(layout.calibration) - out.columns * left.tail(members_own);
    out.columns.conservativeResize(Eigen::NoChange, members_own + law.cols());
    out.columns.rightCols(law.cols()) = law;
    u.conservativeResize(own + law.cols());
    u.tail(law.cols()).setZero();
    layout.all.resize(static_cast<std::size_t>(own + law.cols()));
    linearise();
    gradient.tail(law.cols()) = law.transpose() * beyond;
  }
  for (const Eigen::Index k : free) gradient[k] = 0;
  out.log_evidence =
      -objective + log_integral_over_law_errors(layout, u, out.precision, gradient, law.cols()) - log_totals_;
  const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(u.size(), u.size()));
  for (std::size_t m = 0; m < members.size(); ++m)
    for (std::size_t k = 0; k < layout.theta[m].size(); ++k) {
      const Eigen::Index at = layout.first[m] + static_cast<Eigen::Index>(k);
      out.theta_deviation.push_back(std::abs(layout.theta[m][k].prior.slope(u[at])) *
                                    std::sqrt(covariance(at, at)));
    }
  out.calibration_columns = b_;
  out.rest = std::move(rest);
  out.calibration = deviations_.cwiseProduct(u.head(layout.calibration));
  out.coordinates = std::move(u);
  out.first = layout.first;
  out.members = std::move(members);
  return out;
}

SetMember Evidence::member_at(int hypothesis, int point, const Eigen::VectorXd& amplitudes) const {
  const Hypothesis& h = hypotheses_[static_cast<std::size_t>(hypothesis)];
  SetMember out;
  out.hypothesis = hypothesis;
  if (point < 0) {
    out.weights = amplitudes;
    return out;
  }
  const ShapePoint& at = h.points[static_cast<std::size_t>(point)];
  out.theta = at.theta;
  for (std::size_t k = 0; k < at.amplitude.size(); ++k) {
    const ParameterPrior prior = problem_.prior(*h.effect, at.amplitude[k]);
    const double u = amplitudes[static_cast<Eigen::Index>(k)];
    out.theta[at.amplitude[k]] = prior.value(prior.law == Law::half_normal ? std::max(0.05, u) : u);
  }
  const std::vector<double> spread = h.effect->start_spread(at.theta.data());
  if (spread.empty()) return out;
  // columns of initial states are those of a load of one standard deviation
  const auto windows = static_cast<Eigen::Index>(problem_.memory_windows().size());
  out.start = Eigen::VectorXd::Zero(windows * static_cast<Eigen::Index>(spread.size()));
  auto column = static_cast<Eigen::Index>(at.amplitude.size());
  const double mass = std::max(0.1, amplitudes[0]);
  for (Eigen::Index k = 0; k < out.start.size(); ++k) {
    const double s = spread[static_cast<std::size_t>(k) % spread.size()];
    if (s > 0) out.start[k] = s * std::clamp(amplitudes[column++] / mass, -3.0, 3.0);
  }
  return out;
}

}  // namespace omniflight::diagnosis
