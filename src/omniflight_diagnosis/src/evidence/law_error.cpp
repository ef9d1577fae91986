#include "law_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "laplace.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kLawKnot = 2.0;  ///< s, least correlation time of a law's relative error
constexpr int kLawKnots = 8;      ///< at most, a flight
/// RMS errors of laws over the one that is told, equally likely.
constexpr std::array<double, 4> kLawErrors{1, 0.3, 0.1, 0.03};

}  // namespace

Eigen::MatrixXd law_error_columns(const RegressionProblem& problem, const NoiseModel& noise,
                                  const std::vector<Hypothesis>& hypotheses, double law_error,
                                  const std::vector<SetMember>& members) {
  std::vector<Eigen::VectorXd> raw;
  const int n = problem.samples();
  for (const SetMember& member : members) {
    const Hypothesis& h = hypotheses[static_cast<std::size_t>(member.hypothesis)];
    if (h.pattern || law_error <= 0) continue;
    const Eigen::VectorXd value = expected_wrench(problem, h, member);
    const int knots = std::clamp(static_cast<int>(n * problem.period() / kLawKnot), 2, kLawKnots);
    const double distance = static_cast<double>(n) / (knots - 1);
    for (int half = 0; half < 2; ++half) {
      if (value.segment(3 * half * n, 3 * n).norm() < 1e-12) continue;
      for (int k = 0; k < knots; ++k) {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.rows());
        for (int i = 0; i < n; ++i) {
          const double hat = 1 - std::abs(i - k * distance) / distance;
          if (hat <= 0) continue;
          for (int c = 3 * half; c < 3 * half + 3; ++c) x[c * n + i] = law_error * hat * value[c * n + i];
        }
        raw.push_back(std::move(x));
      }
    }
  }
  Eigen::MatrixXd columns(problem.rows(), static_cast<Eigen::Index>(raw.size()));
  for (std::size_t k = 0; k < raw.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = raw[k];
  return noise.apply(columns);
}

double log_integral_over_law_errors(const SetCoordinates& coordinates, const Eigen::VectorXd& u,
                                    const Eigen::MatrixXd& precision, const Eigen::VectorXd& gradient,
                                    Eigen::Index law) {
  if (law == 0) return coordinates.log_integral(u, precision, gradient);
  std::array<double, kLawErrors.size()> value{};
  for (std::size_t k = 0; k < kLawErrors.size(); ++k) {
    const double share = kLawErrors[k];
    Eigen::MatrixXd scaled = precision;
    scaled.bottomRows(law) *= share;
    scaled.rightCols(law) *= share;
    scaled.diagonal().tail(law).array() += 1 - share * share;  // the prior stays one
    Eigen::VectorXd slope = gradient;
    slope.tail(law) *= share;
    value[k] = coordinates.log_integral(u, scaled, slope);
  }
  const double best = *std::max_element(value.begin(), value.end());
  double sum = 0;
  for (const double v : value) sum += std::exp(v - best);
  return best + std::log(sum / static_cast<double>(value.size()));
}

}  // namespace omniflight::diagnosis
