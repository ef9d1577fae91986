#include "rosbag1_reader.hpp"

#include <algorithm>
#include <optional>

#include "byte_cursor.hpp"
#include "omniflight_files/files.hpp"
#include "unpack.hpp"

namespace omniflight::recording {
namespace {

enum Op : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

constexpr std::uint32_t kMostHeader = 1u << 20, kMostChunk = 256u << 20;
constexpr std::size_t kMaxBag1Notes = 200, kMaxConnections = 65536;

using Fields = std::map<std::string_view, std::string_view>;

/// "length, name=value" one after the other.
std::optional<Fields> read_fields(std::string_view bytes) {
  Fields out;
  ByteCursor c(bytes);
  while (c.left() > 0) {
    const auto field = c.string();
    const auto equals = field.find('=');
    if (!c.ok() || equals == 0 || equals == std::string_view::npos || out.size() > 100) return std::nullopt;
    out.emplace(field.substr(0, equals), field.substr(equals + 1));
  }
  return out;
}

struct BagRecord {
  std::uint8_t op = 0;
  Fields fields;
  std::string_view data;
  std::size_t bytes = 0;  // of header and data
  bool whole = true;      // otherwise its data go on behind the end of the file
};

/// The record at this byte; nothing when there is no sound header.
std::optional<BagRecord> bag_record_at(std::string_view bytes, std::size_t at) {
  if (at >= bytes.size()) return std::nullopt;
  ByteCursor c(bytes.substr(at));
  const auto length = c.get<std::uint32_t>();
  if (length > kMostHeader) return std::nullopt;
  const auto header = c.take(length);
  const auto size = c.get<std::uint32_t>();
  if (!c.ok()) return std::nullopt;
  auto fields = read_fields(header);
  if (!fields) return std::nullopt;
  const auto op = fields->find("op");
  if (op == fields->end() || op->second.size() != 1) return std::nullopt;
  BagRecord out;
  out.op = static_cast<std::uint8_t>(op->second[0]);
  if (out.op < kMessage || out.op > kConnection) return std::nullopt;
  out.fields = std::move(*fields);
  out.whole = size <= c.left();
  out.data = c.take(std::min<std::size_t>(size, c.left()));
  out.bytes = c.at();
  return out;
}

template <class T>
std::optional<T> number(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  if (found == fields.end() || found->second.size() != sizeof(T)) return std::nullopt;
  return ByteCursor(found->second).get<T>();
}

class Bag1Scanner {
 public:
  Bag1Scanner(std::string_view bytes, const Bag1Visitor& visit)
      : bytes_(bytes),
        visit_(visit),
        budget_(std::max<std::uint64_t>(files::kSmallEnough, bytes.size() * files::kMostGzipRatio)) {}

  Bag1Content content;

  void run() {
    std::size_t at = kBag1Magic.size();
    while (at < bytes_.size()) {
      const auto record = bag_record_at(bytes_, at);
      if (!record || (!record->whole && record->op != kChunk)) {
        at = behind_damage(at);
        continue;
      }
      if (!record->whole) {  // a chunk: either the file is cut, or the chunk's size is wrong
        const std::size_t next = next_chunk(at + 1);
        if (next < bytes_.size()) {
          damage(at, next);
          at = next;
          continue;
        }
      }
      handle(*record);
      at += record->bytes;
    }
    finish();
  }

 private:
  std::size_t behind_damage(std::size_t at) {
    const std::size_t next = next_chunk(at + 1);
    if (next < bytes_.size())
      damage(at, next);
    else
      note(Note::Kind::loss, "the bag ends in the middle of a record: its last " +
                                 std::to_string(bytes_.size() - at) + " bytes were left out");
    return next;
  }

  void damage(std::size_t from, std::size_t to) {
    note(Note::Kind::damage, std::to_string(to - from) + " bytes at byte " + std::to_string(from) +
                                 " cannot be read and were skipped");
  }

  /// The next whole chunk: its header has a field that nothing else has, at one of few places.
  std::size_t next_chunk(std::size_t from) const {
    constexpr std::string_view kMark = "compression=";
    constexpr std::size_t kBefore = 8, kFurthest = 100;
    for (std::size_t mark = bytes_.find(kMark, from); mark != std::string_view::npos;
         mark = bytes_.find(kMark, mark + 1))
      for (std::size_t back = kBefore; back <= std::min(mark, kFurthest); ++back) {
        if (mark - back < from) break;
        const auto record = bag_record_at(bytes_, mark - back);
        if (record && record->whole && record->op == kChunk) return mark - back;
      }
    return bytes_.size();
  }

  void handle(const BagRecord& r) {
    switch (r.op) {
      case kBagHeader:
        content.closed = number<std::uint64_t>(r.fields, "index_pos").value_or(0) != 0;
        told_chunks_ = number<std::uint32_t>(r.fields, "chunk_count");
        break;
      case kChunk:
        settle_chunk();
        chunk(r);
        break;
      case kIndex:
        indexed_ += number<std::uint32_t>(r.fields, "count").value_or(0);
        break;
      case kConnection:
        connection(r);
        break;
      case kMessage:
        message(r);
        break;
      default:
        break;  // chunk infos repeat what the indexes say
    }
  }

  void chunk(const BagRecord& r) {
    ++content.chunks;
    const auto found = r.fields.find("compression");
    const std::string compression(found == r.fields.end() ? std::string_view() : found->second);
    ++content.compressions[compression];
    const auto size = number<std::uint32_t>(r.fields, "size").value_or(0);
    std::string_view records = r.data;
    std::string why;
    if (compression == "none") {
      if (r.whole && r.data.size() != size) why = "its size is wrong";
    } else if (compression != "bz2" && compression != "lz4") {
      why = "its compression " + files::shown(compression) + " is not known (none, bz2 and lz4 are)";
    } else if (!r.whole) {
      why = "it is cut off";
    } else if (size > kMostChunk || size > budget_) {
      why = "it would unpack to more than 100 times the size of the bag";
    } else {
      budget_ -= size;
      unpacked_.resize(size);
      if (!(compression == "bz2" ? unpack_bz2(r.data, unpacked_) : unpack_lz4(r.data, unpacked_)))
        why = "it cannot be unpacked (" + compression + ")";
      records = unpacked_;
    }
    if (!why.empty()) {
      note(Note::Kind::loss, "chunk " + std::to_string(content.chunks) + " was left out because " + why);
      return;
    }
    if (!r.whole) note(Note::Kind::loss, "the bag is cut off in chunk " + std::to_string(content.chunks));
    records_of_chunk(records);
  }

  void records_of_chunk(std::string_view records) {
    for (std::size_t at = 0; at < records.size();) {
      const auto record = bag_record_at(records, at);
      if (!record || !record->whole || (record->op != kMessage && record->op != kConnection)) {
        note(Note::Kind::loss, "chunk " + std::to_string(content.chunks) +
                                   " ends in the middle of a record, or is damaged: its last " +
                                   std::to_string(records.size() - at) + " bytes were left out");
        return;
      }
      handle(*record);
      at += record->bytes;
    }
  }

  void connection(const BagRecord& r) {
    const auto id = number<std::uint32_t>(r.fields, "conn");
    const auto topic = r.fields.find("topic");
    const auto inner = read_fields(r.data);
    if (!id || topic == r.fields.end() || !inner || !inner->contains("type")) {
      note(Note::Kind::damage, "a connection has no topic or type");
      return;
    }
    Bag1Connection c;
    c.topic = std::string(topic->second);
    c.type = std::string(inner->at("type"));
    if (const auto text = inner->find("message_definition"); text != inner->end())
      c.definition = std::string(text->second);
    if (content.connections.size() >= kMaxConnections) return;
    const auto [known, fresh] = content.connections.try_emplace(*id, std::move(c));
    if (!fresh && known->second.topic != topic->second)
      note(Note::Kind::damage,
           "connection " + std::to_string(*id) + " is defined twice with different topics");
  }

  void message(const BagRecord& r) {
    const auto id = number<std::uint32_t>(r.fields, "conn");
    const auto time = number<std::uint64_t>(r.fields, "time");
    const auto found = id ? content.connections.find(*id) : content.connections.end();
    ++in_chunk_;
    if (!time || found == content.connections.end()) {
      ++homeless_;
      return;
    }
    ++content.messages;
    const std::int64_t seconds = static_cast<std::int64_t>(*time & 0xffffffffu);
    visit_(*id, found->second, r.data, seconds * 1'000'000'000 + static_cast<std::int64_t>(*time >> 32));
  }

  /// The indexes behind a chunk say how many messages it held.
  void settle_chunk() {
    if (indexed_ > in_chunk_) {
      note(Note::Kind::loss,
           "chunk " + std::to_string(content.chunks) + " held " + std::to_string(indexed_) + " messages, " +
               std::to_string(in_chunk_) + " were read",
           indexed_ - in_chunk_);
    }
    indexed_ = in_chunk_ = 0;
  }

  void finish() {
    settle_chunk();
    if (homeless_ > 0)
      note(Note::Kind::loss, std::to_string(homeless_) + " messages belong to no known topic", homeless_);
    if (!content.closed)
      note(Note::Kind::loss,
           "the bag was not closed by its recorder; what it had not written yet is missing");
    else if (told_chunks_ && *told_chunks_ != content.chunks)
      note(Note::Kind::loss, "the bag tells of " + std::to_string(*told_chunks_) + " chunks, " +
                                 std::to_string(content.chunks) + " were found");
  }

  void note(Note::Kind kind, std::string what, std::uint64_t messages = 0) {
    if (content.notes.size() < kMaxBag1Notes) content.notes.push_back({kind, std::move(what), messages});
  }

  std::string_view bytes_;
  const Bag1Visitor& visit_;
  std::uint64_t budget_;  // bytes that may still be unpacked
  std::string unpacked_;
  std::uint64_t indexed_ = 0, in_chunk_ = 0, homeless_ = 0;
  std::optional<std::uint32_t> told_chunks_;
};

}  // namespace

Result<Bag1Content> scan_bag1(std::string_view bytes, const std::string& file, const Bag1Visitor& visit) {
  if (bytes.substr(0, kBag1Magic.size()) != kBag1Magic)
    return bad_input("is no ROS 1 bag of version 2.0", file, "Give a recording");
  Bag1Scanner scanner(bytes, visit);
  scanner.run();
  return std::move(scanner.content);
}

}  // namespace omniflight::recording
