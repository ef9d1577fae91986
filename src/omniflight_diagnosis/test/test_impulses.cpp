// Lone samples that have more than noise: found, and only they.
#include "../src/evidence/impulses.hpp"

#include <cmath>
#include <memory>

#include "../src/evidence/noise_estimate.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

constexpr double kBlow = 6.0, kLasts = 0.03;     // N, s
constexpr double kFirst = 3.025, kEvery = 1.31;  // s

/// A nominal OmniMorph of which every 1.31 s something knocks from below, and its problem and noise.
struct Knocked {
  vehicle::Vehicle vehicle = test::omnimorph();
  Options options;
  Flight flight;
  std::unique_ptr<RegressionProblem> problem;
  std::unique_ptr<NoiseModel> noise;
  std::vector<double> times;

  Knocked(double blow, std::uint64_t seed, Options told = {}) : options(std::move(told)) {
    test::Flown f;
    f.duration_s = 30;
    f.seed = seed;
    recording::Recording r = test::fly(vehicle, {}, f);
    recording::Signal& acc = r.signals.at("acc");
    for (double at = kFirst; at < 29; at += kEvery) times.push_back(at);
    for (std::size_t i = 0; i < acc.t_s.size(); ++i)
      for (const double at : times)
        if (acc.t_s[i] >= at && acc.t_s[i] < at + kLasts)
          acc.values(static_cast<Eigen::Index>(i), 2) += blow / vehicle.mass;
    auto prepared = prepare_flight(r, vehicle, options);
    EXPECT_TRUE(prepared);
    flight = *prepared;
    const Flight* one[] = {&flight};
    problem = std::make_unique<RegressionProblem>(one, vehicle, options, Horizon{0.1});
    noise = estimate_noise(*problem, slow_columns(*problem), Eigen::VectorXd::Zero(problem->rows()), 1,
                           ToldShape::corrected, LoneSamples::sought);
  }

  /// Spectral density of the force along z [N^2 T] at a frequency [Hz].
  double density(double frequency) const {
    return noise->spectrum(0, 2).densities(Eigen::ArrayXd::Constant(1, frequency))[0];
  }
};

TEST(Impulses, AreFoundWhereTheyAreAndLeaveTheSpectrumAsItIsWithoutThem) {
  const Knocked calm(0, 1), knocked(kBlow, 1);
  const Impulses& found = knocked.noise->impulses();
  const int n = knocked.problem->samples();
  ASSERT_GT(found.count, 0);
  int seen = 0;
  for (const double at : knocked.times) {
    double sum = 0;
    for (int i = 0; i < n; ++i)
      if (std::abs(knocked.problem->measured(i).t - (at + 0.5 * kLasts)) < 0.05)
        sum += found.wrench[2 * n + i];
    seen += std::abs(sum * knocked.problem->period() - kBlow * kLasts) < 0.3 * kBlow * kLasts;  // Ns
  }
  EXPECT_GE(seen, static_cast<int>(knocked.times.size()) - 2) << "of " << knocked.times.size();
  EXPECT_NEAR(found.wrench.segment(2 * n, n).norm() / found.wrench.norm(), 1.0, 1e-3) << "in other channels";

  Options gaussian;
  gaussian.without.insert(Assumption::heavy_tails);
  const Knocked as_noise(kBlow, 1, gaussian);
  EXPECT_EQ(as_noise.noise->impulses().count, 0);
  for (const double frequency : {3.0, 8.0, 15.0}) {
    EXPECT_NEAR(std::log(knocked.density(frequency) / calm.density(frequency)), 0, 0.25) << frequency;
    EXPECT_GT(as_noise.density(frequency), 2 * calm.density(frequency)) << frequency;
  }
}

TEST(Impulses, AreNotInGaussianNoise) {
  int found = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) found += Knocked(0, seed).noise->impulses().count;
  EXPECT_LE(found, 3) << "of 43,000 samples of six channels";
}

TEST(Impulses, CostWhatTheirPriorSays) {
  const Knocked s(kBlow, 2);
  const Impulses& found = s.noise->impulses();
  // one in a thousand of a normal size of ten deviations: ln 999 + ln(101)/2 each, and half the square of
  // their sizes
  EXPECT_LT(found.log_prior, -found.count * (std::log(999.0) + 0.5 * std::log(101.0)));
  EXPECT_EQ(s.noise->residual(), s.problem->residual() - found.wrench);
}

}  // namespace
}  // namespace omniflight::diagnosis
