#include "omniflight_bus/subscription.hpp"

#include <algorithm>
#include <vector>

#include "dds/ddsi/ddsi_serdata.h"
#include "endpoint.hpp"

namespace omniflight::bus {
namespace detail {

struct Reader : Endpoint {
  SampleCallback on_sample;
  BytesCallback on_bytes;
  std::atomic<std::uint64_t> received{0}, lost{0}, foreign{0};
  bool one_publisher = false;
  dds_instance_handle_t followed = 0;  ///< with one_publisher: whose messages are delivered
  std::chrono::steady_clock::time_point followed_at;
  dds_entity_t waitset = 0;
  std::vector<std::byte> bytes;  ///< reused for messages that must be copied
  void* sample = nullptr;  ///< reused for every delivery, so that its strings and sequences keep their memory

  ~Reader() {
    if (waitset > 0) dds_delete(waitset);
    close();
    if (sample != nullptr) dds_sample_free(sample, type->descriptor, DDS_FREE_ALL);
  }

  /// Cyclone DDS pads to a multiple of four and says so in the last two bits of the header; ROS 2 does
  /// neither. Only padded messages are copied.
  std::span<const std::byte> canonical(std::span<const std::byte> cdr) {
    if (cdr.size() < 4 || (cdr[2] == std::byte{0} && cdr[3] == std::byte{0})) return cdr;
    const std::size_t padding =
        std::min<std::size_t>(std::to_integer<std::size_t>(cdr[3]) & 3u, cdr.size() - 4);
    bytes.assign(cdr.begin(), cdr.end() - static_cast<std::ptrdiff_t>(padding));
    bytes[2] = bytes[3] = std::byte{0};
    return bytes;
  }

  /// With one_publisher: whether this message is of the publisher that is followed. Another one takes its
  /// place only when that is gone or has been silent for a second (it may have been killed; its lease lasts
  /// longer). reader: this one; callbacks may run before `entity` is set.
  bool is_followed(dds_entity_t reader, dds_instance_handle_t publisher) {
    constexpr std::chrono::seconds kSilence{1};
    const auto now = std::chrono::steady_clock::now();
    if (publisher != followed && followed != 0 && now - followed_at < kSilence) {
      dds_builtintopic_endpoint_t* alive = dds_get_matched_publication_data(reader, followed);
      if (alive != nullptr) {
        dds_builtintopic_free_endpoint(alive);
        report(EventKind::foreign_publisher, foreign.fetch_add(1, std::memory_order_relaxed) + 1);
        return false;
      }
    }
    followed = publisher;
    followed_at = now;
    return true;
  }

  static Reader& of(void* arg) { return *static_cast<Reader*>(arg); }

  static void on_sample_available(dds_entity_t entity, void* arg) noexcept {
    Reader& self = of(arg);
    const DeliveryScope scope(self.participant->domain, self.topic);
    dds_sample_info_t info;
    while (dds_take(entity, &self.sample, &info, 1, 1) == 1) {
      if (!info.valid_data) continue;
      if (self.one_publisher && !self.is_followed(entity, info.publication_handle)) continue;
      self.received.fetch_add(1, std::memory_order_relaxed);
      self.on_sample(self.sample, info.source_timestamp);
    }
  }

  static void on_bytes_available(dds_entity_t entity, void* arg) noexcept {
    Reader& self = of(arg);
    const DeliveryScope scope(self.participant->domain, self.topic);
    dds_sample_info_t info;
    ddsi_serdata* data = nullptr;
    while (dds_takecdr(entity, &data, 1, &info, DDS_ANY_STATE) == 1) {
      if (info.valid_data) {
        ddsrt_iovec_t part;
        ddsi_serdata* held = ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &part);
        self.received.fetch_add(1, std::memory_order_relaxed);
        self.on_bytes(self.canonical({static_cast<const std::byte*>(part.iov_base), part.iov_len}),
                      info.source_timestamp);
        ddsi_serdata_to_ser_unref(held, &part);
      }
      ddsi_serdata_unref(data);
    }
  }

  static void on_matched(dds_entity_t, const dds_subscription_matched_status_t status, void* arg) noexcept {
    of(arg).set_peers(status.current_count);
  }
  static void on_deadline(dds_entity_t, const dds_requested_deadline_missed_status_t status,
                          void* arg) noexcept {
    of(arg).report(EventKind::deadline_missed, status.total_count);
  }
  static void on_liveliness(dds_entity_t, const dds_liveliness_changed_status_t status, void* arg) noexcept {
    of(arg).report(EventKind::liveliness_changed, status.alive_count);
  }
  static void on_qos(dds_entity_t, const dds_requested_incompatible_qos_status_t status, void* arg) noexcept {
    of(arg).report(EventKind::incompatible_qos, status.total_count, policy_name(status.last_policy_id));
  }
  static void on_lost(dds_entity_t, const dds_sample_lost_status_t status, void* arg) noexcept {
    of(arg).lost.store(status.total_count, std::memory_order_relaxed);
    of(arg).report(EventKind::sample_lost, status.total_count);
  }
};

Result<SubscriptionBase> SubscriptionBase::create(const Participant& participant,
                                                  const msgs::MessageType& type, std::string_view topic,
                                                  const Qos& qos, SampleCallback on_sample,
                                                  BytesCallback on_bytes, EventCallback on_event) {
  auto reader = std::make_unique<Reader>();
  if (Status opened = reader->open(participant, type, topic, qos, std::move(on_event)); !opened) {
    return Failure(std::move(opened.error()));
  }
  reader->on_sample = std::move(on_sample);
  reader->one_publisher = qos.one_publisher;
  reader->on_bytes = std::move(on_bytes);
  const ListenerHandle listener(dds_create_listener(reader.get()));
  if (reader->on_sample) {
    reader->sample = reallocate_zeroed(nullptr, 0, type.size);
    dds_lset_data_available(listener.get(), &Reader::on_sample_available);
  } else if (reader->on_bytes) {
    dds_lset_data_available(listener.get(), &Reader::on_bytes_available);
  }
  dds_lset_subscription_matched(listener.get(), &Reader::on_matched);
  dds_lset_requested_deadline_missed(listener.get(), &Reader::on_deadline);
  dds_lset_liveliness_changed(listener.get(), &Reader::on_liveliness);
  dds_lset_requested_incompatible_qos(listener.get(), &Reader::on_qos);
  dds_lset_sample_lost(listener.get(), &Reader::on_lost);
  // Callbacks may run before this returns; everything they touch is in place.
  const dds_entity_t entity = dds_create_reader(participant.state()->entity, reader->topic_entity,
                                                make_qos(qos, type).get(), listener.get());
  if (entity < 0)
    return dds_failure(entity, "cannot subscribe to " + reader->topic, "Report this with the topic's name");
  reader->attach(EndpointKind::reader, entity);
  if (!reader->on_sample && !reader->on_bytes) {
    reader->waitset = dds_create_waitset(participant.state()->entity);
    const dds_entity_t condition = dds_create_readcondition(entity, DDS_ANY_STATE);
    const dds_return_t code = dds_waitset_attach(reader->waitset, condition, 0);
    if (code < 0)
      return dds_failure(code, "cannot wait on " + reader->topic, "Report this with the topic's name");
  }
  return SubscriptionBase(std::move(reader));
}

Result<bool> SubscriptionBase::take_sample(void* sample, std::int64_t& source_ns,
                                           std::chrono::nanoseconds timeout) {
  if (reader_->waitset <= 0) {
    return fail(ErrorCode::internal, "take on a subscription with a callback", "topic " + reader_->topic,
                "Create it without a callback");
  }
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    dds_sample_info_t info;
    const dds_return_t taken = dds_take(reader_->entity, &sample, &info, 1, 1);
    if (taken < 0)
      return dds_failure(taken, "cannot take from " + reader_->topic, "Report this with the topic's name");
    if (taken == 1 && info.valid_data) {
      reader_->received.fetch_add(1, std::memory_order_relaxed);
      source_ns = info.source_timestamp;
      return true;
    }
    if (taken == 1) continue;
    const std::chrono::nanoseconds left = deadline - std::chrono::steady_clock::now();
    if (left.count() <= 0) return false;
    const dds_return_t woken = dds_waitset_wait(reader_->waitset, nullptr, 0, left.count());
    if (woken < 0)
      return dds_failure(woken, "cannot wait on " + reader_->topic, "Report this with the topic's name");
  }
}

SubscriptionBase::SubscriptionBase(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}
SubscriptionBase::SubscriptionBase(SubscriptionBase&&) noexcept = default;
SubscriptionBase& SubscriptionBase::operator=(SubscriptionBase&&) noexcept = default;
SubscriptionBase::~SubscriptionBase() = default;

Status SubscriptionBase::wait_for_peers(std::uint32_t n, std::chrono::nanoseconds timeout) const {
  return reader_->wait_for_peers(n, timeout, "publishers");
}
std::uint32_t SubscriptionBase::peers() const {
  const std::lock_guard lock(reader_->mutex);
  return reader_->peers;
}
const std::string& SubscriptionBase::topic() const { return reader_->topic; }
std::uint64_t SubscriptionBase::received() const { return reader_->received.load(std::memory_order_relaxed); }
std::uint64_t SubscriptionBase::foreign() const { return reader_->foreign.load(std::memory_order_relaxed); }
std::uint64_t SubscriptionBase::lost() const { return reader_->lost.load(std::memory_order_relaxed); }

}  // namespace detail

Result<RawSubscription> RawSubscription::create(const Participant& participant, const msgs::MessageType& type,
                                                std::string_view topic, const Qos& qos, Callback callback,
                                                EventCallback on_event) {
  auto base =
      SubscriptionBase::create(participant, type, topic, qos, {}, std::move(callback), std::move(on_event));
  if (!base) return Failure(std::move(base.error()));
  return RawSubscription(std::move(*base));
}

}  // namespace omniflight::bus
