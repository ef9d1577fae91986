#include <gtest/gtest.h>
#include <lz4frame.h>
#include <unistd.h>

#include <algorithm>
#include <random>

#include "../src/mcap_records.hpp"
#include "../src/message_decoder.hpp"
#include "omniflight_recording/mcap_reader.hpp"
#include "real_data.hpp"
#include "sample_bag.hpp"
#include "sample_bag1.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

class Mcap : public testing::Test {
 protected:
  fs::path file = fs::temp_directory_path() / ("omniflight_mcap_" + std::to_string(::getpid()) + ".mcap");
  void TearDown() override { fs::remove(file); }
};

bool prefix_of(const Signal* part, const Signal* whole) {
  if (!part) return true;
  return whole && part->size() <= whole->size() && part->values == whole->values.topRows(part->size());
}
bool same(const Recording& a, const Recording& b) {
  return a.signal_names() == b.signal_names() && prefix_of(a.find("gyro"), b.find("gyro")) &&
         prefix_of(b.find("gyro"), a.find("gyro")) && prefix_of(a.find("position"), b.find("position")) &&
         prefix_of(b.find("position"), a.find("position"));
}

TEST_F(Mcap, WhatIsWrittenIsReadBack) {
  const std::uint64_t start = 1'700'000'000'123'456'789;  // an epoch time must not cost precision
  sample::write_flight(file, 2000, 64 * 1024, start);
  const auto r = load(file);
  ASSERT_TRUE(r) << r.error().text();
  EXPECT_EQ(r->format, "mcap");
  EXPECT_TRUE(r->notes.empty()) << r->notes.front().text;
  EXPECT_EQ(r->sha256.size(), 64u);
  EXPECT_EQ(r->find("gyro")->size(), 2000);
  EXPECT_EQ(r->find("position")->size(), 200);
  EXPECT_NEAR(r->start_s, 1'700'000'000.123456789, 1e-6);
  EXPECT_NEAR(r->find("gyro")->t_s[1999], 1.999, 1e-12);
  EXPECT_EQ(r->find("acc")->values(0, 0), 0.1);
  const double t = 1e-9 * static_cast<double>(start);
  EXPECT_NEAR(r->find("attitude")->values(0, 0), std::cos(t / 2), 1e-6);  // w first
  EXPECT_EQ(r->find("gyro")->source, "/omniflight/imu angular_velocity.x");
  EXPECT_EQ(r->metadata.at("omniflight.hashes.vehicle"), "abc");
  EXPECT_EQ(r->metadata.at("omniflight.dropped./omniflight/imu"), "0");
  EXPECT_EQ(r->metadata.at("attachment.vehicle.yaml"), "mass: 1\n");
  EXPECT_DOUBLE_EQ(r->duration_s, 1.999);
}

TEST_F(Mcap, CutAtEveryByteItKeepsAMonotonePrefixAndTellsTheLoss) {
  sample::write_flight(file, 60, 2000);
  const std::string bytes = sample::slurp(file);
  const auto whole = sample::read_bytes(bytes).value();
  Eigen::Index before = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto r = sample::read_bytes(std::string_view(bytes).substr(0, size));
    if (!r) {
      ASSERT_EQ(before, 0) << size;
      continue;
    }
    ASSERT_TRUE(r->lost_anything()) << size;
    ASSERT_TRUE(prefix_of(r->find("gyro"), whole.find("gyro"))) << size;
    ASSERT_TRUE(prefix_of(r->find("position"), whole.find("position"))) << size;
    const Eigen::Index now = r->find("gyro") ? r->find("gyro")->size() : 0;
    ASSERT_GE(now, before) << size;
    before = now;
  }
  EXPECT_EQ(before, 60);
}

TEST_F(Mcap, FlippedBitsAreNoticedOrHarmless) {
  sample::write_flight(file, 60, 2000);
  const std::string bytes = sample::slurp(file);
  const auto whole = sample::read_bytes(bytes).value();
  std::mt19937_64 random(1);
  int refused = 0, noticed = 0, harmless = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = bytes;
    const std::size_t bit = random() % (8 * bytes.size());
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const auto r = sample::read_bytes(damaged);
    if (!r) {
      ++refused;
    } else if (r->lost_anything()) {
      ++noticed;
    } else {
      ASSERT_TRUE(same(*r, whole)) << "bit " << bit;
      ++harmless;
    }
  }
  EXPECT_GT(noticed, 1900);
  EXPECT_LT(refused, 20);
  EXPECT_LT(harmless, 20);
}

TEST_F(Mcap, ADamagedChunkIsLeftOutAndItsMessagesAreCounted) {
  sample::write_flight(file, 200, 8000);
  const std::string bytes = sample::slurp(file);
  const auto whole = sample::read_bytes(bytes).value();
  const std::size_t first = bytes.find("zstd"), second = bytes.find("zstd", first + 4);
  std::string damaged = bytes;
  damaged[second + 40] = static_cast<char>(damaged[second + 40] ^ 0x10);  // inside the compressed records
  const auto r = sample::read_bytes(damaged).value();
  std::uint64_t lost = 0;
  for (const Note& n : r.notes) lost += n.kind == Note::Kind::loss ? n.messages : 0;
  const auto missing = [&](const char* s) { return whole.find(s)->size() - r.find(s)->size(); };
  EXPECT_GT(missing("gyro"), 5);
  EXPECT_GE(static_cast<Eigen::Index>(lost), missing("gyro") + missing("position"));
  EXPECT_EQ(r.find("gyro")->t_s.back(), whole.find("gyro")->t_s.back());  // everything behind it is there

  damaged = bytes;
  damaged[second - 4 - 4 - 24 - 3] =
      '\x7f';  // the length of that chunk record: the scan must find the next one
  const auto s = sample::read_bytes(damaged).value();
  EXPECT_TRUE(s.lost_anything());
  EXPECT_EQ(s.find("gyro")->t_s.back(), whole.find("gyro")->t_s.back());
}

TEST_F(Mcap, UncompressedAndLz4ChunksAreRead) {
  using mcap::Bytes;
  for (const std::string compression : {"", "lz4"}) {
    std::string records;
    for (std::uint32_t i = 0; i < 10; ++i)
      records += mcap::record(mcap::kMessage, Bytes()
                                                  .put(std::uint16_t{7})
                                                  .put(i)
                                                  .put(i * std::uint64_t{1000000})
                                                  .put(std::uint64_t{0})
                                                  .raw(sample::imu_message(i * 1000000))
                                                  .text());
    std::string packed = records;
    if (compression == "lz4") {
      packed.resize(LZ4F_compressFrameBound(records.size(), nullptr));
      packed.resize(
          LZ4F_compressFrame(packed.data(), packed.size(), records.data(), records.size(), nullptr));
    }
    const auto topic = sample::imu_topic();
    const std::string file_bytes =
        std::string(mcap::kMagic) +
        mcap::record(mcap::kHeader, Bytes().string("ros2").string("other").text()) +
        mcap::record(mcap::kSchema, Bytes()
                                        .put(std::uint16_t{3})
                                        .string(topic.type)
                                        .string("ros2msg")
                                        .string(topic.schema_text)
                                        .text()) +
        mcap::record(mcap::kChannel, Bytes()
                                         .put(std::uint16_t{7})
                                         .put(std::uint16_t{3})
                                         .string(topic.topic)
                                         .string("cdr")
                                         .strings({})
                                         .text()) +
        mcap::record(mcap::kChunk, Bytes()
                                       .put(std::uint64_t{0})
                                       .put(std::uint64_t{9000000})
                                       .put(static_cast<std::uint64_t>(records.size()))
                                       .put(mcap::crc32_of(records))
                                       .string(compression)
                                       .put(static_cast<std::uint64_t>(packed.size()))
                                       .raw(packed)
                                       .text()) +
        mcap::record(mcap::kDataEnd, Bytes().put(std::uint32_t{0}).text()) +
        mcap::record(mcap::kFooter,
                     Bytes().put(std::uint64_t{0}).put(std::uint64_t{0}).put(std::uint32_t{0}).text()) +
        std::string(mcap::kMagic);
    const auto r = sample::read_bytes(file_bytes);
    ASSERT_TRUE(r) << r.error().text();
    EXPECT_FALSE(r->lost_anything()) << r->notes.front().text;
    ASSERT_NE(r->find("gyro"), nullptr);
    EXPECT_EQ(r->find("gyro")->size(), 10);
    EXPECT_NEAR(r->find("gyro")->values(9, 2), 0.009, 1e-12);
  }
}

TEST_F(Mcap, BagsOfRos1ThatWereConvertedAreRead) {
  using mcap::Bytes;
  const auto channel = [](std::uint16_t id, const std::string& topic, const std::string& encoding) {
    return mcap::record(
        mcap::kChannel,
        Bytes().put(id).put(std::uint16_t{3}).string(topic).string(encoding).strings({}).text());
  };
  std::string bytes = std::string(mcap::kMagic) +
                      mcap::record(mcap::kHeader, Bytes().string("ros1").string("other").text()) +
                      mcap::record(mcap::kSchema, Bytes()
                                                      .put(std::uint16_t{3})
                                                      .string("sensor_msgs/Imu")
                                                      .string("ros1msg")
                                                      .string(sample::imu_definition1())
                                                      .text()) +
                      channel(1, "/imu", "ros1") + channel(2, "/b/imu", "json");
  for (std::uint32_t k = 0; k < 30; ++k) {
    const std::uint64_t ns = k * std::uint64_t{1'000'000} + 1;
    bytes += mcap::record(mcap::kMessage, Bytes()
                                              .put(std::uint16_t{1})
                                              .put(k)
                                              .put(ns)
                                              .put(ns)
                                              .raw(sample::imu_message1(k, ns, sample::moment(1e-3 * k)))
                                              .text());
  }
  const auto r = sample::read_as("mcap", bytes).value();
  ASSERT_NE(r.find("gyro"), nullptr);
  ASSERT_EQ(r.find("gyro")->size(), 30);
  EXPECT_LT((Vec3(r.find("gyro")->values.row(7)) - sample::moment(0.007).w_B).norm(), 1e-9);
  const bool told = std::any_of(r.notes.begin(), r.notes.end(), [](const Note& n) {
    return n.text.find("'/b/imu' (sensor_msgs/Imu) cannot be decoded: its messages are 'json'") !=
           std::string::npos;
  });
  EXPECT_TRUE(told);
}

/// By the text of a definition, as ROS 2 has it.
Result<MessageDecoder> cdr_decoder(const std::string& type, const std::string& text,
                                   const std::vector<std::string>& wanted) {
  const auto types = parse_ros_definition(type, text);
  if (!types) return Failure(types.error());
  return MessageDecoder::create(type, *types, wanted, Encoding::xcdr1);
}

TEST(Cdr, DecodesEveryKindInBothByteOrdersAndRefusesCutMessages) {
  const std::string schema =
      "uint8 PHASE=1\nstring text \"a b\"\nbool flag\nint16[] list\nInner[2] inner\nfloat32 f\nuint64 "
      "big\n===\nMSG: p/Inner\nint8 a\nfloat64 b\n";
  const auto d = cdr_decoder("p/msg/Outer", schema, {"list", "inner.b", "f", "big", "nothing", "flag"});
  ASSERT_TRUE(d) << d.error().text();
  EXPECT_FALSE(d->has(4));
  sample::Cdr c;
  c.string("hello")
      .put(std::uint8_t{1})
      .put(std::uint32_t{3})
      .put(std::int16_t{-1})
      .put(std::int16_t{2})
      .put(std::int16_t{3});
  c.put(std::int8_t{5}).put(1.5).put(std::int8_t{6}).put(-2.5).put(0.25f).put(std::uint64_t{1} << 40);
  std::vector<std::vector<double>> out;
  ASSERT_TRUE(d->decode(c.text(), out));
  EXPECT_EQ(out[0], (std::vector<double>{-1, 2, 3}));
  EXPECT_EQ(out[1], (std::vector<double>{1.5, -2.5}));
  EXPECT_EQ(out[2], std::vector<double>{0.25});
  EXPECT_EQ(out[3], std::vector<double>{1099511627776.0});
  EXPECT_EQ(out[5], std::vector<double>{1});
  for (std::size_t size = 0; size < c.text().size(); ++size)
    EXPECT_FALSE(d->decode(std::string_view(c.text()).substr(0, size), out)) << size;
  std::string huge = c.text();
  huge.replace(4 + 4 + 6 + 2, 4, "\xff\xff\xff\xff");  // length of the list
  EXPECT_FALSE(d->decode(huge, out));

  const auto small = cdr_decoder("p/S", "float64 x\n", {"x"}).value();
  ASSERT_TRUE(small.decode(std::string_view("\0\0\0\0\x3f\xf8\0\0\0\0\0\0", 12), out));  // big endian
  EXPECT_EQ(out[0], std::vector<double>{1.5});
  EXPECT_FALSE(cdr_decoder("p/S", "Missing x\n", {"x"}));
  EXPECT_FALSE(cdr_decoder("p/S", "S x\n", {"x"}));  // contains itself
  EXPECT_FALSE(cdr_decoder("p/S", "float64\n", {"x"}));
  std::string wide = "A a0\n";  // 999 fields, each of 999 fields
  for (int i = 1; i < 999; ++i) wide += "A a" + std::to_string(i) + "\n";
  wide += "====\nMSG: p/A\n";
  for (int i = 0; i < 999; ++i) wide += "uint8 b" + std::to_string(i) + "\n";
  const auto refused = cdr_decoder("p/S", wide, {"a7.b3"});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("too many fields"), std::string::npos);
}

TEST(RealBags, EveryMcapBagOfOthersIsReadCompletely) {
  NEEDS_REAL_DATA("formats/rosbag2");
  // counted with the package @mcap/core 2 of npm
  const std::map<std::string, std::uint64_t> reference{
      {"rewriter_a_0.mcap", 150},      {"rewriter_b_0.mcap", 75},       {"talker.mcap", 20},
      {"multiple_files_0.mcap", 1324}, {"multiple_files_1.mcap", 1324}, {"multiple_files_2.mcap", 529},
      {"wbag_0.mcap", 1246},           {"wbag_1.mcap", 1240},           {"wbag_2.mcap", 1240},
      {"wbag_3.mcap", 1240},           {"wbag_4.mcap", 1108},           {"test_bag_for_seek_0.mcap", 5}};
  int bags = 0;
  for (const auto& entry : fs::recursive_directory_iterator(real_data("formats/rosbag2"))) {
    if (entry.path().extension() != ".mcap") continue;
    const std::string bytes = sample::slurp(entry.path());
    const auto content = scan_mcap(bytes, entry.path(), [](const McapChannel&, const McapMessage&) {});
    ASSERT_TRUE(content) << content.error().text();
    EXPECT_TRUE(content->complete) << entry.path() << ": "
                                   << (content->notes.empty() ? "" : content->notes.front().text);
    EXPECT_EQ(content->messages, reference.at(entry.path().filename().string())) << entry.path();
    ++bags;
  }
  EXPECT_GE(bags, 14);
}

}  // namespace
