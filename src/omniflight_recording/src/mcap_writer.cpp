#include "omniflight_recording/mcap_writer.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "mcap_records.hpp"

namespace omniflight::recording {

std::uint32_t mcap::crc32_of(std::string_view bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

using mcap::Bytes;

namespace {

struct Channel {
  std::string schema_record, channel_record, topic;
  std::uint64_t messages = 0, dropped = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  // of the open chunk: log time, offset
};

struct ChunkIndex {
  std::uint64_t first_ns, last_ns, start, length, index_length, compressed, uncompressed;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> index_offsets;
};

}  // namespace

struct McapWriter::State {
  std::string path;
  McapWriterOptions options;
  int fd = -1;
  bool regular = false, closed = false;
  std::uint64_t offset = 0;         // of the end of the file
  std::uint32_t data_crc = 0;       // over everything from the leading magic on
  std::uint64_t checked_to = 0;     // end of the last checkpoint
  std::uint32_t unchecked_crc = 0;  // over everything since
  std::optional<Error> broken;
  std::vector<Channel> channels;  // id = position + 1
  std::string chunk;              // open chunk, uncompressed
  std::uint64_t chunk_first_ns = 0, chunk_last_ns = 0, chunk_born_ns = 0;
  std::uint64_t first_ns = 0, last_ns = 0, messages = 0;
  std::uint32_t attachments = 0, metadata = 0;
  std::vector<ChunkIndex> chunks;
  std::string attachment_indexes, metadata_indexes;  // finished index records
  ZSTD_CCtx* zstd = nullptr;
  std::vector<char> packed;

  ~State() {
    if (fd >= 0) ::close(fd);
    ZSTD_freeCCtx(zstd);
  }

  /// Appends bytes with one write(2) (more only when the kernel takes less); on failure the file is cut back.
  Status append(std::string_view bytes) {
    if (broken) return Failure(*broken);
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return give_up("write");
      done += static_cast<std::size_t>(n);
    }
    offset += bytes.size();
    data_crc = mcap::crc32_of(bytes, data_crc);
    unchecked_crc = mcap::crc32_of(bytes, unchecked_crc);
    if (options.sync && ::fdatasync(fd) != 0) return give_up("sync");
    return {};
  }

  /// Appends records and a checkpoint behind them in one write: most carry no checksum, and that of a chunk
  /// does not cover its opcode and length.
  Status append_checked(const std::string& records) {
    const std::uint32_t crc = mcap::crc32_of(records, unchecked_crc);
    auto ok =
        append(records + mcap::record(mcap::kCheckpoint,
                                      Bytes().raw(mcap::kCheckpointMark).put(checked_to).put(crc).text()));
    if (ok) checked_to = offset, unchecked_crc = 0;
    return ok;
  }

  Status give_up(const std::string& step) {
    const std::string why = std::strerror(errno);
    broken = Error{ErrorCode::bad_input,
                   "the recording cannot be continued (" + step + ": " + why + ") after " +
                       std::to_string(offset) + " bytes",
                   path, "Free space on the disk; what was written stays readable"};
    if (regular && ::ftruncate(fd, static_cast<off_t>(offset)) != 0)
      broken->message += "; its end holds a torn record";
    return Failure(*broken);
  }

  Status flush_chunk();
  std::string summary(std::uint64_t summary_start) const;
};

Status McapWriter::State::flush_chunk() {
  if (broken) return Failure(*broken);
  if (chunk.empty()) return {};
  packed.resize(ZSTD_compressBound(chunk.size()));
  const std::size_t size =
      ZSTD_compressCCtx(zstd, packed.data(), packed.size(), chunk.data(), chunk.size(), options.zstd_level);
  if (ZSTD_isError(size)) return fail(ErrorCode::internal, "zstd cannot compress a chunk", path);
  Bytes content;
  content.put(chunk_first_ns).put(chunk_last_ns).put(static_cast<std::uint64_t>(chunk.size()));
  content.put(mcap::crc32_of(chunk)).string("zstd").put(static_cast<std::uint64_t>(size));
  content.raw({packed.data(), size});
  std::string out = mcap::record(mcap::kChunk, content.text());
  ChunkIndex index{chunk_first_ns, chunk_last_ns, offset, out.size(), 0, size, chunk.size(), {}};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].index.empty()) continue;
    const auto id = static_cast<std::uint16_t>(i + 1);
    index.index_offsets.emplace_back(id, offset + out.size());
    Bytes entries;
    for (const auto& [time, at] : channels[i].index) entries.put(time).put(at);
    out += mcap::record(mcap::kMessageIndex, Bytes().put(id).string(entries.text()).text());
    channels[i].index.clear();
  }
  index.index_length = out.size() - index.length;
  chunk.clear();
  auto written = append_checked(out);
  if (written) chunks.push_back(std::move(index));
  return written;
}

McapWriter::McapWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<McapWriter>> McapWriter::create(const std::filesystem::path& path,
                                                       const McapWriterOptions& options) {
  auto state = std::make_unique<State>();
  state->path = path.string();
  state->options = options;
  const int how = O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK | (options.overwrite ? O_TRUNC : O_EXCL);
  state->fd = ::open(path.c_str(), how, 0644);
  if (state->fd < 0)
    return bad_input(std::string("the recording cannot be created (") + std::strerror(errno) + ")",
                     state->path,
                     errno == EEXIST ? "Choose a new name or remove the old recording" : "Check the folder");
  struct stat info {};
  state->regular = ::fstat(state->fd, &info) == 0 && S_ISREG(info.st_mode);
  state->zstd = ZSTD_createCCtx();
  if (!state->zstd) return fail(ErrorCode::internal, "zstd cannot start", state->path);
  state->chunk.reserve(options.chunk_bytes + 65536);
  const std::string header = mcap::record(mcap::kHeader, Bytes().string("ros2").string("omniflight").text());
  if (auto ok = state->append_checked(std::string(mcap::kMagic) + header); !ok) return Failure(ok.error());
  return std::unique_ptr<McapWriter>(new McapWriter(std::move(state)));
}

McapWriter::~McapWriter() {
  if (state_ && !state_->closed) (void)close();
}

Result<std::uint16_t> McapWriter::add_topic(const McapTopic& topic) {
  State& s = *state_;
  if (s.broken) return Failure(*s.broken);
  if (s.closed) return fail(ErrorCode::internal, "the recording is closed", s.path);
  if (s.channels.size() >= 65000) return bad_input("more than 65000 topics", s.path);
  const auto id = static_cast<std::uint16_t>(s.channels.size() + 1);
  std::map<std::string, std::string> metadata{{"offered_qos_profiles", topic.offered_qos_profiles}};
  if (!topic.type_hash.empty()) metadata["topic_type_hash"] = topic.type_hash;
  Channel channel;
  channel.topic = topic.topic;
  channel.schema_record = mcap::record(
      mcap::kSchema, Bytes().put(id).string(topic.type).string("ros2msg").string(topic.schema_text).text());
  channel.channel_record = mcap::record(
      mcap::kChannel, Bytes().put(id).put(id).string(topic.topic).string("cdr").strings(metadata).text());
  if (auto ok = s.flush_chunk(); !ok) return Failure(ok.error());
  if (auto ok = s.append_checked(channel.schema_record + channel.channel_record); !ok)
    return Failure(ok.error());
  s.channels.push_back(std::move(channel));
  return id;
}

Status McapWriter::write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_ns,
                         std::uint64_t publish_ns, std::string_view cdr, std::uint64_t now_ns) {
  State& s = *state_;
  if (s.broken) return Failure(*s.broken);
  if (s.closed || channel == 0 || channel > s.channels.size())
    return fail(ErrorCode::internal, s.closed ? "the recording is closed" : "no such channel", s.path);
  if (s.chunk.empty()) {
    s.chunk_first_ns = s.chunk_last_ns = log_ns;
    s.chunk_born_ns = now_ns;
  }
  Channel& c = s.channels[channel - 1u];
  c.index.emplace_back(log_ns, s.chunk.size());
  const std::uint64_t size = 22 + cdr.size();
  const auto put = [&](auto value) { s.chunk.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint8_t>(mcap::kMessage));
  put(size);
  put(channel);
  put(sequence);
  put(log_ns);
  put(publish_ns);
  s.chunk.append(cdr);
  s.chunk_first_ns = std::min(s.chunk_first_ns, log_ns);
  s.chunk_last_ns = std::max(s.chunk_last_ns, log_ns);
  s.first_ns = s.messages == 0 ? log_ns : std::min(s.first_ns, log_ns);
  s.last_ns = s.messages == 0 ? log_ns : std::max(s.last_ns, log_ns);
  ++s.messages;
  ++c.messages;
  if (s.chunk.size() >= s.options.chunk_bytes) return s.flush_chunk();
  return tick(now_ns);
}

Status McapWriter::tick(std::uint64_t now_ns) {
  State& s = *state_;
  if (s.broken) return Failure(*s.broken);
  if (!s.chunk.empty() && now_ns - s.chunk_born_ns >= s.options.chunk_period_ns) return s.flush_chunk();
  return {};
}

Status McapWriter::flush() { return state_->flush_chunk(); }

void McapWriter::count_dropped(std::uint16_t channel, std::uint64_t count) {
  if (channel > 0 && channel <= state_->channels.size()) state_->channels[channel - 1u].dropped += count;
}

Status McapWriter::write_dropped() {
  std::map<std::string, std::string> counts;
  for (const Channel& c : state_->channels) counts[c.topic] = std::to_string(c.dropped);
  return write_metadata("omniflight.dropped", counts);
}

Status McapWriter::write_metadata(const std::string& name, const std::map<std::string, std::string>& values) {
  State& s = *state_;
  if (auto ok = s.flush_chunk(); !ok) return ok;
  const std::string out = mcap::record(mcap::kMetadata, Bytes().string(name).strings(values).text());
  const std::string index =
      mcap::record(mcap::kMetadataIndex,
                   Bytes().put(s.offset).put(static_cast<std::uint64_t>(out.size())).string(name).text());
  auto ok = s.append_checked(out);
  if (ok) {
    ++s.metadata;
    s.metadata_indexes += index;
  }
  return ok;
}

Status McapWriter::write_attachment(const std::string& name, const std::string& media_type,
                                    std::uint64_t log_ns, std::string_view data) {
  State& s = *state_;
  if (auto ok = s.flush_chunk(); !ok) return ok;
  Bytes content;
  content.put(log_ns).put(log_ns).string(name).string(media_type);
  content.put(static_cast<std::uint64_t>(data.size())).raw(data);
  content.put(mcap::crc32_of(content.text()));
  const std::string out = mcap::record(mcap::kAttachment, content.text());
  Bytes index;
  index.put(s.offset).put(static_cast<std::uint64_t>(out.size())).put(log_ns).put(log_ns);
  index.put(static_cast<std::uint64_t>(data.size())).string(name).string(media_type);
  auto ok = s.append_checked(out);
  if (ok) {
    ++s.attachments;
    s.attachment_indexes += mcap::record(mcap::kAttachmentIndex, index.text());
  }
  return ok;
}

std::string McapWriter::State::summary(std::uint64_t summary_start) const {
  std::string out, offsets;
  const auto group = [&](mcap::Op op, const std::string& records) {
    if (records.empty()) return;
    offsets += mcap::record(mcap::kSummaryOffset, Bytes()
                                                      .put(static_cast<std::uint8_t>(op))
                                                      .put(summary_start + out.size())
                                                      .put(static_cast<std::uint64_t>(records.size()))
                                                      .text());
    out += records;
  };
  std::string schemas, topics, indexes;
  Bytes counts;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    schemas += channels[i].schema_record;
    topics += channels[i].channel_record;
    counts.put(static_cast<std::uint16_t>(i + 1)).put(channels[i].messages);
  }
  for (const ChunkIndex& c : chunks) {
    Bytes places;
    for (const auto& [id, at] : c.index_offsets) places.put(id).put(at);
    Bytes index;
    index.put(c.first_ns).put(c.last_ns).put(c.start).put(c.length).string(places.text()).put(c.index_length);
    indexes +=
        mcap::record(mcap::kChunkIndex, index.string("zstd").put(c.compressed).put(c.uncompressed).text());
  }
  const auto topic_count = static_cast<std::uint32_t>(channels.size());
  Bytes statistics;
  statistics.put(messages)
      .put(static_cast<std::uint16_t>(topic_count))
      .put(topic_count)
      .put(attachments)
      .put(metadata);
  statistics.put(static_cast<std::uint32_t>(chunks.size())).put(first_ns).put(last_ns).string(counts.text());
  group(mcap::kSchema, schemas);
  group(mcap::kChannel, topics);
  group(mcap::kStatistics, mcap::record(mcap::kStatistics, statistics.text()));
  group(mcap::kChunkIndex, indexes);
  group(mcap::kAttachmentIndex, attachment_indexes);
  group(mcap::kMetadataIndex, metadata_indexes);
  const std::uint64_t offset_start = summary_start + out.size();
  out += offsets;
  Bytes footer;  // the CRC covers the summary and the footer up to the CRC itself
  footer.put(static_cast<std::uint8_t>(mcap::kFooter))
      .put(std::uint64_t{20})
      .put(summary_start)
      .put(offset_start);
  const std::uint32_t crc = mcap::crc32_of(footer.text(), mcap::crc32_of(out));
  return out + footer.put(crc).text();
}

Status McapWriter::close() {
  State& s = *state_;
  if (s.closed) return s.broken ? Status(Failure(*s.broken)) : Status{};
  Status ok = write_dropped();  // flushes the open chunk first
  s.closed = true;
  if (ok) {
    const std::uint64_t summary_start = s.offset + 13;  // behind the DataEnd record
    const std::string end = mcap::record(mcap::kDataEnd, Bytes().put(s.data_crc).text());
    ok = s.append(end + s.summary(summary_start) + std::string(mcap::kMagic));
  }
  const int fd = std::exchange(s.fd, -1);
  if (ok && s.regular && ::fsync(fd) != 0) ok = s.give_up("sync");
  if (::close(fd) != 0 && ok) ok = s.give_up("close");
  return ok;
}

McapStatistics McapWriter::statistics() const {
  McapStatistics out;
  out.messages = state_->messages;
  for (const Channel& c : state_->channels) out.dropped += c.dropped;
  out.bytes = state_->offset;
  out.chunks = static_cast<std::uint32_t>(state_->chunks.size());
  return out;
}

}  // namespace omniflight::recording
