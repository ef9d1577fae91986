// The graph of nodes for ROS 2: components are nodes with their publishers and subscriptions as long as they
// live. What another vendor's DDS reads of it is in second_vendor/.
#include <array>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "bus_fixture.hpp"
#include "dds/dds.h"
#include "omniflight_bus/component.hpp"
#include "omniflight_bus/raw_publisher.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_msgs/messages.h"

namespace omniflight::bus {
namespace {

using msgs::std_msgs::String;
using Info = msgs::rmw_dds_common::ParticipantEntitiesInfo;

/// The last list of nodes that somebody in the domain has published, and how many lists came.
class GraphReader {
 public:
  explicit GraphReader(int domain)
      : participant_(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr)) {
    const dds_entity_t topic =
        dds_create_topic(participant_, &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                         "ros_discovery_info", nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 64);
    reader_ = dds_create_reader(participant_, topic, qos, nullptr);
    dds_delete_qos(qos);
  }
  ~GraphReader() { dds_delete(participant_); }
  GraphReader(const GraphReader&) = delete;
  GraphReader& operator=(const GraphReader&) = delete;

  const Info& last() {
    void* sample = &*last_;
    dds_sample_info_t info;
    while (dds_take(reader_, &sample, &info, 1, 1) == 1) count_ += info.valid_data ? 1 : 0;
    return *last_;
  }
  int count() {
    (void)last();
    return count_;
  }
  bool is_there() const { return reader_ > 0; }

 private:
  dds_entity_t participant_ = 0, reader_ = 0;
  Message<Info> last_;
  int count_ = 0;
};

class RosGraph : public BusTest {
 protected:
  void TearDown() override { unsetenv("OMNIFLIGHT_ROS_DISTRO"); }
  /// "name: readers, writers" of every node.
  static std::vector<std::string> nodes(GraphReader& reader) {
    std::vector<std::string> out;
    for (const auto& n : view(reader.last().node_entities_info_seq))
      out.push_back(std::string(n.node_namespace) + n.node_name + ": " +
                    std::to_string(n.reader_gid_seq._length) + ", " +
                    std::to_string(n.writer_gid_seq._length));
    return out;
  }
  using Nodes = std::vector<std::string>;
  static bool become(GraphReader& reader, const Nodes& wanted) {
    return eventually([&] { return nodes(reader) == wanted; });
  }
};

/// Publishes on one topic while it is configured, and subscribes to another.
class Probe final : public Component {
 public:
  using Component::Component;

 private:
  Status on_configure(const YAML::Node&) override {
    auto out = advertise<String>("/said");
    if (!out) return Failure(out.error());
    said_.emplace(std::move(*out));
    auto in = Subscription<String>::create(participant(), "/heard");
    if (!in) return Failure(in.error());
    heard_.emplace(std::move(*in));
    return {};
  }
  Status on_cleanup() override {
    said_.reset();
    heard_.reset();
    return {};
  }
  std::optional<Publisher<String>> said_;
  std::optional<Subscription<String>> heard_;
};

TEST_F(RosGraph, EveryComponentIsANodeWithItsEndpointsWhileTheyLive) {
  GraphReader reader(claim->domain());
  ASSERT_TRUE(reader.is_there());
  const Participant participant = join();
  EXPECT_TRUE(eventually([&] { return reader.count() > 0; })) << "a participant without nodes says so";
  Probe first("first"), second("second");
  ASSERT_TRUE(first.configure(participant, YAML::Node()));
  EXPECT_TRUE(become(reader, {"/first: 1, 2"})) << "also its /component_state";
  ASSERT_TRUE(second.configure(participant, YAML::Node()));
  EXPECT_TRUE(become(reader, {"/first: 1, 2", "/second: 1, 2"}));
  ASSERT_TRUE(first.cleanup());
  EXPECT_TRUE(become(reader, {"/first: 0, 1", "/second: 1, 2"}));
  ASSERT_TRUE(first.shutdown());
  EXPECT_TRUE(become(reader, {"/second: 1, 2"}));
}

TEST_F(RosGraph, GidsAreThoseOfDiscovery) {
  GraphReader reader(claim->domain());
  const Participant participant = join();
  const auto node = participant.as_node("node");
  ASSERT_TRUE(node);
  const auto publisher =
      RawPublisher::create(*node, msgs::TypeSupport<String>::type(), "/said", Qos::standard());
  const auto of_none = Publisher<String>::create(participant, "/of_none");
  ASSERT_TRUE(publisher && of_none);
  ASSERT_TRUE(become(reader, {"/node: 0, 1"})) << "an endpoint of the participant itself is of no node";

  const dds_entity_t observer =
      dds_create_participant(static_cast<dds_domainid_t>(claim->domain()), nullptr, nullptr);
  const dds_entity_t publications =
      dds_create_reader(observer, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
  const Info& told = reader.last();
  const auto& gid = view(view(told.node_entities_info_seq)[0].writer_gid_seq)[0];
  bool found = false;
  EXPECT_TRUE(eventually([&] {
    void* sample = nullptr;
    dds_sample_info_t info;
    while (dds_take(publications, &sample, &info, 1, 1) == 1) {
      const auto& seen = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
      if (info.valid_data && std::string(seen.topic_name) == "rt/said") {
        found = true;
        EXPECT_EQ(std::memcmp(seen.key.v, gid.data, 16), 0);
        EXPECT_EQ(std::memcmp(seen.participant_key.v, told.gid.data, 16), 0);
      }
      dds_return_loan(publications, &sample, 1);
    }
    return found;
  }));
  dds_delete(observer);
}

TEST_F(RosGraph, PublishingMessagesPublishesNoGraph) {
  GraphReader reader(claim->domain());
  const Participant participant = join();
  const auto node = participant.as_node("node");
  auto publisher = Publisher<String>::create(*node, "/said");
  ASSERT_TRUE(publisher);
  ASSERT_TRUE(become(reader, {"/node: 0, 1"}));
  const int before = reader.count();
  EXPECT_EQ(before, 3) << "the participant, the node, the publisher";
  const Message<String> message;
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(publisher->publish(*message, i));
  const auto last = Publisher<String>::create(*node, "/last");
  ASSERT_TRUE(become(reader, {"/node: 0, 2"}));
  EXPECT_EQ(reader.count(), before + 1);
}

TEST_F(RosGraph, EndpointsThatComeAndGoOnManyThreadsLeaveARightGraph) {
  GraphReader reader(claim->domain());
  const Participant participant = join();
  const auto one = participant.as_node("one"), two = participant.as_node("two");
  ASSERT_TRUE(one && two);
  std::array<std::optional<Publisher<String>>, 2> kept;
  const auto come_and_go = [&](const Participant& node, std::size_t k) {
    const std::string topic = "/topic" + std::to_string(k);
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(Publisher<String>::create(node, topic));
    auto last = Publisher<String>::create(node, topic);
    ASSERT_TRUE(last);
    kept[k].emplace(std::move(*last));
  };
  std::thread first(come_and_go, *one, 0), second(come_and_go, *two, 1);
  first.join();
  second.join();
  EXPECT_TRUE(become(reader, {"/one: 0, 1", "/two: 0, 1"}));
}

TEST_F(RosGraph, NamesThatRos2RefusesAreRefused) {
  const Participant participant = join();
  for (const std::string& name : {std::string(), std::string("1st"), std::string("a node"),
                                  std::string("a/b"), std::string(256, 'a')}) {
    const auto node = participant.as_node(name);
    ASSERT_FALSE(node) << name;
    EXPECT_NE(node.error().text().find("is not a name of a node"), std::string::npos);
  }
  EXPECT_TRUE(participant.as_node(std::string(255, 'a')));
}

TEST_F(RosGraph, AnUnknownDistributionIsRefused) {
  setenv("OMNIFLIGHT_ROS_DISTRO", "humbel", 1);
  const auto refused = Participant::create(claim->domain());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
  EXPECT_EQ(refused.error().text(),
            "OMNIFLIGHT_ROS_DISTRO: 'humbel' is no distribution of ROS 2. Give humble, or jazzy for Iron and "
            "newer");
  for (const char* known : {"humble", "jazzy", ""}) {
    setenv("OMNIFLIGHT_ROS_DISTRO", known, 1);
    EXPECT_TRUE(Participant::create(claim->domain())) << known;
  }
}

}  // namespace
}  // namespace omniflight::bus
