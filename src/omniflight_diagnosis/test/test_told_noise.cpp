// Noise of the wrench residual where the laboratory told its turbulence and its sensors.
#include "../src/evidence/told_noise.hpp"

#include <cmath>

#include "../src/evidence/noise_estimate.hpp"
#include "omniflight_core/random.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

ToldNoise told_of(const test::Flown& f) {
  ToldNoise out;
  out.force = f.force_noise_N;
  out.torque = f.torque_noise_Nm;
  out.correlation_time = f.correlation_s;
  out.accelerometer = f.accelerometer_noise;
  out.gyro = f.gyro_noise;
  return out;
}

struct Setting {
  vehicle::Vehicle vehicle = test::omnimorph();
  Options options;
  Flight flight;
  std::unique_ptr<RegressionProblem> problem;

  Setting(const test::Flown& f, const ToldNoise& noise)
      : Setting(test::fly(test::omnimorph(), {}, f), noise) {}
  Setting(const recording::Recording& flown, const ToldNoise& noise) {
    options.noise = noise;
    auto prepared = prepare_flight(flown, vehicle, options);
    EXPECT_TRUE(prepared);
    flight = *prepared;
    const Flight* one[] = {&flight};
    problem = std::make_unique<RegressionProblem>(one, vehicle, options, Horizon{0.15});
  }
  std::unique_ptr<NoiseModel> noise() const {
    return estimate_noise(*problem, slow_columns(*problem), Eigen::VectorXd::Zero(problem->rows()), 1);
  }
};

TEST(ToldNoise, OfTurbulenceIsTheSpectrumOfItsBlockMeans) {
  constexpr double kRms = 0.2, kTime = 0.3, kStep = 1e-3, kPeriod = 0.025;
  constexpr int kBlock = 25, kSize = 4096;
  Random random(3, "turbulence");
  const double keep = std::exp(-kStep / kTime), fresh = kRms * std::sqrt(1 - keep * keep);
  double x = kRms * random.normal();
  Eigen::VectorXd means = Eigen::VectorXd::Zero(kSize);
  for (int i = 0; i < kSize; ++i)
    for (int k = 0; k < kBlock; ++k) {
      means[i] += x / kBlock;
      x = keep * x + fresh * random.normal();
    }
  CosineTransform(kSize).apply(means);
  const ToldSpectrum told(kRms, kTime, kPeriod / std::sqrt(12.0), kPeriod, {});
  const Eigen::ArrayXd f = Eigen::ArrayXd::LinSpaced(kSize, 0, kSize - 1) * (0.5 / (kSize * kPeriod));
  const Eigen::ArrayXd ratio = means.array().square() / told.turbulence(f);
  for (int from = 16; 2 * from <= kSize; from *= 2)  // octaves up to 20 Hz
    EXPECT_NEAR(ratio.segment(from, from).mean(), 1, 4 * std::sqrt(2.0 / from) + 0.1) << f[from] << " Hz";
}

TEST(ToldNoise, OfSensorsReachesTheResidualAsItDidInFlight) {
  test::Flown f;
  f.force_noise_N = f.torque_noise_Nm = 1e-9;
  f.speed_noise = 0;
  f.damped = false;
  const Setting s(f, told_of(f));
  ASSERT_TRUE(s.problem->noise_told());
  EXPECT_EQ(s.problem->temperature(), s.options.told_temperature);
  const int n = s.problem->samples();
  for (int c = 0; c < 6; ++c) {
    const auto flown = s.problem->residual().segment(c * n, n),
               drawn = s.problem->sensor_noise().segment(c * n, n);
    const auto spread = [](const auto& x) { return std::sqrt((x.array() - x.mean()).square().mean()); };
    EXPECT_NEAR(spread(drawn) / spread(flown), 1, 0.15) << c;
  }
}

TEST(ToldNoise, IsNotTakenFromHalfOfWhatItNeeds) {
  test::Flown f;
  f.duration_s = 10;
  ToldNoise noise = told_of(f);
  noise.gyro = 0;
  EXPECT_FALSE(Setting(f, noise).problem->noise_told());
  noise = told_of(f);
  noise.correlation_time = 0;
  EXPECT_EQ(Setting(f, noise).problem->temperature(), Options{}.temperature);
}

TEST(ToldNoise, NumbersThatNoFlightHasChangeNothing) {
  test::Flown f;
  f.duration_s = 10;
  ToldNoise noise = told_of(f);
  noise.force = noise.torque = 1e-200;
  noise.accelerometer = noise.gyro = 1e-200;
  const Setting told(f, noise), free(f, {});
  const auto absurd = told.noise(), usual = free.noise();
  ASSERT_TRUE(told.problem->noise_told());
  EXPECT_EQ(absurd->log_prior(), 0);
  EXPECT_NEAR(absurd->log_scale(), usual->log_scale(), 1e-6 * std::abs(usual->log_scale()));
}

TEST(ToldNoise, OneChannelApartIsLessLikelyThanAllTogether) {
  const auto told = std::make_shared<const ToldSpectrum>(0.2, 0.3, 0.007, 0.025, NoiseSpectrum());
  const std::array<std::shared_ptr<const ToldSpectrum>, 3> all{told, told, told};
  PowerBands bands;
  bands.frequency = Eigen::VectorXd::LinSpaced(100, 0.1, 20);
  bands.freedom = Eigen::VectorXd::Constant(100, 20);
  bands.power = 20 * told->turbulence(bands.frequency.array());
  PowerBands louder = bands;
  louder.power *= 2;
  const auto log_prior = [&](const std::array<PowerBands, 3>& power, std::array<NoiseSpectrum, 3>& out) {
    return NoiseSpectrum::fit_told(std::span(all), std::span(power), ToldShape::corrected, 1, std::span(out));
  };
  std::array<NoiseSpectrum, 3> out;
  EXPECT_NEAR(log_prior({bands, bands, bands}, out), 0, 0.01);
  const double together = log_prior({louder, louder, louder}, out),
               apart = log_prior({bands, louder, bands}, out);
  EXPECT_GT(together, -1.5);
  EXPECT_LT(apart, together - 3);
  const Eigen::ArrayXd at = Eigen::ArrayXd::Constant(1, 3.0);
  EXPECT_NEAR(out[1].densities(at)[0] / told->turbulence(at)[0], 2, 0.2);  // data outweigh what is told
  EXPECT_NEAR(out[0].densities(at)[0] / told->turbulence(at)[0], 1, 0.1);
}

TEST(ToldNoise, FluctuationsOfOneChannelAreNoTurbulence) {
  test::Flown f;
  f.damped = false;
  const double nominal = Setting(f, told_of(f)).noise()->log_prior();
  EXPECT_GT(nominal, -6);
  vehicle::Vehicle v = test::omnimorph();
  recording::Recording r = test::fly(v, {}, f);
  recording::Signal& acc = r.signals["acc"];
  Random random(5, "hidden");
  double x = 0;
  for (Eigen::Index i = 0; i < acc.size(); ++i) {
    x = 0.97 * x + 0.25 * 2 * f.force_noise_N / v.mass * random.normal();  // twice the turbulence
    acc.values(i, 2) += x;
  }
  EXPECT_LT(Setting(r, told_of(f)).noise()->log_prior(), nominal - 6);
}

}  // namespace
}  // namespace omniflight::diagnosis
