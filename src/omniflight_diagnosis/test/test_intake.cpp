// What is known before anything is fitted: clocks, excitation, what is told, and stopping early.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_diagnosis/flight.hpp"
#include "omniflight_diagnosis/prior_knowledge.hpp"
#include "synthetic.hpp"

namespace omniflight::diagnosis {
namespace {

using test::omnimorph;

/// A body that turns briskly about all axes for a minute: gyro with noise, attitude from the same rates.
recording::Recording turning() {
  recording::Recording r;
  recording::Signal &w = r.signals["gyro"], &q = r.signals["attitude"];
  w.name = "gyro";
  q.name = "attitude";
  constexpr int n = 6000;
  w.values.resize(n, 3);
  q.values.resize(n, 4);
  Random random(5, "turning");
  Quat body = Quat::Identity();
  for (int i = 0; i < n; ++i) {
    const double t = 0.01 * i;
    const auto rate = [](double at) {
      return Vec3(0.5 * std::sin(4.4 * at) + 0.4 * std::sin(11.0 * at + 1), 0.6 * std::sin(7.1 * at),
                  0.4 * std::sin(3.1 * at + 2) + 0.3 * std::sin(14.0 * at));
    };
    w.t_s.push_back(t);
    q.t_s.push_back(0.012 + (1 + 400e-6) * t);
    for (int c = 0; c < 3; ++c) w.values(i, c) = rate(t)[c] + 0.02 * random.normal();
    q.values.row(i) << body.w(), body.x(), body.y(), body.z();
    body = (body * exp_rotation(0.01 * rate(t + 0.005))).normalized();
  }
  return r;
}

const Alignment* pair(const std::vector<Alignment>& all, const std::string& early, const std::string& late) {
  for (const Alignment& a : all)
    if (a.early == early && a.late == late) return &a;
  return nullptr;
}

// Thrust is filtered as squares of speeds; their root starts at zero like a wall, and a rotor that swings
// through rest would seem to spin up without end there.
TEST(Intake, ARotorThatReversesSpinsUpAsItDoes) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, {.duration_s = 12, .speed_noise = 0});
  recording::Signal& speed = r.signals["rotor_speed"];
  constexpr double kSwing = 150, kRate = 2 * kPi * 2;  // rad/s
  for (Eigen::Index i = 0; i < speed.size(); ++i)
    speed.values(i, 0) = kSwing * std::sin(kRate * speed.t_s[static_cast<std::size_t>(i)]);
  const auto f = prepare_flight(r, v, {});
  ASSERT_TRUE(f) << f.error().text();
  for (const Segment& s : f->segments)
    for (int i = s.begin + 20; i < s.end - 20; ++i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_NEAR(f->situation[k].rotors[0].acceleration, kSwing * kRate * std::cos(kRate * f->t[k]),
                  0.05 * kSwing * kRate)
          << f->t[k] << " s";
    }
}

TEST(Intake, MeasuresLagAndSkewOfTheAttitude) {
  const recording::Recording r = turning();
  const std::vector<Alignment> all = align_signals(r);
  const Alignment* a = pair(all, "gyro", "attitude");
  ASSERT_TRUE(a);
  // at the middle of the recording the skew has added 12 ms
  EXPECT_NEAR(a->lag_s, 0.024, 4 * a->lag_se + 0.001);
  EXPECT_LT(a->lag_se, 0.002);
  EXPECT_NEAR(a->skew, 400e-6, 4 * a->skew_se + 20e-6);
  EXPECT_GT(a->skew, 3 * a->skew_se);
}

TEST(Intake, CheckTellsWhatAFlightCannotShowInSeconds) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown hover;
  hover.duration_s = 20;
  hover.climb_m = 0;
  hover.side_m = 0.15;
  const recording::Recording r = test::fly(v, {}, hover);
  const auto c = check(std::span(&r, 1), v);
  ASSERT_TRUE(c) << c.error().text();
  EXPECT_EQ(c->verdict, Verdict::checked) << "nothing was asked, so nothing can be missing or not";
  EXPECT_TRUE(c->findings.empty());
  EXPECT_FALSE(c->intake.signals.empty());
  EXPECT_FALSE(c->intake.excitation.empty());
  // in hover a mass and a thrust scale are one direction
  const auto& groups = c->intake.alias_groups;
  const bool together = std::any_of(groups.begin(), groups.end(), [](const auto& g) {
    const auto has = [&](const char* id) { return std::find(g.begin(), g.end(), id) != g.end(); };
    return has("payload_mass") && has("thrust_scale");
  });
  EXPECT_TRUE(together) << c->summary;
  EXPECT_NE(c->summary.find("Nothing was fitted"), std::string::npos);
}

TEST(Intake, StopsInTimeAndSaysWhatIsLeftOut) {
  const vehicle::Vehicle v = omnimorph();
  test::Flown flown;
  flown.duration_s = 15;
  const recording::Recording r = test::fly(v, {{physics::find_effect("payload_mass"), {0.3}}}, flown);
  Options o;
  int asked = 0;
  o.stop = [&] { return ++asked > 5; };
  const auto d = diagnose(std::span(&r, 1), {}, v, o);
  ASSERT_TRUE(d) << d.error().text();
  ASSERT_FALSE(d->left_out.empty());
  EXPECT_EQ(d->verdict, Verdict::unfinished);
  EXPECT_EQ(d->summary.find("Not finished"), 0u) << d->summary;
  EXPECT_NE(d->summary.find("Still open: the search for left-out physics"), std::string::npos) << d->summary;
  for (const char* word : {"Found", "Nothing is missing"})
    EXPECT_EQ(d->summary.find(word), std::string::npos) << d->summary;
  for (const Finding& f : d->findings) EXPECT_TRUE(std::isnan(f.probability)) << f.effect;
  EXPECT_NE(to_json(*d).find("\"verdict\": \"unfinished\""), std::string::npos);
  EXPECT_FALSE(d->fit.in_sample.empty());
}

TEST(Intake, AParameterThatMayHaveAnyValueIsNotIdentifiable) {
  const ParameterValue whole{"start_height", "h_0", "m", 1.0, -1.0, 3.0};
  ParameterValue bounded = whole;
  bounded.low = 0.9;
  EXPECT_FALSE(identifiable("hung_cable", whole));
  EXPECT_TRUE(identifiable("hung_cable", bounded));
  EXPECT_TRUE(identifiable("no_such_effect", whole));
}

TEST(Intake, TakesWhatIsToldAndRefusesWhatIsNoNumber) {
  const std::string path = testing::TempDir() + "flight.csv.told.yaml";
  std::ofstream(path) << "environment: {floor_z_m: 0.055, air_density_kgpm3: 1.18}\n"
                         "sensors: {accelerometer: {bias_mps2: 0.08}, camera: {shutter_ms: 3}}\n"
                         "controller: {kp: [10, 10, 12], kv: 6}\nneighbours: [other.csv]\n";
  EXPECT_EQ(prior_knowledge_beside(testing::TempDir() + "flight.csv"), path);
  const auto told = load_prior_knowledge(path);
  ASSERT_TRUE(told) << told.error().text();
  ASSERT_EQ(told->neighbours.size(), 1u);
  EXPECT_EQ(told->neighbours[0], testing::TempDir() + "other.csv");
  EXPECT_EQ(told->ignored, std::vector<std::string>{"sensors.camera.shutter_ms"});
  Options o;
  apply(*told, o);
  EXPECT_DOUBLE_EQ(o.environment.floor_z, 0.055);
  EXPECT_TRUE(o.floor_told);
  EXPECT_DOUBLE_EQ(o.environment.air_density, 1.18);
  EXPECT_DOUBLE_EQ(o.tolerance.accelerometer_lateral, 0.08);
  EXPECT_DOUBLE_EQ(o.controller.kp.z(), 12);
  EXPECT_DOUBLE_EQ(o.controller.kv.x(), 6);
  std::ofstream(path) << "environment: {floor_z_m: high}\n";
  const auto bad = load_prior_knowledge(path);
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().text().find("environment.floor_z_m"), std::string::npos) << bad.error().text();
  std::ofstream(path) << "sensors: {imu: {position_m: 0.02}}\n";
  const auto one = load_prior_knowledge(path);
  ASSERT_FALSE(one) << "a place has three numbers";
  EXPECT_NE(one.error().text().find("position_m"), std::string::npos) << one.error().text();
}

TEST(Intake, TellsHowWellEachKindOfNumberOfTheVehicleIsKnown) {
  const std::string path = testing::TempDir() + "measured.csv.told.yaml";
  std::ofstream(path)
      << "tolerance: {inertia: 0.25, drag_torque: 0.5, center_of_mass: 0, rotor_axis_rad: 0.002}\n";
  const auto told = load_prior_knowledge(path);
  ASSERT_TRUE(told) << told.error().text();
  EXPECT_TRUE(told->ignored.empty());
  Options o;
  apply(*told, o);
  EXPECT_DOUBLE_EQ(o.tolerance.inertia, 0.25);
  EXPECT_DOUBLE_EQ(o.tolerance.drag_torque, 0.5);
  EXPECT_DOUBLE_EQ(o.tolerance.rotor_axis, 0.002);
  EXPECT_GT(o.tolerance.center_of_mass, 0) << "an exact number still has a direction";
  EXPECT_LT(o.tolerance.center_of_mass, 1e-5);
  EXPECT_EQ(o.tolerance.told,
            (std::set<std::string>{"center_of_mass", "drag_torque", "inertia", "rotor_axis"}));
}

TEST(Intake, TakesEveryThingThatAToldFileMayState) {
  const std::string path = testing::TempDir() + "complete.csv.told.yaml";
  const auto three = [](const char* gain) { return "  " + std::string(gain) + ": [9.5, 10.5, 12.0]\n"; };
  std::ofstream(path)
      << "rates_hz: {imu: 250, mocap: 125.5, rotor_speed: 100}\n"
         "sensors:\n"
         "  accelerometer: {noise_rms_mps2: 0.08, bias_mps2: 0.03, scale: 0.004, misalignment_rad: 0.006}\n"
         "  imu: {position_m: [0.02, -0.01, 0.015]}\n"
         "  gyro: {noise_rms_radps: 0.004, bias_radps: 0.002, low_pass_hz: 80}\n"
         "  mocap: {position_noise_m: 0.0002, attitude_noise_rad: 0.0008, stamp_jitter_s: 0.0005, stamps: "
         "receive}\n"
         "  rotor_speed: {method: half_period, tick_us: 1, jitter: 0.01}\n"
         "ambient: {turbulence_force_rms_N: 0.15, turbulence_torque_rms_Nm: 0.01, correlation_time_s: 0.3}\n"
         "controller:\n"
      << three("kp") << three("kv") << three("ki") << three("kR") << three("kw") << three("kI")
      << "  allocation_mass_kg: 2.8\n"
         "environment: {floor_z_m: -0.2, air_density_kgpm3: 1.21}\n"
         "neighbours: [one.csv, /tracks/two.csv]\n";
  const auto told = load_prior_knowledge(path);
  ASSERT_TRUE(told) << told.error().text();
  const std::vector<std::pair<const char*, double>> scalars{{"rates_hz.imu", 250},
                                                            {"rates_hz.mocap", 125.5},
                                                            {"rates_hz.rotor_speed", 100},
                                                            {"sensors.accelerometer.noise_rms_mps2", 0.08},
                                                            {"sensors.accelerometer.bias_mps2", 0.03},
                                                            {"sensors.accelerometer.scale", 0.004},
                                                            {"sensors.accelerometer.misalignment_rad", 0.006},
                                                            {"sensors.gyro.noise_rms_radps", 0.004},
                                                            {"sensors.gyro.bias_radps", 0.002},
                                                            {"sensors.gyro.low_pass_hz", 80},
                                                            {"sensors.mocap.position_noise_m", 0.0002},
                                                            {"sensors.mocap.attitude_noise_rad", 0.0008},
                                                            {"sensors.mocap.stamp_jitter_s", 0.0005},
                                                            {"sensors.rotor_speed.tick_us", 1},
                                                            {"sensors.rotor_speed.jitter", 0.01},
                                                            {"ambient.turbulence_force_rms_N", 0.15},
                                                            {"ambient.turbulence_torque_rms_Nm", 0.01},
                                                            {"ambient.correlation_time_s", 0.3},
                                                            {"controller.allocation_mass_kg", 2.8},
                                                            {"environment.floor_z_m", -0.2},
                                                            {"environment.air_density_kgpm3", 1.21}};
  for (const auto& [place, value] : scalars) {
    const auto found = told->numbers.find(place);
    ASSERT_NE(found, told->numbers.end()) << place;
    EXPECT_EQ(found->second, std::vector<double>{value}) << place;
  }
  for (const char* gain : {"kp", "kv", "ki", "kR", "kw", "kI"}) {
    const auto found = told->numbers.find(std::string("controller.") + gain);
    ASSERT_NE(found, told->numbers.end()) << gain;
    EXPECT_EQ(found->second, (std::vector<double>{9.5, 10.5, 12.0})) << gain;
  }
  EXPECT_EQ(told->numbers.size(), scalars.size() + 7);
  EXPECT_EQ(told->numbers.at("sensors.imu.position_m"), (std::vector<double>{0.02, -0.01, 0.015}));
  // words are no numbers to use, but no reason to refuse the file either
  EXPECT_EQ(told->ignored, (std::vector<std::string>{"sensors.mocap.stamps", "sensors.rotor_speed.method"}));
  EXPECT_EQ(told->neighbours, (std::vector<std::string>{testing::TempDir() + "one.csv", "/tracks/two.csv"}));
}

/// Drops the positions in [from, to) and calls the velocity the vehicle's own estimate.
void lose_positions(recording::Recording& r, const std::vector<std::pair<double, double>>& gaps) {
  r.signals["est_velocity"] = r.signals.at("velocity");
  r.signals["est_velocity"].name = "est_velocity";
  r.signals.erase("velocity");
  r.signals["est_position"] = r.signals.at("position");
  r.signals["est_position"].name = "est_position";
  recording::Signal &p = r.signals.at("position"), kept = p;
  kept.t_s.clear();
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const double t = p.t_s[static_cast<std::size_t>(i)];
    if (std::any_of(gaps.begin(), gaps.end(), [&](const auto& g) { return t >= g.first && t < g.second; }))
      continue;
    kept.t_s.push_back(t);
    rows.push_back(i);
  }
  kept.values = Eigen::MatrixXd(p.values(rows, Eigen::all));
  p = kept;
}

TEST(Intake, CutsOutWhereAnEstimatedVelocityWasDeadReckoning) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, {});
  lose_positions(r, {{12.0, 12.6}, {20.0, 22.0}});
  const auto f = prepare_flight(r, v, {});
  ASSERT_TRUE(f) << f.error().text();
  int windows = 0;
  for (const Window& w : f->excluded)
    if (w.why.find("without a position") != std::string::npos) {
      ++windows;
      const double from = windows == 1 ? 12.0 : 20.0, to = windows == 1 ? 12.6 : 22.0;
      EXPECT_NEAR(w.from_s, from + Options{}.max_gap_s, 0.05);
      EXPECT_NEAR(w.to_s, to + Options{}.max_gap_s, 0.05);
    }
  EXPECT_EQ(windows, 2);
  for (const Segment& s : f->segments)
    for (int i = s.begin; i < s.end; ++i)
      EXPECT_FALSE(f->t[static_cast<std::size_t>(i)] > 20.2 && f->t[static_cast<std::size_t>(i)] < 22.0);
}

TEST(Intake, SaysWhenTheVelocityWasDeadReckoningNearlyAllTheTime) {
  const vehicle::Vehicle v = omnimorph();
  recording::Recording r = test::fly(v, {}, {});
  std::vector<std::pair<double, double>> gaps;
  for (double t = 0.5; t < 200; t += 0.8) gaps.emplace_back(t, t + 0.4);
  lose_positions(r, gaps);
  const auto f = prepare_flight(r, v, {});
  ASSERT_TRUE(f) << f.error().text();
  EXPECT_TRUE(std::any_of(f->notes.begin(), f->notes.end(), [](const std::string& note) {
    return note.find("dead reckoning") != std::string::npos;
  }));
  EXPECT_GT(f->usable(), 2 * f->rate_hz);
}

}  // namespace
}  // namespace omniflight::diagnosis
