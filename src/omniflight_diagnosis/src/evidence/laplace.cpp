#include "laplace.hpp"

#include <algorithm>
#include <cmath>

#include "first_stage.hpp"
#include "inner_products.hpp"
#include "law_error.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kIterations = 8;
constexpr int kBoundRounds = 4;
constexpr int kShortenings = 6;
constexpr double kConverged = 0.1;  ///< nat: the objective may still fall by less

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
      z_(noise.impulses().count == 0 ? noise.scale(fitted.residual) : noise.apply(noise.residual())),
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

void Evidence::evaluate(const SetCoordinates& coordinates, const Eigen::VectorXd& u,
                        std::vector<SetMember>& members, Eigen::VectorXd& rest,
                        Eigen::MatrixXd* columns) const {
  rest = z_ - *b_ * u.head(coordinates.calibration());
  if (columns) columns->resize(z_.size(), u.size() - coordinates.calibration());
  Eigen::VectorXd value;
  Eigen::MatrixXd by_theta, by_start;
  for (std::size_t m = 0; m < members.size(); ++m) {
    SetMember& member = members[m];
    coordinates.give(u, m, member);
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
    const Eigen::Index first = coordinates.first()[m], column = first - coordinates.calibration();
    if (h.pattern) {
      rest -= h.pattern->whitened * member.weights;
      if (columns) columns->middleCols(column, h.pattern->whitened.cols()) = h.pattern->whitened;
      continue;
    }
    const auto parameters = static_cast<Eigen::Index>(member.theta.size());
    const auto slope = [&](Eigen::Index k) {
      return coordinates.parameters(m)[static_cast<std::size_t>(k)].prior.slope(u[first + k]);
    };
    if (h.is_linear()) {
      rest -= h.linear * Eigen::Map<const Eigen::VectorXd>(member.theta.data(), parameters);
      if (columns)
        for (Eigen::Index k = 0; k < parameters; ++k) columns->col(column + k) = slope(k) * h.linear.col(k);
      continue;
    }
    const Eigen::Index states = member.start.size();
    problem_.wrench_of({h.effect, member.theta, member.start}, value, columns ? &by_theta : nullptr,
                       columns && states > 0 ? &by_start : nullptr);
    const double predictable = member.first_stage.value_or(1.0);
    rest -= predictable * noise_.apply(value);
    if (!columns) continue;
    for (Eigen::Index k = 0; k < parameters; ++k) by_theta.col(k) *= predictable * slope(k);
    columns->middleCols(column, parameters) = noise_.apply(by_theta);
    if (states == 0) continue;
    const std::vector<double> spread = h.effect->start_spread(member.theta.data());
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

/// The way to the optimum of a set, and the quadratic of the posterior density there.
class Evidence::Descent {
 public:
  Descent(const Evidence& evidence, std::vector<SetMember> members)
      : evidence_(evidence),
        members_(std::move(members)),
        coordinates_(evidence.problem_, evidence.hypotheses_, evidence.b_->cols(), members_),
        u_(coordinates_.of(members_)) {
    for (SetMember& member : members_) {
      const Hypothesis& h = evidence.hypotheses_[static_cast<std::size_t>(member.hypothesis)];
      if (!h.pattern && !h.is_linear() && !member.first_stage)
        member.first_stage = evidence.first_stage_of(member);
      linear_ = linear_ && (h.pattern || h.is_linear());
    }
    evidence.evaluate(coordinates_, u_, members_, out_.rest, &out_.columns);
    objective_ = objective(out_.rest, u_);
    linearise();
  }

  /// Gauss-Newton, with steps shortened until the objective falls.
  void run() {
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      const Move moved = move_along(bounded_step());
      evidence_.evaluate(coordinates_, u_, members_, out_.rest, moved.fell > 0 ? &out_.columns : nullptr);
      if (moved.fell > 0) linearise();
      if (moved.fell < kConverged || (linear_ && moved.whole)) break;
    }
  }

  /// Integrates, over errors of laws as well, which are zero at the optimum.
  SetFit integrate() && {
    // A free coordinate has no gradient at the optimum. What is left of one where a law has a kink (a rope
    // that comes taut), or where the iterations ended before, is no gain, and none of the law's error either.
    const std::vector<Eigen::Index> free = coordinates_.free(u_);
    const Eigen::MatrixXd law = law_error_columns(evidence_.problem_, evidence_.noise_, evidence_.hypotheses_,
                                                  evidence_.law_error_, members_);
    if (law.cols() > 0) {
      Eigen::VectorXd left = Eigen::VectorXd::Zero(u_.size());
      left(free) = Eigen::VectorXd(
          Eigen::MatrixXd(out_.precision(free, free)).llt().solve(Eigen::VectorXd(gradient_(free))));
      const Eigen::Index own = out_.columns.cols();
      const Eigen::VectorXd beyond =
          out_.rest - *evidence_.b_ * left.head(coordinates_.calibration()) - out_.columns * left.tail(own);
      out_.columns.conservativeResize(Eigen::NoChange, own + law.cols());
      out_.columns.rightCols(law.cols()) = law;
      coordinates_.append(law.cols());
      u_.conservativeResize(coordinates_.size());
      u_.tail(law.cols()).setZero();
      linearise();
      gradient_.tail(law.cols()) = law.transpose() * beyond;
    }
    for (const Eigen::Index k : free) gradient_[k] = 0;
    out_.log_evidence = -objective_ - evidence_.log_totals_ +
                        log_integral_over_law_errors(coordinates_, u_, out_.precision, gradient_, law.cols());
    deviations();
    out_.calibration_columns = evidence_.b_;
    out_.calibration = evidence_.deviations_.cwiseProduct(u_.head(coordinates_.calibration()));
    out_.coordinates = std::move(u_);
    out_.first = coordinates_.first();
    out_.members = std::move(members_);
    return std::move(out_);
  }

 private:
  struct Move {
    double fell = 0;     ///< nat
    bool whole = false;  ///< as far as the quadratic's optimum: what is linear is there
  };

  static double objective(const Eigen::VectorXd& rest, const Eigen::VectorXd& u) {
    return 0.5 * (rest.squaredNorm() + u.squaredNorm());
  }

  /// The quadratic at u, from residual and columns there.
  void linearise() {
    const Eigen::MatrixXd& b = *evidence_.b_;
    const Eigen::Index shared = coordinates_.calibration(), own = out_.columns.cols();
    out_.precision.resize(shared + own, shared + own);
    out_.precision.topLeftCorner(shared, shared) = evidence_.bb_;
    out_.precision.topRightCorner(shared, own) = inner_products(b, out_.columns);
    out_.precision.bottomLeftCorner(own, shared) = out_.precision.topRightCorner(shared, own).transpose();
    out_.precision.bottomRightCorner(own, own) = inner_products(out_.columns);
    out_.precision.diagonal().array() += 1;
    factor_.compute(out_.precision);
    out_.moment.resize(shared + own);
    out_.moment << b.transpose() * out_.rest, out_.columns.transpose() * out_.rest;
    gradient_ = out_.moment - u_;
  }

  /// To the quadratic's optimum; coordinates at a bound that it would cross are held.
  Eigen::VectorXd bounded_step() const {
    std::vector<Eigen::Index> held;
    Eigen::VectorXd step = factor_.solve(gradient_);
    for (int round = 1; round < kBoundRounds; ++round) {
      const std::size_t before = held.size();
      for (Eigen::Index k = 0; k < u_.size(); ++k)
        if (step[k] * coordinates_.inward(k, u_[k]) < 0) held.push_back(k);
      if (held.size() == before) break;
      Eigen::MatrixXd precision = out_.precision;
      Eigen::VectorXd gradient = gradient_;
      for (const Eigen::Index k : held) {
        precision.row(k).setZero();
        precision.col(k).setZero();
        precision(k, k) = 1;
        gradient[k] = 0;
      }
      step = precision.llt().solve(gradient);
    }
    return step;
  }

  /// Goes the part of a step by which the objective falls.
  Move move_along(const Eigen::VectorXd& step) {
    double length = 1;
    Eigen::VectorXd rest;
    for (int shortened = 0; shortened < kShortenings; ++shortened, length *= 0.4) {
      const Eigen::VectorXd aim = u_ + length * step;
      Eigen::VectorXd trial = coordinates_.within_bounds(aim);
      evidence_.evaluate(coordinates_, trial, members_, rest, nullptr);
      const double value = objective(rest, trial);
      if (!(value < objective_)) continue;
      const double fell = objective_ - value;
      objective_ = value;
      // what is free is not at its optimum beside what met its bound
      const bool whole = length == 1 && trial == aim;
      u_ = std::move(trial);
      return {fell, whole};
    }
    return {};
  }

  /// Of the members' parameters.
  void deviations() {
    const Eigen::MatrixXd covariance = factor_.solve(Eigen::MatrixXd::Identity(u_.size(), u_.size()));
    for (std::size_t m = 0; m < members_.size(); ++m) {
      Eigen::Index at = coordinates_.first()[m];
      for (const SetCoordinates::Parameter& p : coordinates_.parameters(m)) {
        out_.theta_deviation.push_back(std::abs(p.prior.slope(u_[at])) * std::sqrt(covariance(at, at)));
        ++at;
      }
    }
  }

  const Evidence& evidence_;
  std::vector<SetMember> members_;
  SetCoordinates coordinates_;
  Eigen::VectorXd u_, gradient_;
  bool linear_ = true;
  double objective_ = 0;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  SetFit out_;
};

SetFit Evidence::fit(std::vector<SetMember> members) const {
  Descent descent(*this, std::move(members));
  descent.run();
  return std::move(descent).integrate();
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
    const physics::ParameterPrior prior = problem_.prior(*h.effect, at.amplitude[k]);
    const double u = amplitudes[static_cast<Eigen::Index>(k)];
    out.theta[at.amplitude[k]] =
        prior.value(prior.law == physics::ParameterPrior::Law::half_normal ? std::max(0.05, u) : u);
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
