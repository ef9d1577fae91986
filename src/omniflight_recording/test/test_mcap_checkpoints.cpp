// Bit flips in files that were never closed: schemas, topics, metadata, opcodes and lengths have no checksum
// of their own.
#include <gtest/gtest.h>

#include <iostream>

#include "omniflight_recording/mcap_reader.hpp"
#include "sample_bag.hpp"

namespace fs = std::filesystem;
using namespace omniflight;
using namespace omniflight::recording;

namespace {

/// A recording whose writer was killed after a while: header, metadata, attachment, two topics, some chunks.
std::string unclosed() {
  const fs::path file = fs::path(testing::TempDir()) / "unclosed.mcap";
  auto writer = McapWriter::create(file, {.overwrite = true}).value();
  EXPECT_TRUE(writer->write_metadata("omniflight", {{"vehicle", "omnimorph"}, {"synthetic", "yes"}}));
  EXPECT_TRUE(writer->write_attachment("certificate.json", "text/plain", 0, "{}"));
  const auto imu = writer->add_topic(sample::imu_topic()).value();
  const auto pose = writer->add_topic(sample::pose_topic()).value();
  for (std::uint32_t i = 0; i < 60; ++i) {
    const std::uint64_t ns = i * 3'000'000ull;  // two flush periods, so two chunks
    EXPECT_TRUE(writer->write(imu, i, ns, ns, sample::imu_message(ns), ns));
    if (i % 10 != 0) continue;
    EXPECT_TRUE(writer->write(pose, i / 10, ns, ns, sample::pose_message(ns), ns));
  }
  EXPECT_TRUE(writer->flush());
  return sample::slurp(file);  // as it lies on the disk when the process is killed here
}

/// Everything that a reader is told of a file.
struct Told {
  std::string text;
  std::size_t notes = 0;
};

Told told(const std::string& bytes) {
  Told out;
  const auto content = scan_mcap(bytes, "x", [&](const McapChannel& c, const McapMessage& m) {
    out.text += c.topic + c.schema.name + c.schema.text + std::to_string(m.log_ns) + std::string(m.data);
  });
  if (!content) {
    out.notes = 1000;
    return out;
  }
  for (const auto& [name, values] : content->metadata)
    for (const auto& [key, value] : values) out.text += name + key + value;
  for (const auto& [id, channel] : content->channels)
    for (const auto& [key, value] : channel.metadata) out.text += key + value;
  for (const auto& a : content->attachments) out.text += a.name + a.media_type + a.data;
  out.text += content->profile + content->library;
  out.notes = content->notes.size();
  return out;
}

TEST(Checkpoints, EveryBitFlipOfAnUnclosedFileThatChangesAnythingIsTold) {
  const std::string whole = unclosed();
  const Told sound = told(whole);
  ASSERT_EQ(sound.notes, 1u) << "only that the file was not closed";
  std::size_t flips = 0, changed = 0, silent = 0;
  std::string flipped = whole;
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      flipped[at] = static_cast<char>(whole[at] ^ (1 << bit));
      const Told now = told(flipped);
      flipped[at] = whole[at];
      ++flips;
      if (now.text == sound.text) continue;
      ++changed;
      if (now.notes > sound.notes) continue;
      ++silent;
      if (silent < 5) {
        ADD_FAILURE() << "byte " << at << " bit " << bit << " changes what is read and is not told";
      }
    }
  std::cout << flips << " flips, " << changed << " change what is read, " << silent << " of these silently\n";
  EXPECT_GT(changed, 1000u);
  EXPECT_EQ(silent, 0u);
}

TEST(Checkpoints, FilesOfOthersMayUseTheSameOpcode) {
  std::string bytes = unclosed();
  int replaced = 0;
  for (std::size_t at = 0; (at = bytes.find("omnicrc1", at)) != std::string::npos; ++replaced)
    bytes.replace(at, 8, "othermrk");
  EXPECT_GE(replaced, 5);
  EXPECT_EQ(told(bytes).notes, 1u);
}

}  // namespace
