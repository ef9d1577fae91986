// The residuals in flight: quiet on a nominal flight, and how soon they speak when something is wrong.
#include <gtest/gtest.h>

#include "omniflight_diagnosis/monitor.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

/// What a monitor said about a recording, asked every 0.1 s; held until `release_s`.
struct Heard {
  std::array<double, 3> warn{-1, -1, -1}, error{-1, -1, -1};  ///< s, first time; -1: never
  std::array<Check, 3> last;
  double largest_sigma = 0, latency = 0;
};

Heard listen(const recording::Recording& r, Monitor& monitor, double release_s = 1.0,
             double rotors_silent_from_s = 1e9, const Eigen::MatrixXd* commands = nullptr) {
  Heard out;
  const auto &acc = r.signals.at("acc"), &gyro = r.signals.at("gyro"), &speed = r.signals.at("rotor_speed");
  for (Eigen::Index i = 0; i < acc.size(); ++i) {
    const double t = acc.t_s[static_cast<std::size_t>(i)];
    monitor.add_imu(t, acc.values.row(i).transpose(), gyro.values.row(i).transpose());
    const auto& q = r.signals.at("attitude").values;
    monitor.add_mocap(t, r.signals.at("position").values.row(i).transpose(),
                      Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)));
    const Eigen::VectorXd x = speed.values.row(i).transpose();
    const std::span<const double> speeds{x.data(), static_cast<std::size_t>(x.size())};
    if (t < rotors_silent_from_s) monitor.add_rotors(t, speeds, r.signals.at("alpha").values(i, 0));
    const Eigen::VectorXd u = commands ? Eigen::VectorXd(commands->row(i)) : x;
    monitor.add_command(t, {u.data(), static_cast<std::size_t>(u.size())});
    if (i % 10 != 0) continue;
    out.last = monitor.assess(t, t >= release_s);
    for (std::size_t k = 0; k < 3; ++k) {
      if (out.last[k].level == Level::warn && out.warn[k] < 0) out.warn[k] = t;
      if (out.last[k].level == Level::error && out.error[k] < 0) out.error[k] = t;
    }
    for (const auto& v : out.last[0].values) {
      if (v.key == "largest [sigma]" && t > release_s + 1)
        out.largest_sigma = std::max(out.largest_sigma, v.value);
      if (v.key == "latency [s]") out.latency = std::max(out.latency, v.value);
    }
  }
  return out;
}

TEST(Monitor, ANominalFlightStaysOkWithinBoundedLatency) {
  const auto vehicle = omnimorph();
  auto monitor = Monitor::create(vehicle);
  ASSERT_TRUE(monitor) << monitor.error().text();
  const Heard h = listen(test::fly(vehicle, {}, {.sway = 0.2}), *monitor);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LT(h.warn[k], 0) << h.last[k].name << ": " << h.last[k].message;
    EXPECT_LT(h.error[k], 0) << h.last[k].name;
    EXPECT_EQ(h.last[k].level, Level::ok);
  }
  EXPECT_LT(h.largest_sigma, 3.0);
  EXPECT_LT(h.latency, monitor->delay_s() + 0.05);
}

// An unmodelled mass must show as m_extra times the specific force, and within a second of the release.
TEST(Monitor, AHiddenLoadIsAnErrorWithinASecond) {
  const auto vehicle = omnimorph();
  const physics::Effect* payload = physics::find_effect("payload_mass");
  ASSERT_NE(payload, nullptr);
  physics::ActiveEffect load{payload, {}};
  for (const auto& p : payload->info().parameters) load.theta.push_back(p.name == "mass" ? 0.28 : p.neutral);
  auto monitor = Monitor::create(vehicle);
  ASSERT_TRUE(monitor);
  const Heard h = listen(test::fly(vehicle, {load}, {}), *monitor, 2.0);
  EXPECT_GT(h.error[0], 2.0);
  EXPECT_LT(h.error[0], 3.0);
  EXPECT_EQ(h.last[0].level, Level::error);
  EXPECT_NEAR(monitor->residual().z(), -0.28 * kGravity, 0.35);
  EXPECT_EQ(h.last[1].level, Level::ok) << "the motors follow";
}

// An accelerometer a hand's breadth off reads what turning does to it; told where it is, that is no wrench.
TEST(Monitor, AnImuOffTheOriginIsNoWrenchWhereItsPlaceIsTold) {
  const auto vehicle = omnimorph();
  const Vec3 place(0.25, -0.1, 0.15);
  recording::Recording r = test::fly(vehicle, {}, {.sway = 0.2});
  const recording::Signal& gyro = r.signals.at("gyro");
  recording::Signal& acc = r.signals.at("acc");
  for (Eigen::Index i = 1; i + 1 < gyro.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vec3 w = gyro.values.row(i).transpose();
    const Vec3 dw =
        (gyro.values.row(i + 1) - gyro.values.row(i - 1)).transpose() / (gyro.t_s[k + 1] - gyro.t_s[k - 1]);
    acc.values.row(i) += (dw.cross(place) + w.cross(w.cross(place))).transpose();
  }
  auto unaware = Monitor::create(vehicle);
  MonitorOptions aware;
  aware.imu_position = place;
  auto told = Monitor::create(vehicle, aware);
  ASSERT_TRUE(unaware && told);
  const Heard without = listen(r, *unaware), with = listen(r, *told);
  EXPECT_LT(with.largest_sigma, 3.0);
  EXPECT_GT(without.largest_sigma, 2 * with.largest_sigma);
  EXPECT_LT(with.warn[0], 0) << with.last[0].message;
}

TEST(Monitor, ARotorThatDoesNotFollowIsNamed) {
  const auto vehicle = omnimorph();
  recording::Recording r = test::fly(vehicle, {}, {});
  const Eigen::MatrixXd commands = r.signals.at("rotor_speed").values;
  auto& speed = r.signals.at("rotor_speed").values;
  for (Eigen::Index i = 1000; i < speed.rows(); ++i) speed(i, 2) = 0;  // from 10 s
  auto monitor = Monitor::create(vehicle);
  ASSERT_TRUE(monitor);
  const Heard h = listen(r, *monitor, 1.0, 1e9, &commands);
  EXPECT_GT(h.error[1], 10.0);
  EXPECT_LT(h.error[1], 11.0);
  EXPECT_NE(h.last[1].message.find("rotor 3"), std::string::npos) << h.last[1].message;
}

TEST(Monitor, SilentTelemetryIsStaleAndNeverOk) {
  const auto vehicle = omnimorph();
  auto monitor = Monitor::create(vehicle);
  ASSERT_TRUE(monitor);
  const Heard h = listen(test::fly(vehicle, {}, {}), *monitor, 1.0, 10.0);
  EXPECT_NEAR(h.warn[2], 10.2, 0.15);
  EXPECT_EQ(h.last[0].level, Level::stale);
  EXPECT_EQ(h.last[1].level, Level::stale);
  EXPECT_EQ(h.last[2].level, Level::error) << h.last[2].message;
}

TEST(Monitor, RefusesWhatIsOutOfRangeAndIgnoresWhatIsNoNumber) {
  const auto vehicle = omnimorph();
  MonitorOptions fast;
  fast.cutoff_hz = 500;
  const auto refused = Monitor::create(vehicle, fast);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("cutoff_hz"), std::string::npos);
  auto monitor = Monitor::create(vehicle);
  ASSERT_TRUE(monitor);
  monitor->add_imu(std::nan(""), Vec3::Zero(), Vec3::Zero());
  monitor->add_imu(1.0, Vec3::Constant(std::nan("")), Vec3::Zero());
  const double three[] = {1, 2, 3};
  monitor->add_rotors(1.0, three, 0.0);  // eight are needed
  const auto& checks = monitor->assess(2.0, true);
  EXPECT_EQ(checks[0].level, Level::stale);
  EXPECT_EQ(checks[2].level, Level::error);
}

TEST(CausalLowPass, HoldsAConstantAndDelaysARampByItsGroupDelay) {
  CausalLowPass filter(200, 2, 1);
  Eigen::VectorXd x(1);
  for (int i = 0; i < 400; ++i) {
    x[0] = 3.0;
    filter.step(x);
    ASSERT_NEAR(x[0], 3.0, 1e-9);
  }
  for (int i = 1; i <= 2000; ++i) {
    x[0] = 3.0 + i / 200.0;
    filter.step(x);
  }
  EXPECT_NEAR(x[0], 13.0 - filter.delay_s(), 0.003);
}

}  // namespace
}  // namespace omniflight::diagnosis
