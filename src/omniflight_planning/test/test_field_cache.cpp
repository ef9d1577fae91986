// Distance fields kept between runs: the same field, a damaged file, and files that go.
#include <gtest/gtest.h>

#include "../src/field_cache.hpp"
#include "missions.hpp"
#include "omniflight_core/random.hpp"
#include "omniflight_planning/octree_file.hpp"

namespace omniflight::planning {
namespace {

namespace fs = std::filesystem;

struct Cache : testing::Test {
  const fs::path folder =
      fs::path(testing::TempDir()) /
      (std::string("fields_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::path map_file;
  void SetUp() override {
    fs::remove_all(folder);
    map_file = map_of(0.6);
  }
  void TearDown() override { fs::remove_all(folder); }

  static fs::path map_of(double window) {
    return written("window_" + std::to_string(window) + ".bt",
                   octree_bytes(*make_octree(window_bed(window, window, 0.1)).value()).value());
  }
  DistanceMap load() const { return DistanceMap::load(map_file, {.cache = folder}).value(); }
  std::vector<fs::path> files() const {
    std::vector<fs::path> out;
    for (const auto& entry : fs::directory_iterator(folder)) out.push_back(entry.path());
    return out;
  }
};

void expect_same(const DistanceMap& a, const DistanceMap& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.lower(), b.lower());
  EXPECT_EQ(a.upper(), b.upper());
  EXPECT_EQ(a.sha256(), b.sha256());
  EXPECT_EQ(a.max_distance(), b.max_distance());
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = random.uniform(a.lower()[k] - 0.1, a.upper()[k] + 0.1);
    const auto here = a.distance_bounds(p), there = b.distance_bounds(p);
    ASSERT_EQ(here.lower, there.lower);
    ASSERT_EQ(here.upper, there.upper);
  }
}

TEST_F(Cache, AKeptFieldIsTheOneThatIsComputed) {
  const DistanceMap cold = load();
  ASSERT_EQ(files().size(), 1u);
  const auto written = fs::last_write_time(files()[0]);
  expect_same(load(), cold);
  expect_same(DistanceMap::load(map_file).value(), cold);
  EXPECT_EQ(fs::last_write_time(files()[0]), written) << "read, not computed again";
  EXPECT_EQ(load().cache_remark(), "");
}

TEST_F(Cache, ADamagedFileIsComputedAgainAndSaid) {
  const DistanceMap good = load();
  const fs::path file = files().at(0);
  const std::string bytes = files::read_file(file, 100u << 20).value();
  const auto hashed = [](std::string b) { return b.replace(0, 64, files::sha256_hex(b.substr(64))); };
  const auto with = [&](std::size_t at, const std::string& what) {
    return std::string(bytes).replace(at, what.size(), what);
  };
  const std::string nan("\x00\x00\xc0\x7f", 4), huge("\xff\xff\xff\x7f", 4), zero(4, '\0');
  const struct {
    const char* what;
    std::string bytes;
  } cases[] = {{"is truncated", ""},
               {"is truncated", bytes.substr(0, 100)},
               {"does not have its hash", bytes.substr(0, bytes.size() - 4)},
               {"does not have its hash", with(5000, "x")},
               {"has another format", hashed(with(64, "OFFLD0"))},
               {"has no size that a map may have", hashed(with(64 + 12, zero))},
               {"has no size that a map may have", hashed(with(64 + 12, huge))},
               {"does not have its size", hashed(bytes + "1234")},
               {"lies nowhere", hashed(with(64 + 24, std::string("\0\0\0\0\0\0\xf8\x7f", 8)))},
               {"holds what is no distance", hashed(with(bytes.size() - 4, nan))}};
  for (const auto& c : cases) {
    ASSERT_TRUE(files::write_file_atomic(file, c.bytes));
    const DistanceMap again = load();
    EXPECT_NE(again.cache_remark().find(c.what), std::string::npos) << c.what << ": " << again.cache_remark();
    EXPECT_NE(again.cache_remark().find("It is computed again"), std::string::npos) << again.cache_remark();
    expect_same(again, good);
    EXPECT_EQ(files::read_file(file, 100u << 20).value(), bytes) << "written again";
  }
}

TEST_F(Cache, AnotherMapOrPolicyHasAnotherFile) {
  load();
  ASSERT_TRUE(DistanceMap::load(map_of(0.9), {.cache = folder}));
  ASSERT_TRUE(DistanceMap::load(map_file, {.unknown = UnknownSpace::free, .cache = folder}));
  ASSERT_TRUE(DistanceMap::load(map_file, {.max_distance = 0.5, .cache = folder}));
  EXPECT_EQ(files().size(), 4u);
}

TEST_F(Cache, TheOldestFieldsGoWhenThereAreTooMany) {
  const StoredField small{{1, 1, 1}, Vec3::Zero(), 0.1, {0.5f}};
  for (int i = 0; i < 4; ++i) {
    const fs::path file = folder / (std::to_string(i) + ".field");
    write_field(file, small, 1000);
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(10 - i));
  }
  EXPECT_EQ(files().size(), 4u);
  const auto size = fs::file_size(folder / "0.field");
  write_field(folder / "4.field", small, 2 * size);
  EXPECT_TRUE(fs::exists(folder / "4.field"));
  EXPECT_TRUE(fs::exists(folder / "3.field"));
  EXPECT_EQ(files().size(), 2u);
}

TEST_F(Cache, AFolderThatCannotBeWrittenCostsNoPlan) {
  const fs::path file = written("no_folder", "a file");
  EXPECT_TRUE(DistanceMap::load(map_file, {.cache = file}));
}

TEST_F(Cache, MissingMapsAreRefusedInTheWordsOfTheReader) {
  const auto none = DistanceMap::load("no_such.bt", {.cache = folder});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().text(), read_octree("no_such.bt").error().text());
}

}  // namespace
}  // namespace omniflight::planning
