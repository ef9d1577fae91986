// The file of a tilt over time: to the bit and back, and hostile ones.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "omniflight_components/tilt_schedule_file.hpp"

namespace omniflight::components {
namespace {

namespace fs = std::filesystem;

class TiltScheduleFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  Result<allocation::TiltSchedule> read(const std::string& text) {
    std::ofstream(folder_ / "tilt.yaml") << text;
    return read_tilt_schedule(folder_ / "tilt.yaml", tilt_);
  }
  fs::path folder_ = fs::temp_directory_path() / ("omniflight_tilt_" + std::to_string(::getpid()));
  vehicle::Tilt tilt_{vehicle::TiltKind::common, 0, to_radians(60), to_radians(30)};
};

TEST_F(TiltScheduleFile, IsReadAsWritten) {
  allocation::TiltSchedule s;
  s.period = 0.05;
  for (int k = 0; k < 100; ++k) s.alpha.push_back(std::min(tilt_.max, tilt_.rate * s.period * k));
  const auto back = read(tilt_schedule_text(s));
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(back->period, s.period);
  ASSERT_EQ(back->alpha.size(), s.alpha.size());
  for (std::size_t k = 0; k < s.alpha.size(); ++k) EXPECT_NEAR(back->alpha[k], s.alpha[k], 1e-9);
  EXPECT_NEAR(back->at(0.075), tilt_.rate * 0.075, 1e-9);
  EXPECT_EQ(back->at(-1), back->alpha.front());
  EXPECT_EQ(back->at(1e9), back->alpha.back());
}

TEST_F(TiltScheduleFile, EveryTruncationAndMistakeIsRefusedByName) {
  const std::string good = "schema: omniflight.tilt_schedule/1\nperiod_s: 0.1\nalpha_deg: [0, 1, 2]\n";
  ASSERT_TRUE(read(good));
  for (std::size_t n = 0; n + 2 < good.size(); ++n) EXPECT_FALSE(read(good.substr(0, n))) << n;
  const auto refused = [&](const std::string& from, const std::string& to, const char* field) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    const auto r = read(text);
    ASSERT_FALSE(r) << text;
    EXPECT_NE(r.error().text().find(field), std::string::npos) << r.error().text();
  };
  refused("schedule/1", "schedule/2", "schema");
  refused("0.1", "0", "period_s");
  refused("0.1", ".nan", "period_s");
  refused("[0, 1, 2]", "[]", "alpha_deg");
  refused("[0, 1, 2]", "[0, 1, 70]", "alpha_deg");
  refused("[0, 1, 2]", "[0, 10, 2]", "the servo does 30 deg/s");
  refused("[0, 1, 2]", "[0, .inf, 2]", "alpha_deg");
  refused("period_s", "pace_s", "p");
}

}  // namespace
}  // namespace omniflight::components
