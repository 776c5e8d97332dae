// rosbag2's SQLite files: a table of topics, one of messages, and since 2023 one of descriptions.
// The database is hostile until shown otherwise: read from memory, nothing but these tables, within
// bounds.
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "decoded_topic.h"
#include "readers.h"
#include "unpack.h"

namespace recording {
namespace {

constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);
constexpr std::size_t kMostTopics = 65536;

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

/// Nothing may run but a SELECT that reads columns: no views, no recursion. What computed columns
/// call is held by SQLITE_DBCONFIG_TRUSTED_SCHEMA to functions that do nothing else.
int only_reading(void*, int action, const char*, const char*, const char*, const char*) {
  return action == SQLITE_SELECT || action == SQLITE_READ ? SQLITE_OK : SQLITE_DENY;
}

/// Called every million steps of SQLite's machine; stops it where no bag takes as many.
int stop_at_none(void* left) { return --*static_cast<std::int64_t*>(left) < 0 ? 1 : 0; }

class Bag {
 public:
  Bag(std::string_view bytes, const std::string& name)
      : name_(name), may_unpack_(most_unpacked(bytes.size())) {
    sqlite3* made = nullptr;
    const int opened = sqlite3_open_v2(":memory:", &made, SQLITE_OPEN_READWRITE, nullptr);
    db_ = Database(made, sqlite3_close);
    want(opened == SQLITE_OK);
    bytes_ = bytes;
    // A database that was written ahead of a log says so in two bytes, and is refused in memory.
    if (bytes_.size() > 20) bytes_[18] = bytes_[19] = 1;
    auto* const raw = reinterpret_cast<unsigned char*>(bytes_.data());
    const auto size = static_cast<sqlite3_int64>(bytes_.size());
    want(sqlite3_deserialize(db_.get(), "main", raw, size, size, SQLITE_DESERIALIZE_READONLY) ==
         SQLITE_OK);
    sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_limit(db_.get(), SQLITE_LIMIT_LENGTH,
                  static_cast<int>(std::min<std::size_t>(bytes_.size() + 1, 1 << 30)));
    sqlite3_set_authorizer(db_.get(), only_reading, nullptr);
    millions_left_ = 100 + static_cast<std::int64_t>(bytes_.size() / 1000);
    sqlite3_progress_handler(db_.get(), 1000000, stop_at_none, &millions_left_);
  }

  FileTopics read() {
    read_descriptions();
    read_topics();
    read_messages();
    FileTopics out;
    for (auto& [id, decoded] : topics_)
      if (decoded) std::move(*decoded).move_to(out.topics);
    out.notes = std::move(notes_);
    return out;
  }

 private:
  void want(bool good) const {
    if (good) return;
    std::string said = db_ ? sqlite3_errmsg(db_.get()) : "no memory";
    for (char& c : said)
      if (static_cast<unsigned char>(c) < 32) c = ' ';
    throw base::Error(
        fmt::format("{}: as an SQLite database: {}; no rosbag2 file, or it is damaged", name_,
                    said.substr(0, 200)));
  }

  Statement prepared(const char* sql) const {
    sqlite3_stmt* made = nullptr;
    const int result = sqlite3_prepare_v2(db_.get(), sql, -1, &made, nullptr);
    Statement out(made, sqlite3_finalize);
    want(result == SQLITE_OK);
    return out;
  }

  bool next(const Statement& statement) {
    const int result = sqlite3_step(statement.get());
    want(result == SQLITE_ROW || result == SQLITE_DONE);
    count(1);
    return result == SQLITE_ROW;
  }

  /// Pages that lead back to themselves hold more than the file.
  void count(std::size_t bytes) {
    bytes_read_ += bytes;
    if (bytes_read_ > 4 * bytes_.size() + 10000)
      throw base::Error(name_ + ": more rows than the file has room for; it is damaged");
  }

  std::string_view bytes_at(const Statement& row, int column) {
    const void* const bytes = sqlite3_column_blob(row.get(), column);
    const auto length = static_cast<std::size_t>(sqlite3_column_bytes(row.get(), column));
    count(length);
    if (bytes == nullptr) return {};
    return {static_cast<const char*>(bytes), length};
  }

  bool has_table(std::string_view wanted) {
    const Statement rows = prepared("SELECT type, name FROM sqlite_master");
    while (next(rows))
      if (bytes_at(rows, 0) == "table" && bytes_at(rows, 1) == wanted) return true;
    return false;
  }

  void read_descriptions() {
    if (!has_table("message_definitions")) return;
    const Statement rows = prepared(
        "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
    while (next(rows) && descriptions_.size() < kMostTopics) {
      const std::string type(bytes_at(rows, 0));
      std::string encoding(bytes_at(rows, 1)), text(bytes_at(rows, 2));
      descriptions_.try_emplace(type, std::move(encoding), std::move(text));
    }
  }

  void read_topics() {
    const Statement rows = prepared("SELECT id, name, type, serialization_format FROM topics");
    while (next(rows) && topics_.size() < kMostTopics) {
      const sqlite3_int64 id = sqlite3_column_int64(rows.get(), 0);
      const std::string topic(bytes_at(rows, 1));
      Description described{std::string(bytes_at(rows, 3)), "", std::string(bytes_at(rows, 2)), ""};
      if (const auto found = descriptions_.find(described.schema_name);
          found != descriptions_.end()) {
        described.schema_encoding = found->second.first;
        described.schema = found->second.second;
      }
      std::optional<DecodedTopic>& decoded = topics_[id];
      if (decoded) continue;
      try {
        decoded.emplace(topic, described);
      } catch (const base::Error& error) {
        if (notes_.size() < 100)
          notes_.push_back(fmt::format("{}: not read: {}", topic.substr(0, 200), error.what()));
      }
    }
  }

  void read_messages() {
    const Statement rows = prepared("SELECT topic_id, timestamp, data FROM messages");
    while (next(rows)) {
      const std::string_view data = bytes_at(rows, 2);
      const auto topic = topics_.find(sqlite3_column_int64(rows.get(), 0));
      if (topic == topics_.end() || !topic->second) continue;
      read_message(*topic->second, sqlite3_column_int64(rows.get(), 1), data);
    }
  }

  void read_message(DecodedTopic& topic, sqlite3_int64 logged_ns, std::string_view data) {
    const auto moment = static_cast<std::uint64_t>(logged_ns);
    if (!is_zstd(data)) return topic.read(moment, data);
    try {
      const std::string unpacked = unpack_zstd(data, may_unpack_);
      may_unpack_ -= unpacked.size();
      topic.read(moment, unpacked);
    } catch (const base::Error& error) {
      throw base::Error(
          fmt::format("{}: a message of {} {}", name_, topic.name().substr(0, 200), error.what()));
    }
  }

  const std::string& name_;
  std::size_t may_unpack_, bytes_read_ = 0;
  std::int64_t millions_left_ = 0;
  std::string bytes_;  ///< outlives the database
  Database db_{nullptr, sqlite3_close};
  std::map<std::string, std::pair<std::string, std::string>>
      descriptions_;  ///< encoding and text by type
  std::map<sqlite3_int64, std::optional<DecodedTopic>> topics_;
  std::vector<std::string> notes_;
};

}  // namespace

bool is_rosbag2(std::string_view bytes) { return bytes.starts_with(kSqliteMagic); }

FileTopics topics_of_rosbag2(std::string_view bytes, const std::string& name) {
  return Bag(bytes, name).read();
}

Log parse_rosbag2(std::string_view bytes, const std::string& name) {
  return log_of_file(topics_of_rosbag2(bytes, name), "rosbag2", name);
}

}  // namespace recording
