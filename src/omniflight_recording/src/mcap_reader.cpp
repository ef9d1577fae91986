#include "omniflight_recording/mcap_reader.hpp"

#include <algorithm>
#include <optional>

#include "mcap_chunk.hpp"
#include "mcap_records.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::recording {
namespace {

using namespace mcap;

constexpr std::uint64_t kMaxUnpacked = std::uint64_t{4} << 30, kMaxAttachments = 64u << 20;
constexpr std::size_t kMaxMcapNotes = 1000;

double seconds(std::uint64_t ns) { return 1e-9 * static_cast<double>(ns); }

std::map<std::string, std::string> read_strings(ByteCursor& cursor) {
  std::map<std::string, std::string> out;
  ByteCursor body(cursor.string());
  while (body.ok() && body.left() > 0) {
    const auto key = body.string(), value = body.string();
    if (body.ok()) out[std::string(key)] = std::string(value);
  }
  return out;
}

class McapScanner {
 public:
  McapScanner(std::string_view bytes, const McapVisitor& visit) : bytes_(bytes), visit_(visit) {}
  McapContent content;

  void run() {
    if (bytes_.substr(0, mcap::kMagic.size()) != mcap::kMagic)
      note(Note::Kind::damage, "the leading magic is damaged");
    std::size_t at = mcap::kMagic.size();
    while (!finished_) at = step(at);
    settle_lost_chunk();
    cross_check();
  }

 private:
  /// Handles the record at `at`; returns where to go on.
  std::size_t step(std::size_t at) {
    ByteCursor head(bytes_.substr(std::min(at, bytes_.size())));
    const auto op = head.get<std::uint8_t>();
    const auto length = head.get<std::uint64_t>();
    const bool torn = !head.ok() || op == 0 || (op > kDataEnd && op < 0x80) || length > head.left();
    const std::string_view body = torn ? bytes_.substr(std::min(at + 9, bytes_.size()))
                                       : bytes_.substr(at + 9, static_cast<std::size_t>(length));
    if (!torn && op != kMessageIndex) settle_lost_chunk();
    if (const auto next = swallowed_checkpoint(op, body, at)) return *next;
    if (torn) return recover(at);
    if (!handle(op, body, at)) {
      note(Note::Kind::damage,
           "record " + std::to_string(op) + " at byte " + std::to_string(at) + " is malformed");
    }
    if (op == kFooter) end_of_file(at + 9 + static_cast<std::size_t>(length));
    return at + 9 + static_cast<std::size_t>(length);
  }

  /// Where the scan goes on when opcode or length of the record at `at` is damaged, so that it runs over the
  /// checkpoint that follows; nothing for a sound record. Without this the loss looks like a torn end.
  std::optional<std::size_t> swallowed_checkpoint(std::uint8_t op, std::string_view body, std::size_t at) {
    constexpr std::size_t kSize = kCheckpointMark.size() + 12;  // bytes of its body
    if (op == kCheckpoint && body.size() == kSize) return std::nullopt;
    for (auto mark = body.find(kCheckpointMark); mark != std::string_view::npos;
         mark = body.find(kCheckpointMark, mark + 1)) {
      ByteCursor c(body.substr(mark + kCheckpointMark.size()));
      if (c.get<std::uint64_t>() != checked_to_ || !c.ok()) continue;
      note(Note::Kind::damage, "record " + std::to_string(op) + " at byte " + std::to_string(at) +
                                   " runs over the checkpoint behind it and was skipped");
      if (mark >= 9) return at + mark;  // its body began 9 bytes later: here begins the checkpoint
      checked_to_ = at + 9 + mark + kSize;
      return checked_to_;
    }
    return std::nullopt;
  }

  /// Damage or a torn end at `at`: the next sound chunk, or the end.
  std::size_t recover(std::size_t at) {
    settle_lost_chunk();
    std::string scratch;
    for (std::size_t next = bytes_.find(static_cast<char>(kChunk), at + 1); next != std::string_view::npos;
         next = bytes_.find(static_cast<char>(kChunk), next + 1)) {
      ByteCursor head(bytes_.substr(next));
      head.get<std::uint8_t>();
      const auto length = head.get<std::uint64_t>();
      if (!head.ok() || length > head.left()) continue;
      const auto chunk = read_chunk_header(head.take(length));
      if (!chunk || chunk->crc == 0 || !unpack_chunk(*chunk, scratch).empty()) continue;
      note(Note::Kind::damage, std::to_string(next - at) + " bytes at byte " + std::to_string(at) +
                                   " cannot be read and were skipped");
      return next;
    }
    finished_ = true;
    if (!data_end_)
      note(Note::Kind::loss,
           "the file ends without its summary: " + std::to_string(content.messages) +
               " messages were recovered up to " + std::to_string(seconds(last_ns_)) + " s, " +
               std::to_string(bytes_.size() - std::min(at, bytes_.size())) +
               " bytes of a torn record were discarded; the writer's last flush period may be missing");
    else
      note(Note::Kind::damage, "the summary is cut off; all messages of the data section were read");
    return bytes_.size();
  }

  void end_of_file(std::size_t at) {
    finished_ = true;
    footer_ = true;
    if (bytes_.substr(at) != mcap::kMagic)
      note(Note::Kind::damage, "the trailing magic is missing or followed by other bytes");
  }

  bool handle(std::uint8_t op, std::string_view body, std::size_t at) {
    ByteCursor c(body);
    switch (op) {
      case kHeader:
        content.profile = std::string(c.string());
        content.library = std::string(c.string());
        break;
      case kSchema:
        return schema(c);
      case kChannel:
        return channel(c);
      case kMessage:
        return message(body);
      case kChunk:
        return chunk(body);
      case kMessageIndex:
        c.get<std::uint16_t>();
        if (lost_chunk_) lost_messages_ += c.string().size() / 16;
        break;
      case kAttachment:
        return attachment(body);
      case kStatistics:
        statistics_messages_ = c.get<std::uint64_t>();
        c.take(2 + 4 + 4 + 4);
        statistics_chunks_ = c.get<std::uint32_t>();
        break;
      case kMetadata: {
        const std::string name(c.string());
        const auto values = read_strings(c);
        if (c.ok()) content.metadata[name] = values;
        break;
      }
      case kDataEnd: {
        const auto crc = c.get<std::uint32_t>();
        data_end_ = true;
        summary_at_ = at + 9 + body.size();
        if (c.ok() && crc != 0 && crc != crc32_of(bytes_.substr(0, at)))
          note(Note::Kind::damage, "the checksum of the data section does not match");
        break;
      }
      case kFooter: {
        c.get<std::uint64_t>();
        c.get<std::uint64_t>();
        const auto crc = c.get<std::uint32_t>();
        if (!data_end_) note(Note::Kind::damage, "the end of the data section is not marked");
        if (c.ok() && crc != 0 && crc != crc32_of(bytes_.substr(summary_at_, at + 9 + 16 - summary_at_)))
          note(Note::Kind::damage, "the checksum of the summary does not match");
        break;
      }
      case kCheckpoint:
        return checkpoint(c, at, body.size());
      default:
        break;  // indexes; we scan instead
    }
    return c.ok();
  }

  bool checkpoint(ByteCursor& c, std::size_t at, std::size_t size) {
    if (size != kCheckpointMark.size() + 12 || c.take(kCheckpointMark.size()) != kCheckpointMark) return true;
    const auto from = c.get<std::uint64_t>();
    const auto crc = c.get<std::uint32_t>();
    if (from != checked_to_)
      note(Note::Kind::damage,
           "the checkpoint at byte " + std::to_string(at) + " does not follow the one before");
    else if (crc32_of(bytes_.substr(checked_to_, at - checked_to_)) != crc)
      note(Note::Kind::damage, "the checksum over bytes " + std::to_string(checked_to_) + " to " +
                                   std::to_string(at) +
                                   " does not match: what was read or left out there may be damaged");
    checked_to_ = at + 9 + size;
    return true;
  }

  bool schema(ByteCursor& c) {
    const auto id = c.get<std::uint16_t>();
    McapSchema s;
    s.name = std::string(c.string());
    s.encoding = std::string(c.string());
    s.text = std::string(c.string());
    if (c.ok() && id != 0 && !data_end_) schemas_[id] = std::move(s);
    return c.ok();
  }

  bool channel(ByteCursor& c) {
    McapChannel ch;
    ch.id = c.get<std::uint16_t>();
    const auto schema_id = c.get<std::uint16_t>();
    ch.topic = std::string(c.string());
    ch.message_encoding = std::string(c.string());
    ch.metadata = read_strings(c);
    if (!c.ok()) return false;
    if (const auto found = schemas_.find(schema_id); found != schemas_.end()) ch.schema = found->second;
    const auto known = content.channels.find(ch.id);
    if (known == content.channels.end())
      content.channels.emplace(ch.id, std::move(ch));
    else if (known->second.topic != ch.topic)
      note(Note::Kind::damage,
           "channel " + std::to_string(ch.id) + " is defined twice with different topics");
    return true;
  }

  bool message(std::string_view body) {
    ByteCursor c(body);
    const auto id = c.get<std::uint16_t>();
    McapMessage m;
    m.sequence = c.get<std::uint32_t>();
    m.log_ns = c.get<std::uint64_t>();
    m.publish_ns = c.get<std::uint64_t>();
    m.data = c.take(c.left());
    if (!c.ok()) return false;
    const auto found = content.channels.find(id);
    if (found == content.channels.end()) {
      ++homeless_;
      return true;
    }
    ++found->second.messages;
    ++content.messages;
    last_ns_ = std::max(last_ns_, m.log_ns);
    visit_(found->second, m);
    return true;
  }

  bool chunk(std::string_view body) {
    ++chunks_;
    const auto header = read_chunk_header(body);
    std::string why = header ? std::string() : std::string("its header is damaged");
    if (header) {
      unpacked_ += header->uncompressed;
      why = unpacked_ > kMaxUnpacked ? "the file holds more than 4 GB of messages"
                                     : unpack_chunk(*header, records_);
    }
    if (!why.empty()) {
      lost_chunk_ = true;
      lost_messages_ = 0;
      lost_why_ = why;
      lost_from_ns_ = header ? header->first_ns : 0;
      lost_to_ns_ = header ? header->last_ns : 0;
      return true;
    }
    ByteCursor c(records_);
    while (c.left() > 0) {
      const auto op = c.get<std::uint8_t>();
      const auto record = c.take(c.get<std::uint64_t>());
      if (!c.ok()) return false;
      ByteCursor inner(record);
      if (op == kMessage && !message(record)) return false;
      if (op == kSchema && !schema(inner)) return false;
      if (op == kChannel && !channel(inner)) return false;
    }
    return true;
  }

  bool attachment(std::string_view body) {
    ByteCursor c(body);
    McapAttachment a;
    a.log_ns = c.get<std::uint64_t>();
    c.get<std::uint64_t>();
    a.name = std::string(c.string());
    a.media_type = std::string(c.string());
    const auto data = c.take(c.get<std::uint64_t>());
    const std::size_t covered = c.at();
    const auto crc = c.get<std::uint32_t>();
    if (!c.ok()) return false;
    if (crc != 0 && crc32_of(body.substr(0, covered)) != crc) {
      note(Note::Kind::damage, "attachment " + files::shown(a.name) + " is damaged and was left out");
    } else if (attached_ + data.size() > kMaxAttachments) {
      note(Note::Kind::ignored, "attachment " + files::shown(a.name) + " is too large and was left out");
    } else {
      attached_ += data.size();
      a.data = std::string(data);
      content.attachments.push_back(std::move(a));
    }
    return true;
  }

  /// A damaged chunk is told once its message indexes have said how many messages it held.
  void settle_lost_chunk() {
    if (!lost_chunk_) return;
    lost_chunk_ = false;
    lost_total_ += lost_messages_;
    note(Note::Kind::loss,
         "a chunk was left out because " + lost_why_ + " (" + std::to_string(lost_messages_) + " messages)",
         lost_messages_, seconds(lost_from_ns_), seconds(lost_to_ns_));
  }

  void cross_check() {
    if (homeless_ > 0)
      note(Note::Kind::loss, std::to_string(homeless_) + " messages belong to no known topic", homeless_);
    const std::uint64_t read = content.messages + lost_total_ + homeless_;
    if (statistics_chunks_ && *statistics_chunks_ != chunks_)
      note(Note::Kind::loss, "the summary tells of " + std::to_string(*statistics_chunks_) + " chunks, " +
                                 std::to_string(chunks_) + " were found");
    if (statistics_messages_ && *statistics_messages_ != read)
      note(Note::Kind::loss,
           "the summary tells of " + std::to_string(*statistics_messages_) + " messages, " +
               std::to_string(content.messages) + " were read",
           *statistics_messages_ > read ? *statistics_messages_ - read : 0);
    content.closed = footer_;
    content.complete = footer_ && content.notes.empty();
  }

  void note(Note::Kind kind, std::string text, std::uint64_t messages = 0, double from_s = 0,
            double to_s = 0) {
    if (content.notes.size() < kMaxMcapNotes)
      content.notes.push_back({kind, std::move(text), messages, from_s, to_s});
  }

  std::string_view bytes_;
  const McapVisitor& visit_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::string records_, lost_why_;
  bool finished_ = false, data_end_ = false, footer_ = false, lost_chunk_ = false;
  std::size_t summary_at_ = 0, checked_to_ = 0;
  std::uint64_t last_ns_ = 0, homeless_ = 0, unpacked_ = 0, attached_ = 0, chunks_ = 0;
  std::uint64_t lost_messages_ = 0, lost_total_ = 0, lost_from_ns_ = 0, lost_to_ns_ = 0;
  std::optional<std::uint64_t> statistics_messages_;
  std::optional<std::uint32_t> statistics_chunks_;
};

}  // namespace

Result<McapContent> scan_mcap(std::string_view bytes, const std::string& file, const McapVisitor& visit) {
  if (bytes.size() < mcap::kMagic.size() + 9)
    return bad_input("holds nothing but the start of an MCAP file", file,
                     "The recorder was killed at once; record again");
  McapScanner scanner(bytes, visit);
  scanner.run();
  if (scanner.content.channels.empty() && scanner.content.metadata.empty() && scanner.content.profile.empty())
    return bad_input("contains no readable MCAP record", file, "Give a recording");
  return std::move(scanner.content);
}

}  // namespace omniflight::recording
