// Writes SQLite bags as rosbag2 does, of the made-up flight.
#pragma once

#include <sqlite3.h>

#include <filesystem>
#include <stdexcept>

#include "sample_bag.hpp"
#include "sample_ulog.hpp"

namespace sample {

class Bag2 {
 public:
  /// With the tables of Iron and later, or of before (no definitions).
  Bag2(const std::filesystem::path& file, bool definitions) : file_(file) {
    std::filesystem::remove(file);
    if (sqlite3_open(file.c_str(), &db_) != SQLITE_OK) throw std::runtime_error("sqlite");
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT "
        "NULL, "
        "data BLOB NOT NULL)");
    run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
    if (definitions)
      run("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT "
          "NOT "
          "NULL, encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL)");
    run("BEGIN");
  }
  Bag2(const Bag2&) = delete;
  Bag2& operator=(const Bag2&) = delete;
  ~Bag2() { close(); }
  void close() {
    if (!db_) return;
    run("COMMIT");
    sqlite3_close(db_);
    db_ = nullptr;
  }
  void run(const std::string& sql) {
    if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
      throw std::runtime_error(sqlite3_errmsg(db_));
  }
  void topic(int id, const std::string& name, const std::string& type, const std::string& definition = {},
             const std::string& format = "cdr") {
    run("INSERT INTO topics VALUES(" + std::to_string(id) + ",'" + name + "','" + type + "','" + format +
        "','')");
    if (!definition.empty())
      run("INSERT INTO message_definitions(topic_type, encoding, encoded_message_definition, "
          "type_description_hash) VALUES('" +
          type + "','ros2msg','" + definition + "','')");
  }
  void message(int topic, std::uint64_t ns, const std::string& data) {
    sqlite3_stmt* s = nullptr;
    sqlite3_prepare_v2(db_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", -1, &s, nullptr);
    sqlite3_bind_int(s, 1, topic);
    sqlite3_bind_int64(s, 2, static_cast<sqlite3_int64>(ns));
    sqlite3_bind_blob(s, 3, data.data(), static_cast<int>(data.size()), SQLITE_STATIC);
    const int code = sqlite3_step(s);
    sqlite3_finalize(s);
    if (code != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(db_));
  }
  std::string bytes() {
    close();
    return slurp(file_);
  }

 private:
  std::filesystem::path file_;
  sqlite3* db_ = nullptr;
};

/// px4_msgs/VehicleOdometry of the flight, as the uXRCE bridge publishes it: NED, FRD, microseconds.
inline const char* kPx4Odometry =
    "uint32 MESSAGE_VERSION = 0\nuint64 timestamp # us\nuint64 timestamp_sample\nuint8 POSE_FRAME_NED=1\n"
    "uint8 pose_frame\nfloat32[3] position\nfloat32[4] q\nuint8 velocity_frame\nfloat32[3] velocity\n"
    "float32[3] angular_velocity\n";
inline std::string px4_odometry(std::uint64_t us, const Moment& m, bool in_body = false) {
  Cdr c;
  c.put(us + 500).put(us).put(std::uint8_t{1});
  const auto p = ned(m.p_WB), w = frd(m.w_B), v = in_body ? frd(m.q_WB.conjugate() * m.v_WB) : ned(m.v_WB);
  const auto q = ned_frd(m.q_WB);
  for (int i = 0; i < 3; ++i) c.put(static_cast<float>(p(i)));
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) c.put(static_cast<float>(value));
  c.put(static_cast<std::uint8_t>(in_body ? 3 : 1));
  for (int i = 0; i < 3; ++i) c.put(static_cast<float>(v(i)));
  for (int i = 0; i < 3; ++i) c.put(static_cast<float>(w(i)));
  return c.text();
}

}  // namespace sample
