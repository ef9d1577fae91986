#include "ros_graph.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "endpoint.hpp"
#include "omniflight_bus/message.hpp"
#include "omniflight_bus/say.hpp"

namespace omniflight::bus::detail {
namespace {

constexpr const char* kTopic = "ros_discovery_info";
constexpr const char* kTypeName = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
constexpr const char* kVariable = "OMNIFLIGHT_ROS_DISTRO";

/// Whether the distribution is older than rmw_dds_common 2.0.0 (Iron), which made a GID 16 bytes long.
Result<bool> long_gids() {
  const char* value = std::getenv(kVariable);
  const std::string distribution = value == nullptr ? "" : value;
  for (const char* older : {"foxy", "galactic", "humble"})
    if (distribution == older) return true;
  for (const char* newer : {"", "iron", "jazzy", "kilted", "lyrical", "rolling"})
    if (distribution == newer) return false;
  return bad_input("'" + distribution + "' is no distribution of ROS 2", kVariable,
                   "Give humble, or jazzy for Iron and newer");
}

/// The type's description for the middleware under the name that ROS 2 gives it, and without XTypes metadata:
/// ROS 2 describes its types itself, so that readers match by the name.
dds_topic_descriptor_t descriptor_of(const msgs::MessageType& type) {
  const dds_topic_descriptor_t& d = *type.descriptor;
  return {d.m_size,     d.m_align,    d.m_flagset & ~DDS_TOPIC_XTYPES_METADATA,
          d.m_nkeys,    kTypeName,    d.m_keys,
          d.m_nops,     d.m_ops,      d.m_meta,
          {nullptr, 0}, {nullptr, 0}, d.restrict_data_representation};
}

dds_guid_t guid_of(dds_entity_t entity) {
  dds_guid_t out{};
  (void)dds_get_guid(entity, &out);
  return out;
}

bool same(const dds_guid_t& a, const dds_guid_t& b) { return std::memcmp(a.v, b.v, sizeof a.v) == 0; }

/// The GUID as it is on the wire, then zeros.
template <class Gid>
void put_gid(Gid& out, const dds_guid_t& guid) {
  static_assert(sizeof out.data >= sizeof guid.v);
  std::memcpy(out.data, guid.v, sizeof guid.v);
}

template <class Sequence>
void put_gids(Sequence& out, const std::vector<dds_guid_t>& guids) {
  resize(out, guids.size());
  for (std::size_t i = 0; i < guids.size(); ++i) put_gid(view(out)[i], guids[i]);
}

/// Into a bounded string of a zeroed message; names are checked to be shorter before.
template <std::size_t N>
void put_text(char (&out)[N], const std::string& text) {
  std::memcpy(out, text.data(), std::min(text.size(), N - 1));
}

}  // namespace

template <class Info>
dds_return_t RosGraph::write(dds_entity_t writer, const dds_guid_t& participant,
                             const std::vector<Node>& nodes) {
  Message<Info> message;
  put_gid(message->gid, participant);
  resize(message->node_entities_info_seq, nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    auto& out = view(message->node_entities_info_seq)[i];
    put_text(out.node_namespace, "/");
    put_text(out.node_name, nodes[i].name);
    put_gids(out.reader_gid_seq, nodes[i].readers);
    put_gids(out.writer_gid_seq, nodes[i].writers);
  }
  return dds_write(writer, &*message);
}

Result<std::unique_ptr<RosGraph>> RosGraph::open(dds_entity_t participant) {
  const auto humble = long_gids();
  if (!humble) return Failure(humble.error());
  using Short = msgs::rmw_dds_common::ParticipantEntitiesInfo;
  using Long = msgs::rmw_dds_common_humble::ParticipantEntitiesInfo;
  const msgs::MessageType& type =
      *humble ? msgs::TypeSupport<Long>::type() : msgs::TypeSupport<Short>::type();
  std::unique_ptr<RosGraph> out(new RosGraph());
  out->participant_ = guid_of(participant);
  out->write_ = *humble ? &write<Long> : &write<Short>;
  const dds_topic_descriptor_t descriptor = descriptor_of(type);
  const dds_entity_t topic = dds_create_topic(participant, &descriptor, kTopic, nullptr, nullptr);
  out->writer_ =
      topic < 0 ? topic
                : dds_create_writer(participant, topic, make_qos(Qos::latched_last(), type).get(), nullptr);
  if (out->writer_ == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY) {
    out->writer_ = 0;
    say("bus",
        "the keys do not permit ros_discovery_info, so ROS 2 does not see nodes of this process; omniflight "
        "keys makes keys that do");
  }
  if (out->writer_ < 0)
    return dds_failure(out->writer_, std::string("cannot publish on ") + kTopic, "Report this");
  out->publish();
  return out;
}

void RosGraph::publish() {
  if (writer_ == 0) return;
  if (const dds_return_t code = write_(writer_, participant_, nodes_); code < 0)
    say("bus", std::string(kTopic) + " not sent: " + dds_strretcode(-code));
}

RosGraph::Node* RosGraph::find(int node) {
  const auto at = std::find_if(nodes_.begin(), nodes_.end(), [&](const Node& n) { return n.number == node; });
  return at == nodes_.end() ? nullptr : &*at;
}

int RosGraph::add_node(const std::string& name) {
  const std::lock_guard lock(mutex_);
  nodes_.push_back({++last_number_, name, {}, {}});
  publish();
  return last_number_;
}

void RosGraph::remove_node(int node) {
  const std::lock_guard lock(mutex_);
  std::erase_if(nodes_, [&](const Node& n) { return n.number == node; });
  publish();
}

void RosGraph::add_endpoint(int node, EndpointKind kind, dds_entity_t endpoint) {
  const std::lock_guard lock(mutex_);
  Node* const at = find(node);
  if (at == nullptr) return;
  at->endpoints(kind).push_back(guid_of(endpoint));
  publish();
}

void RosGraph::remove_endpoint(int node, EndpointKind kind, dds_entity_t endpoint) {
  const std::lock_guard lock(mutex_);
  Node* const at = find(node);
  if (at == nullptr) return;
  const dds_guid_t guid = guid_of(endpoint);
  std::erase_if(at->endpoints(kind), [&](const dds_guid_t& g) { return same(g, guid); });
  publish();
}

RosNode::RosNode(std::shared_ptr<ParticipantState> of, const std::string& name)
    : participant(std::move(of)), number(participant->graph->add_node(name)) {}
RosNode::~RosNode() { participant->graph->remove_node(number); }

}  // namespace omniflight::bus::detail
