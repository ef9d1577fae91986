// Injection: what is added to the rotor speeds of a flight is the wrench that was asked for, and nothing else
// changes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "family_laboratory.hpp"
#include "injection.hpp"
#include "omniflight_recording/formats.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;

struct Flown {
  recording::Recording recording;
  vehicle::Vehicle vehicle;
};
Flown quadrotor() {
  Coordinates where{.vehicle = "quadrotor_37g",
                    .controller = "geometric",
                    .told_gains = "told",
                    .start = "rest",
                    .manoeuvre = "eight",
                    .signals = "imu+speed",
                    .turbulence = "ou",
                    .noise = "white",
                    .calibration = "exact",
                    .length = 14,
                    .speed_hz = 250,
                    .tilt = "none"};
  BoxRandom random(Random(21), Box::tuning);
  auto vehicle = draw_vehicle(where, random);
  EXPECT_TRUE(vehicle);
  Laboratory lab = draw_laboratory(where, *vehicle, "", 1, random);
  auto flown = fly(lab.flight);
  EXPECT_TRUE(flown) << flown.error().text();
  return {flown->recording, vehicle->nominal};
}
const Injectable& find(const std::string& id) {
  for (const Injectable& i : injectables())
    if (i.id == id) return i;
  ADD_FAILURE() << id;
  return injectables()[0];
}
/// Mean of force along z and torques that two recordings' rotor speeds differ by, over the middle of the
/// flight.
Eigen::Vector4d difference(const RealFlight& before, const RealFlight& after) {
  const Eigen::MatrixXd B = before.vehicle().allocation_matrix(0).bottomRows(4);
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  int n = 0;
  for (std::size_t i = before.size() / 4; i < 3 * before.size() / 4; ++i, ++n)
    sum += B * (after.thrust(i) - before.thrust(i));
  return sum / n;
}

TEST(Injection, RotorsCarryTheLoadThatIsHidden) {
  const Flown flown = quadrotor();
  auto flight = RealFlight::create(flown.recording, flown.vehicle);
  ASSERT_TRUE(flight) << flight.error().text();
  const double weight = flown.vehicle.mass * kGravity;
  const Injected load = inject(*flight, find("payload_mass"), 0.1, Shape{});
  auto loaded = RealFlight::create(load.recording, flown.vehicle);
  ASSERT_TRUE(loaded) << loaded.error().text();
  const Eigen::Vector4d w = difference(*flight, *loaded);
  EXPECT_NEAR(w[0], 0.1 * weight, 0.01 * weight);
  EXPECT_LT(w.tail<3>().norm(), 1e-3 * weight * 0.046);
  EXPECT_NEAR(load.rms[2], 0.1 * weight, 0.02 * weight);
  EXPECT_EQ(load.channel, "Fz");
  EXPECT_GT(load.sigma, 1);
  EXPECT_EQ(load.limited, 0);
  for (const char* same : {"acc", "gyro", "position", "attitude"})
    EXPECT_EQ(load.recording.find(same)->values, flown.recording.find(same)->values) << same;
  EXPECT_FALSE(load.recording.find("thrust_command")) << "what was computed on board would give it away";
  // commands lead, and carry the load as well
  const auto *before = flown.recording.find("rotor_command"), *after = load.recording.find("rotor_command");
  const Eigen::Index half = before->size() / 2;
  EXPECT_NEAR(after->values(half, 0) / before->values(half, 0), std::sqrt(1.1), 0.03);
}

TEST(Injection, OneWeakRotorTurnsFasterByTheRootOfWhatItLacks) {
  const Flown flown = quadrotor();
  auto flight = RealFlight::create(flown.recording, flown.vehicle);
  ASSERT_TRUE(flight) << flight.error().text();
  Shape first{};  // u = 0: the first rotor
  const Injected weak = inject(*flight, find("rotor_thrust_scale"), 0.1, first);
  const auto& a = flown.recording.find("rotor_speed")->values;
  const auto& b = weak.recording.find("rotor_speed")->values;
  const Eigen::Index from = a.rows() / 4, count = a.rows() / 2;
  const double ratio = b.col(0).segment(from, count).sum() / a.col(0).segment(from, count).sum();
  EXPECT_NEAR(ratio, std::sqrt(1 / 0.9), 0.005);
  for (int k = 1; k < 4; ++k)
    EXPECT_NEAR(b.col(k).segment(from, count).sum() / a.col(k).segment(from, count).sum(), 1, 1e-3);
}

TEST(Injection, MoreThanARotorCanIsSaid) {
  const Flown flown = quadrotor();
  auto flight = RealFlight::create(flown.recording, flown.vehicle);
  ASSERT_TRUE(flight) << flight.error().text();
  EXPECT_GT(inject(*flight, find("payload_mass"), 4, Shape{}).limited, 0.5);
}

TEST(Injection, RefusesFlightsWithoutRotorSpeeds) {
  Flown flown = quadrotor();
  flown.recording.file = "flight 7";
  flown.recording.signals.erase("rotor_speed");
  auto flight = RealFlight::create(flown.recording, flown.vehicle);
  ASSERT_FALSE(flight);
  EXPECT_NE(flight.error().text().find("rotor_speed"), std::string::npos) << flight.error().text();
}

TEST(Injection, RealFlightsTakeEveryInjection) {
  const char* data = std::getenv("OMNIFLIGHT_REAL_DATA");
  if (!data || !fs::exists(fs::path(data) / "flights" / "crazyflie_brushless"))
    GTEST_SKIP() << "no real flights: set OMNIFLIGHT_REAL_DATA to a folder with flights/crazyflie_brushless";
  auto vehicle = vehicle::load_vehicle(std::string(OMNIFLIGHT_SOURCE_ROOT) +
                                       "/configs/vehicles/crazyflie_brushless/crazyflie_brushless.yaml");
  ASSERT_TRUE(vehicle) << vehicle.error().text();
  for (const auto& file : fs::directory_iterator(fs::path(data) / "flights" / "crazyflie_brushless")) {
    auto recording = recording::load(file.path());
    auto flight =
        recording ? RealFlight::create(*recording, *vehicle) : Result<RealFlight>(Failure(recording.error()));
    if (!flight) continue;
    for (const Injectable& i : injectables()) {
      const Injected one = inject(*flight, i, 0.2 * i.typical, Shape{});
      EXPECT_GT(one.sigma, 0) << i.realisation;
      EXPECT_LT(one.limited, 0.1) << i.realisation;
    }
    return;
  }
  FAIL() << "no flight there could be used";
}

}  // namespace
}  // namespace omniflight::proof
