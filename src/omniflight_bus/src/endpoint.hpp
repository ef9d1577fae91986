// What publishers and subscriptions share inside this library.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

#include "dds/dds.h"
#include "omniflight_bus/event.hpp"
#include "omniflight_bus/participant.hpp"
#include "omniflight_bus/qos.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_msgs/message_type.hpp"
#include "ros_graph.hpp"

namespace omniflight::bus::detail {

struct ParticipantState {
  int domain = 0;
  dds_entity_t entity = 0;
  std::unique_ptr<RosGraph> graph;
  ~ParticipantState();
};

/// Topic, matching and events of one publisher or subscription. Its address is the listeners' argument.
struct Endpoint {
  std::shared_ptr<ParticipantState> participant;
  std::shared_ptr<RosNode> node;  ///< null: of no node
  const msgs::MessageType* type = nullptr;
  std::string topic;  ///< ROS name
  dds_entity_t topic_entity = 0;
  dds_entity_t entity = 0;  ///< reader or writer
  EndpointKind endpoint_kind = EndpointKind::reader;
  EventCallback on_event;

  std::mutex mutex;
  std::condition_variable match_changed;
  std::uint32_t peers = 0;

  Endpoint() = default;
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
  ~Endpoint() { close(); }

  /// Checks the name and the QoS and creates the topic.
  Status open(const Participant& owner, const msgs::MessageType& message, std::string_view ros_topic,
              const Qos& qos, EventCallback events);
  /// Keeps the reader or writer that has been created, and tells the node's graph.
  void attach(EndpointKind kind, dds_entity_t created);
  /// Deletes reader or writer and waits for its callbacks; nothing is called afterwards.
  void close();
  void report(EventKind kind, std::uint64_t count, const char* detail = "") const;
  void set_peers(std::uint32_t now);
  Status wait_for_peers(std::uint32_t wanted, std::chrono::nanoseconds timeout, const char* what);
};

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using QosHandle = std::unique_ptr<dds_qos_t, QosDeleter>;
using ListenerHandle = std::unique_ptr<dds_listener_t, ListenerDeleter>;

QosHandle make_qos(const Qos& qos, const msgs::MessageType& type);
const char* policy_name(std::uint32_t id);
Failure dds_failure(dds_return_t code, const std::string& what, const std::string& next_step);

/// Marks that this thread is inside the callback of a subscription: publishing on the same topic would wait
/// for itself.
class DeliveryScope {
 public:
  DeliveryScope(int domain, const std::string& topic);
  ~DeliveryScope();
  DeliveryScope(const DeliveryScope&) = delete;
  DeliveryScope& operator=(const DeliveryScope&) = delete;
  static bool inside(int domain, const std::string& topic);

 private:
  int domain_;
  const std::string& topic_;
  DeliveryScope* outer_;
};

}  // namespace omniflight::bus::detail
