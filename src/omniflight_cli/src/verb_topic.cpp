// `topic list|echo|hz|record`: what is said on the bus right now.
#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <mutex>
#include <thread>

#include "bus_access.hpp"
#include "folder.hpp"
#include "omniflight_bus/subscription.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_recording/mcap_writer.hpp"
#include "process.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
namespace topics = components::topics;

struct TopicOptions {
  std::string action, topic, keys;
  double for_s = 3.0;
  std::uint64_t count = 5;
  int domain = 0;
};

struct Heard {
  std::int64_t ns;
  std::string bytes;
};

/// Everything said on some topics while it lives; at most `most` messages a topic are kept.
class Ear {
 public:
  explicit Ear(std::size_t most) : most_(most) {}
  Status listen(const bus::Participant& participant, const topics::Entry& entry) {
    const msgs::MessageType* type = msgs::find_message_type(entry.type);
    if (!type) return fail(ErrorCode::internal, "its type is not in the table", entry.topic);
    counts_.push_back(0);
    heard_.emplace_back();
    const std::size_t k = counts_.size() - 1;
    auto made = bus::RawSubscription::create(
        participant, *type, entry.topic, entry.latched ? bus::Qos::latched_last(16) : bus::Qos::bulk(512),
        [this, k](std::span<const std::byte> cdr, std::int64_t ns) {
          const std::lock_guard lock(mutex_);
          ++counts_[k];
          if (heard_[k].size() < most_)
            heard_[k].push_back({ns, std::string(reinterpret_cast<const char*>(cdr.data()), cdr.size())});
        });
    if (!made) return Failure(made.error());
    subscriptions_.push_back(std::move(*made));
    return {};
  }
  std::uint64_t count(std::size_t k) {
    const std::lock_guard lock(mutex_);
    return counts_[k];
  }
  std::uint32_t publishers(std::size_t k) const { return subscriptions_[k].peers(); }
  /// Only once nothing is received any more.
  const std::vector<Heard>& heard(std::size_t k) const { return heard_[k]; }
  void stop() { subscriptions_.clear(); }

 private:
  std::mutex mutex_;
  std::size_t most_;
  std::vector<std::uint64_t> counts_;
  std::vector<std::vector<Heard>> heard_;
  std::vector<bus::RawSubscription> subscriptions_;
};

/// Waits for_s seconds, or until enough is heard, or Ctrl-C. Seconds waited.
double wait(double for_s, const std::function<bool()>& enough) {
  const auto begin = std::chrono::steady_clock::now();
  const auto passed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  while (passed() < for_s && !interrupted() && !enough()) std::this_thread::sleep_for(5ms);
  return passed();
}

Result<const topics::Entry*> find_topic(const std::string& name) {
  std::vector<std::string> known;
  for (const auto& entry : topics::recorded) {
    if (name == entry.topic) return &entry;
    known.emplace_back(entry.topic);
  }
  const std::string near = files::nearest_word(name, known);
  return bad_input("unknown topic " + files::shown(name), "topic",
                   near.empty() ? "`omniflight topic list` shows them" : "Did you mean '" + near + "'?");
}

Result<int> list(const TopicOptions& o, const bus::Participant& participant, const Common& common) {
  Ear ear(0);
  for (const auto& entry : topics::recorded)
    if (auto ok = ear.listen(participant, entry); !ok) return Failure(ok.error());
  wait(o.for_s, [] { return false; });
  nlohmann::json j = nlohmann::json::array();
  std::size_t alive = 0;
  for (std::size_t k = 0; k < std::size(topics::recorded); ++k) {
    const auto& entry = topics::recorded[k];
    alive += ear.publishers(k) > 0;
    j.push_back({{"topic", entry.topic},
                 {"type", entry.type},
                 {"publishers", ear.publishers(k)},
                 {"messages", ear.count(k)}});
    say(common, fmt::format("{:26} {:42} {} publishers, {} messages in {:.1f} s", entry.topic, entry.type,
                            ear.publishers(k), ear.count(k), o.for_s));
  }
  print_json(common, j);
  return alive > 0 ? 0 : static_cast<int>(ErrorCode::incomplete);
}

Result<int> hz(const TopicOptions& o, const bus::Participant& participant, const topics::Entry& entry,
               const Common& common) {
  Ear ear(1'000'000);
  if (auto ok = ear.listen(participant, entry); !ok) return Failure(ok.error());
  const double seconds = wait(o.for_s, [] { return false; });
  ear.stop();
  const auto& heard = ear.heard(0);
  double worst = 0;
  for (std::size_t i = 1; i < heard.size(); ++i)
    worst = std::max(worst, 1e-9 * static_cast<double>(heard[i].ns - heard[i - 1].ns));
  const double span = heard.size() > 1 ? 1e-9 * static_cast<double>(heard.back().ns - heard.front().ns) : 0.0;
  const double stamped = span > 0 ? static_cast<double>(heard.size() - 1) / span : 0.0;
  print_json(common, {{"topic", entry.topic},
                      {"messages", heard.size()},
                      {"wall_Hz", static_cast<double>(heard.size()) / seconds},
                      {"stamp_Hz", stamped},
                      {"longest_gap_s", worst}});
  say(common,
      fmt::format(
          "{}: {} messages in {:.1f} s, {:.1f} Hz by arrival, {:.1f} Hz by stamp, longest gap {:.4f} s",
          entry.topic, heard.size(), seconds, static_cast<double>(heard.size()) / seconds, stamped, worst));
  return heard.empty() ? static_cast<int>(ErrorCode::incomplete) : 0;
}

/// The messages as samples of canonical signals: through a recording, the one place that decodes them.
Result<recording::Recording> decode(const topics::Entry& entry, const std::vector<Heard>& heard) {
  const fs::path file =
      fs::temp_directory_path() / ("omniflight_echo_" + std::to_string(::getpid()) + ".mcap");
  const msgs::MessageType& type = *msgs::find_message_type(entry.type);
  auto result = [&]() -> Result<recording::Recording> {
    auto writer = recording::McapWriter::create(file, {.overwrite = true});
    if (!writer) return Failure(writer.error());
    auto channel = (*writer)->add_topic(
        {entry.topic, std::string(type.ros_name), std::string(type.schema), "", std::string(type.type_hash)});
    if (!channel) return Failure(channel.error());
    for (std::size_t i = 0; i < heard.size(); ++i) {
      const auto ns = static_cast<std::uint64_t>(std::max<std::int64_t>(0, heard[i].ns));
      if (auto ok = (*writer)->write(*channel, static_cast<std::uint32_t>(i), ns, ns, heard[i].bytes, 0); !ok)
        return Failure(ok.error());
    }
    if (auto ok = (*writer)->close(); !ok) return Failure(ok.error());
    return recording::load(file);
  }();
  std::error_code ec;
  fs::remove(file, ec);
  return result;
}

Result<int> echo(const TopicOptions& o, const bus::Participant& participant, const topics::Entry& entry,
                 const Common& common) {
  Ear ear(o.count);
  if (auto ok = ear.listen(participant, entry); !ok) return Failure(ok.error());
  wait(o.for_s, [&] { return ear.count(0) >= o.count; });
  ear.stop();
  if (ear.heard(0).empty()) {
    say(common, fmt::format("nothing was said on {} within {:.1f} s", entry.topic, o.for_s));
    print_json(common, nlohmann::json::array());
    return static_cast<int>(ErrorCode::incomplete);
  }
  auto r = decode(entry, ear.heard(0));
  if (!r) return Failure(r.error());
  nlohmann::json all = nlohmann::json::array();
  for (const auto& [name, s] : r->signals)
    for (Eigen::Index i = 0; i < s.size(); ++i) {
      nlohmann::json line{
          {"signal", name}, {"unit", s.unit}, {"t_s", r->start_s + s.t_s[static_cast<std::size_t>(i)]}};
      for (Eigen::Index c = 0; c < s.width(); ++c) line["value"].push_back(s.values(i, c));
      say(common, line.dump());
      all.push_back(std::move(line));
    }
  if (all.empty())
    say(common, fmt::format("{} messages, which carry no signal of a flight", ear.heard(0).size()));
  print_json(common, all);
  return 0;
}

Result<int> record(const TopicOptions& o, const std::string& keys, const Common& common) {
  const auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  const fs::path out = common.out.empty() ? fresh_folder("recorded") + ".mcap" : common.out;
  if (out.has_parent_path())
    if (auto ok = make_folder(out.parent_path().string()); !ok) return Failure(ok.error());
  auto program = find_program("omniflight_recorder");
  if (!program) return Failure(program.error());
  std::vector<std::string> arguments{"-p",         "file:=" + nlohmann::json(out.string()).dump(),
                                     "--domain",   std::to_string(o.domain),
                                     "--loopback", (*configs / "cyclonedds_loopback.xml").string()};
  if (!keys.empty()) arguments.insert(arguments.end(), {"--secure", fs::absolute(keys).string()});
  const std::string log = out.string() + ".log";
  auto child = Child::start(*program, arguments, {.log = log});
  if (!child) return Failure(child.error());
  wait(o.for_s, [&] { return child->poll().has_value(); });
  const bool early = child->poll().has_value();
  const std::string words = child->last_words();
  const int code = child->terminate(5.0);
  if (early || code != 0)
    return fail(static_cast<ErrorCode>(code == 4 ? 4 : 2), words, "recorder", "Its log is " + log);
  std::error_code ec;
  fs::remove(log, ec);
  auto r = recording::load(out);
  if (!r) return Failure(r.error());
  say(common, fmt::format("{}: {:.2f} s, {} signals", out.string(), r->duration_s, r->signals.size()));
  print_json(common,
             {{"written", out.string()}, {"duration_s", r->duration_s}, {"signals", r->signal_names()}});
  return r->signals.empty() ? static_cast<int>(ErrorCode::incomplete) : 0;
}

Result<int> topic(const TopicOptions& o, const Common& common) {
  std::string keys = o.keys;
  if (auto ok = use_bus_of(o.domain, keys); !ok) return Failure(ok.error());
  if (o.action == "record") return record(o, keys, common);
  auto participant = bus::Participant::create(o.domain);
  if (!participant) return Failure(participant.error());
  if (o.action == "list") return list(o, *participant, common);
  if (o.topic.empty())
    return bad_input("needs a topic", "topic " + o.action, "`omniflight topic list` shows them");
  auto entry = find_topic(o.topic);
  if (!entry) return Failure(entry.error());
  return o.action == "hz" ? hz(o, *participant, **entry, common) : echo(o, *participant, **entry, common);
}

}  // namespace

Action add_topic(CLI::App& verb, Common& common) {
  auto o = std::make_shared<TopicOptions>();
  verb.add_option("action", o->action, "list | echo | hz | record")
      ->required()
      ->check(CLI::IsMember({"list", "echo", "hz", "record"}));
  verb.add_option("topic", o->topic, "For echo and hz");
  verb.add_option("--domain", o->domain, "Domain of the bus")->check(CLI::Range(0, 231));
  add_secure(verb, o->keys);
  verb.add_option("--for-s", o->for_s, "Longest time to listen [s]")->check(not_negative(false));
  verb.add_option("--count", o->count, "echo: messages")->check(CLI::Range(1, 1000000));
  return [o, &common] { return topic(*o, common); };
}

}  // namespace omniflight::cli
