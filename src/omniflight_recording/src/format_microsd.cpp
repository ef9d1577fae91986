// Crazyflie micro-SD log: 0xBC, version, event types with named and typed variables, packed records, CRC32.
#include <zlib.h>

#include <algorithm>
#include <map>

#include "byte_cursor.hpp"
#include "collector.hpp"
#include "format_table.hpp"
#include "omniflight_core/frames.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

/// A signal and the variables it is made of; '#' in the only variable stands for the motor number 1, 2, ...
/// The first row of a signal whose variables are all logged by one event type is used.
struct Source {
  const char* signal;
  std::vector<const char*> variables;
  double scale;
};
const std::vector<Source>& sources() {
  constexpr double degree = kPi / 180.0, rpm = kPi / 30.0, sixteen_bit = 1.0 / 65535.0;
  static const std::vector<Source> table{
      {"position", {"locSrv.x", "locSrv.y", "locSrv.z"}, 1},
      {"position", {"stateEstimate.x", "stateEstimate.y", "stateEstimate.z"}, 1},
      {"attitude", {"locSrv.qw", "locSrv.qx", "locSrv.qy", "locSrv.qz"}, 1},
      {"attitude", {"stateEstimate.qw", "stateEstimate.qx", "stateEstimate.qy", "stateEstimate.qz"}, 1},
      {"velocity", {"stateEstimate.vx", "stateEstimate.vy", "stateEstimate.vz"}, 1},
      {"est_position", {"stateEstimate.x", "stateEstimate.y", "stateEstimate.z"}, 1},
      {"est_attitude", {"stateEstimate.qw", "stateEstimate.qx", "stateEstimate.qy", "stateEstimate.qz"}, 1},
      {"est_velocity", {"stateEstimate.vx", "stateEstimate.vy", "stateEstimate.vz"}, 1},
      {"est_acceleration", {"stateEstimate.ax", "stateEstimate.ay", "stateEstimate.az"}, kGravity},
      {"est_roll", {"stateEstimate.roll"}, degree},
      {"est_yaw", {"stateEstimate.yaw"}, degree},
      {"gyro", {"gyro.x", "gyro.y", "gyro.z"}, degree},
      {"acc", {"acc.x", "acc.y", "acc.z"}, kGravity},
      {"rotor_speed", {"rpm.m#"}, rpm},
      {"pwm", {"pwm.m#_pwm"}, sixteen_bit},
      {"motor_power", {"motor.m#"}, sixteen_bit},
      {"ref_position", {"ctrltarget.x", "ctrltarget.y", "ctrltarget.z"}, 1},
      {"ref_velocity", {"ctrltarget.vx", "ctrltarget.vy", "ctrltarget.vz"}, 1},
      {"vbat", {"pm.vbatMV"}, 1e-3},
      {"vbat", {"pm.vbat"}, 1},
  };
  return table;
}

std::size_t size_of(char type) {
  switch (type) {
    case 'b':
    case 'B':
    case '?':
      return 1;
    case 'h':
    case 'H':
      return 2;
    case 'i':
    case 'I':
    case 'l':
    case 'L':
    case 'f':
      return 4;
    case 'q':
    case 'Q':
    case 'd':
      return 8;
    default:
      return 0;
  }
}

double value_of(char type, std::string_view bytes) {
  ByteCursor c(bytes);
  switch (type) {
    case 'b':
      return c.get<std::int8_t>();
    case 'B':
    case '?':
      return c.get<std::uint8_t>();
    case 'h':
      return c.get<std::int16_t>();
    case 'H':
      return c.get<std::uint16_t>();
    case 'i':
    case 'l':
      return c.get<std::int32_t>();
    case 'I':
    case 'L':
      return c.get<std::uint32_t>();
    case 'f':
      return static_cast<double>(c.get<float>());
    case 'q':
      return static_cast<double>(c.get<std::int64_t>());
    case 'Q':
      return static_cast<double>(c.get<std::uint64_t>());
    default:
      return c.get<double>();
  }
}

struct Variable {
  std::string name;
  char type;
  std::size_t offset;
};
struct Mapping {
  std::string signal;
  double scale;
  std::vector<const Variable*> variables;
};
struct EventType {
  std::string name;
  std::vector<Variable> variables;
  std::size_t bytes = 0;
  std::vector<Mapping> mappings;
  std::uint64_t records = 0;
};

const Variable* find(const EventType& event, const std::string& name) {
  for (const Variable& v : event.variables)
    if (v.name == name) return &v;
  return nullptr;
}

std::vector<const Variable*> match(const EventType& event, const Source& source) {
  std::vector<const Variable*> out;
  const std::string first = source.variables.front();
  if (const auto hash = first.find('#'); hash != std::string::npos) {
    for (int motor = 1; motor <= 16; ++motor) {
      const Variable* v = find(event, first.substr(0, hash) + std::to_string(motor) + first.substr(hash + 1));
      if (!v) break;
      out.push_back(v);
    }
    return out;
  }
  for (const char* name : source.variables) {
    const Variable* v = find(event, name);
    if (!v) return {};
    out.push_back(v);
  }
  return out;
}

Result<std::map<std::uint16_t, EventType>> read_types(ByteCursor& cursor, const std::string& file) {
  std::map<std::uint16_t, EventType> types;
  const auto count = cursor.get<std::uint16_t>();
  for (int i = 0; i < count && cursor.ok(); ++i) {
    const auto id = cursor.get<std::uint16_t>();
    EventType event;
    event.name = std::string(cursor.zero_terminated(255));
    const auto variables = cursor.get<std::uint16_t>();
    for (int k = 0; k < variables && cursor.ok(); ++k) {
      const auto text = cursor.zero_terminated(255);
      if (!cursor.ok()) break;
      const std::size_t size = text.size() >= 4 && text[text.size() - 3] == '(' && text.back() == ')'
                                   ? size_of(text[text.size() - 2])
                                   : 0;
      if (size == 0)
        return bad_input("variable " + files::shown(text) + " has an unknown type", file,
                         "The header is damaged");
      event.variables.push_back(
          {std::string(text.substr(0, text.size() - 3)), text[text.size() - 2], event.bytes});
      event.bytes += size;
    }
    if (!types.emplace(id, std::move(event)).second)
      return bad_input("event type " + std::to_string(id) + " is defined twice", file,
                       "The header is damaged");
  }
  if (!cursor.ok())
    return bad_input("the header of the log is cut off", file, "Copy the file from the card again");
  return types;
}

/// Notes how many gaps the longest time base has: the logger drops records when its buffer is full.
void note_gaps(const std::string& name, const std::vector<double>& t, Recording& recording) {
  if (t.size() < 10) return;
  Signal clock;
  clock.t_s = t;
  const double period = clock.median_period_s();
  double longest = 0, missing = 0;
  std::uint64_t gaps = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double step = t[i] - t[i - 1];
    if (step < 3.5 * period) continue;
    ++gaps;
    longest = std::max(longest, step);
    missing += step / period - 1;
  }
  if (gaps > 0)
    recording.note(Note::Kind::information,
                   name + ": " + std::to_string(gaps) + " gaps of the logger (longest " +
                       std::to_string(longest) + " s, nominal period " + std::to_string(period) + " s)",
                   static_cast<std::uint64_t>(missing));
}

bool is_microsd(std::string_view head) {
  if (head.size() < 8 || static_cast<unsigned char>(head[0]) != 0xBC) return false;
  const unsigned version =
      static_cast<unsigned char>(head[1]) | static_cast<unsigned>(static_cast<unsigned char>(head[2])) << 8;
  return version < 100;
}

Result<Recording> read_microsd(std::string_view bytes, const std::string& file, const LoadOptions&) {
  ByteCursor cursor(bytes);
  cursor.get<std::uint8_t>();
  const auto version = cursor.get<std::uint16_t>();
  if (version != 1 && version != 2)
    return bad_input("micro-SD log version " + std::to_string(version) + " is not known", file,
                     "Versions 1 and 2 are read");
  auto types = read_types(cursor, file);
  if (!types) return Failure(types.error());

  Recording recording;
  std::size_t end = bytes.size();
  const auto crc = bytes.size() >= 4 ? ByteCursor(bytes.substr(bytes.size() - 4)).get<std::uint32_t>() : 0u;
  const bool whole = bytes.size() > cursor.at() + 4 &&
                     ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size() - 4) == crc;
  if (whole) end -= 4;
  if (!whole)
    recording.note(Note::Kind::damage, "the CRC32 at the end does not match: the log is cut off or damaged");

  Collector collector;
  std::map<std::string, bool> taken;
  for (const Source& source : sources()) {
    if (taken[source.signal]) continue;
    for (auto& [id, event] : *types) {
      const auto variables = match(event, source);
      if (variables.empty()) continue;
      taken[source.signal] = true;
      event.mappings.push_back({source.signal, source.scale, variables});
      collector.describe(source.signal, find_spec(source.signal)->unit,
                         event.name + " " + variables.front()->name);
      break;
    }
  }

  std::map<std::uint16_t, std::vector<double>> clocks;
  bool first = true;
  double start = 0;
  std::vector<double> values;
  const std::size_t stamp_bytes = version == 2 ? 8 : 4;
  while (cursor.at() + 2 + stamp_bytes <= end) {
    const std::size_t begin = cursor.at();
    const auto type = types->find(cursor.get<std::uint16_t>());
    const double t = version == 2 ? 1e-6 * static_cast<double>(cursor.get<std::uint64_t>())
                                  : 1e-3 * cursor.get<std::uint32_t>();
    if (type == types->end() || cursor.at() + type->second.bytes > end) {
      recording.note(Note::Kind::loss, "the last " + std::to_string(end - begin) +
                                           " bytes hold no whole record of a known type and were left out");
      break;
    }
    EventType& event = type->second;
    const auto body = cursor.take(event.bytes);
    if (first) start = t;
    first = false;
    ++event.records;
    clocks[type->first].push_back(t - start);
    for (const Mapping& m : event.mappings) {
      values.clear();
      for (const Variable* v : m.variables)
        values.push_back(m.scale * value_of(v->type, body.substr(v->offset)));
      collector.add(m.signal, t - start, values.data(), values.size());
    }
  }
  if (first) return bad_input("the log contains no record", file, "Record again");
  for (auto& [id, clock] : clocks) note_gaps(types->at(id).name, clock, recording);
  recording.start_s = start;
  recording.metadata["microsd.version"] = std::to_string(version);
  for (const auto& [id, event] : *types)
    recording.metadata["microsd.records." + event.name] = std::to_string(event.records);
  collector.finish(recording);
  if (recording.signal_names().empty())
    return bad_input("the log contains none of the known variables", file,
                     "Log stateEstimate, gyro, acc, pwm or rpm");
  return recording;
}

}  // namespace

const Format& microsd_format() {
  static const Format format{"crazyflie_microsd", "Crazyflie micro-SD log", is_microsd, read_microsd};
  return format;
}

}  // namespace omniflight::recording
