#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <fstream>
#include <numbers>

#include "notes.hpp"
#include "omniflight_recording/alignment.hpp"
#include "omniflight_recording/formats.hpp"
#include "sample_bag.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

class Csv : public testing::Test {
 protected:
  fs::path file = fs::temp_directory_path() / ("omniflight_csv_" + std::to_string(::getpid()));
  void TearDown() override { fs::remove(file); }
  Result<Recording> read(const std::string& text, const LoadOptions& options = {}) {
    std::ofstream(file, std::ios::binary) << text;
    return load(file, options);
  }
  std::string refusal(const std::string& text) {
    const auto r = read(text);
    return r ? "accepted" : r.error().text().substr(file.string().size());
  }
};

TEST_F(Csv, ColumnsInAnyOrderEmptyCellsAndGapsAreRead) {
  const auto r = read(
      "qz,qw,t_s,qx,qy,rotor2_radps,rotor1_radps,vbat_V,remark_x\n"
      "0,1.5,0.5,0,0,,,11.1,7\n"
      "0,1,0.75,0,0,-20,10,,7\n"
      "\n"
      "0,1,4,0,0,-21,11,,7\r\n");
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_EQ(r->format, "csv");
  EXPECT_EQ(r->find("attitude")->size(), 3);
  EXPECT_EQ(r->find("attitude")->values(0, 0), 1.0);  // normalised, w first
  EXPECT_EQ(r->find("rotor_speed")->t_s, (std::vector<double>{0.75, 4}));
  EXPECT_EQ(r->find("rotor_speed")->values(0, 1), -20);
  EXPECT_EQ(r->find("vbat")->size(), 1);
  EXPECT_EQ(r->duration_s, 3.5);
  ASSERT_EQ(r->notes.size(), 1u);
  EXPECT_EQ(r->notes[0].text, "column 'remark_x' has no known meaning");
}

TEST_F(Csv, HostileTablesAreRefusedWithLineAndColumn) {
  EXPECT_EQ(
      refusal("time,px_m\n0,1\n"),
      ":1: there is no column t_s (time in seconds), and no map under configs/csv_maps fits. Rename the "
      "time column, or describe the columns with --map FILE (omniflight new map NAME --from FILE starts "
      "one)");
  EXPECT_EQ(refusal("t_s,vbat_V\n0,1\n1,abc\n"),
            ":3: vbat_V: 'abc' is not a finite number. Correct the cell or leave it empty");
  EXPECT_EQ(refusal("t_s,vbat_V\n0,inf\n"),
            ":2: vbat_V: 'inf' is not a finite number. Correct the cell or leave it empty");
  EXPECT_EQ(refusal("t_s,vbat_V\n0,1\n1\n2,3\n"), ":3: has 1 cells, the header has 2. Repair the row");
  EXPECT_EQ(refusal("t_s,vbat_V\n,1\n"), ":2: t_s: time '' is not a finite number. Repair the row");
  EXPECT_EQ(refusal("t_s,vbat_V,vbat_V\n0,1,2\n"), ":1: column 'vbat_V' appears twice. Rename one of them");
  EXPECT_EQ(refusal("t_s,px_m,py_m\n0,1,2\n"),
            ":1: column pz_m is missing beside the others of position. Add it, or remove the others");
  EXPECT_EQ(refusal("t_s,vbat_V\n"),
            ": contains no sample of any known signal. Describe its columns with --map FILE");
  EXPECT_EQ(refusal(""), ": is empty. Give a recording");
  EXPECT_NE(refusal("hello world\n"), "accepted");
  EXPECT_NE(refusal(std::string(5000, ',') + "\n1\n"), "accepted");
  EXPECT_NE(refusal("t_s," + std::string(2 << 20, 'x') + "\n1,2\n"), "accepted");
  EXPECT_NE(refusal(std::string("t_s\0,vbat_V\n0,1\n", 16)), "accepted");
}

TEST_F(Csv, SemicolonsDecimalCommasTabsAndQuotesAreRead) {
  const auto r = read("t_s;vbat_V;\"rotor1_radps\";rotor2_radps\n0,00;11,1;-1,5e2;\n0,01;;151;\"152,25\"\n");
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_EQ(r->find("vbat")->values(0, 0), 11.1);
  EXPECT_EQ(r->find("rotor_speed")->t_s, std::vector<double>{0.01});
  EXPECT_EQ(r->find("rotor_speed")->values(0, 1), 152.25);
  EXPECT_TRUE(has_note(*r, "decimal commas"));
  EXPECT_EQ(read("t_s\tvbat_V\n0,5\t11,1\n")->find("vbat")->values(0, 0), 11.1);
  EXPECT_EQ(read("t_s\tvbat_V\n0.5\t11.1\n")->find("vbat")->values(0, 0), 11.1);
  EXPECT_EQ(read("t_s;vbat_V\n0.5;11.1\n")->notes.size(), 0u);
  EXPECT_EQ(read("t_s,\"remark, of mine\",vbat_V\n0,\"a, b\",11.1\n")->find("vbat")->values(0, 0), 11.1);
}

TEST_F(Csv, ADecimalMarkIsNeverGuessed) {
  EXPECT_EQ(
      refusal("t_s;vbat_V\n0,1;11\n0,2;1.234\n"),
      ":3: vbat_V: '1.234': the table has decimal commas (line 2) and points (line 3). Export it with one "
      "decimal mark and without groups of thousands");
  EXPECT_EQ(refusal("t_s;vbat_V\n0;1.234,5\n"),
            ":2: vbat_V: '1.234,5' is not a finite number. Correct the cell or leave it empty");
  EXPECT_EQ(refusal("t_s;vbat_V\n0;1,2,3\n"),
            ":2: vbat_V: '1,2,3' is not a finite number. Correct the cell or leave it empty");
  EXPECT_EQ(refusal("t_s,vbat_V\n0,11,1\n"),
            ":2: has 3 cells, the header has 2. Repair the row; numbers with decimal commas need semicolons "
            "between cells");
  EXPECT_EQ(refusal("t_s,vbat_V\n0,\"11,1\"\n"),
            ":2: vbat_V: '11,1' is not a finite number. Correct the cell or leave it empty");
}

TEST_F(Csv, ACellMayHoldAllComponents) {
  const auto r = read(
      "t_s,gyro,attitude,rotor_speed\n0,\"[0.1, -0.2, 3e-1]\",\"(1 0 0 0)\",100 101 102\n"
      "0.1,,1;0;0;0,103 104 105\n0.2,\"[1, 2]\",[],\n");
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_EQ(r->find("gyro")->values, Eigen::RowVector3d(0.1, -0.2, 0.3));
  EXPECT_EQ(r->find("attitude")->size(), 2);
  EXPECT_EQ(r->find("rotor_speed")->values(1, 2), 105);
  EXPECT_TRUE(has_note(*r, "gyro: 1 rows have only some of its cells (first in line 4)"));
  EXPECT_EQ(
      refusal("t_s,gyro\n0,[1 2 x]\n"),
      ":2: gyro: '[1 2 x]' is not a finite number. Write finite numbers with decimal points, as [0.1, 0.2, "
      "9.8], or leave it empty");
  EXPECT_NE(refusal("t_s,gyro\n0,[1 2 3\n").find(":2: gyro"), std::string::npos);
  EXPECT_NE(refusal("t_s,gyro\n0,[1 2 inf]\n").find(":2: gyro"), std::string::npos);
  std::string bomb;
  for (int i = 0; i < 101; ++i) bomb += "1 ";
  EXPECT_NE(refusal("t_s,rotor_speed\n0," + bomb + "\n").find(":2: rotor_speed"), std::string::npos);
  EXPECT_EQ(refusal("t_s,gyro,gyro_x_radps\n0,1 2 3,1\n"),
            ":1: column 'gyro' is a list of what other columns have, too. Remove it, or the others");
}

TEST_F(Csv, AMapNamesListsAndTheirOrder) {
  const fs::path map = file.string() + ".yaml";
  const auto with_map = [&](const std::string& signals) {
    std::ofstream(map) << "schema: omniflight.csv_map/1\ntime: {column: ms, scale: 0.001}\nsignals:\n"
                       << signals;
    return read("ms;q;a\n1;[0, 0, 0, 1];[0 0 1]\n2,5;[0, 0, 0.6, 0.8];[0 0 1]\n", {.map = map});
  };
  const auto r = with_map(
      "  - {signal: attitude, list: q, quaternion: xyzw}\n  - {signal: acc, list: a, scale: 9.81}\n");
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_EQ(r->find("attitude")->values.row(0), Eigen::RowVector4d(1, 0, 0, 0));
  EXPECT_NEAR(r->find("attitude")->values(1, 3), 0.6, 1e-12);
  EXPECT_EQ(r->find("acc")->values(0, 2), 9.81);
  EXPECT_NEAR(r->find("acc")->t_s[1], 0.0025, 1e-15);
  const auto message = [&](const std::string& signals) { return with_map(signals).error().text(); };
  EXPECT_NE(message("  - {signal: acc, list: b}\n").find("no column 'b'"), std::string::npos);
  EXPECT_NE(message("  - {signal: acc, list: a, columns: [a]}\n").find("Keep one"), std::string::npos);
  EXPECT_NE(message("  - {signal: acc, list: a, quaternion: xyzw}\n").find("Leave it out"),
            std::string::npos);
  EXPECT_NE(message("  - {signal: attitude, list: q, quaternion: zyxw}\n").find("Use wxyz"),
            std::string::npos);
  fs::remove(map);
}

TEST_F(Csv, CutOrChangedAnywhereItIsReadOrRefused) {
  std::string text = "t_s;gyro;vbat_V;\"px_m\";py_m;pz_m\n";
  for (int k = 0; k < 20; ++k)
    text += "0," + std::to_string(10 + k) + ";[0.1, " + std::to_string(k) + " 3];11,5;\"0,5\";1;2\n";
  for (std::size_t size = 0; size < text.size(); ++size) {
    const auto r = read(text.substr(0, size));
    EXPECT_TRUE(!r || r->lost_anything() || text[size - 1] == '\n') << size;
    std::string changed = text;
    changed[size] = static_cast<char>(changed[size] ^ (1 << size % 8));
    (void)read(changed);
  }
}

TEST_F(Csv, ACutLastRowIsToldAndRepeatedTimesAreLeftOut) {
  const auto r = read("t_s,vbat_V\n0,1\n0,2\n1,3\n2");
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_TRUE(r->lost_anything());
  EXPECT_EQ(r->find("vbat")->values.col(0), Eigen::Vector2d(1, 3));
}

TEST_F(Csv, AMapNamesForeignColumns) {
  const fs::path map = file.string() + ".yaml";
  LoadOptions options;
  options.map = map;
  const auto with_map = [&](const std::string& yaml) {
    std::ofstream(map) << yaml;
    return read("us,volt\n1000000,3700\n2000000,3600\n", options);
  };
  const std::string head = "schema: omniflight.csv_map/1\ntime: {column: us, scale: 1.0e-6}\nsignals:\n";
  const auto r = with_map(head + "  - {signal: vbat, columns: [volt], scale: 0.001, offset: 0.5}\n");
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_NEAR(r->find("vbat")->values(1, 0), 4.1, 1e-12);
  EXPECT_NEAR(r->find("vbat")->t_s[1], 2.0, 1e-12);
  const auto message = [&](const std::string& yaml) { return with_map(yaml).error().text(); };
  EXPECT_NE(message(head + "  - {signal: vbat, columns: [vlt]}\n").find("Did you mean 'volt'?"),
            std::string::npos);
  EXPECT_NE(message(head + "  - {signal: vbatt, columns: [volt]}\n").find("Did you mean 'vbat'?"),
            std::string::npos);
  EXPECT_NE(message(head + "  - {signal: gyro, columns: [volt]}\n").find("has 3 components"),
            std::string::npos);
  EXPECT_NE(message(head + "  - {signal: vbat, columns: [volt], skale: 2}\n").find("Did you mean 'scale'?"),
            std::string::npos);
  fs::remove(map);
}

TEST_F(Csv, AForeignTableIsRecognisedByAllItsColumns) {
  const fs::path configs = file.string() + "_configs";
  fs::create_directories(configs / "csv_maps");
  fs::create_directories(configs / "vehicles");
  std::ofstream(configs / "csv_maps/board.yaml")
      << "schema: omniflight.csv_map/1\ntime: {column: us, scale: 1.0e-6}\nsignals:\n"
         "  - {signal: vbat, columns: [volt], scale: 0.001}\n";
  setenv("OMNIFLIGHT_CONFIGS", configs.c_str(), 1);
  const auto r = read("us,volt\n1000000,3700\n2000000,3600\n");
  EXPECT_EQ(refusal("us,volts\n1000000,3700\n").substr(0, 39), ":1: there is no column t_s (time in sec");
  LoadOptions by_name;
  by_name.map = "board";
  EXPECT_TRUE(read("us,volt,more\n1,3700,0\n", by_name));
  EXPECT_EQ(read("t_s,us,volt,vbat_V\n0,1,3700,3.5\n")->find("vbat")->values(0, 0), 3.5);  // it is canonical
  unsetenv("OMNIFLIGHT_CONFIGS");
  fs::remove_all(configs);
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_NEAR(r->find("vbat")->values(1, 0), 3.6, 1e-12);
  ASSERT_EQ(r->notes.size(), 1u);
  EXPECT_EQ(r->notes[0].text, "its columns were read as the map board says");
  EXPECT_FALSE(r->lost_anything());
}

TEST_F(Csv, ARecordingExportedToCsvReadsBackExactly) {
  const fs::path mcap = file.string() + ".mcap";
  sample::write_flight(mcap, 300, 10000);
  const auto a = load(mcap).value();
  sample::need(write_csv(a, file));
  const auto b = load(file);
  ASSERT_TRUE(b) << b.error().text();
  EXPECT_EQ(a.signal_names(), b->signal_names());
  for (const auto& name : a.signal_names()) {
    EXPECT_EQ(a.find(name)->t_s, b->find(name)->t_s) << name;
    EXPECT_TRUE(a.find(name)->values.isApprox(b->find(name)->values, 1e-15)) << name;
  }
  fs::remove(mcap);
}

TEST_F(Csv, EveryCanonicalSignalSurvivesTheExport) {
  Recording r;
  for (const SignalSpec& spec : canonical_signals()) {
    Signal s;
    s.name = spec.name;
    s.t_s = {0.0, 0.1};
    s.values = Eigen::MatrixXd::Constant(2, spec.width > 0 ? spec.width : 5, 0.5);
    r.signals[s.name] = s;
  }
  const auto back = read(to_csv(r));
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(back->signal_names(), r.signal_names());
  for (const auto& name : r.signal_names()) EXPECT_EQ(back->find(name)->values, r.find(name)->values) << name;
}

TEST(Signals, ResamplingIsLinearSphericalAndHonoursGaps) {
  Signal line{"vbat", "V", {0, 1, 5}, Eigen::Vector3d(0, 2, 6), ""};
  const auto v = resample(line, {-1, 0, 0.25, 1, 3, 5, 6, 0.5}, 2.0);
  EXPECT_TRUE(std::isnan(v(0, 0)) && std::isnan(v(4, 0)) && std::isnan(v(6, 0)));
  EXPECT_EQ(v(2, 0), 0.5);
  EXPECT_EQ(v(5, 0), 6);
  EXPECT_EQ(v(7, 0), 1);
  Signal turn{"attitude", "1", {0, 1}, Eigen::MatrixXd(2, 4), ""};
  turn.values << 1, 0, 0, 0, -std::cos(0.5), 0, 0, -std::sin(0.5);  // 1 rad about z, other sign
  const auto q = resample(turn, {0.5});
  EXPECT_NEAR(std::abs(q(0, 0)), std::cos(0.25), 1e-12);
  const auto rate = rate_of_attitude(turn);
  EXPECT_NEAR(rate.values(0, 2), 1.0, 1e-12);
  EXPECT_EQ(window(line, 0.5, 1.0).t_s, std::vector<double>{1});
}

TEST(Signals, AKnownLagIsFoundWithinItsStandardError) {
  const double lag = 0.0137;
  double worst = 0, inside = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::srand(seed);
    Signal a{"gyro", "rad/s", {}, Eigen::MatrixXd(2000, 1), ""}, b = a;
    for (int i = 0; i < 2000; ++i) {
      const double t = 0.005 * i, tb = 0.0031 + 0.005 * i;
      const auto f = [](double x) { return std::sin(3 * x) + 0.5 * std::sin(11 * x + 1); };
      a.t_s.push_back(t);
      b.t_s.push_back(tb);
      a.values(i, 0) = f(t) + 0.02 * Eigen::internal::random<double>(-1, 1);
      b.values(i, 0) = 2 * f(tb - lag) + 0.1 * Eigen::internal::random<double>(-1, 1);
    }
    const auto e = estimate_lag(a, b);
    ASSERT_TRUE(e) << e.error().text();
    EXPECT_NEAR(e->gain, 2.0, 0.05);
    worst = std::max(worst, std::abs(e->lag_s - lag));
    inside += std::abs(e->lag_s - lag) < 2.5 * e->standard_error_s;
  }
  EXPECT_LT(worst, 0.002);
  EXPECT_GE(inside, 17);
}

TEST(Signals, ALagOfAMotionThatRepeatsItselfHasARivalAndHalfAPeriodIsNone) {
  const auto swing = [](double period, double lag) {
    Signal s{"gyro", "rad/s", {}, Eigen::MatrixXd(4000, 1), ""};
    for (int i = 0; i < 4000; ++i) {
      s.t_s.push_back(0.01 * i);
      s.values(i, 0) = std::sin(2 * std::numbers::pi * (0.01 * i - lag) / period);
    }
    return s;
  };
  // a quarter late of 4 s, or a quarter early with the opposite sign
  const auto opposite = estimate_lag(swing(4, 0), swing(4, 1), {.max_lag_s = 1.9});
  ASSERT_TRUE(opposite) << opposite.error().text();
  EXPECT_GT(opposite->rival, 0.95);
  const auto same = estimate_lag(swing(4, 0), swing(4, 1), {.max_lag_s = 1.9, .same_sign = true});
  ASSERT_TRUE(same) << same.error().text();
  EXPECT_NEAR(same->lag_s, 1, 0.01);
  EXPECT_LT(same->rival, 0.5);
  const auto quick = estimate_lag(swing(1.5, 0), swing(1.5, 0.4), {.max_lag_s = 1.9, .same_sign = true});
  ASSERT_TRUE(quick) << quick.error().text();
  EXPECT_GT(quick->rival, 0.95);
}

}  // namespace
