// `replay`: the messages of an MCAP file on the bus again.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <thread>
#include <utility>

#include "omniflight_bus/domain.hpp"
#include "omniflight_bus/raw_publisher.hpp"
#include "omniflight_components/topics.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_reader.hpp"
#include "verbs.hpp"

namespace omniflight::cli {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr double kLongestGap =
    1.0;  // s of silence that is waited for; stamps may jump from one clock to another

struct ReplayOptions {
  std::string file;
  std::vector<std::string> only;
  double rate = 1.0, wait_s = 2.0;
  int domain = 0;
};

struct Message {
  std::uint64_t ns;
  std::size_t topic;
  std::string data;
};

Result<int> replay(const ReplayOptions& o, const Common& common) {
  auto bytes = files::read_file(o.file, std::size_t{2} << 30);
  if (!bytes) return Failure(bytes.error());
  std::map<std::string, std::size_t> index;
  std::vector<std::pair<std::string, std::string>> found;  // topic, type
  std::vector<Message> messages;
  const auto content = recording::scan_mcap(
      *bytes, o.file, [&](const recording::McapChannel& c, const recording::McapMessage& m) {
        // what it says of its components is not true now; it can be asked for
        if (o.only.empty() && c.topic == components::topics::state) return;
        if (!o.only.empty() && std::find(o.only.begin(), o.only.end(), c.topic) == o.only.end()) return;
        const auto [at, fresh] = index.try_emplace(c.topic, found.size());
        if (fresh) found.emplace_back(c.topic, c.schema.name);
        messages.push_back({m.log_ns, at->second, std::string(m.data)});
      });
  if (!content) return Failure(content.error());
  if (messages.empty())
    return bad_input("has no message" + std::string(o.only.empty() ? "" : " on these topics"), o.file,
                     "`omniflight info` lists what it holds");
  std::stable_sort(messages.begin(), messages.end(), [](auto& a, auto& b) { return a.ns < b.ns; });
  if (auto configs = files::config_dir())
    (void)bus::use_loopback((*configs / "cyclonedds_loopback.xml").string());
  auto participant = bus::Participant::create(o.domain);
  if (!participant) return Failure(participant.error());
  std::vector<std::optional<bus::RawPublisher>> publishers(found.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto* type = msgs::find_message_type(found[k].second);
    if (!type) {
      say(common, "  " + found[k].first + ": type " + found[k].second + " is unknown here, left out");
      continue;
    }
    const bool latched = found[k].first == components::topics::trajectory;
    auto made = bus::RawPublisher::create(*participant, *type, found[k].first,
                                          latched ? bus::Qos::latched_last() : bus::Qos::bulk(512));
    if (!made) return Failure(made.error());
    publishers[k].emplace(std::move(*made));
  }
  // whoever wants to hear it from the first message on may take a moment to be found; nobody need
  const auto heard =
      std::find_if(publishers.begin(), publishers.end(), [](auto& p) { return p.has_value(); });
  if (heard != publishers.end())
    (void)(*heard)->wait_for_peers(1, std::chrono::nanoseconds(static_cast<std::int64_t>(o.wait_s * 1e9)));
  std::this_thread::sleep_for(100ms);  // the other side may know a few milliseconds later
  Progress progress("replay", static_cast<double>(messages.size()), "messages", common.quiet);
  std::vector<std::uint64_t> sent(found.size(), 0);
  auto due = Clock::now();
  std::uint64_t before = messages.front().ns;
  double shortened = 0, done = 0;
  for (const Message& m : messages) {
    if (interrupted()) break;
    double gap = 1e-9 * static_cast<double>(m.ns - std::exchange(before, m.ns));
    if (gap > kLongestGap) shortened += gap - kLongestGap, gap = kLongestGap;
    if (o.rate > 0) {
      due += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap / o.rate));
      std::this_thread::sleep_until(due);
    }
    if (!publishers[m.topic]) continue;
    if (auto ok =
            publishers[m.topic]->publish(std::as_bytes(std::span(m.data)), static_cast<std::int64_t>(m.ns));
        !ok)
      return Failure(ok.error());
    ++sent[m.topic];
    progress.update(++done);
  }
  progress.finish();
  std::this_thread::sleep_for(200ms);  // what is on its way arrives
  if (shortened > 0)
    say(common,
        fmt::format("gaps longer than {} s were shortened, by {:.1f} s in all", kLongestGap, shortened));
  nlohmann::json j{{"file", o.file}, {"domain", o.domain}, {"complete", !interrupted()}};
  for (std::size_t k = 0; k < found.size(); ++k) {
    j["messages"][found[k].first] = sent[k];
    say(common, fmt::format("  {:26} {:8} messages", found[k].first, sent[k]));
  }
  print_json(common, j);
  return interrupted() ? static_cast<int>(ErrorCode::incomplete) : 0;
}

}  // namespace

Action add_replay(CLI::App& verb, Common& common) {
  auto o = std::make_shared<ReplayOptions>();
  verb.add_option("recording", o->file, "MCAP file; others: `omniflight import LOG --out LOG.mcap` first")
      ->required();
  verb.add_option("--topic", o->only, "Only these topics");
  verb.add_option("--rate", o->rate, "Times real time; 0 = as fast as possible")->check(not_negative());
  verb.add_option("--domain", o->domain, "Domain of the bus")->check(CLI::Range(0, 231));
  verb.add_option("--wait-s", o->wait_s, "Longest wait for a listener [s]")->check(not_negative());
  return [o, &common] { return replay(*o, common); };
}

}  // namespace omniflight::cli
