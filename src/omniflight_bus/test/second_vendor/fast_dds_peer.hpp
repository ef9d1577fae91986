// A participant of eProsima Fast DDS, the DDS of ROS 2's default middleware, and what it finds in a domain.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>

namespace omniflight::bus::second_vendor {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;

/// A GUID as it is on the wire.
using Gid = std::array<std::uint8_t, 16>;

inline Gid gid_of(const rtps::GUID_t& guid) {
  Gid out{};
  std::copy_n(guid.guidPrefix.value, 12, out.begin());
  std::copy_n(guid.entityId.value, 4, out.begin() + 12);
  return out;
}

/// The type T under a name of DDS, by `void decode(Cdr&, T&)` and `void encode(Cdr&, const T&)` of T's
/// namespace.
template <class T>
class Type final : public dds::TopicDataType {
 public:
  explicit Type(const char* name) {
    setName(name);
    m_typeSize = 1 << 14;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    payload->encapsulation = CDR_LE;
    cdr.serialize_encapsulation();
    encode(cdr, *static_cast<const T*>(data));
    payload->length = static_cast<std::uint32_t>(cdr.getSerializedDataLength());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    try {
      cdr.read_encapsulation();
      decode(cdr, *static_cast<T*>(data));
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return std::uint32_t{1 << 14}; };
  }
  void* createData() override { return new T(); }
  void deleteData(void* data) override { delete static_cast<T*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

/// What is known of another's publisher or subscription by discovery.
struct Found {
  std::string topic, type;
};

class Peer final : public dds::DomainParticipantListener {
 public:
  /// The profile of the shipped file.
  static dds::DomainParticipantQos on_loopback() {
    auto* factory = dds::DomainParticipantFactory::get_instance();
    dds::DomainParticipantQos qos;
    using Code = eprosima::fastrtps::types::ReturnCode_t;
    if (factory->load_XML_profiles_file(OMNIFLIGHT_SOURCE_ROOT "/configs/fastdds_loopback.xml") !=
            Code::RETCODE_OK ||
        factory->get_participant_qos_from_profile("loopback", qos) != Code::RETCODE_OK)
      throw std::runtime_error("Fast DDS does not take configs/fastdds_loopback.xml");
    return qos;
  }

  explicit Peer(int domain) {
    const dds::DomainParticipantQos qos = on_loopback();
    auto* factory = dds::DomainParticipantFactory::get_instance();
    participant_ =
        factory->create_participant(static_cast<std::uint32_t>(domain), qos, this, dds::StatusMask::none());
    if (participant_ == nullptr) throw std::runtime_error("Fast DDS makes no participant");
  }
  ~Peer() override {
    participant_->set_listener(nullptr);
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  std::set<Gid> participants() const { return copy(participants_); }
  std::map<Gid, Found> writers() const { return copy(writers_); }
  std::map<Gid, Found> readers() const { return copy(readers_); }

  /// RELIABLE, and TRANSIENT_LOCAL where it is latched.
  template <class T>
  dds::DataReader* reader(const char* topic, const char* type, bool latched) {
    dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().depth = 64;
    dds::Subscriber* by = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    dds::DataReader* out = by->create_datareader(topic_of<T>(topic, type), qos);
    if (out == nullptr) throw std::runtime_error("Fast DDS makes no reader");
    return out;
  }
  template <class T>
  dds::DataWriter* writer(const char* topic, const char* type) {
    dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    dds::Publisher* by = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    dds::DataWriter* out = by->create_datawriter(topic_of<T>(topic, type), qos);
    if (out == nullptr) throw std::runtime_error("Fast DDS makes no writer");
    return out;
  }

 private:
  template <class T>
  dds::Topic* topic_of(const char* topic, const char* type) {
    dds::TypeSupport support(new Type<T>(type));
    support.register_type(participant_);
    return participant_->create_topic(topic, type, dds::TOPIC_QOS_DEFAULT);
  }
  template <class Container>
  Container copy(const Container& of) const {
    const std::lock_guard lock(mutex_);
    return of;
  }
  template <class Proxy>
  void note(const dds::DomainParticipant* self, std::map<Gid, Found>& into, const Proxy& proxy, bool gone) {
    if (proxy.guid().guidPrefix == self->guid().guidPrefix) return;  // its own are reported, too
    const std::lock_guard lock(mutex_);
    if (gone)
      into.erase(gid_of(proxy.guid()));
    else
      into[gid_of(proxy.guid())] = {proxy.topicName().c_str(), proxy.typeName().c_str()};
  }
  void on_participant_discovery(dds::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& found) override {
    const std::lock_guard lock(mutex_);
    const Gid gid = gid_of(found.info.m_guid);
    if (found.status == rtps::ParticipantDiscoveryInfo::REMOVED_PARTICIPANT ||
        found.status == rtps::ParticipantDiscoveryInfo::DROPPED_PARTICIPANT)
      participants_.erase(gid);
    else
      participants_.insert(gid);
  }
  void on_publisher_discovery(dds::DomainParticipant* self, rtps::WriterDiscoveryInfo&& found) override {
    note(self, writers_, found.info, found.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER);
  }
  void on_subscriber_discovery(dds::DomainParticipant* self, rtps::ReaderDiscoveryInfo&& found) override {
    note(self, readers_, found.info, found.status == rtps::ReaderDiscoveryInfo::REMOVED_READER);
  }

  dds::DomainParticipant* participant_ = nullptr;
  mutable std::mutex mutex_;  ///< guards everything below
  std::set<Gid> participants_;
  std::map<Gid, Found> writers_, readers_;
};

}  // namespace omniflight::bus::second_vendor
