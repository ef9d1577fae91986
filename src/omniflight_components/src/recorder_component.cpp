// Writes every topic of a flight into one MCAP file. Messages are copied into a bounded queue on the bus's
// thread and written by a thread of its own, so that a slow disk never blocks a publisher; what does not fit
// is counted, and so is what publishers say they sent and never arrived.
#include <atomic>
#include <condition_variable>
#include <deque>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>

#include "conversions.hpp"
#include "factories.hpp"
#include "omniflight_bus/delivery_ledger.hpp"
#include "omniflight_bus/parameters.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_writer.hpp"

namespace omniflight::components {
namespace {

using namespace std::chrono_literals;
using msgs::omniflight_msgs::ComponentState;
using msgs::omniflight_msgs::RecorderState;
using msgs::omniflight_msgs::Tick;

std::uint64_t monotonic_ns() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

class Recorder final : public bus::Component {
 public:
  Recorder() : Component("recorder") {}
  ~Recorder() override { stop(); }

 private:
  static constexpr std::int64_t kOtherClock = 86'400'000'000'000;  // ns: a day off is another clock
  static constexpr std::size_t kMostEarly = 256;                   // messages

  struct Item {
    std::size_t channel;
    std::int64_t source_ns;
    std::uint32_t sequence;
    std::string bytes;
  };
  /// Tells a message from the one before it on its topic.
  struct Fingerprint {
    std::int64_t source_ns = -1;
    std::size_t hash = 0;
    bool operator==(const Fingerprint&) const = default;
  };

  Status on_configure(const YAML::Node& node) override {
    bus::Parameters p(node, "recorder");
    file_ = p.text("file", {});
    const bool overwrite = p.flag("overwrite", false);
    const std::string attachments = p.text("attachments", "");
    const std::string metadata = p.text("metadata", "");
    record_truth_ = p.flag("record_truth", true);
    capacity_ = static_cast<std::size_t>(p.integer("queue_bytes", 64 << 20, 1 << 16, std::int64_t{1} << 32));
    if (auto ok = p.finish(); !ok) return ok;
    auto writer = recording::McapWriter::create(file_, {.overwrite = overwrite});
    if (!writer) return Failure(writer.error());
    writer_ = std::move(*writer);
    std::map<std::string, std::string> facts;
    for (const std::string& item : split(metadata)) {
      const auto equals = item.find('=');
      if (equals != std::string::npos) facts[item.substr(0, equals)] = item.substr(equals + 1);
    }
    if (auto ok = writer_->write_metadata("omniflight", facts); !ok) return ok;
    for (const std::string& path : split(attachments)) {
      auto content = files::read_file(path, 16 * files::kMegabyte);
      if (!content) return Failure(content.error());
      const std::string name = path.substr(path.find_last_of('/') + 1);
      if (auto ok = writer_->write_attachment(name, "text/plain", 0, *content); !ok) return ok;
    }
    std::vector<const msgs::MessageType*> types;
    for (const topics::Entry& t : topics::recorded) {
      if (!record_truth_ && t.topic == std::string_view(topics::truth)) continue;
      const msgs::MessageType* type = msgs::find_message_type(t.type);
      if (!type)
        return fail(ErrorCode::internal, std::string("type ") + t.type + " is not in the table", "recorder");
      if (auto ok = add_channel(t, *type); !ok) return ok;
      types.push_back(type);
    }
    if (auto ok = subscribe(types); !ok) return ok;
    auto counts = bus::Subscription<ComponentState>::create(
        participant(), topics::state, bus::Qos::latched_last(16),
        [this](const ComponentState& m, std::int64_t) { ledger_.note(m); });
    if (!counts) return Failure(counts.error());
    counts_.emplace(std::move(*counts));
    auto state = advertise<RecorderState>(topics::recorder, bus::Qos::control());
    if (!state) return Failure(state.error());
    state_.emplace(std::move(*state));
    bus::set_text(state_message_->file, file_);
    running_ = true;  // a latched message may already be here
    thread_ = std::thread([this] { write_loop(); });
    return {};
  }
  Status add_channel(const topics::Entry& t, const msgs::MessageType& type) {
    auto channel = writer_->add_topic(
        {t.topic, std::string(type.ros_name), std::string(type.schema),
         std::string("- history: keep_last\n  depth: 512\n  reliability: reliable\n  durability: ") +
             (t.latched ? "transient_local" : "volatile") + "\n",
         std::string(type.type_hash)});
    if (!channel) return Failure(channel.error());
    channels_.push_back(*channel);
    topics_.emplace_back(t.topic);
    latched_.push_back(t.latched);
    sequences_.push_back(0);
    newest_.emplace_back();
    return {};
  }
  /// Messages may come from the first subscription on, in threads of the bus: every channel is there before.
  Status subscribe(const std::vector<const msgs::MessageType*>& types) {
    for (std::size_t index = 0; index < types.size(); ++index) {
      auto subscription = bus::RawSubscription::create(
          participant(), *types[index], topics_[index],
          latched_[index] ? bus::Qos::latched_last(16) : bus::Qos::bulk(),
          [this, index](std::span<const std::byte> cdr, std::int64_t ns) { enqueue(index, cdr, ns); });
      if (!subscription) return Failure(subscription.error());
      subscriptions_.push_back(std::move(*subscription));
    }
    return {};
  }
  Status on_cleanup() override {
    subscriptions_.clear();
    counts_.reset();
    stop();
    if (writer_)
      for (std::size_t k = 0; k < channels_.size(); ++k)
        if (const std::uint64_t lost = ledger_.lost(topics_[k], sequences_[k]); lost > 0)
          writer_->count_dropped(channels_[k], lost);
    state_.reset();
    Status status = error_;
    if (writer_) {
      if (auto ok = writer_->close(); !ok && status) status = ok;
      writer_.reset();
    }
    return status;
  }
  void stop() {
    {
      const std::lock_guard lock(mutex_);
      running_ = false;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  void enqueue(std::size_t channel, std::span<const std::byte> cdr, std::int64_t ns) {
    bool notify = false;
    {
      const std::lock_guard lock(mutex_);
      const std::uint32_t sequence = sequences_[channel]++;
      // in lockstep who was not heard in time says the same once more; that is no second sample
      const Fingerprint print{
          ns, std::hash<std::string_view>{}({reinterpret_cast<const char*>(cdr.data()), cdr.size()})};
      if (std::exchange(newest_[channel], print) == print) return;
      if (queued_bytes_ + cdr.size() > capacity_) {
        ++dropped_[channel];
        ++lost_;
        return;
      }
      Item item{channel, ns, sequence, spare_.empty() ? std::string() : std::move(spare_.back())};
      if (!spare_.empty()) spare_.pop_back();
      item.bytes.assign(reinterpret_cast<const char*>(cdr.data()), cdr.size());
      queued_bytes_ += cdr.size();
      queue_.push_back(std::move(item));
      notify = queue_.size() == 64;  // the writer looks every few milliseconds anyway
    }
    if (notify) wake_.notify_one();
  }

  /// All log times of a file lie on the clock of its ticks. What a component says of itself carries wall
  /// time; beside simulated time it is logged at the tick it came with. Before the first tick that clock is
  /// not known, so such messages wait for it (early_).
  void write(const Item& item, std::uint64_t now) {
    std::int64_t ns = std::max<std::int64_t>(0, item.source_ns);
    if (flight_ns_ && std::abs(ns - *flight_ns_) > kOtherClock) ns = *flight_ns_;
    const auto stamp = static_cast<std::uint64_t>(ns);
    if (error_)
      error_ = writer_->write(channels_[item.channel], item.sequence, stamp, stamp, item.bytes, now);
  }

  void write_loop() {
    std::deque<Item> batch;
    std::uint64_t ticks = 0, reported = 0;
    for (bool last = false; !last;) {
      {
        std::unique_lock lock(mutex_);
        wake_.wait_for(lock, 5ms, [&] { return !running_ || queue_.size() >= 64; });
        batch.swap(queue_);
        queued_bytes_ = 0;
        last = !running_ && batch.empty();
        for (auto& [channel, count] : dropped_)
          if (count > 0) writer_->count_dropped(channels_[channel], std::exchange(count, 0));
      }
      const std::uint64_t now = monotonic_ns();
      for (Item& item : batch) {
        if (item.channel == 0) {
          flight_ns_ = item.source_ns;
          ++ticks;
        }
        if (!flight_ns_ && latched_[item.channel] && early_.size() < kMostEarly)
          early_.push_back(std::move(item));
        else
          write(item, now);
      }
      if (flight_ns_ || last) {
        for (const Item& item : early_) write(item, now);
        early_.clear();
      }
      {
        const std::lock_guard lock(mutex_);
        while (!batch.empty()) {
          if (spare_.size() < 4096) spare_.push_back(std::move(batch.back().bytes));
          batch.pop_back();
        }
      }
      if (error_) error_ = writer_->tick(now);
      if (!error_ && !reported_error_) {
        reported_error_ = true;
        finish(error_);
      }
      if (ticks != reported || last) {
        reported = ticks;
        state_message_->stored = writer_->statistics().messages;
        state_message_->lost = losses();
        state_message_->ticks_seen = ticks;
        (void)state_->publish(*state_message_);
      }
    }
  }
  /// Dropped here, and sent but never received. In flight the counts of the senders are up to a second old.
  std::uint64_t losses() {
    const std::lock_guard lock(mutex_);
    std::uint64_t lost = lost_;
    for (std::size_t k = 0; k < channels_.size(); ++k) lost += ledger_.lost(topics_[k], sequences_[k]);
    return lost;
  }

  std::string file_;
  bool record_truth_ = true;
  std::unique_ptr<recording::McapWriter> writer_;
  std::vector<std::uint16_t> channels_;
  std::vector<std::string> topics_;
  std::vector<bool> latched_;              // by channel: waits for the first tick
  std::vector<Item> early_;                // by the writing thread
  std::optional<std::int64_t> flight_ns_;  // of the last tick, by the writing thread
  bus::DeliveryLedger ledger_;
  std::optional<bus::Subscription<ComponentState>> counts_;
  std::vector<bus::RawSubscription> subscriptions_;
  std::optional<bus::Publisher<RecorderState>> state_;
  bus::Message<RecorderState> state_message_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> queue_;
  std::vector<std::string> spare_;
  std::vector<std::uint32_t> sequences_;
  std::vector<Fingerprint> newest_;
  std::map<std::size_t, std::uint64_t> dropped_;
  std::size_t queued_bytes_ = 0, capacity_ = 64 << 20;
  std::uint64_t lost_ = 0;
  bool running_ = false, reported_error_ = false;
  Status error_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<bus::Component> make_recorder() { return std::make_unique<Recorder>(); }

}  // namespace omniflight::components
