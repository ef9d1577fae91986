// Real flights, where they are at hand: OMNIFLIGHT_REAL_DATA or ../shared/data beside the checkout.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_diagnosis/neighbour_file.hpp"
#include "omniflight_recording/formats.hpp"
#include "real_data.hpp"

namespace omniflight::diagnosis {
namespace {

using test::flights;

std::vector<recording::Recording> load_all(const std::vector<std::string>& names) {
  std::vector<recording::Recording> out;
  for (const std::string& name : names) {
    auto r = recording::load(flights() / name);
    EXPECT_TRUE(r) << r.error().text();
    if (r) out.push_back(std::move(*r));
  }
  return out;
}

/// The vehicle that flew this recording; nothing, and the test is skipped, where the recording is not at
/// hand.
std::optional<vehicle::Vehicle> vehicle_of(const std::string& recording, const std::string& name) {
  if (!std::filesystem::exists(flights() / recording)) {
    [] { GTEST_SKIP() << "no recordings at " << flights() << "; set OMNIFLIGHT_REAL_DATA"; }();
    return {};
  }
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  auto v = vehicle::load_vehicle(name);
  EXPECT_TRUE(v) << v.error().text();
  if (!v) return {};
  return std::move(*v);
}

bool named(const Diagnosis& d, const std::string& effect) {
  return std::any_of(d.findings.begin(), d.findings.end(),
                     [&](const Finding& f) { return f.effect == effect; });
}

TEST(RealFlights, RotorDragIsNamedAndNoLoad) {
  const auto v = vehicle_of("crazyflie_brushless/eckart00", "crazyflie_brushless");
  if (!v) return;
  const std::string f = "crazyflie_brushless/eckart";
  const auto fit = load_all({f + "00", f + "06", f + "12", f + "17", f + "22"});
  const auto held_out = load_all({f + "01", f + "07", f + "13", f + "18"});
  const auto d = diagnose(fit, held_out, *v);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_GE(d->candidates.size(), 8u);
  EXPECT_TRUE(named(*d, "rotor_drag")) << d->summary;
  for (const char* absent :
       {"payload_mass", "hung_cable", "constant_pull", "wind", "lateral_stiffness", "thrust_scale"})
    EXPECT_FALSE(named(*d, absent)) << d->summary;
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  for (const ChannelFit& c : d->fit.held_out) {
    if (c.channel == "ax") x0 += c.rms_before / 4, x1 += c.rms_after / 4;
    if (c.channel == "ay") y0 += c.rms_before / 4, y1 += c.rms_after / 4;
  }
  RecordProperty("held_out_ax", std::to_string(x1));
  EXPECT_GT(x0, 0.15);
  EXPECT_GT(y0, 0.15);
  EXPECT_LE(x1, 0.09);
  EXPECT_LE(y1, 0.10);
  const auto inertia = std::find_if(d->findings.begin(), d->findings.end(),
                                    [](const Finding& x) { return x.effect == "rotor_inertia"; });
  ASSERT_NE(inertia, d->findings.end()) << d->summary;
  // the propeller alone has 3.9e-8 kg m2 (github.com/utiasDSL/drone-models, cf21B_500), the motor's bell adds
  // to it; on slow flights feedback hides a part of both
  EXPECT_GT(inertia->parameters[0].value, 3.0e-8);
  EXPECT_LT(inertia->parameters[0].value, 9.0e-8);
  for (const ChannelFit& c : d->fit.held_out) {
    if (c.channel == "Mz") {
      EXPECT_GT(c.r2_after, c.r2_before + 0.4) << c.recording;
    }
  }
}

TEST(RealFlights, SpinUpExplainsTheYawOfQuickFlights) {
  const auto v = vehicle_of("crazyflie_brushless/eckart30", "crazyflie_brushless");
  if (!v) return;
  const std::string f = "crazyflie_brushless/eckart";
  Options o;
  o.rollouts = false;
  const auto d = diagnose(load_all({f + "12", f + "17", f + "22", f + "27", f + "30"}),
                          load_all({f + "13", f + "18", f + "23", f + "24", f + "28"}), *v, o);
  ASSERT_TRUE(d) << d.error().text();
  const auto inertia = std::find_if(d->findings.begin(), d->findings.end(),
                                    [](const Finding& x) { return x.effect == "rotor_inertia"; });
  ASSERT_NE(inertia, d->findings.end()) << d->summary;
  EXPECT_GT(inertia->parameters[0].value, 5e-8);
  EXPECT_LT(inertia->parameters[0].value, 9e-8);
  // R2 over all flights that were not fitted: what is left and what was to be explained, both summed
  double all = 0, before = 0, after = 0;
  for (const ChannelFit& c : d->fit.held_out) {
    if (c.channel != "Mz") continue;
    const double variance = c.rms_after * c.rms_after / (1 - c.r2_after);
    all += variance;
    before += variance * (1 - c.r2_before);
    after += variance * (1 - c.r2_after);
  }
  RecordProperty("yaw_r2_before", std::to_string(1 - before / all));
  RecordProperty("yaw_r2_after", std::to_string(1 - after / all));
  EXPECT_LT(1 - before / all, 0.4);
  EXPECT_GE(1 - after / all, 0.8);
}

// Eight flights with a ball on a thread, 4 to 9 s, up to 60 degrees of swing. Its own track, which no fit
// sees, is 0.522 m away from the vehicle's.
TEST(RealFlights, ABallOnAThreadIsASlungLoadOfItsLength) {
  const auto v = vehicle_of("crazyflie_payload/eckart07", "crazyflie_brushless");
  if (!v) return;
  Options o;
  o.rollouts = false;
  int named = 0;
  for (const char* flight : {"07", "13", "24", "30", "46", "58", "69", "78"}) {
    const auto d = diagnose(load_all({std::string("crazyflie_payload/eckart") + flight}), {}, *v, o);
    ASSERT_TRUE(d) << d.error().text();
    const auto load = std::find_if(d->findings.begin(), d->findings.end(),
                                   [](const Finding& x) { return x.effect == "slung_load"; });
    if (load == d->findings.end()) continue;
    const double mass = load->parameters[0].value;
    const double distance = load->parameters[1].value - load->parameters[5].value;
    std::printf("%s: %.2f g, %.3f m\n", flight, 1e3 * mass, distance);
    EXPECT_NEAR(distance, 0.522, 0.15 * 0.522) << flight;
    ++named;
  }
  EXPECT_GE(named, 7);
}

/// A finding that is called `effect`, or that cannot be told apart from it.
const Finding* said(const Diagnosis& d, const std::string& effect) {
  for (const Finding& f : d.findings) {
    const auto& rivals = f.cannot_be_told_apart_from;
    if (f.effect == effect || std::find(rivals.begin(), rivals.end(), effect) != rivals.end()) return &f;
  }
  return nullptr;
}

TEST(RealFlights, AVehicleFileSetWrongIsSaid) {
  const auto nominal = vehicle_of("crazyflie_brushless/eckart01", "crazyflie_brushless");
  if (!nominal) return;
  Options o;
  o.rollouts = false;
  for (const char* flight : {"01", "07", "13", "18", "23"}) {
    SCOPED_TRACE(flight);
    const auto recording = load_all({std::string("crazyflie_brushless/eckart") + flight});
    const auto ask = [&](const vehicle::Vehicle& v) {
      auto d = diagnose(recording, {}, v, o);
      EXPECT_TRUE(d) << d.error().text();
      return d ? *d : Diagnosis{};
    };
    const Diagnosis right = ask(*nominal);
    // feedback lets the rotors of 07 seem to turn the body in yaw less than half as much as they do
    for (const char* absent :
         {"payload_mass", "thrust_scale", "constant_pull", "rotor_thrust_scale", "drag_torque_scale"})
      EXPECT_FALSE(named(right, absent)) << right.summary;

    vehicle::Vehicle heavy = *nominal;
    heavy.mass *= 1.1;
    const Diagnosis of_heavy = ask(heavy);
    const Finding* load = said(of_heavy, "payload_mass");
    ASSERT_TRUE(load) << of_heavy.summary;
    if (load->effect == "payload_mass") {
      EXPECT_NEAR(load->parameters[0].value, -0.1 * nominal->mass, 0.01 * nominal->mass);
    }

    // ... and one of 13 weak, where a load is missing in the file
    vehicle::Vehicle light = *nominal;
    light.mass *= 0.92;
    const Diagnosis of_light = ask(light);
    EXPECT_FALSE(named(of_light, "rotor_thrust_scale")) << of_light.summary;
    if (named(of_light, "payload_mass")) {
      EXPECT_NEAR(said(of_light, "payload_mass")->parameters[0].value, 0.08 * nominal->mass,
                  0.01 * nominal->mass);
    }

    vehicle::Vehicle weak = *nominal;
    for (vehicle::Rotor& r : weak.rotors) r.thrust_coefficient *= 0.9;
    const Diagnosis of_weak = ask(weak);
    EXPECT_TRUE(said(of_weak, "thrust_scale")) << of_weak.summary;

    vehicle::Vehicle shifted = *nominal;
    shifted.center_of_mass.x() += 0.004;
    const Diagnosis of_shifted = ask(shifted);
    const Finding* centre = said(of_shifted, "com_offset");
    ASSERT_TRUE(centre) << of_shifted.summary;
    EXPECT_NEAR(centre->parameters[0].value, -0.004, 0.0008);
  }
}

/// One of a pair, beside the track of the other if `other` is named.
recording::Recording load_one_of_two(const std::string& own, const std::string& other) {
  const auto folder = flights() / "crazyflie_pairs";
  recording::LoadOptions load;
  load.map = OMNIFLIGHT_SOURCE_ROOT "/configs/csv_maps/crazyflie_pairs.yaml";
  auto r = recording::load(folder / (own + ".csv.gz"), load);
  EXPECT_TRUE(r) << r.error().text();
  if (!r || other.empty()) return r ? *r : recording::Recording{};
  const auto track = load_neighbour((folder / (other + ".csv.gz")).string(), load.map, r->start_s);
  EXPECT_TRUE(track) << track.error().text();
  if (!track) return *r;
  recording::Signal& s = r->signals["neighbour1_position"];
  s.name = "neighbour1_position";
  s.unit = "m";
  s.t_s = track->t_s;
  s.values.resize(static_cast<Eigen::Index>(track->p_WN.size()), 3);
  for (Eigen::Index i = 0; i < s.size(); ++i)
    s.values.row(i) = track->p_WN[static_cast<std::size_t>(i)].transpose();
  return *r;
}

/// The flight of the lower one of two that change places, and the one of the upper.
struct Swap {
  const char *own, *other;
};

TEST(RealFlights, TheWashOfANeighbourIsNamedAndHalvesTheForceError) {
  auto v = vehicle_of("crazyflie_pairs/swapSS_cf50_00.csv.gz", "crazyflie_brushed");
  if (!v) return;
  constexpr Swap kSmall[] = {{"swapSS_cf50_00", "swapSS_cf51_00"}, {"swapSS_cf50_02", "swapSS_cf51_02"}};
  constexpr Swap kLarge[] = {{"swapLL_cf102_00", "swapLL_cf101_00"}, {"swapLL_cf101_06", "swapLL_cf102_06"}};
  Options o;
  o.rollouts = false;
  for (const auto& [pair, mass] : {std::pair{kSmall, 0.033}, {kLarge, 0.065}})
    for (int k = 0; k < 2; ++k) {
      v->mass = mass;
      const Swap &seen = pair[k], &other_run = pair[1 - k];
      const auto fit = load_one_of_two(seen.own, seen.other);
      const auto held_out = load_one_of_two(other_run.own, other_run.other);
      const auto d = diagnose(std::span(&fit, 1), std::span(&held_out, 1), *v, o);
      ASSERT_TRUE(d) << d.error().text();
      EXPECT_TRUE(named(*d, "neighbour_downwash")) << seen.own << ": " << d->summary;
      for (const Finding& f : d->findings)  // and nothing but how air drags on rotors
        EXPECT_TRUE(f.effect == "neighbour_downwash" || f.effect == "rotor_drag") << d->summary;
      for (const Unexplained& u : d->unexplained) EXPECT_NE(u.channel, "Fz") << d->summary;
      for (const ChannelFit& c : d->fit.held_out) {
        if (c.channel != "Fz") continue;
        RecordProperty(std::string("held_out_Fz_ratio_") + seen.own,
                       std::to_string(c.rms_after / c.rms_before));
        EXPECT_LE(c.rms_after, 0.5 * c.rms_before) << c.recording;
      }
    }
}

TEST(RealFlights, ANeighbourThatWasElsewhereIsNoFinding) {
  auto v = vehicle_of("crazyflie_pairs/swapSS_cf50_00.csv.gz", "crazyflie_brushed");
  if (!v) return;
  Options o;
  o.rollouts = false;
  for (const auto& [upper, mass] : {std::pair{Swap{"swapSS_cf51_02", "swapSS_cf50_02"}, 0.033},
                                    {{"swapLL_cf101_04", "swapLL_cf102_00"}, 0.065}}) {
    v->mass = mass;
    auto r = load_one_of_two(upper.own, upper.other);
    r.signals["neighbour1_position"].values.col(2).array() += 0.65;  // it flew below, and is told to be above
    const auto d = diagnose(std::span(&r, 1), {}, *v, o);
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_FALSE(named(*d, "neighbour_downwash")) << upper.own << ": " << d->summary;
    EXPECT_FALSE(d->candidates.empty());
    EXPECT_TRUE(std::any_of(d->candidates.begin(), d->candidates.end(),
                            [](const auto& c) { return c.effect == "neighbour_downwash"; }));
  }
}

TEST(RealFlights, AWashOfNobodyIsAForceFromOutside) {
  auto v = vehicle_of("crazyflie_pairs/swapSS_cf50_00.csv.gz", "crazyflie_brushed");
  if (!v) return;
  v->mass = 0.033;
  Options o;
  o.rollouts = false;
  const auto alone = load_one_of_two("swapSS_cf50_00", "");
  const auto d = diagnose(std::span(&alone, 1), {}, *v, o);
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_EQ(d->verdict, Verdict::unexplained) << d->summary;
  EXPECT_FALSE(named(*d, "neighbour_downwash")) << d->summary;
  EXPECT_TRUE(std::any_of(d->unexplained.begin(), d->unexplained.end(), [](const Unexplained& u) {
    return u.channel == "Fz" && u.frame == "world";
  })) << d->summary;
  EXPECT_NE(d->summary.find("downward force"), std::string::npos) << d->summary;
}

TEST(RealFlights, TakeOffsShowTheGroundEffectWithItsHeightLaw) {
  auto v = vehicle_of("crazyflie_pairs/takeoffS19_cf50_00.csv.gz", "crazyflie_brushed");
  if (!v) return;
  for (const auto& [name, mass] : {std::pair{"takeoffS19_cf50_00", 0.033}, {"takeoffL19_cf101_00", 0.065}}) {
    v->mass = mass;
    for (vehicle::Rotor& r : v->rotors) r.max_thrust = 5 * mass;
    const auto flight = load_one_of_two(name, "");
    const auto d = diagnose(std::span(&flight, 1), {}, *v, {});
    ASSERT_TRUE(d) << d.error().text();
    EXPECT_TRUE(named(*d, "ground_effect")) << name << ": " << d->summary;
    for (const Unexplained& u : d->unexplained) EXPECT_NE(u.channel, "Fz") << name << ": " << d->summary;
    for (const ChannelFit& c : d->fit.in_sample)
      if (c.channel == "Fz") {
        RecordProperty(std::string("Fz_ratio_") + name, std::to_string(c.rms_after / c.rms_before));
        EXPECT_LT(c.rms_after, 0.7 * c.rms_before) << name;
      }
  }
}

TEST(RealFlights, AMotorThatIsSlowerOrQuickerThanTheFileIsNamed) {
  auto v = vehicle_of("crazyflie_brushless/eckart01", "crazyflie_brushless");
  if (!v) return;
  for (const auto& [name, told] :
       {std::pair{"eckart01", 0.015}, {"eckart08", 0.015}, {"eckart18", 0.015}, {"eckart18", 0.07}}) {
    for (vehicle::Rotor& r : v->rotors) r.time_constant = told;
    const auto flight = load_all({std::string("crazyflie_brushless/") + name});
    const auto d = diagnose(flight, {}, *v, {});
    ASSERT_TRUE(d) << d.error().text();
    const auto value = [&](const char* effect) {
      for (const Finding& f : d->findings)
        if (f.effect == effect) return f.parameters[0].value;
      return 0.0;
    };
    // 34 ms of lag and 6 ms of delay (test_motor_verbs), which may be one of stamps and is not claimed
    EXPECT_NEAR(told + value("motor_lag"), 0.038, 0.004) << name << ": " << d->summary;
    EXPECT_EQ(value("transport_delay"), 0.0) << name << ": " << d->summary;
  }
}

TEST(RealFlights, AStuckSpeedSensorIsNamed) {
  const auto v = vehicle_of("crazyflie_brushed/jana20", "crazyflie_brushed");
  if (!v) return;
  const auto good = load_all({"crazyflie_brushed/jana00"}), bad = load_all({"crazyflie_brushed/jana20"});
  ASSERT_EQ(good.size() + bad.size(), 2u);
  Options options;
  const auto faults = [&](const recording::Recording& r) {
    const auto f = prepare_flight(r, *v, options);
    return f ? f->faults.size() : std::size_t{99};
  };
  EXPECT_EQ(faults(good[0]), 0u);
  EXPECT_GE(faults(bad[0]), 1u);
}

}  // namespace
}  // namespace omniflight::diagnosis
