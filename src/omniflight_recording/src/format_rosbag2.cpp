// ROS 2 bags in SQLite: read from memory, so that the file cannot be written to; messages decoded by the
// definitions in the bag, or those of the maps.
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "format_table.hpp"
#include "omniflight_files/files.hpp"
#include "topic_feeds.hpp"
#include "unpack.hpp"

namespace omniflight::recording {
namespace {

constexpr std::string_view kSqliteMagic{"SQLite format 3\0", 16};
constexpr std::size_t kSqliteHeaderBytes = 100;
constexpr int kMostValue = 256 << 20;  // bytes of one message

struct Close {
  void operator()(sqlite3* db) const { sqlite3_close(db); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, Close>;

/// A database of unknown origin: no triggers, views or functions of its schema are run, and the work is
/// bounded by its size, since a damaged tree can lead in circles.
class Database {
 public:
  Status open(std::string_view bytes, const std::string& file) {
    if (bytes.size() < kSqliteHeaderBytes)
      return bad_input("holds only the start of an SQLite database", file);
    bytes = made_whole(bytes);
    sqlite3* db = nullptr;
    int code = sqlite3_open_v2(":memory:", &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_MEMORY, nullptr);
    db_.reset(db);
    if (code == SQLITE_OK) {
      // the library does not write to it: SQLITE_DESERIALIZE_READONLY
      auto* data = reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data()));
      const auto size = static_cast<sqlite3_int64>(bytes.size());
      code = sqlite3_deserialize(db, "main", data, size, size, SQLITE_DESERIALIZE_READONLY);
    }
    if (code != SQLITE_OK) return fail(ErrorCode::internal, "SQLite cannot be started", file);
    sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kMostValue);
    left_ = 1000 + static_cast<std::int64_t>(bytes.size()) / 10;  // thousands of steps; a row takes about ten
    sqlite3_progress_handler(
        db, 1000, [](void* self) { return --static_cast<Database*>(self)->left_ < 0 ? 1 : 0; }, this);
    return {};
  }

  std::uint32_t missing_pages() const { return missing_pages_; }

  Statement prepare(const char* sql) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(db_.get(), sql, -1, &statement, nullptr);
    return Statement(statement);
  }
  std::string error() const { return left_ < 0 ? "its tables lead in circles" : sqlite3_errmsg(db_.get()); }

 private:
  /// A database in memory cannot have a write-ahead log, so the mark of one is taken from a copy. Of a cut
  /// file the last page and the count of pages are corrected: what is missing would be read as zeros
  /// otherwise.
  std::string_view made_whole(std::string_view bytes) {
    constexpr std::size_t kPageSize = 16, kWriteVersion = 18, kReadVersion = 19, kPages = 28;
    const auto big_endian = [&](std::size_t at, std::size_t count) {
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < count; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
      return value;
    };
    std::uint32_t page = big_endian(kPageSize, 2);
    if (page == 1) page = 65536;
    if (page < 512) return bytes;  // SQLite will say so
    const std::uint32_t told = big_endian(kPages, 4);
    const auto there = static_cast<std::uint32_t>(bytes.size() / page);
    const bool cut = told > there || bytes.size() % page != 0;
    if (!cut && bytes[kWriteVersion] != 2 && bytes[kReadVersion] != 2) return bytes;
    copy_ = std::string(bytes.substr(0, std::size_t{there} * page));
    if (copy_.size() < kSqliteHeaderBytes) return bytes;
    copy_[kWriteVersion] = copy_[kReadVersion] = 1;
    if (cut) {
      missing_pages_ = std::max(told, there + 1) - there;
      for (std::size_t i = 0; i < 4; ++i) copy_[kPages + i] = static_cast<char>(there >> (24 - 8 * i) & 0xff);
    }
    return copy_;
  }

  std::string copy_;  // the database reads it until it is closed
  std::unique_ptr<sqlite3, Close> db_;
  std::int64_t left_ = 0;
  std::uint32_t missing_pages_ = 0;
};

std::string text(const Statement& s, int column) {
  const auto* value = reinterpret_cast<const char*>(sqlite3_column_text(s.get(), column));
  return value ? std::string(value, static_cast<std::size_t>(sqlite3_column_bytes(s.get(), column)))
               : std::string();
}

class Rosbag2Loader {
 public:
  Rosbag2Loader(Database& db, std::size_t bytes, TopicMap map, Recording& recording)
      : db_(db),
        budget_(std::max<std::uint64_t>(files::kSmallEnough, bytes * files::kMostGzipRatio)),
        recording_(recording),
        feeds_(std::move(map), recording) {}

  Status run(const std::string& file) {
    for (const char* table : {"topics", "messages"})
      if (auto ok = plain_table(table, file); !ok) return ok;
    if (db_.missing_pages() > 0)
      recording_.note(Note::Kind::loss, "the file is cut: its last " + std::to_string(db_.missing_pages()) +
                                            " pages are missing");
    check();
    definitions();
    if (auto ok = topics(file); !ok) return ok;
    messages();
    return feeds_.finish();
  }

 private:
  /// No view, virtual table or computed column under that name.
  Status plain_table(const std::string& name, const std::string& file) {
    const auto s = db_.prepare("SELECT type, rootpage, sql FROM sqlite_master WHERE name = ?1");
    if (s) sqlite3_bind_text(s.get(), 1, name.c_str(), -1, SQLITE_STATIC);
    if (!s || sqlite3_step(s.get()) != SQLITE_ROW)
      return bad_input(
          "is an SQLite database without the table " + name + " of a ROS 2 bag", file,
          s && db_.error() != "no more rows available" ? "SQLite says: " + db_.error() : "Give a recording");
    std::string sql = text(s, 2);
    std::transform(sql.begin(), sql.end(), sql.begin(), [](unsigned char c) { return std::toupper(c); });
    if (text(s, 0) != "table" || sqlite3_column_int(s.get(), 1) <= 0 ||
        sql.find(" AS ") != std::string::npos || sql.find(" AS(") != std::string::npos ||
        sql.find("GENERATED") != std::string::npos || sql.find("VIRTUAL") != std::string::npos)
      return bad_input("its table " + name + " is no plain table", file, "This is no bag of rosbag2");
    return {};
  }

  /// The structure of the file; the messages themselves have no checksum.
  void check() {
    const auto s = db_.prepare("PRAGMA quick_check(1)");
    if (s && sqlite3_step(s.get()) == SQLITE_ROW && text(s, 0) != "ok")
      recording_.note(Note::Kind::damage, "the database is damaged: " + files::shown(text(s, 0)));
    else if (!s || sqlite3_errcode(sqlite3_db_handle(s.get())) == SQLITE_CORRUPT)
      recording_.note(Note::Kind::damage, "the database is damaged: " + db_.error());
  }

  /// Of bags since ROS 2 Iron.
  void definitions() {
    const auto s =
        db_.prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
    while (s && sqlite3_step(s.get()) == SQLITE_ROW && definitions_.size() < 10000)
      if (text(s, 1) == "ros2msg") definitions_[short_type(text(s, 0))] = text(s, 2);
    if (const auto schema = db_.prepare("SELECT ros_distro FROM schema");
        schema && sqlite3_step(schema.get()) == SQLITE_ROW)
      recording_.metadata["rosbag2.ros_distro"] = files::shown(text(schema, 0));
  }

  Status topics(const std::string& file) {
    const auto s = db_.prepare("SELECT id, name, type, serialization_format FROM topics");
    if (!s) return bad_input("its table topics has not the columns of a ROS 2 bag: " + db_.error(), file);
    while (sqlite3_step(s.get()) == SQLITE_ROW) {
      DeclaredTopic topic;
      topic.name = text(s, 1);
      topic.type = short_type(text(s, 2));
      if (text(s, 3) != "cdr")
        topic.unreadable = "its messages are " + files::shown(text(s, 3)) + "; cdr is read";
      if (const auto found = definitions_.find(topic.type); found != definitions_.end())
        topic.definition = found->second;
      topics_[sqlite3_column_int64(s.get(), 0)] = feeds_.open(topic);
    }
    return {};
  }

  void messages() {
    const auto s = db_.prepare("SELECT topic_id, timestamp, data FROM messages NOT INDEXED");
    std::uint64_t read = 0, homeless = 0;
    int code = s ? SQLITE_ROW : SQLITE_ERROR;
    while (s && (code = sqlite3_step(s.get())) == SQLITE_ROW) {
      const auto topic = topics_.find(sqlite3_column_int64(s.get(), 0));
      const auto* data = static_cast<const char*>(sqlite3_column_blob(s.get(), 2));
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(s.get(), 2));
      ++read;
      if (topic == topics_.end())
        ++homeless;
      else
        feeds_.message(topic->second, unpacked(data ? std::string_view(data, size) : std::string_view()),
                       sqlite3_column_int64(s.get(), 1));
    }
    if (code != SQLITE_DONE)
      recording_.note(Note::Kind::loss,
                      "the bag cannot be read behind message " + std::to_string(read) + ": " + db_.error());
    if (homeless > 0)
      recording_.note(Note::Kind::loss, std::to_string(homeless) + " messages belong to no known topic",
                      homeless);
    recording_.metadata["rosbag2.messages"] = std::to_string(read);
  }

  /// Of bags that were recorded with --compression-mode message; other messages begin with a zero.
  std::string_view unpacked(std::string_view message) {
    if (message.substr(0, kZstdMagic.size()) != kZstdMagic) return message;
    if (!unpack_zstd(message, std::min<std::uint64_t>(budget_, kMostValue), unpacked_)) return {};
    budget_ -= unpacked_.size();
    return unpacked_;
  }

  Database& db_;
  std::uint64_t budget_;  // bytes that may still be unpacked
  std::string unpacked_;
  Recording& recording_;
  TopicFeeds feeds_;
  std::map<std::string, std::string> definitions_;
  std::map<std::int64_t, std::size_t> topics_;
};

bool is_rosbag2(std::string_view head) { return head.substr(0, kSqliteMagic.size()) == kSqliteMagic; }

Result<Recording> read_rosbag2(std::string_view bytes, const std::string& file, const LoadOptions& options) {
  auto map = topic_map_for(options.map);
  if (!map) return Failure(map.error());
  Database db;
  if (auto ok = db.open(bytes, file); !ok) return Failure(ok.error());
  Recording recording;
  if (auto ok = Rosbag2Loader(db, bytes.size(), std::move(*map), recording).run(file); !ok)
    return Failure(ok.error());
  std::error_code ec;
  if (const auto size = std::filesystem::file_size(file + "-wal", ec); !ec && size > 0)
    recording.note(Note::Kind::loss,
                   "messages in the write-ahead log beside it were not read; to have them in "
                   "the bag: sqlite3 " +
                       file + " 'PRAGMA wal_checkpoint'");
  return recording;
}

}  // namespace

const Format& rosbag2_format() {
  static const Format format{"rosbag2_sqlite", "ROS 2 bag (SQLite)", is_rosbag2, read_rosbag2};
  return format;
}

}  // namespace omniflight::recording
