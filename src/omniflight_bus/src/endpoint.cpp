#include "endpoint.hpp"

#include <cstring>

namespace omniflight::bus::detail {
namespace {
thread_local DeliveryScope* g_innermost = nullptr;
}

DeliveryScope::DeliveryScope(int domain, const std::string& topic)
    : domain_(domain), topic_(topic), outer_(g_innermost) {
  g_innermost = this;
}
DeliveryScope::~DeliveryScope() { g_innermost = outer_; }
bool DeliveryScope::inside(int domain, const std::string& topic) {
  for (const DeliveryScope* scope = g_innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->domain_ == domain && scope->topic_ == topic) return true;
  }
  return false;
}

Failure dds_failure(dds_return_t code, const std::string& what, const std::string& next_step) {
  return fail(ErrorCode::internal, what + ": " + dds_strretcode(-code), "Cyclone DDS", next_step);
}

const char* policy_name(std::uint32_t id) {
  switch (id) {
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
      return "data representation";
    case DDS_PARTITION_QOS_POLICY_ID:
      return "partition";
    default:
      return "another policy";
  }
}

QosHandle make_qos(const Qos& qos, const msgs::MessageType& type) {
  QosHandle out(dds_create_qos());
  // A bounded wait, even though KEEP_LAST writers do not wait: the control path must never stand still.
  dds_qset_reliability(out.get(), qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_history(out.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  dds_qset_durability(out.get(), qos.latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  if (qos.latched) {
    dds_qset_durability_service(out.get(), 0, DDS_HISTORY_KEEP_LAST, qos.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  if (qos.deadline_ns) dds_qset_deadline(out.get(), *qos.deadline_ns);
  if (qos.liveliness_lease_ns) {
    dds_qset_liveliness(out.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, *qos.liveliness_lease_ns);
  }
  dds_qset_writer_data_lifecycle(out.get(), false);
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(out.get(), 1, &xcdr1);
  const std::string user_data = "typehash=" + std::string(type.type_hash) + ";";
  dds_qset_userdata(out.get(), user_data.data(), user_data.size());
  return out;
}

Status Endpoint::open(const Participant& owner, const msgs::MessageType& message, std::string_view ros_topic,
                      const Qos& qos, EventCallback events) {
  const Result<std::string> name = dds_topic_name(ros_topic);
  if (!name) return Failure(name.error());
  if (qos.depth < 1 || qos.depth > 1'000'000) {
    return bad_input("a history of " + std::to_string(qos.depth) + " messages",
                     "topic " + std::string(ros_topic), "Give a depth from 1 to 1000000");
  }
  if ((qos.deadline_ns && *qos.deadline_ns <= 0) ||
      (qos.liveliness_lease_ns && *qos.liveliness_lease_ns <= 0)) {
    return bad_input("deadline and lease must be longer than 0 ns", "topic " + std::string(ros_topic));
  }
  participant = owner.state();
  node = owner.node();
  type = &message;
  topic = ros_topic;
  on_event = std::move(events);
  topic_entity = dds_create_topic(participant->entity, message.descriptor, name->c_str(), nullptr, nullptr);
  if (topic_entity < 0) {
    const dds_return_t code = topic_entity;
    topic_entity = 0;
    return dds_failure(code, "cannot create topic " + topic + " of type " + std::string(message.ros_name),
                       "Use one type for a topic everywhere in the domain");
  }
  return {};
}

void Endpoint::attach(EndpointKind kind, dds_entity_t created) {
  endpoint_kind = kind;
  entity = created;
  if (node) participant->graph->add_endpoint(node->number, kind, entity);
}

void Endpoint::close() {
  if (entity > 0 && node) participant->graph->remove_endpoint(node->number, endpoint_kind, entity);
  // dds_delete waits for callbacks that run, and the middleware starts none afterwards.
  if (entity > 0) dds_delete(entity);
  entity = 0;
  if (topic_entity > 0) dds_delete(topic_entity);
  topic_entity = 0;
}

void Endpoint::report(EventKind kind, std::uint64_t count, const char* detail) const {
  if (on_event) on_event(Event{kind, topic, count, detail});
}

void Endpoint::set_peers(std::uint32_t now) {
  {
    const std::lock_guard lock(mutex);
    peers = now;
  }
  match_changed.notify_all();
  report(EventKind::matched, now);
}

Status Endpoint::wait_for_peers(std::uint32_t wanted, std::chrono::nanoseconds timeout, const char* what) {
  std::unique_lock lock(mutex);
  if (match_changed.wait_for(lock, timeout, [&] { return peers >= wanted; })) return {};
  return fail(ErrorCode::incomplete,
              std::to_string(peers) + " of " + std::to_string(wanted) + " " + what + " came within " +
                  std::to_string(std::chrono::duration<double>(timeout).count()) + " s",
              "topic " + topic,
              "Start the missing component in domain " + std::to_string(participant->domain));
}

}  // namespace omniflight::bus::detail
