#include "impulses.hpp"

#include <algorithm>
#include <cmath>

namespace omniflight::diagnosis {
namespace {

/// Chosen: one sample in a thousand; ten deviations.
constexpr double kImpulse = 1e-3, kSize = 10;
constexpr int kImpulseRounds = 12;  ///< in which more of them are found
constexpr int kSolverSteps = 30;
constexpr double kSolved = 1e-3;  ///< of the slope before the first step

/// What smoothing the signals (Flight::kernel_s) leaves of each cosine amplitude of an impulse.
Eigen::ArrayXd smoothed(const RegressionProblem& problem) {
  Eigen::ArrayXd out(amplitude_count(problem));
  Eigen::Index amplitude = 0;
  for (const Stretch& s : problem.stretches()) {
    const int size = transform_length(s.size());
    const double step = kPi / (size * problem.period()) * problem.kernel(s.flight);  // 2 pi frequency sigma
    for (int c = 0; c < 6; ++c)
      for (int k = 0; k < size; ++k) out[amplitude++] = std::exp(-0.5 * std::pow(k * step, 2));
  }
  return out;
}

/// Slopes of the log-likelihood by impulses of one deviation, at sizes of `u` deviations.
class Slopes {
 public:
  Slopes(const RegressionProblem& problem, const NoiseModel& noise, const Eigen::VectorXd& rest)
      : problem_(problem), kernel_(smoothed(problem)), deviations_(Eigen::ArrayXd::Zero(problem.rows())) {
    const Eigen::ArrayXd inverse = noise.inverse_deviations();
    sought_ = kernel_ * inverse.square() * rest.array();
    precision_ = (kernel_ * inverse).square();
    Eigen::Index amplitude = 0;
    for (const Stretch& s : problem.stretches()) {
      const int size = transform_length(s.size());
      for (int c = 0; c < 6; ++c, amplitude += size) {
        const double weight = precision_.segment(amplitude, size).sum() / size;
        if (weight > 0) deviations_.segment(c * problem.samples() + s.begin, size) = 1 / std::sqrt(weight);
      }
    }
  }
  Eigen::ArrayXd at_none() const { return deviations_ * samples_of(problem_, sought_).array(); }
  /// What sizes take from the slopes.
  Eigen::ArrayXd taken(const Eigen::ArrayXd& u) const {
    return deviations_ * samples_of(problem_, precision_ * amplitudes(u)).array();
  }
  Eigen::VectorXd sizes(const Eigen::ArrayXd& u) const { return deviations_ * u; }
  Eigen::VectorXd wrench(const Eigen::ArrayXd& u) const {
    return samples_of(problem_, kernel_ * amplitudes(u));
  }

 private:
  Eigen::ArrayXd amplitudes(const Eigen::ArrayXd& u) const {
    return cosine_amplitudes(problem_, sizes(u)).col(0);
  }
  const RegressionProblem& problem_;
  Eigen::ArrayXd kernel_, sought_, precision_;
  Eigen::ArrayXd deviations_;  ///< of an impulse in each sample given all others, N and Nm; 0: no noise there
};

/// The likeliest sizes of impulses in these samples, by conjugate gradients from `u`.
void solve(const Slopes& slopes, const Eigen::ArrayXd& none, const Eigen::ArrayXd& here, Eigen::ArrayXd& u) {
  constexpr double kPrior = 1 / (kSize * kSize);
  Eigen::ArrayXd left = here * (none - slopes.taken(u) - kPrior * u), direction = left;
  double square = left.square().sum();
  const double enough = kSolved * kSolved * (here * none).square().sum();
  for (int step = 0; step < kSolverSteps && square > enough; ++step) {
    const Eigen::ArrayXd curved = here * (slopes.taken(direction) + kPrior * direction);
    const double length = square / (direction * curved).sum();
    u += length * direction;
    left -= length * curved;
    const double next = left.square().sum();
    direction = left + next / square * direction;
    square = next;
  }
}

}  // namespace

Impulses find_impulses(const RegressionProblem& problem, const NoiseModel& noise,
                       const Eigen::VectorXd& rest) {
  constexpr double kCurvature = 1 + 1 / (kSize * kSize);
  const double cost = -std::log(kImpulse / (1 - kImpulse)) + 0.5 * std::log(1 + kSize * kSize);
  const Slopes slopes(problem, noise, rest);
  const Eigen::ArrayXd none = slopes.at_none();
  Eigen::ArrayXd u = Eigen::ArrayXd::Zero(problem.rows()), here = u, slope = none;
  Impulses out;
  for (int round = 0; round < kImpulseRounds; ++round) {
    const int before = out.count;
    for (const Stretch& s : problem.stretches())
      for (int c = 0; c < 6; ++c) {
        const Eigen::Index begin = static_cast<Eigen::Index>(c) * problem.samples() + s.begin,
                           end = begin + s.size();
        for (Eigen::Index i = begin; i < end; ++i) {
          const double size = std::abs(slope[i]);
          if (here[i] > 0 || 0.5 * size * size / kCurvature <= cost) continue;
          if ((i > begin && size < std::abs(slope[i - 1])) || (i + 1 < end && size < std::abs(slope[i + 1])))
            continue;
          here[i] = 1;
          ++out.count;
        }
      }
    if (out.count == before) break;
    solve(slopes, none, here, u);
    slope = none - slopes.taken(u);
  }
  out.log_prior = -0.5 * u.square().sum() / (kSize * kSize) - out.count * cost;
  out.sizes = slopes.sizes(u);
  out.wrench = slopes.wrench(u);
  return out;
}

}  // namespace omniflight::diagnosis
