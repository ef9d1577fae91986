#include "mcap_export.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "omniflight_components/topics.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_msgs/message_type.hpp"
#include "omniflight_recording/formats.hpp"
#include "omniflight_recording/mcap_reader.hpp"
#include "omniflight_recording/mcap_writer.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;
namespace topics = components::topics;
using recording::Recording;
using recording::Signal;

enum class Put {
  numbers,     ///< count float64 from the signal, from column `first`
  quaternion,  ///< (w, x, y, z) as x, y, z, w
  sequence,    ///< all columns as float64[]
  constant,    ///< count float64 of value `first`
  single,      ///< float32 from column `first`
  index,       ///< uint64, number of the message
  u32,         ///< 0
  u8,          ///< count bytes of value `first`
  nothing,     ///< empty sequence
  text,        ///< empty string
};
struct Field {
  Put put;
  const char* signal = "";
  int first = 0, count = 1;
};
struct Layout {
  const char* topic;
  std::vector<Field> fields;  ///< behind the header, in the order of the message definition
};

const std::vector<Layout>& layouts() {
  using enum Put;
  static const std::vector<Layout> table{
      {topics::imu,
       {{constant, "", 0, 4},
        {constant, "", -1, 1},
        {constant, "", 0, 8},
        {numbers, "gyro", 0, 3},
        {constant, "", 0, 9},
        {numbers, "acc", 0, 3},
        {constant, "", 0, 9}}},
      {topics::mocap, {{numbers, "position", 0, 3}, {quaternion, "attitude"}}},
      {topics::rotors, {{index}, {sequence, "rotor_speed"}, {nothing}, {numbers, "alpha", 0, 1}}},
      {topics::command, {{sequence, "alpha_command"}, {sequence, "rotor_command"}, {nothing}}},
      {topics::controller,
       {{index},
        {u8, "", 1},
        {constant, "", 0, 1},
        {numbers, "ref_position", 0, 3},
        {numbers, "ref_attitude", 0, 4},
        {numbers, "ref_velocity", 0, 3},
        {numbers, "ref_angular_velocity", 0, 3},
        {numbers, "ref_acceleration", 0, 3},
        {numbers, "ref_angular_acceleration", 0, 3},
        {numbers, "est_position", 0, 3},
        {numbers, "est_attitude", 0, 4},
        {numbers, "est_velocity", 0, 3},
        {numbers, "est_angular_velocity", 0, 3},
        {numbers, "integral", 0, 6},
        {numbers, "qddr", 0, 6},
        {nothing}}},
      {topics::allocator,
       {{index},
        {numbers, "alpha_command", 0, 1},
        {sequence, "thrust_command"},
        {numbers, "qdd", 0, 6},
        {constant, "", 0, 6},
        {constant, "", 0, 1},
        {u32},
        {constant, "", 0, 1}}},
      {topics::battery,
       {{single, "vbat"},
        {single, ""},
        {single, "ibat"},
        {single, ""},
        {single, ""},
        {single, ""},
        {single, ""},
        {u8, "", 0, 3},
        {u8, "", 1},
        {nothing},
        {nothing},
        {text},
        {text}}},
      {topics::truth,
       {{numbers, "truth_position", 0, 3},
        {numbers, "truth_attitude", 0, 4},
        {numbers, "truth_velocity", 0, 3},
        {numbers, "truth_angular_velocity", 0, 3},
        {sequence, "truth_rotor_speed"},
        {numbers, "truth_alpha", 0, 1},
        {numbers, "truth_power", 0, 1},
        {numbers, "truth_wrench", 0, 6}}},
  };
  return table;
}

/// XCDR1, little endian, with its encapsulation header.
class Cdr {
 public:
  void begin() { bytes_.assign("\x00\x01\x00\x00", 4); }
  template <class T>
  void put(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\0';
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
  }
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text);
    bytes_ += '\0';
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Values of a layout's signals at the times of the one with the most samples, so that none is lost; of
/// several the first.
struct Samples {
  const Signal* base = nullptr;
  std::map<std::string, Eigen::MatrixXd> values;
};

Samples sample(const Recording& r, const Layout& layout) {
  Samples out;
  for (const Field& f : layout.fields)
    if (const Signal* s = *f.signal != 0 ? r.find(f.signal) : nullptr)
      if (!out.base || s->size() > out.base->size()) out.base = s;
  if (!out.base) return out;
  for (const Field& f : layout.fields)
    if (const Signal* s = *f.signal != 0 ? r.find(f.signal) : nullptr)
      out.values[f.signal] = recording::resample(*s, out.base->t_s);
  return out;
}

void encode(const Layout& layout, const Samples& samples, Eigen::Index row, std::int64_t ns, Cdr& cdr) {
  cdr.begin();
  cdr.put(static_cast<std::int32_t>(ns / 1'000'000'000));
  cdr.put(static_cast<std::uint32_t>(ns % 1'000'000'000));
  cdr.put_text("map");
  for (const Field& f : layout.fields) {
    const auto at = samples.values.find(f.signal);
    const auto number = [&](Eigen::Index column) {
      return at != samples.values.end() && column < at->second.cols() ? at->second(row, column)
                                                                      : std::nan("");
    };
    switch (f.put) {
      case Put::numbers:
        for (int k = 0; k < f.count; ++k) cdr.put(number(f.first + k));
        break;
      case Put::quaternion:
        for (const int k : {1, 2, 3, 0}) cdr.put(number(k));
        break;
      case Put::sequence: {
        const Eigen::Index n = at != samples.values.end() ? at->second.cols() : 0;
        cdr.put(static_cast<std::uint32_t>(n));
        for (Eigen::Index k = 0; k < n; ++k) cdr.put(number(k));
        break;
      }
      case Put::constant:
        for (int k = 0; k < f.count; ++k) cdr.put(static_cast<double>(f.first));
        break;
      case Put::single:
        cdr.put(static_cast<float>(number(f.first)));
        break;
      case Put::index:
        cdr.put(static_cast<std::uint64_t>(row));
        break;
      case Put::u8:
        for (int k = 0; k < f.count; ++k) cdr.put(static_cast<std::uint8_t>(f.first));
        break;
      case Put::u32:
      case Put::nothing:
        cdr.put(std::uint32_t{0});
        break;
      case Put::text:
        cdr.put_text("");
        break;
    }
  }
}

const char* type_of(std::string_view topic) {
  for (const auto& entry : topics::recorded)
    if (topic == entry.topic) return entry.type;
  return "";
}

constexpr double kEpoch_s = 1e6;  // clocks beyond are subtracted by readers

/// Added to the times of the recording to get stamps [ns]: the epoch, counted apart from the times, because
/// 1e9 s in a double leaves 0.2 us; nothing for clocks that count from a boot, which readers do not subtract;
/// and what makes the earliest sample 0 where times are negative, which no stamp can be.
std::int64_t offset_of_stamps(const Recording& r) {
  double earliest = 0;
  for (const auto& [name, signal] : r.signals)
    if (!signal.empty()) earliest = std::min(earliest, signal.t_s.front());
  const double start = r.start_s > kEpoch_s ? r.start_s : 0.0;
  return std::llround(1e9 * std::max(start, -earliest));
}

Status write_topics(const Recording& r, recording::McapWriter& writer, McapExport& out) {
  std::map<std::string, std::string> facts = {{"origin", r.file}, {"origin_format", r.format}};
  for (const auto& [key, value] : r.metadata)
    if (key.rfind("omniflight.", 0) == 0 && key.rfind("omniflight.dropped", 0) != 0)
      facts[key.substr(11)] = value;
  if (auto ok = writer.write_metadata("omniflight", facts); !ok) return ok;
  const std::int64_t offset_ns = offset_of_stamps(r);
  Cdr cdr;
  for (const Layout& layout : layouts()) {
    const Samples samples = sample(r, layout);
    if (!samples.base) continue;
    const msgs::MessageType* type = msgs::find_message_type(type_of(layout.topic));
    if (!type) return fail(ErrorCode::internal, "the type of the topic is not in the table", layout.topic);
    auto channel = writer.add_topic({layout.topic, std::string(type->ros_name), std::string(type->schema), "",
                                     std::string(type->type_hash)});
    if (!channel) return Failure(channel.error());
    out.types[layout.topic] = std::string(type->ros_name);
    for (std::size_t i = 0; i < samples.base->t_s.size(); ++i) {
      const std::int64_t ns = offset_ns + std::llround(1e9 * samples.base->t_s[i]);
      encode(layout, samples, static_cast<Eigen::Index>(i), ns, cdr);
      const auto stamp = static_cast<std::uint64_t>(ns);
      if (auto ok = writer.write(*channel, static_cast<std::uint32_t>(i), stamp, stamp, cdr.bytes(), 0); !ok)
        return ok;
      out.first_ns = out.messages.empty() ? ns : std::min(out.first_ns, ns);
      out.last_ns = std::max(out.last_ns, ns);
      ++out.messages[layout.topic];
    }
  }
  return {};
}

/// Copies what a scan of the file finds into the writer.
class Copy {
 public:
  Copy(recording::McapWriter& writer, McapExport& out) : writer_(writer), out_(out) {}

  void message(const recording::McapChannel& from, const recording::McapMessage& m) {
    if (!status) return;
    const auto [place, fresh] = ids_.try_emplace(from.id, std::uint16_t{0});
    if (fresh) place->second = open(from);
    if (place->second == 0) return;
    status = writer_.write(place->second, m.sequence, m.log_ns, m.publish_ns, m.data, 0);
    const auto ns = static_cast<std::int64_t>(m.log_ns);
    out_.first_ns = out_.messages.empty() ? ns : std::min(out_.first_ns, ns);
    out_.last_ns = std::max(out_.last_ns, ns);
    ++out_.messages[from.topic];
  }

  void finish(const recording::McapContent& content) {
    for (const auto& [id, channel] : content.channels)  // topics on which nothing was said
      if (status && !ids_.contains(id)) ids_[id] = open(channel);
    for (const auto& [name, values] : content.metadata) {
      if (name == "omniflight.dropped") {
        for (const auto& [topic, count] : values)
          for (const auto& [id, channel] : content.channels)
            if (channel.topic == topic && ids_[id] != 0)
              writer_.count_dropped(ids_[id], std::strtoull(count.c_str(), nullptr, 10));
      } else if (status) {
        status = writer_.write_metadata(name, values);
      }
    }
    for (const auto& a : content.attachments)
      if (status) status = writer_.write_attachment(a.name, a.media_type, a.log_ns, a.data);
  }

  Status status;

 private:
  std::uint16_t open(const recording::McapChannel& from) {
    if (from.message_encoding != "cdr" || from.schema.encoding != "ros2msg") {
      out_.left_out.push_back(from.topic);
      return 0;
    }
    const auto told = [&](const char* key) {
      const auto found = from.metadata.find(key);
      return found == from.metadata.end() ? std::string() : found->second;
    };
    auto id = writer_.add_topic({from.topic, from.schema.name, from.schema.text, told("offered_qos_profiles"),
                                 told("topic_type_hash")});
    if (!id) {
      status = Failure(id.error());
      return 0;
    }
    out_.types[from.topic] = from.schema.name;
    return *id;
  }

  recording::McapWriter& writer_;
  McapExport& out_;
  std::map<std::uint16_t, std::uint16_t> ids_;  // from its channel to ours; 0: left out
};

Status copy_topics(const std::string& file, recording::McapWriter& writer, McapExport& out) {
  const auto bytes = files::read_gzip_or_plain(file, recording::LoadOptions{}.max_bytes);
  if (!bytes) return Failure(bytes.error());
  Copy copy(writer, out);
  const auto content = recording::scan_mcap(
      *bytes, file,
      [&](const recording::McapChannel& c, const recording::McapMessage& m) { copy.message(c, m); });
  if (!content) return Failure(content.error());
  copy.finish(*content);
  return copy.status;
}

}  // namespace

Result<McapExport> write_mcap(const Recording& r, const fs::path& path) {
  McapExport out;
  fs::path part = path;
  part += ".part" + std::to_string(::getpid());
  auto writer = recording::McapWriter::create(part, {.overwrite = true});
  if (!writer) return Failure(writer.error());
  // a bag in several files is written again from its signals
  const bool copied = r.format == std::string("mcap") && !fs::is_directory(r.file);
  Status ok = copied ? copy_topics(r.file, **writer, out) : write_topics(r, **writer, out);
  if (ok) ok = (*writer)->close();
  std::error_code ec;
  if (ok && out.messages.empty())
    ok = bad_input("has no signal that one of our topics carries", r.file,
                   "`omniflight info` lists its signals");
  if (ok) fs::rename(part, path, ec);
  if (ok && ec) ok = bad_input("cannot be written: " + ec.message(), path.string(), "Choose another --out");
  if (!ok) {
    fs::remove(part, ec);
    return Failure(ok.error());
  }
  if (copied) return out;
  for (const auto& [name, signal] : r.signals) {
    bool carried = false;
    for (const Layout& layout : layouts())
      for (const Field& f : layout.fields) carried = carried || name == f.signal;
    if (!carried && !signal.empty()) out.left_out.push_back(name);
  }
  return out;
}

Result<McapExport> write_rosbag2(const Recording& r, const fs::path& folder) {
  std::error_code ec;
  if (fs::exists(folder, ec)) return bad_input("exists already", folder.string(), "Choose another --out");
  fs::create_directories(folder, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), folder.string(), "Choose another --out");
  const std::string file = folder.filename().string() + "_0.mcap";
  auto out = write_mcap(r, folder / file);
  std::uint64_t total = 0;
  std::string listed;
  if (out)
    for (const auto& [topic, count] : out->messages) {
      total += count;
      listed += fmt::format(
          "    - topic_metadata: {{name: {}, type: {}, serialization_format: cdr, offered_qos_profiles: "
          "\"\"}}\n"
          "      message_count: {}\n",
          topic, out->types[topic], count);
    }
  const Status ok =
      !out ? Status(Failure(out.error()))
           : files::write_file_atomic(
                 folder / "metadata.yaml",
                 fmt::format(
                     "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
                     "  duration: {{nanoseconds: {1}}}\n"
                     "  starting_time: {{nanoseconds_since_epoch: {0}}}\n  message_count: {2}\n"
                     "  topics_with_message_count:\n{3}  compression_format: \"\"\n  compression_mode: \"\"\n"
                     "  relative_file_paths: [{4}]\n  files:\n"
                     "    - {{path: {4}, starting_time: {{nanoseconds_since_epoch: {0}}}, duration: "
                     "{{nanoseconds: {1}}}, message_count: {2}}}\n",
                     out->first_ns, out->last_ns - out->first_ns, total, listed, file));
  if (!ok) {
    fs::remove_all(folder, ec);
    return Failure(ok.error());
  }
  return out;
}

}  // namespace omniflight::cli
