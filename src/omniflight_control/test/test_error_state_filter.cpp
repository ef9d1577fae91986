// The error-state filter: consistent with what it believes of its errors, right about late poses, quiet about
// outliers, alive after everything.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>

#include "counted_malloc.hpp"
#include "omniflight_control/error_state_filter.hpp"
#include "omniflight_control/estimator.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::control {
namespace {

constexpr double kStep = 0.001;  // s, of the IMU

/// A body on a smooth path with known derivatives.
struct Truth {
  Vec3 p, v, a, w;
  Quat q;
};
Truth truth(double t) {
  Truth s;
  s.p = Vec3(0.6 * std::sin(0.9 * t), 0.4 * std::sin(1.3 * t + 1), 1 + 0.3 * std::sin(0.7 * t));
  s.v = Vec3(0.54 * std::cos(0.9 * t), 0.52 * std::cos(1.3 * t + 1), 0.21 * std::cos(0.7 * t));
  s.a = Vec3(-0.486 * std::sin(0.9 * t), -0.676 * std::sin(1.3 * t + 1), -0.147 * std::sin(0.7 * t));
  // yaw(t) about z, then roll(t) about x: rates in the body
  const double yaw = 0.5 * std::sin(1.1 * t), dyaw = 0.55 * std::cos(1.1 * t);
  const double roll = 0.4 * std::sin(0.8 * t), droll = 0.32 * std::cos(0.8 * t);
  const Quat about_x = exp_rotation(Vec3(roll, 0, 0));
  s.q = exp_rotation(Vec3(0, 0, yaw)) * about_x;
  s.w = about_x.conjugate() * Vec3(0, 0, dyaw) + Vec3(droll, 0, 0);
  return s;
}

/// Sensors whose noise is the one that the filter is told.
struct Sensors {
  ErrorStateConfig config;
  Vec3 ba{0.05, -0.04, 0.08}, bg{0.01, -0.008, 0.012};
  double latency = 0.012, period = 0.008;
  Random rng;
  struct Pose {
    double t;
    Vec3 p;
    Quat q;
  };
  std::deque<Pose> on_the_way;
  int k = 0;

  explicit Sensors(std::uint64_t seed) : rng(seed) {}
  Vec3 noise(double deviation) { return deviation * Vec3(rng.normal(), rng.normal(), rng.normal()); }
  double t() const { return kStep * k; }

  /// One step of the IMU; poses that are due go to every estimator unless `lost`.
  void step(std::initializer_list<StateEstimator*> estimators, bool lost = false,
            const Vec3& pose_error = Vec3::Zero()) {
    ++k;
    const Truth s = truth(t());
    const double per_sample = 1.0 / std::sqrt(kStep);
    const Vec3 f =
        s.q.conjugate() * (s.a + Vec3(0, 0, kGravity)) + ba + noise(config.accelerometer_noise * per_sample);
    const Vec3 w = s.w + bg + noise(config.gyro_noise * per_sample);
    ba += noise(config.accelerometer_walk * std::sqrt(kStep));
    bg += noise(config.gyro_walk * std::sqrt(kStep));
    for (StateEstimator* e : estimators) e->add_imu(t(), f, w);
    if (k % static_cast<int>(std::lround(period / kStep)) == 0)
      on_the_way.push_back(
          {t(), s.p + noise(config.position_noise), s.q * exp_rotation(noise(config.attitude_noise))});
    while (!on_the_way.empty() && on_the_way.front().t <= t() - latency) {
      const Pose pose = on_the_way.front();
      on_the_way.pop_front();
      if (lost) continue;
      for (StateEstimator* e : estimators) e->add_mocap(pose.t, pose.p + pose_error, pose.q);
    }
  }
};

Eigen::Matrix<double, 15, 1> error(const ErrorStateFilter& filter, const Sensors& s) {
  const Truth truth_now = truth(s.t());
  const RigidState& x = filter.state();
  Eigen::Matrix<double, 15, 1> e;
  e << truth_now.p - x.p_WB, truth_now.v - x.v_WB_W, log_rotation(x.q_WB.conjugate() * truth_now.q),
      s.ba - filter.accelerometer_bias(), s.bg - filter.gyro_bias();
  return e;
}

TEST(ErrorStateFilter, IsConsistentInNeesAndNis) {
  // NEES of N independent runs: N * mean is chi^2 with 15 N degrees; NIS likewise with 6 a pose
  constexpr int kRuns = 60;
  double nees = 0, nis = 0;
  int poses = 0;
  for (int run = 0; run < kRuns; ++run) {
    Sensors s(100 + static_cast<std::uint64_t>(run));
    ErrorStateFilter filter(s.config);
    double heard = -1;
    for (int k = 0; k < 6000; ++k) {
      s.step({&filter});
      if (k < 2000 || filter.last_mocap() <= heard) continue;
      heard = filter.last_mocap();
      nis += filter.innovation();
      ++poses;
    }
    const auto e = error(filter, s);
    nees += e.dot(filter.covariance().ldlt().solve(e));
    EXPECT_LT(filter.outliers(), 3u);
  }
  nees /= kRuns;
  nis /= poses;
  // 99.9 % bounds: mean +- 3.29 sqrt(2 n / N)
  const double nees_band = 3.29 * std::sqrt(2.0 * 15 / kRuns), nis_band = 3.29 * std::sqrt(2.0 * 6 / poses);
  std::printf("NEES %.2f of 15 (+- %.2f), NIS %.3f of 6 (+- %.3f) over %d poses\n", nees, nees_band, nis,
              nis_band, poses);
  EXPECT_NEAR(nees, 15.0, nees_band);
  EXPECT_NEAR(nis, 6.0, nis_band);
}

TEST(ErrorStateFilter, ALatePoseIsWorthAPromptOne) {
  Sensors late(5), prompt(5);
  late.latency = 0.0405;
  prompt.latency = 0.0;
  ErrorStateFilter a(late.config), b(prompt.config);
  for (int k = 0; k < 4040; ++k) late.step({&a});
  for (int k = 0; k < 4000; ++k) prompt.step({&b});
  // the same poses have been heard; the prompt filter has only to be carried on with the same samples
  Sensors rest(5);
  ErrorStateFilter c(rest.config);
  rest.latency = 0.0;
  for (int k = 0; k < 4040; ++k) rest.step({&c}, k >= 3999);
  EXPECT_LT((a.state().p_WB - c.state().p_WB).norm(), 1e-9);
  EXPECT_LT((a.state().v_WB_W - c.state().v_WB_W).norm(), 1e-9);
  EXPECT_LT(a.state().q_WB.angularDistance(c.state().q_WB), 1e-7);
  EXPECT_GT((a.state().p_WB - b.state().p_WB).norm(), 1e-4) << "40 ms of motion lie between";
}

TEST(ErrorStateFilter, FindsBothBiasesAndBeatsTheObserverInNoise) {
  Sensors s(9);
  s.config.position_noise = 0.001;
  s.config.attitude_noise = 0.003;
  ErrorStateFilter filter(s.config);
  Estimator observer({});
  double filter_v = 0, observer_v = 0, filter_R = 0, observer_R = 0;
  int n = 0;
  for (int k = 0; k < 20000; ++k) {
    s.step({&filter, &observer});
    if (k < 5000) continue;
    const Truth x = truth(s.t());
    filter_v += (filter.state().v_WB_W - x.v).squaredNorm();
    observer_v += (observer.state().v_WB_W - x.v).squaredNorm();
    filter_R += std::pow(filter.state().q_WB.angularDistance(x.q), 2);
    observer_R += std::pow(observer.state().q_WB.angularDistance(x.q), 2);
    ++n;
  }
  std::printf("velocity %.2f mm/s (observer %.2f), attitude %.2f mrad (observer %.2f)\n",
              1e3 * std::sqrt(filter_v / n), 1e3 * std::sqrt(observer_v / n), 1e3 * std::sqrt(filter_R / n),
              1e3 * std::sqrt(observer_R / n));
  EXPECT_LT((filter.accelerometer_bias() - s.ba).norm(), 0.03);
  EXPECT_LT((filter.gyro_bias() - s.bg).norm(), 0.003);
  EXPECT_LT(filter_v, observer_v);
  EXPECT_LT(filter_R, observer_R);
}

TEST(ErrorStateFilter, HalfASecondWithoutPosesIsFlownThrough) {
  Sensors s(11);
  ErrorStateFilter filter(s.config);
  Estimator observer({});
  for (int k = 0; k < 10000; ++k) s.step({&filter, &observer});
  for (int k = 0; k < 500; ++k) s.step({&filter, &observer}, true);
  const double lost = (filter.state().p_WB - truth(s.t()).p).norm();
  const double lost_observer = (observer.state().p_WB - truth(s.t()).p).norm();
  std::printf("0.5 s on the IMU alone: %.1f mm off (observer %.1f)\n", 1e3 * lost, 1e3 * lost_observer);
  EXPECT_LT(lost, 0.02);
  EXPECT_LT(lost, lost_observer) << "the observer knows no bias of the accelerometer";
  for (int k = 0; k < 200; ++k) s.step({&filter, &observer});
  EXPECT_LT((filter.state().p_WB - truth(s.t()).p).norm(), 0.003);
  EXPECT_LT(filter.outliers(), 2u);
}

TEST(ErrorStateFilter, OutliersThatAMonitorOfJumpsWouldPassMoveNothing) {
  Sensors s(13), clean(13);
  ErrorStateFilter filter(s.config), undisturbed(s.config);
  for (int k = 0; k < 5000; ++k) {
    s.step({&filter});
    clean.step({&undisturbed});
  }
  for (int k = 0; k < 160; ++k) {
    s.step({&filter}, false, Vec3(0.05, 0, 0));  // 100 deviations
    clean.step({&undisturbed}, true);
  }
  EXPECT_EQ(filter.outliers(), 20u);
  EXPECT_LT((filter.state().p_WB - undisturbed.state().p_WB).norm(), 1e-9) << "as if nothing had been heard";
  EXPECT_LT(filter.last_mocap(), s.t() - 0.15) << "they count as no pose";
}

TEST(ErrorStateFilter, PosesThatStayElsewhereAreBelievedInTheEnd) {
  Sensors s(17);
  ErrorStateFilter filter(s.config);
  for (int k = 0; k < 3000; ++k) s.step({&filter});
  for (int k = 0; k < 1000; ++k) s.step({&filter}, false, Vec3(0.2, 0, 0));
  EXPECT_LT((filter.state().p_WB - truth(s.t()).p - Vec3(0.2, 0, 0)).norm(), 0.005);
}

TEST(ErrorStateFilter, GapsOfTheImuAreOpenedNotGuessed) {
  Sensors s(19);
  ErrorStateFilter filter(s.config);
  for (int k = 0; k < 3000; ++k) s.step({&filter});
  s.k += 400;  // nothing is heard for 0.4 s
  for (int k = 0; k < 300; ++k) s.step({&filter});
  EXPECT_LT((filter.state().p_WB - truth(s.t()).p).norm(), 0.01);
}

TEST(ErrorStateFilter, WithoutPosesForMinutesItStaysBounded) {
  Sensors s(23);
  ErrorStateFilter filter(s.config);
  for (int k = 0; k < 3000; ++k) s.step({&filter});
  for (int k = 0; k < 5000; ++k) s.step({&filter}, true);  // five times what it keeps of samples
  EXPECT_TRUE(is_finite(filter.state()));
  EXPECT_GT(filter.covariance()(0, 0), 1e-4) << "it knows that it knows less";
}

TEST(ErrorStateFilter, NonsenseIsIgnoredAndHostileSequencesStayFinite) {
  ErrorStateFilter filter({});
  filter.add_mocap(0.0, Vec3(1, 2, 3), Quat::Identity());
  filter.add_imu(0.001, Vec3(std::nan(""), 0, 0), Vec3::Zero());
  filter.add_mocap(0.002, Vec3(0, 0, INFINITY), Quat::Identity());
  filter.add_mocap(0.003, Vec3::Zero(), Quat(0, 0, 0, 0));
  EXPECT_EQ(filter.refused(), 3u);
  EXPECT_EQ(filter.state().p_WB, Vec3(1, 2, 3));
  Random rng(29);
  double t = 0;
  for (int k = 0; k < 100000; ++k) {
    t += rng.uniform() < 0.001 ? rng.uniform(0, 100) : rng.uniform(0, 0.002);
    const auto any = [&](double size) -> Vec3 {
      return size * Vec3(rng.normal(), rng.normal(), rng.normal());
    };
    if (rng.uniform() < 0.8)
      filter.add_imu(t - rng.uniform(0, 0.001), any(rng.uniform() < 0.01 ? 1e4 : 10),
                     any(rng.uniform() < 0.01 ? 1e3 : 1));
    else
      filter.add_mocap(t - rng.uniform(0, 0.05), any(1), exp_rotation(any(1)));
    ASSERT_TRUE(is_finite(filter.state())) << k;
  }
}

TEST(ErrorStateFilter, APoseOlderThanTheSamplesThatAreKeptIsRefused) {
  ErrorStateFilter filter({});
  filter.add_mocap(0.0, Vec3(1, 2, 3), Quat::Identity());
  double t = 0;
  for (int k = 0; k < 1500; ++k) filter.add_imu(t += kStep, Vec3(0, 0, kGravity), Vec3::Zero());
  filter.add_mocap(0.1, Vec3(5, 5, 5), Quat::Identity());  // 1.4 s ago; a second is kept
  EXPECT_EQ(filter.refused(), 1u);
  EXPECT_LT((filter.state().p_WB - Vec3(1, 2, 3)).norm(), 1e-6);
  filter.add_mocap(t, Vec3(1, 2, 3), Quat::Identity());
  EXPECT_EQ(filter.refused(), 1u);
}

TEST(ErrorStateFilter, ImuSamplesBeforeTheFirstPoseMoveNothing) {
  ErrorStateFilter filter({});
  filter.add_mocap(1.0, Vec3(1, 2, 3), Quat::Identity());
  for (int k = 1; k < 100; ++k) filter.add_imu(1.0 - 0.1 + kStep * k, Vec3(9, 9, 9), Vec3(1, 1, 1));
  EXPECT_EQ(filter.state().p_WB, Vec3(1, 2, 3));
  EXPECT_EQ(filter.state().v_WB_W, Vec3::Zero());
  EXPECT_EQ(filter.refused(), 0u);
  filter.add_mocap(-2e9, Vec3::Zero(), Quat::Identity());  // of no clock of a flight
  EXPECT_EQ(filter.refused(), 1u);
}

TEST(ErrorStateFilter, AllocatesNothingAfterConstruction) {
  if (!counted::works) GTEST_SKIP() << "a sanitizer owns malloc";
  Sensors s(31);
  ErrorStateFilter filter(s.config);
  const Truth x = truth(0);
  const long before = counted::allocations;
  for (int k = 1; k < 3000; ++k) {
    filter.add_imu(kStep * k, Vec3(0, 0, kGravity), Vec3::Zero());
    if (k % 8 == 0) filter.add_mocap(kStep * k - 0.0121, x.p, x.q);
  }
  EXPECT_EQ(counted::allocations, before);
}

}  // namespace
}  // namespace omniflight::control
