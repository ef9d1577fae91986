// What a ROS 2 node with another vendor's DDS sees of this bus: eProsima Fast DDS finds participants, topics
// and types, reads which nodes have them, and exchanges messages. Both run in this process, over UDP on
// loopback.
#include <algorithm>
#include <atomic>
#include <cstdlib>

#include "../bus_fixture.hpp"
#include "fast_dds_peer.hpp"
#include "messages.hpp"
#include "omniflight_bus/publisher.hpp"
#include "omniflight_bus/subscription.hpp"

namespace omniflight::bus {
namespace {

using msgs::geometry_msgs::PoseStamped;
using msgs::std_msgs::String;
using second_vendor::Entities;
using second_vendor::Gid;
using second_vendor::NodeEntities;
using second_vendor::Peer;

/// The GIDs of the endpoints of a topic, sorted.
std::vector<Gid> on_topic(const std::map<Gid, second_vendor::Found>& found, const std::string& topic) {
  std::vector<Gid> out;
  for (const auto& [gid, endpoint] : found)
    if (endpoint.topic == topic) out.push_back(gid);
  return out;
}

std::string topics_of(const std::map<Gid, second_vendor::Found>& found) {
  std::string out;
  for (const auto& [gid, endpoint] : found) out += endpoint.topic + " ";
  return out;
}

/// A GID as a message of `bytes` a GID carries it: the GUID, then zeros.
std::vector<std::uint8_t> as_sent(const Gid& gid, std::size_t bytes) {
  std::vector<std::uint8_t> out(gid.begin(), gid.end());
  out.resize(bytes, 0);
  return out;
}

const NodeEntities* node_called(const std::vector<NodeEntities>& nodes, const std::string& name) {
  const auto at = std::find_if(nodes.begin(), nodes.end(), [&](const auto& n) { return n.name == name; });
  return at == nodes.end() ? nullptr : &*at;
}

class FastDds : public BusTest {
 protected:
  void TearDown() override { unsetenv("OMNIFLIGHT_ROS_DISTRO"); }
  /// Takes samples until one satisfies the condition; false after 10 s.
  template <class T, class Condition>
  static bool take_until(
      second_vendor::dds::DataReader* reader, T& sample, Condition condition,
      const std::function<void()>& between = [] {}) {
    return eventually(
        [&] {
          between();
          second_vendor::dds::SampleInfo info;
          while (reader->take_next_sample(&sample, &info) ==
                 eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
            if (info.valid_data && condition()) return true;
          return false;
        },
        10s);
  }
  /// Two nodes and an endpoint of none: what is told agrees with what discovery finds, and follows what goes.
  template <std::size_t bytes>
  void expect_the_graph_to_be_told() {
    const Participant participant = join();
    auto controller = std::make_optional(participant.as_node("controller"));
    const auto allocator = participant.as_node("allocator");
    ASSERT_TRUE(controller->has_value() && allocator);
    auto poses = std::make_optional(Publisher<PoseStamped>::create(**controller, "/pose"));
    const auto words = Publisher<String>::create(*allocator, "/words");
    auto heard = Subscription<PoseStamped>::create(*allocator, "/pose");
    const auto of_none = Publisher<String>::create(participant, "/of_none");
    ASSERT_TRUE(poses->has_value() && words && heard && of_none);

    Peer peer(claim->domain());
    auto* reader =
        peer.reader<Entities<bytes>>("ros_discovery_info", second_vendor::kEntitiesType, /*latched=*/true);
    Entities<bytes> told;
    ASSERT_TRUE(take_until(reader, told, [&] { return told.nodes.size() == 2; }));
    ASSERT_TRUE(eventually([&] { return peer.writers().size() == 4 && peer.readers().size() == 1; }, 10s))
        << topics_of(peer.writers()) << "read: " << topics_of(peer.readers());
    const auto writers = peer.writers(), readers = peer.readers();

    ASSERT_EQ(peer.participants().size(), 1u);
    EXPECT_EQ(told.gid, as_sent(*peer.participants().begin(), bytes));
    const NodeEntities* c = node_called(told.nodes, "controller");
    const NodeEntities* a = node_called(told.nodes, "allocator");
    ASSERT_TRUE(c != nullptr && a != nullptr);
    EXPECT_EQ(c->name_space, "/");
    using Gids = std::vector<std::vector<std::uint8_t>>;
    EXPECT_EQ(c->writers, Gids{as_sent(on_topic(writers, "rt/pose").at(0), bytes)});
    EXPECT_EQ(c->readers, Gids{});
    EXPECT_EQ(a->writers, Gids{as_sent(on_topic(writers, "rt/words").at(0), bytes)});
    EXPECT_EQ(a->readers, Gids{as_sent(on_topic(readers, "rt/pose").at(0), bytes)});

    poses.reset();
    EXPECT_TRUE(take_until(reader, told, [&] {
      const NodeEntities* still = node_called(told.nodes, "controller");
      return told.nodes.size() == 2 && still != nullptr && still->writers.empty();
    })) << "the publisher has gone";
    controller.reset();
    EXPECT_TRUE(take_until(reader, told, [&] {
      return told.nodes.size() == 1 && told.nodes[0].name == "allocator";
    })) << "the node has gone";
  }
};

TEST_F(FastDds, FindsParticipantTopicsAndTypesAsRos2NamesThem) {
  const Participant participant = join();
  const auto poses = Publisher<PoseStamped>::create(participant, "/omni/pose");
  const auto words = Subscription<String>::create(participant, "/omni/words");
  ASSERT_TRUE(poses && words);
  const Peer peer(claim->domain());
  ASSERT_TRUE(eventually([&] { return peer.writers().size() == 2 && peer.readers().size() == 1; }, 10s))
      << topics_of(peer.writers()) << "read: " << topics_of(peer.readers());
  EXPECT_EQ(peer.participants().size(), 1u);
  const auto writers = peer.writers(), readers = peer.readers();
  const auto pose = on_topic(writers, "rt/omni/pose"), told = on_topic(writers, "ros_discovery_info");
  ASSERT_TRUE(pose.size() == 1 && told.size() == 1);
  EXPECT_EQ(writers.at(pose[0]).type, "geometry_msgs::msg::dds_::PoseStamped_");
  EXPECT_EQ(writers.at(told[0]).type, "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_");
  EXPECT_EQ(readers.begin()->second.topic, "rt/omni/words");
  EXPECT_EQ(readers.begin()->second.type, "std_msgs::msg::dds_::String_");
}

TEST_F(FastDds, ReadsWhichNodesHaveTheEndpointsItFinds) { expect_the_graph_to_be_told<16>(); }

TEST_F(FastDds, ReadsThemAsHumbleHasThem) {
  setenv("OMNIFLIGHT_ROS_DISTRO", "humble", 1);
  expect_the_graph_to_be_told<24>();
}

TEST_F(FastDds, ReadsAPoseOfOurs) {
  const Participant participant = join();
  auto publisher = Publisher<PoseStamped>::create(participant, "/omni/pose");
  ASSERT_TRUE(publisher);
  Peer peer(claim->domain());
  auto* reader = peer.reader<second_vendor::Pose>("rt/omni/pose", second_vendor::kPoseType, false);
  ASSERT_TRUE(publisher->wait_for_peers(1, 10s));
  Message<PoseStamped> sent;
  sent->header.stamp = {1, 2};
  set_text(sent->header.frame_id, "map");
  sent->pose.position = {1.5, -2.5, 3.25};
  sent->pose.orientation = {0.0, 0.6, 0.0, 0.8};
  second_vendor::Pose read;
  // Each side learns of the other at its own time: what is sent in between is not delivered.
  ASSERT_TRUE(take_until(
      reader, read, [&] { return read.sec == 1; }, [&] { (void)publisher->publish(*sent, 1); }));
  EXPECT_EQ(read.sec, 1);
  EXPECT_EQ(read.nanosec, 2u);
  EXPECT_EQ(read.frame, "map");
  EXPECT_EQ(read.numbers, (std::array<double, 7>{1.5, -2.5, 3.25, 0.0, 0.6, 0.0, 0.8}));
}

TEST_F(FastDds, IsReadByUs) {
  const Participant participant = join();
  std::atomic<int> count{0};
  std::array<double, 7> seen{};
  auto subscription = Subscription<PoseStamped>::create(participant, "/omni/pose", Qos::standard(),
                                                        [&](const PoseStamped& m, std::int64_t) {
                                                          const auto& p = m.pose.position;
                                                          const auto& q = m.pose.orientation;
                                                          seen = {p.x, p.y, p.z, q.x, q.y, q.z, q.w};
                                                          ++count;
                                                        });
  ASSERT_TRUE(subscription);
  Peer peer(claim->domain());
  auto* writer = peer.writer<second_vendor::Pose>("rt/omni/pose", second_vendor::kPoseType);
  ASSERT_TRUE(subscription->wait_for_peers(1, 10s));
  second_vendor::Pose sent{3, 4, "map", {1.5, -2.5, 3.25, 0.0, 0.6, 0.0, 0.8}};
  ASSERT_TRUE(eventually([&] { return writer->write(&sent) && count > 0; }, 10s));
  EXPECT_EQ(seen, sent.numbers);
}

}  // namespace
}  // namespace omniflight::bus
