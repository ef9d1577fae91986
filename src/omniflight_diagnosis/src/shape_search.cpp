#include "shape_search.hpp"

#include <algorithm>
#include <cmath>

#include "bounded_step.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr int kGrid = 24;             // steps from one bound to the other
constexpr int kAround = 3;            // of them to each side of bends found before
constexpr double kFinest = 0.02;      // of a step of the grid
constexpr double kWorth = 1;          // nats that a round of steps must bring, or else they are too long
constexpr double kWorthShare = 1e-6;  // of the gain so far

}  // namespace

ShapeSearch::ShapeSearch(const Problem& problem, const Fit& base, const physics::Effect& effect)
    : problem_(problem), effect_(effect), heavy_(adds_inertia(effect)) {
  const auto& parameters = effect.info().parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (is_amplitude(k))
      free_.push_back(static_cast<Eigen::Index>(k));
    else
      shapes_.push_back(k);
    theta_.push_back(is_amplitude(k) ? parameters[k].neutral : parameters[k].typical);
  }
  amplitudes_.assign(parameters.size(), 0.0);
  const auto own = static_cast<Eigen::Index>(free_.size());
  const Unknowns others(problem, base.effects, &base.offsets);
  rest_size_ = others.x.size();
  for (Eigen::VectorXd* v : {&x_, &lower_, &upper_, &g_}) v->resize(own + rest_size_);
  x_.tail(rest_size_) = others.x;
  lower_.tail(rest_size_) = others.lower;
  upper_.tail(rest_size_) = others.upper;
  for (Eigen::Index c = 0; c < own; ++c) {
    const auto k = static_cast<std::size_t>(free_[static_cast<std::size_t>(c)]);
    const Range range = problem.range(effect, k);
    x_[c] = parameters[k].neutral;
    lower_[c] = range.lower;
    upper_[c] = range.upper;
  }
  jacobian_ = jacobian_of(problem, base);
  Z_ = problem.whitened(base.effects, jacobian_);
  target_ = problem.noise().apply_vector(problem, base.residual);
  H_.resize(own + rest_size_, own + rest_size_);
  const auto [H, g] = problem.normal_equations(base.effects, jacobian_, target_);
  H_.bottomRightCorner(rest_size_, rest_size_) = H;
  H_.bottomRightCorner(rest_size_, rest_size_).diagonal() += others.weight;
  g_.tail(rest_size_) = g - others.weight.cwiseProduct(others.x);
}

Eigen::MatrixXd ShapeSearch::columns_at(const std::vector<double>& theta) {
  Eigen::MatrixXd columns;
  if (heavy_) {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem_.offset_sigma().size());
    Eigen::VectorXd rest;
    problem_.predict({{&effect_, theta}}, none, rest, &jacobian_);
    columns.resize(jacobian_.rows(), static_cast<Eigen::Index>(free_.size()));
    for (std::size_t c = 0; c < free_.size(); ++c)
      columns.col(static_cast<Eigen::Index>(c)) = jacobian_.col(free_[c]);
  } else {
    problem_.amplitude_columns(effect_, theta, free_, columns);
  }
  return problem_.noise().apply(problem_, columns);
}

void ShapeSearch::consider(const std::vector<double>& theta, bool remember) {
  const auto known = remember ? problem_.memory().at(effect_, theta, [&] { return columns_at(theta); })
                              : std::make_shared<const Eigen::MatrixXd>(columns_at(theta));
  const Eigen::MatrixXd& X = *known;
  const Eigen::Index own = X.cols();
  H_.topLeftCorner(own, own) = X.transpose() * X;
  H_.topRightCorner(own, rest_size_) = X.transpose() * Z_;
  H_.bottomLeftCorner(rest_size_, own) = H_.topRightCorner(own, rest_size_).transpose();
  g_.head(own) = X.transpose() * target_;
  const Eigen::VectorXd step = bounded_step(H_, g_, lower_ - x_, upper_ - x_);
  const double gain = g_.dot(step) - 0.5 * step.dot(H_ * step);
  if (gain <= gain_ * (1 + 1e-9) + 1e-9) return;
  gain_ = gain;
  theta_ = theta;
  for (Eigen::Index c = 0; c < own; ++c)
    amplitudes_[static_cast<std::size_t>(free_[static_cast<std::size_t>(c)])] = x_[c] + step[c];
}

double ShapeSearch::value_at(std::size_t shape, double share) const {
  const physics::Parameter& p = effect_.info().parameters[shape];
  return p.lower > 0 ? p.lower * std::pow(p.upper / p.lower, share) : p.lower + share * (p.upper - p.lower);
}

double ShapeSearch::share_at(std::size_t shape, double value) const {
  const physics::Parameter& p = effect_.info().parameters[shape];
  return p.lower > 0 ? std::log(value / p.lower) / std::log(p.upper / p.lower)
                     : (value - p.lower) / (p.upper - p.lower);
}

void ShapeSearch::take(const std::vector<double>& theta) {
  for (std::size_t shape : shapes_) theta_[shape] = theta[shape];
  consider(theta_, true);
}

void ShapeSearch::over_bounds() {
  for (std::size_t shape : shapes_) {
    std::vector<double> theta = theta_;
    for (int k = 0; k <= kGrid; ++k) {
      theta[shape] = value_at(shape, static_cast<double>(k) / kGrid);
      consider(theta, true);
    }
  }
}

void ShapeSearch::around(const std::vector<double>& found) {
  take(found);
  for (std::size_t shape : shapes_) {
    std::vector<double> theta = theta_;
    const double share = share_at(shape, theta[shape]);
    for (int k = -kAround; k <= kAround; ++k) {
      theta[shape] = value_at(shape, std::clamp(share + static_cast<double>(k) / kGrid, 0.0, 1.0));
      consider(theta, true);
    }
  }
}

bool ShapeSearch::bends_together(const physics::Effect& effect) {
  const auto& parameters = effect.info().parameters;
  return acts_at_once(effect) && std::count_if(parameters.begin(), parameters.end(), is_shape) > 1;
}

void ShapeSearch::nearby() {
  if (!bends_together(effect_)) return;
  for (double step = 0.5; step > kFinest;) {
    const double before = gain_;
    for (std::size_t shape : shapes_)
      for (const double way : {step, -step}) {
        std::vector<double> theta = theta_;
        theta[shape] = value_at(shape, std::clamp(share_at(shape, theta[shape]) + way / kGrid, 0.0, 1.0));
        consider(theta, false);
      }
    if (gain_ < before + std::max(kWorth, kWorthShare * before)) step /= 2;  // it creeps, or stands
  }
}

std::vector<double> ShapeSearch::best() const {
  std::vector<double> out = theta_;
  const auto& parameters = effect_.info().parameters;
  for (std::size_t k = 0; k < out.size(); ++k)
    if (is_amplitude(k)) out[k] = std::clamp(amplitudes_[k], parameters[k].lower, parameters[k].upper);
  return out;
}

}  // namespace omniflight::diagnosis
