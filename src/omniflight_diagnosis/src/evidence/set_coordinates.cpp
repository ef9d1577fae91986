#include "set_coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "../numerics/statistics.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kFar = 1e6;  ///< standard deviations: no bound

double log_determinant(const Eigen::LLT<Eigen::MatrixXd>& llt) {
  return 2 * llt.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

SetCoordinates::SetCoordinates(const RegressionProblem& problem, const std::vector<Hypothesis>& hypotheses,
                               Eigen::Index calibration, std::vector<SetMember>& members)
    : hypotheses_(hypotheses), calibration_(calibration) {
  append(calibration);
  for (SetMember& member : members) {
    const Hypothesis& h = hypotheses[static_cast<std::size_t>(member.hypothesis)];
    first_.push_back(size());
    parameters_.emplace_back();
    if (h.pattern) {
      append(h.pattern->whitened.cols());
      continue;
    }
    for (std::size_t k = 0; k < member.theta.size(); ++k) {
      Parameter p;
      p.prior = problem.prior(*h.effect, k);
      p.low =
          p.prior.law == physics::ParameterPrior::Law::half_normal ? 0.0 : p.prior.coordinate(p.prior.lower);
      p.high = p.prior.coordinate(p.prior.upper);
      parameters_.back().push_back(p);
      bounds_.push_back({p.low, p.high});
    }
    const std::vector<double> spread = h.effect->start_spread(member.theta.data());
    const auto states = static_cast<Eigen::Index>(spread.size() * problem.memory_windows().size());
    if (member.start.size() != states) member.start = Eigen::VectorXd::Zero(states);
    append(states);
  }
}

void SetCoordinates::append(Eigen::Index count) {
  bounds_.resize(bounds_.size() + static_cast<std::size_t>(count));
}

Eigen::VectorXd SetCoordinates::of(const std::vector<SetMember>& members) const {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(size());
  for (std::size_t m = 0; m < members.size(); ++m) {
    const SetMember& member = members[m];
    const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
    if (h.pattern) {
      if (member.weights.size() > 0) u.segment(first_[m], member.weights.size()) = member.weights;
      continue;
    }
    Eigen::Index at = first_[m];
    for (std::size_t k = 0; k < parameters_[m].size(); ++k) {
      const Parameter& p = parameters_[m][k];
      u[at++] = std::clamp(p.prior.coordinate(member.theta[k]), p.low, p.high);
    }
    const std::vector<double> spread = h.effect->start_spread(member.theta.data());
    for (Eigen::Index k = 0; k < member.start.size(); ++k) {
      const double s = spread[static_cast<std::size_t>(k) % spread.size()];
      u[at++] = s > 0 ? member.start[k] / s : 0.0;
    }
  }
  return u;
}

void SetCoordinates::give(const Eigen::VectorXd& u, std::size_t index, SetMember& member) const {
  const Hypothesis& h = hypotheses_[static_cast<std::size_t>(member.hypothesis)];
  Eigen::Index at = first_[index];
  if (h.pattern) {
    member.weights = u.segment(at, h.pattern->whitened.cols());
    return;
  }
  for (std::size_t k = 0; k < parameters_[index].size(); ++k)
    member.theta[k] = parameters_[index][k].prior.value(u[at++]);
  const std::vector<double> spread = h.effect->start_spread(member.theta.data());
  for (Eigen::Index k = 0; k < member.start.size(); ++k)
    member.start[k] = u[at++] * spread[static_cast<std::size_t>(k) % spread.size()];
}

Eigen::VectorXd SetCoordinates::within_bounds(const Eigen::VectorXd& u) const {
  Eigen::VectorXd out = u;
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const Bounds& b = bounds_[static_cast<std::size_t>(k)];
    out[k] = std::clamp(u[k], b.low, b.high);
  }
  return out;
}

std::vector<Eigen::Index> SetCoordinates::free(const Eigen::VectorXd& u) const {
  std::vector<Eigen::Index> out;
  for (Eigen::Index k = 0; k < u.size(); ++k)
    if (inward(k, u[k]) == 0) out.push_back(k);
  return out;
}

double SetCoordinates::log_integral(const Eigen::VectorXd& u, const Eigen::MatrixXd& precision,
                                    const Eigen::VectorXd& gradient) const {
  const std::vector<Eigen::Index> free = this->free(u);
  std::vector<Eigen::Index> held;
  for (Eigen::Index k = 0; k < u.size(); ++k)
    if (inward(k, u[k]) != 0) held.push_back(k);
  const Eigen::LLT<Eigen::MatrixXd> factor(precision(free, free));
  const Eigen::VectorXd step = factor.solve(Eigen::VectorXd(gradient(free)));
  double sum = 0.5 * step.dot(Eigen::VectorXd(gradient(free))) - 0.5 * log_determinant(factor);
  const Eigen::MatrixXd half =
      factor.matrixL().solve(Eigen::MatrixXd::Identity(factor.rows(), factor.cols()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto& c = bounds_[static_cast<std::size_t>(free[i])];
    if (c.low < -kFar && c.high > kFar) continue;
    const auto at = static_cast<Eigen::Index>(i);
    const double deviation = half.col(at).norm(), optimum = u[free[i]] + step[at];
    sum += log_normal_between((c.low - optimum) / deviation, (c.high - optimum) / deviation) -
           log_normal_between(c.low, c.high);
  }
  for (const Eigen::Index k : held) {
    const auto& c = bounds_[static_cast<std::size_t>(k)];
    const Eigen::VectorXd with = precision(free, std::vector<Eigen::Index>{k});
    const double curvature = std::sqrt(precision(k, k) - with.dot(factor.solve(with)));
    // inwards it could only rise by a step that the fit has refused
    const double slope = std::min(0.0, inward(k, u[k]) * (gradient[k] - with.dot(step)) / curvature);
    sum +=
        0.5 * slope * slope + log_normal_cdf(slope) - std::log(curvature) - log_normal_between(c.low, c.high);
  }
  return sum;
}

}  // namespace omniflight::diagnosis
