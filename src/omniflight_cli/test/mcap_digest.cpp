// Prints one line for each topic of a complete MCAP file: topic, number of messages, sha256 over the sequence
// of (log time, size, bytes). Two recordings are the same, sample for sample, when their lines are. Usage:
// mcap_digest FILE
#include <cstdio>
#include <map>
#include <string>

#include "omniflight_files/files.hpp"
#include "omniflight_recording/mcap_reader.hpp"

namespace {

struct Topic {
  std::uint64_t messages = 0;
  std::string content;
  void add(std::string_view data) { content.append(data); }
  void add(std::uint64_t number) { content.append(reinterpret_cast<const char*>(&number), sizeof number); }
};

}  // namespace

int main(int argc, char** argv) {
  using namespace omniflight;
  if (argc != 2) {
    std::fprintf(stderr, "usage: mcap_digest FILE\n");
    return 4;
  }
  const auto bytes = files::read_file(argv[1], 1024 * files::kMegabyte);
  if (!bytes) {
    std::fprintf(stderr, "%s\n", bytes.error().text().c_str());
    return 4;
  }
  std::map<std::string, Topic> topics;
  const auto content = recording::scan_mcap(
      *bytes, argv[1], [&](const recording::McapChannel& channel, const recording::McapMessage& message) {
        Topic& topic = topics[channel.topic];
        topic.add(message.log_ns);
        topic.add(message.data.size());
        topic.add(message.data);
        ++topic.messages;
      });
  if (!content || !content->complete) {
    std::fprintf(stderr, "%s: %s\n", argv[1], content ? "not complete" : content.error().text().c_str());
    return 2;
  }
  for (const auto& [name, topic] : topics)
    std::printf("%s %llu %s\n", name.c_str(), static_cast<unsigned long long>(topic.messages),
                files::sha256_hex(topic.content).c_str());
  return 0;
}
