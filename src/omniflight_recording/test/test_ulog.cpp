// ULog files of a made-up flight, sound and damaged; and the real ones of PX4 where they are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <regex>

#include "notes.hpp"
#include "omniflight_recording/alignment.hpp"
#include "omniflight_recording/vehicle_hints.hpp"
#include "real_data.hpp"
#include "sample_bag.hpp"
#include "sample_ulog.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

Result<Recording> read(std::string_view bytes) { return sample::read_as("ulog", bytes); }

TEST(Ulog, AFlightComesBackInOurAxesAndUnits) {
  const auto r = read(sample::flight_log(1000).bytes());
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_FALSE(r->lost_anything()) << r->notes.front().text;
  EXPECT_DOUBLE_EQ(r->start_s, 5.0);
  for (const char* name : {"est_position", "est_velocity", "est_attitude", "gyro", "acc"}) {
    const Signal* s = r->find(name);
    ASSERT_NE(s, nullptr) << name;
    ASSERT_EQ(s->size(), std::string(name).substr(0, 3) == "est" ? 100 : 1000) << name;
    for (Eigen::Index i = 0; i < s->size(); i += 7) {
      const auto m = sample::moment(s->t_s[static_cast<std::size_t>(i)]);
      const Eigen::VectorXd row = s->values.row(i);
      const double error =
          s->name == "est_position"   ? (row - m.p_WB).norm()
          : s->name == "est_velocity" ? (row - m.v_WB).norm()
          : s->name == "gyro"         ? (row - m.w_B).norm()
          : s->name == "acc"          ? (m.q_WB * Vec3(row) - Vec3(0, 0, 9.81)).norm()
                             : log_rotation(m.q_WB.conjugate() * Quat(row(0), row(1), row(2), row(3))).norm();
      EXPECT_LT(error, 1e-5) << name << " row " << i;
    }
  }
  EXPECT_EQ(r->find("est_attitude")->source, "vehicle_attitude q, converted from NED/FRD");
  ASSERT_EQ(r->find("rotor_speed")->width(), 4);  // esc_count of eight
  EXPECT_NEAR(r->find("rotor_speed")->values(0, 3), 6180 * kPi / 30, 1e-9);
  ASSERT_EQ(r->find("pwm")->width(), 4);  // the vehicle has four of twelve
  EXPECT_NEAR(r->find("pwm")->values(5, 1), 0.41, 1e-6);
  EXPECT_NEAR(r->find("vbat")->values(0, 0), 15.5, 1e-6);  // of the first battery
  EXPECT_NEAR(r->find("ibat")->values(0, 0), 3.0, 1e-6);   // which has no current sensor
  EXPECT_EQ(r->metadata.at("ulog.ver_hw"), "MADE_UP_1");
}

TEST(Ulog, TopicsAreCountedAndSayWhatTheyFeed) {
  const auto r = read(sample::flight_log(500).bytes()).value();
  std::map<std::string, TopicSummary> topics;
  for (const TopicSummary& t : r.topics) topics[t.name] = t;
  EXPECT_EQ(topics.at("sensor_combined").messages, 500u);
  EXPECT_EQ(topics.at("sensor_combined").feeds, (std::vector<std::string>{"gyro", "acc"}));
  EXPECT_EQ(topics.at("battery_status").feeds, std::vector<std::string>{"vbat"});
  EXPECT_EQ(topics.at("battery_status#1").feeds, std::vector<std::string>{"ibat"});
  EXPECT_EQ(topics.at("battery_status#1").messages, 50u);
}

TEST(Ulog, ParametersTellOfTheVehicle) {
  const auto r = read(sample::flight_log(10).bytes()).value();
  const VehicleHints h = vehicle_hints(r);
  EXPECT_EQ(h.autopilot, "PX4 v1.14.0 on MADE_UP_1");
  EXPECT_EQ(h.airframe, "quadrotor");
  ASSERT_EQ(h.rotors.size(), 4u);
  EXPECT_LT((h.rotors[0].p_B - Vec3(0.15, -0.2, 0)).norm(), 1e-6);  // PX4 has y to the right
  EXPECT_LT((h.rotors[0].axis_B - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(h.rotors[0].spin, -1);  // turns counter-clockwise: its torque on the body is clockwise
  EXPECT_EQ(h.rotors[2].spin, 1);
  EXPECT_NEAR(h.rotors[0].drag_ratio, 0.05, 1e-6);
  EXPECT_FALSE(h.rotors[0].max_thrust);
  EXPECT_FALSE(h.mass);
  EXPECT_NEAR(h.hover_duty.value(), 0.42, 1e-6);
  EXPECT_EQ(h.battery_cells, 4);
}

TEST(Ulog, DropoutsAreGapsAndTextsAndChangesAreTold) {
  sample::Ulog log;
  sample::declare_flight(log);
  for (std::uint64_t k = 0; k < 100; ++k) sample::fly_step(log, k);
  log.dropout(50).parameter("MPC_THR_HOVER", 0.5f);
  log.text('4', 5'120'000, "Low battery").text('6', 5'130'000, "logging started");
  for (std::uint64_t k = 150; k < 200; ++k) sample::fly_step(log, k);
  const auto r = read(log.bytes()).value();
  EXPECT_TRUE(has_note(r, "the logger lost data 1 times, for 50 ms together"));
  const auto gap = std::find_if(r.notes.begin(), r.notes.end(), [](const Note& n) { return n.to_s > 0; });
  ASSERT_NE(gap, r.notes.end());
  EXPECT_EQ(gap->kind, Note::Kind::loss);
  EXPECT_NEAR(gap->from_s, 0.099, 1e-9);
  EXPECT_NEAR(gap->to_s, 0.149, 1e-9);
  EXPECT_TRUE(has_note(r, "warning of the autopilot at 0.120 s: Low battery"));
  EXPECT_FALSE(has_note(r, "logging started"));
  EXPECT_TRUE(has_note(r, "parameter MPC_THR_HOVER was set to 0.5"));
  EXPECT_NEAR(r.parameters.at("MPC_THR_HOVER"), 0.42, 1e-6);  // as the log begins
}

TEST(Ulog, AppendedSectionsAreReadBehindATornRecord) {
  sample::Ulog log;
  log.flags(1, 0);
  const std::size_t offset_at = 16 + 3 + 16;
  sample::Ulog rest;
  sample::declare_flight(rest);
  for (std::uint64_t k = 0; k < 100; ++k) sample::fly_step(rest, k);
  log.append(rest.bytes().substr(rest.boundaries().front()));  // without header and flags
  log.append(
      std::string("\x30\x00"
                  "D\x00\x00torn",
                  9));  // the crash
  const std::size_t appended = log.bytes().size();
  for (std::uint64_t k = 100; k < 120; ++k) sample::fly_step(log, k);
  std::string bytes = log.bytes();
  bytes.replace(offset_at, 8, sample::Packed().put(static_cast<std::uint64_t>(appended)).text());
  const auto r = read(bytes).value();
  EXPECT_EQ(r.find("gyro")->size(), 120);
  EXPECT_TRUE(has_note(r, "a section of the log ends in the middle of a record: its last 9 bytes"));
  // an offset that lies is told, and everything is read as one section
  bytes.replace(offset_at, 8, sample::Packed().put(std::uint64_t{1} << 60).text());
  const auto lying = read(bytes).value();
  EXPECT_TRUE(has_note(lying, "which is not in the file"));
  EXPECT_EQ(lying.find("gyro")->size(), 120);
}

TEST(Ulog, UnknownExtensionsAreRefused) {
  sample::Ulog log;
  log.flags(2);
  const auto r = read(log.bytes());
  ASSERT_FALSE(r);
  EXPECT_NE(r.error().text().find("incompat_flags"), std::string::npos);
}

TEST(Ulog, CutAtEveryByteItKeepsAMonotonePrefixAndTellsTheLoss) {
  const auto log = sample::flight_log(15);
  const auto whole = read(log.bytes()).value();
  Eigen::Index before = 0;
  for (std::size_t size = 0; size < log.bytes().size(); ++size) {
    const auto r = read(std::string_view(log.bytes()).substr(0, size));
    if (!r) {
      ASSERT_EQ(before, 0) << size;
      continue;
    }
    const bool between_records =
        size == 16 || std::binary_search(log.boundaries().begin(), log.boundaries().end(), size);
    ASSERT_TRUE(r->lost_anything() || between_records) << size;  // the format has no mark at its end
    const Signal* gyro = r->find("gyro");
    const Eigen::Index now = gyro ? gyro->size() : 0;
    ASSERT_GE(now, before) << size;
    ASSERT_TRUE(!gyro || gyro->values == whole.find("gyro")->values.topRows(now)) << size;
    before = now;
  }
  EXPECT_EQ(before, 14);  // the last is cut
}

/// What a flipped bit may change without being told: a value, a text. Not how much was recorded.
TEST(Ulog, FlippedBitsNeverLoseAMessageSilently) {
  const auto log = sample::flight_log(60);
  const auto whole = read(log.bytes()).value();
  sample::Ulog declarations;
  sample::declare_flight(declarations);
  const std::size_t declared = declarations.bytes().size();
  std::mt19937_64 random(7);
  int refused = 0, told = 0, same = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string damaged = log.bytes();
    const std::size_t bit = random() % (8 * damaged.size());
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const auto r = read(damaged);
    if (!r) {
      ++refused;
      continue;
    }
    if (texts(*r) != texts(whole)) {
      ++told;
      continue;
    }
    ++same;
    for (const auto& [name, signal] : whole.signals) {
      const Signal* s = r->find(name);
      const bool renamed = bit / 8 < declared;  // in a format: another name, another type of the same size
      ASSERT_TRUE(renamed || (s && s->size() == signal.size())) << name << " bit " << bit;
    }
  }
  EXPECT_LT(refused, 30);
  EXPECT_GT(told, 150);
  EXPECT_GT(same, 500);
}

TEST(Ulog, DamageInTheMiddleCostsOnlyWhatItHit) {
  const auto log = sample::flight_log(300);
  std::string bytes = log.bytes();
  const std::size_t middle = log.boundaries()[log.boundaries().size() / 2];
  bytes.replace(middle + 10, 500, 500, '\xee');
  const auto r = read(bytes).value();
  EXPECT_TRUE(r.lost_anything());
  EXPECT_GT(r.find("gyro")->size(), 280);
  EXPECT_NEAR(r.find("gyro")->t_s.back(), 0.299, 1e-9);
}

TEST(Ulog, LyingSizesAndAbsurdCountsAreAnswered) {
  const auto says = [](const sample::Ulog& log, const std::string& part) {
    const auto r = read(log.bytes());
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_TRUE(has_note(*r, part)) << part;
  };
  sample::Ulog huge;
  huge.format("sensor_combined:uint64_t timestamp;float[4294967295] gyro_rad;")
      .subscribe(0, "sensor_combined");
  huge.data(0, sample::Packed().put(std::uint64_t{1}).raw(std::string(64, 'x')));
  says(huge, "were left out");
  sample::Ulog nothing;  // arrays of records without content must not be looped over
  nothing.format("a:b[4294967295] x;").format("b:c[4294967295] x;").format("c:a[2] x;");
  nothing.format("sensor_combined:uint64_t timestamp;a[4294967295] x;").subscribe(0, "sensor_combined");
  nothing.data(0, sample::Packed().put(std::uint64_t{1}));
  says(nothing, "no usable format");
  sample::Ulog unknown;
  unknown.subscribe(0, "sensor_combined").data(0, sample::Packed().put(std::uint64_t{1}));
  says(unknown, "no usable format");
  sample::Ulog longer;  // messages of another size than their format has
  sample::declare_flight(longer);
  for (std::uint64_t k = 0; k < 20; ++k) sample::fly_step(longer, k);
  longer.data(0, sample::Packed().put(std::uint64_t{5'020'000}).raw(std::string(5000, 'x')));
  for (std::uint64_t k = 21; k < 40; ++k) sample::fly_step(longer, k);
  says(longer, "1 records are damaged");
  EXPECT_EQ(read(longer.bytes())->find("gyro")->size(), 39);
  for (std::uint16_t n = 0; n < 2000; ++n) longer.subscribe(n, "no_such_topic_" + std::to_string(n));
  says(longer, "more such places");
}

TEST(Ulog, AWrongStampDoesNotStretchTheRecording) {
  sample::Ulog log;
  sample::declare_flight(log);
  for (std::uint64_t k = 0; k < 200; ++k) sample::fly_step(log, k, k == 77 ? 1ull << 50 : 5'000'000);
  const auto r = read(log.bytes()).value();
  EXPECT_LT(r.duration_s, 0.3);
  EXPECT_GE(r.find("gyro")->size(), 199);
  EXPECT_TRUE(has_note(r, "stamps are more than 60 s off"));
}

TEST(Ulog, WrittenAsCsvItComesBackTheSame) {
  const auto r = read(sample::flight_log(300).bytes()).value();
  const fs::path csv = fs::temp_directory_path() / ("omniflight_ulog_" + std::to_string(::getpid()) + ".csv");
  sample::need(write_csv(r, csv));
  const auto again = load(csv);
  fs::remove(csv);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->signal_names(), r.signal_names());
  for (const auto& [name, s] : r.signals) {
    ASSERT_EQ(again->find(name)->size(), s.size()) << name;
    EXPECT_LT((again->find(name)->values - s.values).cwiseAbs().maxCoeff(), 1e-12) << name;
  }
}

/// "sensor_combined (0, 72)   17070 1229040" of pyulog's ulog_info.
std::map<std::string, std::uint64_t> reference_counts(const fs::path& file) {
  std::map<std::string, std::uint64_t> out;
  std::ifstream in(file);
  const std::regex row(R"(^ (\w+) \((\d+), \d+\) +(\d+) +\d+)");
  for (std::string line; std::getline(in, line);)
    if (std::smatch m; std::regex_search(line, m, row))
      out[m[1].str() + (m[2] == "0" ? "" : "#" + m[2].str())] = std::stoull(m[3]);
  return out;
}

TEST(RealUlog, CountsAreThoseOfTheReferenceParser) {
  NEEDS_REAL_DATA("formats/ulog/sample_info.txt");
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  for (const std::string name : {"sample", "sample_appended_multiple"}) {
    const auto r = load(real_data("formats/ulog/" + name + ".ulg"));
    ASSERT_TRUE(r) << r.error().text();
    std::map<std::string, std::uint64_t> counts;
    for (const TopicSummary& t : r->topics) counts[t.name] = t.messages;
    const auto reference = reference_counts(real_data("formats/ulog/" + name + "_info.txt"));
    EXPECT_GT(reference.size(), 10u);
    EXPECT_EQ(counts, reference) << name;
  }
}

TEST(RealUlog, LogsWithoutASummaryHaveTheTopicsAndMessagesThatAnotherParserCounts) {
  NEEDS_REAL_DATA("formats/ulog");
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  struct Counted {
    const char* file;
    std::size_t topics;
    std::uint64_t messages, attitudes, imu;
  };
  // counted with the package @foxglove/ulog 2.3 of npm
  for (const Counted& c : {Counted{"foxglove_test_ulog.ulg", 95, 4272, 131, 1297},
                           Counted{"sample_log_small.ulg", 70, 14604, 1298, 1298},
                           Counted{"sample_logging_tagged_and_default_params.ulg", 96, 21229, 1730, 2028},
                           Counted{"sample_px4_events.ulg", 69, 29480, 622, 7783}}) {
    const auto r = load(real_data("formats/ulog") / c.file);
    ASSERT_TRUE(r) << r.error().text();
    std::map<std::string, std::uint64_t> counts;
    std::uint64_t messages = 0;
    for (const TopicSummary& t : r->topics)
      if (t.messages > 0) counts[t.name] = t.messages, messages += t.messages;
    EXPECT_EQ(counts.size(), c.topics) << c.file;
    EXPECT_EQ(messages, c.messages) << c.file;
    EXPECT_EQ(counts["vehicle_attitude"], c.attitudes) << c.file;
    EXPECT_EQ(counts["sensor_combined"], c.imu) << c.file;
  }
}

TEST(RealUlog, GravityPointsDownInEveryLog) {
  NEEDS_REAL_DATA("formats/ulog/sample.ulg");
  setenv("OMNIFLIGHT_CONFIGS", OMNIFLIGHT_SOURCE_ROOT "/configs", 1);
  int logs = 0;
  for (const auto& entry : fs::directory_iterator(real_data("formats/ulog"))) {
    if (entry.path().extension() != ".ulg") continue;
    const auto r = load(entry.path());
    ASSERT_TRUE(r) << r.error().text();
    const Signal *acc = r->find("acc"), *attitude = r->find("est_attitude");
    ASSERT_NE(acc, nullptr) << entry.path();
    const Eigen::MatrixXd q = resample(*attitude, acc->t_s);
    Vec3 mean = Vec3::Zero();
    int n = 0;
    for (Eigen::Index i = 0; i < acc->size(); ++i) {
      if (!q.row(i).allFinite()) continue;
      mean += Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)) * Vec3(acc->values.row(i));
      ++n;
    }
    mean /= n;  // the mean specific force of a flight is its weight
    EXPECT_LT((mean - Vec3(0, 0, 9.81)).norm(), 0.35) << entry.path() << " " << mean.transpose();
    ++logs;
  }
  EXPECT_GE(logs, 6);
}

}  // namespace
