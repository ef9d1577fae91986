// Prints one line for each topic of a complete MCAP file: topic, number of messages, sha256 over the sequence
// of (log time, size, bytes). Two recordings are the same, sample for sample, when their lines are. Usage:
// mcap_digest FILE; with --times: topic, first and last log time [s].
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>

#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_reader.hpp"

namespace {

struct Topic {
  std::uint64_t messages = 0, first_ns = ~std::uint64_t{0}, last_ns = 0;
  std::string content;
  void add(std::string_view data) { content.append(data); }
  void add(std::uint64_t number) { content.append(reinterpret_cast<const char*>(&number), sizeof number); }
};

}  // namespace

int main(int argc, char** argv) {
  using namespace omniflight;
  const bool times = argc == 3 && std::string_view(argv[1]) == "--times";
  if (argc != (times ? 3 : 2)) {
    std::fprintf(stderr, "usage: mcap_digest [--times] FILE\n");
    return 4;
  }
  const char* const file = argv[argc - 1];
  const auto bytes = files::read_file(file, 1024 * files::kMegabyte);
  if (!bytes) {
    std::fprintf(stderr, "%s\n", bytes.error().text().c_str());
    return 4;
  }
  std::map<std::string, Topic> topics;
  const auto content = recording::scan_mcap(
      *bytes, file, [&](const recording::McapChannel& channel, const recording::McapMessage& message) {
        Topic& topic = topics[channel.topic];
        topic.first_ns = std::min(topic.first_ns, message.log_ns);
        topic.last_ns = std::max(topic.last_ns, message.log_ns);
        topic.add(message.log_ns);
        topic.add(message.data.size());
        topic.add(message.data);
        ++topic.messages;
      });
  if (!content || !content->complete) {
    std::fprintf(stderr, "%s: %s\n", file, content ? "not complete" : content.error().text().c_str());
    return 2;
  }
  if (times) {
    for (const auto& [name, topic] : topics)
      std::printf("%s %.9f %.9f\n", name.c_str(), 1e-9 * static_cast<double>(topic.first_ns),
                  1e-9 * static_cast<double>(topic.last_ns));
    return 0;
  }
  for (const auto& [name, topic] : topics)
    std::printf("%s %llu %s\n", name.c_str(), static_cast<unsigned long long>(topic.messages),
                files::sha256_hex(topic.content).c_str());
  return 0;
}
