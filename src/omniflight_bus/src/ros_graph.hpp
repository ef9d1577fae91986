// Which component has which publishers and subscriptions, told to ROS 2: DDS knows participants only, and
// `ros2 node list` shows what participants say of their nodes on the topic ros_discovery_info. Source:
// design.ros2.org/articles/Node_to_Participant_mapping.html and rmw_dds_common.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dds/dds.h"
#include "omniflight_core/result.hpp"

namespace omniflight::bus::detail {

struct ParticipantState;

enum class EndpointKind { reader, writer };

/// The nodes of one participant. Every change publishes the whole list (RELIABLE, TRANSIENT_LOCAL, KEEP_LAST
/// 1); nothing is published between changes. Safe from any thread.
class RosGraph {
 public:
  /// Publishes a participant without nodes. OMNIFLIGHT_ROS_DISTRO in the environment tells whose form a GID
  /// has: humble and older 24 bytes, iron and newer, and where it is not set, 16. ErrorCode::bad_input when
  /// it names no distribution. Keys that do not permit the topic are no error: this graph then stays silent,
  /// and says so once.
  static Result<std::unique_ptr<RosGraph>> open(dds_entity_t participant);

  /// A node in the namespace "/"; returns the number that names it below.
  int add_node(const std::string& name);
  void remove_node(int node);
  void add_endpoint(int node, EndpointKind kind, dds_entity_t endpoint);
  void remove_endpoint(int node, EndpointKind kind, dds_entity_t endpoint);

 private:
  struct Node {
    int number = 0;
    std::string name;
    std::vector<dds_guid_t> readers, writers;
    std::vector<dds_guid_t>& endpoints(EndpointKind kind) {
      return kind == EndpointKind::reader ? readers : writers;
    }
  };
  using Write = dds_return_t (*)(dds_entity_t writer, const dds_guid_t& participant,
                                 const std::vector<Node>& nodes);
  template <class Info>
  static dds_return_t write(dds_entity_t writer, const dds_guid_t& participant,
                            const std::vector<Node>& nodes);
  Node* find(int node);
  void publish();

  std::mutex mutex_;  ///< guards everything below
  dds_guid_t participant_{};
  dds_entity_t writer_ = 0;  ///< 0: not permitted. Deleted with the participant.
  Write write_ = nullptr;
  std::vector<Node> nodes_;
  int last_number_ = 0;
};

/// A node's place in the graph of its participant; given up with the last handle, publisher and subscription.
struct RosNode {
  std::shared_ptr<ParticipantState> participant;
  int number = 0;
  RosNode(std::shared_ptr<ParticipantState> of, const std::string& name);
  ~RosNode();
  RosNode(const RosNode&) = delete;
  RosNode& operator=(const RosNode&) = delete;
};

}  // namespace omniflight::bus::detail
