#include "omniflight_bus/raw_publisher.hpp"

#include "dds/ddsi/ddsi_serdata.h"
#include "endpoint.hpp"
#include "omniflight_bus/message.hpp"

namespace omniflight::bus {

using detail::dds_failure;

struct RawPublisher::State : detail::Endpoint {
  const ddsi_serdata* pattern = nullptr;  ///< any message of the type: it knows how to read bytes
  ~State() {
    close();
    if (pattern != nullptr) ddsi_serdata_unref(const_cast<ddsi_serdata*>(pattern));
  }
  static void on_matched(dds_entity_t, const dds_publication_matched_status_t status, void* arg) noexcept {
    static_cast<State*>(arg)->set_peers(status.current_count);
  }
  Status learn_type();
};

/// The middleware tells the type behind a topic only through its messages, so one is sent to ourselves, in a
/// partition that nobody else looks into.
Status RawPublisher::State::learn_type() {
  const detail::QosHandle alone = detail::make_qos(Qos::latched_last(), *type);
  const std::string partition = "omniflight_raw_publisher_" + std::to_string(dds_time());
  dds_qset_partition1(alone.get(), partition.c_str());
  const dds_entity_t reader = dds_create_reader(participant->entity, topic_entity, alone.get(), nullptr);
  const dds_entity_t writer = dds_create_writer(participant->entity, topic_entity, alone.get(), nullptr);
  void* const zero = detail::reallocate_zeroed(nullptr, 0, type->size);
  dds_return_t code = dds_write_ts(writer, zero, 0);
  dds_sample_free(zero, type->descriptor, DDS_FREE_ALL);
  ddsi_serdata* sample = nullptr;
  dds_sample_info_t info;
  if (code >= 0) code = dds_takecdr(reader, &sample, 1, &info, DDS_ANY_STATE);
  if (code == 1) pattern = sample;
  dds_delete(writer);
  dds_delete(reader);
  if (code == 1) return {};
  return dds_failure(code < 0 ? code : DDS_RETCODE_NO_DATA, "cannot learn the type of " + topic,
                     "Report this with the topic's name");
}

RawPublisher::RawPublisher(std::unique_ptr<State> state) : state_(std::move(state)) {}
RawPublisher::RawPublisher(RawPublisher&&) noexcept = default;
RawPublisher& RawPublisher::operator=(RawPublisher&&) noexcept = default;
RawPublisher::~RawPublisher() = default;

Result<RawPublisher> RawPublisher::create(const Participant& participant, const msgs::MessageType& type,
                                          std::string_view topic, const Qos& qos, EventCallback on_event) {
  auto state = std::make_unique<State>();
  Status ready = state->open(participant, type, topic, qos, std::move(on_event));
  if (ready) ready = state->learn_type();
  if (!ready) return Failure(std::move(ready.error()));
  const detail::ListenerHandle listener(dds_create_listener(state.get()));
  dds_lset_publication_matched(listener.get(), &State::on_matched);
  const dds_entity_t entity = dds_create_writer(participant.state()->entity, state->topic_entity,
                                                detail::make_qos(qos, type).get(), listener.get());
  if (entity < 0)
    return dds_failure(entity, "cannot publish on " + state->topic, "Report this with the topic's name");
  state->attach(detail::EndpointKind::writer, entity);
  return RawPublisher(std::move(state));
}

Status RawPublisher::publish(std::span<const std::byte> cdr, std::int64_t source_ns) {
  const auto invalid = [&](const char* what) {
    return bad_input(std::string(what) + ", " + std::to_string(cdr.size()) + " bytes",
                     "topic " + state_->topic,
                     "Give CDR of " + std::string(state_->type->ros_name) + " with its 4-byte header");
  };
  if (cdr.size() < 4 || cdr.size() > (1u << 30) || cdr[0] != std::byte{0} || cdr[1] > std::byte{1}) {
    return invalid("not XCDR1");
  }
  if (source_ns < 0) return invalid("source time before the epoch");
  if (detail::DeliveryScope::inside(state_->participant->domain, state_->topic)) {
    return fail(ErrorCode::internal, "published from within a callback of the same topic",
                "topic " + state_->topic, "Hand the work to another thread");
  }
  ddsrt_iovec_t part;
  part.iov_base = const_cast<std::byte*>(cdr.data());
  part.iov_len = cdr.size();
  ddsi_serdata* sample = ddsi_serdata_from_ser_iov(state_->pattern->type, SDK_DATA, 1, &part, cdr.size());
  if (sample == nullptr) return invalid("not a message of this type");
  sample->timestamp.v = source_ns;
  sample->statusinfo = 0;
  const dds_return_t code =
      dds_forwardcdr(state_->entity, sample);  // keeps the timestamp and takes the reference
  if (code < 0)
    return dds_failure(code, "message on " + state_->topic + " not sent", "See whether a reader hangs");
  return {};
}

Status RawPublisher::wait_for_peers(std::uint32_t n, std::chrono::nanoseconds timeout) const {
  return state_->wait_for_peers(n, timeout, "subscriptions");
}

}  // namespace omniflight::bus
