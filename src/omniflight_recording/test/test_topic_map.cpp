// The topic table must fit the message definitions of the workspace.
#include <gtest/gtest.h>

#include "../src/message_decoder.hpp"
#include "../src/topic_map.hpp"
#include "sample_bag.hpp"

namespace fs = std::filesystem;
using namespace omniflight::recording;

TEST(TopicMap, EveryFieldExistsInItsMessageDefinition) {
  const fs::path root = fs::path(OMNIFLIGHT_SOURCE_ROOT) / "src/omniflight_msgs/msg";
  std::string all;
  for (const auto& entry : fs::recursive_directory_iterator(root))
    if (entry.path().extension() == ".msg")
      all += "\n" + std::string(80, '=') + "\nMSG: " + entry.path().parent_path().filename().string() + "/" +
             entry.path().stem().string() + "\n" + sample::slurp(entry.path());
  for (const TopicEntry& entry : own_topics()) {
    std::vector<std::string> wanted{"header.stamp.sec", "header.stamp.nanosec"};
    for (const TopicSignal& signal : entry.signals) {
      EXPECT_NE(find_spec(signal.signal), nullptr) << signal.signal;
      wanted.insert(wanted.end(), signal.fields.begin(), signal.fields.end());
    }
    const auto types = parse_ros_definition(entry.type, sample::slurp(root / (entry.type + ".msg")) + all);
    ASSERT_TRUE(types) << types.error().text();
    const auto decoder = MessageDecoder::create(entry.type, *types, wanted, Encoding::xcdr1);
    ASSERT_TRUE(decoder) << decoder.error().text();
    for (std::size_t i = 0; i < wanted.size(); ++i)
      EXPECT_TRUE(decoder->has(i)) << entry.type << " " << wanted[i];
  }
}
