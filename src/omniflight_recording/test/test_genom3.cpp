// Logs of rotorcraft-genom3, synthetic: whole, cut and changed.
#include <gtest/gtest.h>

#include <random>

#include "notes.hpp"
#include "omniflight_core/frames.hpp"
#include "sample_bag.hpp"
#include "sample_genom3.hpp"
#include "sample_ulog.hpp"

using namespace omniflight;
using namespace omniflight::recording;

namespace {

Result<Recording> read(std::string_view bytes) { return sample::read_as("genom3", bytes); }

TEST(Genom3, AHoverIsInSiUnitsAndHeldSamplesAreLeftOut) {
  const auto r = read(sample::genom3_log(1000));
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_FALSE(r->lost_anything());
  EXPECT_NEAR(r->start_s, 1.7e9, 1e-6);
  EXPECT_EQ(samples(*r, "gyro"), 500);
  EXPECT_EQ(samples(*r, "rotor_speed"), 100);
  EXPECT_EQ(samples(*r, "rotor_command"), 1000);
  ASSERT_EQ(r->find("rotor_speed")->width(), 6);
  ASSERT_EQ(r->find("rotor_command")->width(), 6);
  EXPECT_NEAR(r->find("rotor_command")->values(0, 2), 2 * kPi * 102, 1e-9);
  EXPECT_NEAR(r->find("rotor_speed")->values(50, 0), 2 * kPi * 100.5, 1e-9);
  EXPECT_NEAR(r->find("rotor_speed")->t_s[50], 0.5, 1e-6);
  EXPECT_NEAR(r->find("acc")->values(250, 2), 9.81 + 0.1 * std::sin(0.5), 1e-4);
  EXPECT_TRUE(has_note(*r, "rotor_speed: 900 rows repeat the sample before"));
}

TEST(Genom3, ItIsRecognisedByItsHeader) {
  for (const Format& format : formats())
    EXPECT_EQ(format.sniff(sample::genom3_log(3)), std::string(format.name) == "genom3") << format.name;
}

TEST(Genom3, SkippedSamplesAreALoss) {
  const auto r = read(sample::genom3_log(100, true)).value();
  EXPECT_TRUE(r.lost_anything());
  EXPECT_TRUE(has_note(r, "the logger could not keep up 1 times"));
}

TEST(Genom3, CutAnywhereItKeepsAPrefixAndTellsTheLoss) {
  const std::string text = sample::genom3_log(40);
  const auto whole = read(text).value();
  for (std::size_t size = text.find('\n') + 1; size < text.size(); ++size) {
    const auto r = read(std::string_view(text).substr(0, size));
    if (!r) continue;
    const Eigen::Index n = samples(*r, "gyro");
    ASSERT_TRUE(n == 0 || r->find("gyro")->values == whole.find("gyro")->values.topRows(n)) << size;
    ASSERT_TRUE(r->lost_anything() || text[size - 1] == '\n') << size;
  }
}

TEST(Genom3, ChangedBitsAreReadOrRefusedWithTheirLine) {
  const std::string text = sample::genom3_log(40);
  std::mt19937_64 random(5);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string changed = text;
    const std::size_t bit = random() % (8 * changed.size());
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
    const auto r = read(changed);
    if (r) continue;
    ++refused;
    EXPECT_NE(r.error().text().find(':'), std::string::npos);
  }
  EXPECT_GT(refused, 100);
  EXPECT_FALSE(read(text.substr(0, text.find('\n') + 1)));
}

}  // namespace
