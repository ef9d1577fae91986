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
/// before. Turbulence is slower than that about yaw: the last to be asked is the reference alone.
constexpr std::array<double, 3> kHorizons{0.075, 0.15, 0.3};

/// The shortest [s] where the rates are not recorded: a controller feeds them back, so that the rotors answer
/// to disturbances which the motion before does not tell.
constexpr double kLeastWithoutRates = 0.15;

/// Calibration beside which horizons are compared. What follows the rotors is not among it, since feedback
/// would hide there.
constexpr std::array<std::string_view, 8> kOfBody{
    "torque_trim",         "world_force",        "acceleration_bias", "inertia",
    "accelerometer_scale", "accelerometer_turn", "center_of_mass",    "imu_position"};
/// Its standard deviations, over those that are assumed or told, beside what is always asked: a body whose
/// numbers are wrong is no reason to predict further ahead. Beside laws it is one, as where they were found:
/// a wrong inertia, mass or force is a law, too.
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
std::vector<Estimator> estimators(const RegressionProblem& p, const NoiseModel& noise, const Regressors& x,
                                  double width) {
  const Eigen::Index asked = x.predicted.cols();
  const Calibration& calibration = p.calibration();
  std::vector<Eigen::Index> of_body;
  for (std::size_t k = 0; k < calibration.kinds.size(); ++k)
    if (std::find(kOfBody.begin(), kOfBody.end(), calibration.kinds[k]) != kOfBody.end())
      of_body.push_back(static_cast<Eigen::Index>(k));
  const auto beside = static_cast<Eigen::Index>(of_body.size());
  Eigen::MatrixXd A(noise.whitened_rows(), beside + asked);
  A << width * noise.apply(calibration.columns(Eigen::all, of_body)), noise.apply(x.predicted);
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
    if (is_weak(own, coefficients(at, k), left.col(k))) continue;
    out[static_cast<std::size_t>(k)] = own / own.dot(z.col(k));
  }
  return out;
}

/// What a horizon comes to.
double in_samples(double horizon_s, const Options& o) { return std::ceil(horizon_s * o.grid_hz - 1e-9); }

}  // namespace

Horizons::Horizons(std::span<const Flight* const> flights, const vehicle::Vehicle& vehicle, const Options& o)
    : law_error_(o.assumes(Assumption::resolution) ? o.law_error : 0.0) {
  const bool rates = std::all_of(flights.begin(), flights.end(), [](const Flight* f) { return f->has_gyro; });
  horizons_.push_back({std::max(least_horizon(flights), rates ? 0.0 : kLeastWithoutRates)});
  for (const double h : kHorizons)
    if (in_samples(h, o) > in_samples(horizons_.back().s, o)) horizons_.push_back({h});
  if (std::all_of(flights.begin(), flights.end(), [](const Flight* f) { return f->reference.cols() > 0; }))
    horizons_.push_back({horizons_.back().s, true});
  for (const Horizon& h : horizons_)
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
  out.horizon = horizons_[k];
  out.beside_found = !known.isZero(0);
  if (k + 1 == count()) return out;  // the longest has nothing to disagree with
  const RegressionProblem& first = *problems_.front();
  // sensors may be noisier than they are told to be; a spectrum that is estimated has the size of what is
  // left
  const auto noise = estimate_noise(first, slow_, known, first.noise_told() ? first.temperature() : 1.0);
  const Eigen::VectorXd z = noise->apply(first.residual() - known);
  // of each amplitude of z: noise, and what laws that are wrong leave
  const Eigen::VectorXd variance =
      1 + law_error_ * law_error_ * noise->apply(first.wrench_of(laws, States::measured)).array().square();
  const auto compare = [&](const auto& regressors, double width, const auto& name, HorizonTest& test) {
    const auto own = estimators(*problems_[k], *noise, regressors(*problems_[k]), width);
    for (std::size_t longer = k + 1; longer < count(); ++longer) {
      const auto there = estimators(*problems_[longer], *noise, regressors(*problems_[longer]), width);
      for (std::size_t asked = 0; asked < own.size(); ++asked) {
        if (own[asked].size() == 0 || there[asked].size() == 0) continue;
        const Eigen::VectorXd difference = own[asked] - there[asked];
        ++test.compared;
        const double statistic = std::pow(difference.dot(z), 2) / difference.cwiseAbs2().dot(variance);
        if (statistic > test.statistic) {
          test.statistic = statistic;
          test.about = name(asked);
        }
      }
    }
  };
  compare(
      always_asked, kWide, [](std::size_t asked) { return std::string(kAsked[asked]); }, out);
  if (laws.empty()) return out;
  HorizonTest found;
  compare([&](const RegressionProblem& p) { return of_laws(p, laws); }, 1,
          [&](std::size_t asked) { return laws[asked].effect->info().id; }, found);
  out.compared += found.compared;
  out.of_laws = found.statistic;
  if (found.statistic > out.statistic) {
    out.statistic = found.statistic;
    out.about = found.about;
  }
  return out;
}

}  // namespace omniflight::diagnosis
