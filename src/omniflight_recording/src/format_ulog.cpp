// PX4 ULog: topics become signals as the map px4 says; parameters, texts and dropouts are kept beside them.
#include <cstdio>

#include "format_table.hpp"
#include "omniflight_recording/vehicle_hints.hpp"
#include "topic_feeds.hpp"
#include "ulog_reader.hpp"
#include "ulog_records.hpp"

namespace omniflight::recording {
namespace {

constexpr std::size_t kShownTexts = 50, kShownDropouts = 50, kShownChanges = 20;

class UlogLoader {
 public:
  UlogLoader(TopicMap map, Recording& recording) : recording_(recording), feeds_(std::move(map), recording) {}

  void message(const UlogContent& content, const UlogSubscription& topic, std::string_view data,
               std::uint64_t us) {
    if (!started_) start(content, us);
    const auto [place, fresh] = topics_.try_emplace({topic.name, topic.instance}, 0);
    if (fresh) {
      DeclaredTopic declared;
      declared.name = topic.name;
      declared.instance = topic.instance;
      declared.encoding = Encoding::ulog;
      declared.types = &content.types;
      place->second = feeds_.open(declared);
    }
    feeds_.message(place->second, data, static_cast<std::int64_t>(us * 1000));
  }

  Status finish(const UlogContent& content) {
    if (!started_) start(content, content.start_us);
    if (auto ok = feeds_.finish(); !ok) return ok;
    for (const char* name : {"sys_name", "ver_hw", "ver_hw_subtype", "ver_sw", "ver_sw_branch",
                             "ver_sw_release", "sys_os_name", "time_ref_utc"})
      if (const auto found = content.information.find(name); found != content.information.end())
        recording_.metadata[std::string("ulog.") + name] = found->second;
    recording_.metadata["ulog.version"] = std::to_string(content.version);
    recording_.metadata["ulog.messages"] = std::to_string(content.messages);
    recording_.metadata["ulog.dropouts"] = std::to_string(content.dropout_count);
    recording_.notes.insert(recording_.notes.end(), content.notes.begin(), content.notes.end());
    tell_dropouts(content);
    tell_changes(content);
    tell_texts(content);
    return {};
  }

 private:
  void start(const UlogContent& content, std::uint64_t first_us) {
    started_ = true;
    constexpr std::uint64_t kNear = 600'000'000;  // us; otherwise the header's time is of another clock
    const bool near = content.start_us <= first_us && first_us - content.start_us < kNear;
    start_us_ = near ? content.start_us : first_us;
    feeds_.start_at(static_cast<std::int64_t>(start_us_ * 1000));
    recording_.parameters = content.parameters;
    if (const int rotors = vehicle_hints(recording_).rotor_count; rotors > 0)
      feeds_.limit_rotors(static_cast<std::size_t>(rotors));
  }

  double seconds(std::uint64_t us) const {
    return 1e-6 * (static_cast<double>(us) - static_cast<double>(start_us_));
  }

  static std::string at(double t_s) {
    char text[40];
    std::snprintf(text, sizeof text, "at %.3f s", t_s);
    return text;
  }

  void tell_dropouts(const UlogContent& content) {
    if (content.dropout_count == 0) return;
    std::uint32_t longest = 0;
    for (const UlogDropout& d : content.dropouts) longest = std::max(longest, d.duration_ms);
    recording_.note(Note::Kind::loss, "the logger lost data " + std::to_string(content.dropout_count) +
                                          " times, for " + std::to_string(content.dropouts_ms) +
                                          " ms together and " + std::to_string(longest) + " ms at most");
    std::size_t shown = 0;
    for (const UlogDropout& d : content.dropouts) {
      if (d.duration_ms == 0 || ++shown > kShownDropouts) continue;
      const double from = seconds(d.at_us);
      recording_.note(Note::Kind::loss, "gap of " + std::to_string(d.duration_ms) + " ms " + at(from), 0,
                      from, from + 1e-3 * d.duration_ms);
    }
  }

  void tell_changes(const UlogContent& content) {
    for (std::size_t i = 0; i < std::min(content.changes.size(), kShownChanges); ++i) {
      const UlogChange& c = content.changes[i];
      recording_.note(Note::Kind::information, "parameter " + c.name + " was set to " +
                                                   std::to_string(c.value) + " " + at(seconds(c.at_us)));
    }
    if (content.changes.size() > kShownChanges)
      recording_.note(Note::Kind::information,
                      "and " + std::to_string(content.changes.size() - kShownChanges) + " parameters more");
  }

  /// Warnings and worse.
  void tell_texts(const UlogContent& content) {
    std::size_t shown = 0;
    for (const UlogText& t : content.texts) {
      if (t.level > '4' || ++shown > kShownTexts) continue;
      recording_.note(Note::Kind::information, std::string(t.level <= '3' ? "error" : "warning") +
                                                   " of the autopilot " + at(seconds(t.at_us)) + ": " +
                                                   t.text);
    }
    recording_.metadata["ulog.texts"] = std::to_string(content.text_count);
  }

  Recording& recording_;
  TopicFeeds feeds_;
  std::map<std::pair<std::string, std::uint8_t>, std::size_t> topics_;
  std::uint64_t start_us_ = 0;
  bool started_ = false;
};

bool is_ulog(std::string_view head) { return head.substr(0, ulog::kMagic.size()) == ulog::kMagic; }

Result<Recording> read_ulog(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  auto map = topic_map_for(options.map);
  if (!map) return Failure(map.error());
  Recording recording;
  UlogLoader loader(std::move(*map), recording);
  const auto content =
      scan_ulog(bytes, file,
                [&](const UlogContent& c, const UlogSubscription& topic, std::string_view data,
                    std::uint64_t us) { loader.message(c, topic, data, us); });
  if (!content) return Failure(content.error());
  if (auto ok = loader.finish(*content); !ok) return Failure(ok.error());
  return recording;
}

}  // namespace

const Format& ulog_format() {
  static const Format format{"ulog", "PX4 ULog", is_ulog, read_ulog};
  return format;
}

}  // namespace omniflight::recording
