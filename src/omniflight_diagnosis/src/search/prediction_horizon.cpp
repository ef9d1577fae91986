#include "prediction_horizon.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "../evidence/first_stage.hpp"
#include "../evidence/inner_products.hpp"
#include "../regression/predetermined.hpp"

namespace omniflight::diagnosis {
namespace {

/// Horizons [s] that are asked besides the shortest that the sensors' kernels allow; controllers of
/// multirotors answer within about 0.1 s, so that little of a disturbance is left in what was predicted 0.3 s
/// before.
constexpr std::array<double, 3> kHorizons{0.075, 0.15, 0.3};

/// Calibration beside which horizons are compared, and its standard deviations over those that are assumed or
/// told: a body whose numbers are wrong is no reason to predict further ahead. What follows the rotors is not
/// among it, since feedback would hide there.
constexpr std::array<std::string_view, 8> kOfBody{
    "torque_trim",         "world_force",        "acceleration_bias", "inertia",
    "accelerometer_scale", "accelerometer_turn", "center_of_mass",    "imu_position"};
constexpr double kWide = 10;
constexpr double kUnbound = 1e4;  ///< norm of a whitened column that a prior of one does not move

constexpr std::array<const char*, 12> kAsked{"Fx of rotors", "Fy of rotors", "Fz of rotors", "Mx of rotors",
                                             "My of rotors", "Mz of rotors", "drag along x", "drag along y",
                                             "drag along z", "drag about x", "drag about y", "drag about z"};

/// The vector whose product with the whitened residual is the estimate of a coefficient; empty: not excited,
/// or not predictable.
using Estimator = Eigen::VectorXd;

/// Regressors as predicted and as measured; rows of the problem x regressors.
struct Regressors {
  Eigen::MatrixXd predicted, measured;
};

/// Those of kAsked.
Regressors always_asked(const RegressionProblem& p) {
  const int n = p.samples();
  Regressors out;
  out.predicted = out.measured = Eigen::MatrixXd::Zero(p.rows(), static_cast<Eigen::Index>(kAsked.size()));
  for (int i = 0; i < n; ++i)
    for (const auto& [x, columns] :
         {std::pair{&p.situation(i), &out.predicted}, {&p.measured(i), &out.measured}}) {
      const Vec6 rotors = physics::rotor_wrench(*x);
      for (int c = 0; c < (p.forces_only() ? 3 : 6); ++c) {
        (*columns)(c * n + i, c) = rotors[c];
        (*columns)(c * n + i, 6 + c) = c < 3 ? x->v_WB_B[c] : x->body.w_WB_B[c - 3];
      }
    }
  return out;
}

/// The wrench of each law as it was found.
Regressors of_laws(const RegressionProblem& p, std::span<const EffectTerm> laws) {
  Regressors out;
  out.predicted.resize(p.rows(), static_cast<Eigen::Index>(laws.size()));
  out.measured = out.predicted;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    out.predicted.col(at) = p.wrench_of(laws.subspan(k, 1), States::predicted);
    out.measured.col(at) = p.wrench_of(laws.subspan(k, 1), States::measured);
  }
  return out;
}

/// Each beside the others and beside the body's calibration: what its numbers have wrong correlates with a
/// regressor differently at every horizon, and would look like feedback.
std::vector<Estimator> estimators(const RegressionProblem& p, const NoiseModel& noise, const Regressors& x) {
  const Eigen::Index asked = x.predicted.cols();
  const Calibration& calibration = p.calibration();
  std::vector<Eigen::Index> of_body;
  for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
    if (std::find(kOfBody.begin(), kOfBody.end(), calibration.kinds[k]) != kOfBody.end())
      of_body.push_back(static_cast<Eigen::Index>(k));
  const auto beside = static_cast<Eigen::Index>(of_body.size());
  Eigen::MatrixXd A(noise.whitened_rows(), beside + asked);
  A << kWide * noise.apply(calibration.columns(Eigen::all, of_body)), noise.apply(x.predicted);
  const Eigen::MatrixXd z = noise.apply(x.measured);
  // without a prior for what is asked
  Eigen::VectorXd norm = A.rightCols(asked).colwise().norm().cwiseMax(1e-300);
  A.rightCols(asked) *= (kUnbound / norm.array()).matrix().asDiagonal();
  Eigen::MatrixXd precision = inner_products(A);
  precision.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(A.cols(), A.cols()));
  const Eigen::MatrixXd coefficients = factor.solve(A.transpose() * z);
  const Eigen::MatrixXd left = z - A * coefficients;
  std::vector<Estimator> out(static_cast<std::size_t>(asked));
  for (Eigen::Index k = 0; k < asked; ++k) {
    const Eigen::Index at = beside + k;
    if (!(covariance(at, at) < 0.5)) continue;  // not excited, beside the others
    const Eigen::VectorXd own = A * covariance.col(at) / covariance(at, at);
    const double explained = coefficients(at, k) * coefficients(at, k) * own.squaredNorm();
    if (explained * static_cast<double>(own.size()) < kWeakInstrument * left.col(k).squaredNorm()) continue;
    out[static_cast<std::size_t>(k)] = own / own.dot(z.col(k));
  }
  return out;
}

}  // namespace

Horizons::Horizons(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle,
                   const Options& o) {
  horizons_s_.push_back(least_horizon(flights));
  for (const double h : kHorizons)
    if (h > horizons_s_.back() + 0.5 / o.grid_hz) horizons_s_.push_back(h);
  for (const double h : horizons_s_)
    problems_.push_back(std::make_unique<RegressionProblem>(flights, vehicle, o, h));
  slow_ = slow_columns(*problems_.front());
}

std::unique_ptr<RegressionProblem> Horizons::problem(std::size_t k) const {
  return std::make_unique<RegressionProblem>(*problems_[k]);
}

HorizonTest Horizons::test(std::size_t k) const {
  return test(k, Eigen::VectorXd::Zero(problems_[k]->rows()), {});
}

HorizonTest Horizons::test(std::size_t k, const Eigen::VectorXd& known,
                           std::span<const EffectTerm> laws) const {
  HorizonTest out;
  out.horizon_s = horizons_s_[k];
  out.beside_found = !known.isZero(0);
  if (k + 1 == count()) return out;  // the longest has nothing to disagree with
  const RegressionProblem& first = *problems_.front();
  const auto noise = estimate_noise(first, slow_, known, 1.0);
  const Eigen::VectorXd z = noise->apply(first.residual() - known);
  const auto compare = [&](const auto& regressors, const auto& name) {
    const auto own = estimators(*problems_[k], *noise, regressors(*problems_[k]));
    for (std::size_t longer = k + 1; longer < count(); ++longer) {
      const auto there = estimators(*problems_[longer], *noise, regressors(*problems_[longer]));
      for (std::size_t asked = 0; asked < own.size(); ++asked) {
        if (own[asked].size() == 0 || there[asked].size() == 0) continue;
        const Eigen::VectorXd difference = own[asked] - there[asked];
        ++out.compared;
        const double statistic = std::pow(difference.dot(z), 2) / difference.squaredNorm();
        if (statistic > out.statistic) {
          out.statistic = statistic;
          out.about = name(asked);
        }
      }
    }
  };
  compare(always_asked, [](std::size_t asked) { return std::string(kAsked[asked]); });
  if (!laws.empty())
    compare([&](const RegressionProblem& p) { return of_laws(p, laws); },
            [&](std::size_t asked) { return laws[asked].effect->info().id; });
  return out;
}

}  // namespace omniflight::diagnosis
