#include "omniflight_bus/publisher.hpp"

#include "endpoint.hpp"

namespace omniflight::bus {
namespace detail {

struct Writer : Endpoint {
  static Writer& of(void* arg) { return *static_cast<Writer*>(arg); }
  static void on_matched(dds_entity_t, const dds_publication_matched_status_t status, void* arg) noexcept {
    of(arg).set_peers(status.current_count);
  }
  static void on_deadline(dds_entity_t, const dds_offered_deadline_missed_status_t status,
                          void* arg) noexcept {
    of(arg).report(EventKind::deadline_missed, status.total_count);
  }
  static void on_liveliness(dds_entity_t, const dds_liveliness_lost_status_t status, void* arg) noexcept {
    of(arg).report(EventKind::liveliness_changed, status.total_count);
  }
  static void on_qos(dds_entity_t, const dds_offered_incompatible_qos_status_t status, void* arg) noexcept {
    of(arg).report(EventKind::incompatible_qos, status.total_count, policy_name(status.last_policy_id));
  }
};

Result<PublisherBase> PublisherBase::create(const Participant& participant, const msgs::MessageType& type,
                                            std::string_view topic, const Qos& qos, EventCallback on_event) {
  auto writer = std::make_unique<Writer>();
  if (Status opened = writer->open(participant, type, topic, qos, std::move(on_event)); !opened) {
    return Failure(std::move(opened.error()));
  }
  const ListenerHandle listener(dds_create_listener(writer.get()));
  dds_lset_publication_matched(listener.get(), &Writer::on_matched);
  dds_lset_offered_deadline_missed(listener.get(), &Writer::on_deadline);
  dds_lset_liveliness_lost(listener.get(), &Writer::on_liveliness);
  dds_lset_offered_incompatible_qos(listener.get(), &Writer::on_qos);
  const dds_entity_t entity = dds_create_writer(participant.state()->entity, writer->topic_entity,
                                                make_qos(qos, type).get(), listener.get());
  if (entity < 0)
    return dds_failure(entity, "cannot publish on " + writer->topic, "Report this with the topic's name");
  writer->attach(EndpointKind::writer, entity);
  auto count = std::make_shared<SentCount>();
  count->topic = writer->topic;
  return PublisherBase(std::move(writer), std::move(count));
}

PublisherBase::PublisherBase(std::unique_ptr<Writer> writer, std::shared_ptr<SentCount> count)
    : writer_(std::move(writer)), count_(std::move(count)) {}
PublisherBase::PublisherBase(PublisherBase&&) noexcept = default;
PublisherBase& PublisherBase::operator=(PublisherBase&&) noexcept = default;
PublisherBase::~PublisherBase() = default;

Status PublisherBase::publish_sample(const void* sample, std::int64_t source_ns) {
  if (DeliveryScope::inside(writer_->participant->domain, writer_->topic)) {
    return fail(ErrorCode::internal,
                "published from within a callback of the same topic, which would wait for itself",
                "topic " + writer_->topic, "Hand the work to another thread");
  }
  const dds_return_t code = dds_write_ts(writer_->entity, sample, source_ns);
  if (code < 0) {
    return dds_failure(
        code, "message on " + writer_->topic + " not sent, source time " + std::to_string(source_ns) + " ns",
        "A time is at least 0; an invalid message has a null element in a sequence");
  }
  count_->sent.fetch_add(1, std::memory_order_relaxed);
  return {};
}

Status PublisherBase::wait_for_peers(std::uint32_t n, std::chrono::nanoseconds timeout) const {
  return writer_->wait_for_peers(n, timeout, "subscriptions");
}

Status PublisherBase::wait_for_acknowledgement(std::chrono::nanoseconds timeout) const {
  const dds_return_t code = dds_wait_for_acks(writer_->entity, timeout.count());
  if (code < 0)
    return dds_failure(code, "messages on " + writer_->topic + " not acknowledged", "A subscription hangs");
  return {};
}

std::uint32_t PublisherBase::peers() const {
  const std::lock_guard lock(writer_->mutex);
  return writer_->peers;
}
const std::string& PublisherBase::topic() const { return count_->topic; }

}  // namespace detail

std::int64_t wall_clock_ns() { return dds_time(); }

}  // namespace omniflight::bus
