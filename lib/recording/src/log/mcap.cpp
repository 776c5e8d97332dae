// MCAP: records of an opcode, a length and that many bytes between two magics; messages of numbered
// channels stand at the top or inside chunks. Indexes and the summary repeat and are not needed.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "decoded_topic.h"
#include "mcap_records.h"
#include "readers.h"
#include "unpack.h"

namespace recording {
namespace {

constexpr std::size_t kRecordHead = 9, kMostNotes = 100;
constexpr std::string_view kOwnMetadata = "kerbstone";  // of files that crgdrive writes

/// The fields of a record, one after the other.
class Fields {
 public:
  Fields(std::string_view bytes, const std::string& where) : rest_(bytes), where_(where) {}

  template <class T>
  T number() {
    want(sizeof(T));
    const T value = little<T>(rest_, 0);
    rest_.remove_prefix(sizeof(T));
    return value;
  }
  std::string_view bytes(std::uint64_t count) {
    want(count);
    const std::string_view out = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return out;
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }
  std::string_view rest() const { return rest_; }

 private:
  void want(std::uint64_t count) const {
    if (count > rest_.size())
      throw base::Error(where_ + ": the record is shorter than its fields; the file is damaged");
  }
  std::string_view rest_;
  const std::string& where_;
};

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name)
      : bytes_(bytes), name_(name), may_unpack_(most_unpacked(bytes.size())) {}

  FileTopics topics() {
    read_top();
    FileTopics out;
    for (DecodedTopic& decoded : topics_) std::move(decoded).move_to(out.topics);
    out.notes = std::move(notes_);
    return out;
  }

  Log read() {
    Log log = log_of_file(topics(), "MCAP", name_);
    if (const auto own = metadata_.find("columns"); own != metadata_.end())
      as_table(own->second, log);
    return log;
  }

 private:
  struct Schema {
    std::string name, encoding;
    std::string text;
  };

  void read_top() {
    std::size_t at = kMcapMagic.size();
    while (at < bytes_.size()) {
      if (bytes_.size() - at < kRecordHead) return note_cut_off(at);
      const int opcode = static_cast<unsigned char>(bytes_[at]);
      const auto length = little<std::uint64_t>(bytes_, at + 1);
      if (length > bytes_.size() - at - kRecordHead) return note_cut_off(at);
      const std::string_view content = bytes_.substr(at + kRecordHead, length);
      const std::string where = fmt::format("{}: byte {}", name_, at);
      if (opcode == kDataEnd) return check_data(at, Fields(content, where));
      if (opcode == kFooter) return;
      if (opcode == kChunk)
        read_chunk(Fields(content, where), where);
      else
        read_record(opcode, Fields(content, where), where);
      at += kRecordHead + length;
    }
    note_cut_off(at);
  }

  void note_cut_off(std::size_t at) {
    notes_.push_back(fmt::format("the file was cut off at byte {} of {}: what came before is read",
                                 at, bytes_.size()));
  }

  void check_data(std::size_t end, Fields fields) const {
    want_crc(fields.number<std::uint32_t>(), bytes_.substr(0, end), name_ + ": the data");
  }

  static void want_crc(std::uint32_t stated, std::string_view bytes, const std::string& where) {
    if (stated == 0) return;  // not computed
    const std::uint32_t seen = crc_of(bytes);
    if (seen != stated)
      throw base::Error(
          fmt::format("{}: CRC {:08x}, stated {:08x}; the file is damaged", where, seen, stated));
  }

  void read_chunk(Fields fields, const std::string& where) {
    fields.bytes(16);  // its first and last moment
    const auto size = fields.number<std::uint64_t>();
    const auto crc = fields.number<std::uint32_t>();
    const std::string_view packer = fields.text();
    const std::string_view packed = fields.bytes(fields.number<std::uint64_t>());
    if (size > may_unpack_)
      throw base::Error(
          fmt::format("{}: a chunk of {} bytes, more than such a file can hold; it "
                      "is damaged",
                      where, size));
    may_unpack_ -= size;
    std::string unpacked;
    try {
      if (packer == "zstd") unpacked = unpack_zstd(packed, size);
      if (packer == "lz4") unpacked = unpack_lz4(packed, size);
    } catch (const base::Error& error) {
      throw base::Error(fmt::format("{}: a chunk {}", where, error.what()));
    }
    const bool plain = packer.empty();
    if (!plain && packer != "zstd" && packer != "lz4")
      throw base::Error(fmt::format("{}: a chunk packed by '{}', wanted zstd, lz4 or none", where,
                                    packer.substr(0, 40)));
    const std::string_view records = plain ? packed : std::string_view(unpacked);
    if (records.size() != size)
      throw base::Error(fmt::format("{}: a chunk holds {} bytes, stated {}; the file is damaged",
                                    where, records.size(), size));
    want_crc(crc, records, where + ": a chunk");
    read_records(records, where);
  }

  void read_records(std::string_view records, const std::string& where) {
    while (!records.empty()) {
      if (records.size() < kRecordHead ||
          little<std::uint64_t>(records, 1) > records.size() - kRecordHead)
        throw base::Error(where + ": a record ends beyond its chunk; the file is damaged");
      const auto length = little<std::uint64_t>(records, 1);
      const std::string_view content = records.substr(kRecordHead, length);
      read_record(static_cast<unsigned char>(records[0]), Fields(content, where), where);
      records.remove_prefix(kRecordHead + length);
    }
  }

  void read_record(int opcode, Fields fields, const std::string& where) {
    if (opcode == kSchema) read_schema(fields);
    if (opcode == kChannel) read_channel(fields);
    if (opcode == kMessage) read_message(fields, where);
    if (opcode == kMetadata) read_metadata(fields);
  }

  void read_schema(Fields fields) {
    const auto id = fields.number<std::uint16_t>();
    const std::string_view name = fields.text(), encoding = fields.text(), text = fields.text();
    schemas_.try_emplace(id, Schema{std::string(name), std::string(encoding), std::string(text)});
  }

  /// Channels of one topic and type are one.
  void read_channel(Fields fields) {
    const auto id = fields.number<std::uint16_t>();
    const auto schema_id = fields.number<std::uint16_t>();
    const std::string_view topic = fields.text(), encoding = fields.text();
    if (channels_.contains(id)) return;
    std::optional<std::size_t>& index = channels_[id];
    const auto key = std::make_tuple(std::string(topic), std::string(encoding), schema_id);
    if (const auto known = known_.find(key); known != known_.end()) {
      index = known->second;
      return;
    }
    const auto schema = schemas_.find(schema_id);
    Description described{std::string(encoding), "", "", ""};
    if (schema != schemas_.end())
      described = {std::string(encoding), schema->second.encoding, schema->second.name,
                   schema->second.text};
    try {
      topics_.emplace_back(std::string(topic), described);
      index = topics_.size() - 1;
    } catch (const base::Error& error) {
      if (notes_.size() < kMostNotes)
        notes_.push_back(fmt::format("{}: not read: {}", topic.substr(0, 200), error.what()));
    }
    known_.emplace(key, index);
  }

  void read_message(Fields fields, const std::string& where) {
    const auto id = fields.number<std::uint16_t>();
    fields.number<std::uint32_t>();  // which of how many
    const auto logged_ns = fields.number<std::uint64_t>();
    fields.number<std::uint64_t>();  // when it was published
    const auto channel = channels_.find(id);
    if (channel == channels_.end())
      throw base::Error(
          fmt::format("{}: a message of channel {}, which is not described before "
                      "it; the file is damaged",
                      where, id));
    if (channel->second) topics_[*channel->second].read(logged_ns, fields.rest());
  }

  void read_metadata(Fields fields) {
    if (fields.text() != kOwnMetadata) return;
    Fields entries(fields.text(), name_);
    while (!entries.rest().empty()) {
      const std::string key(entries.text());
      metadata_[key] = entries.text();
    }
  }

  /// A file of ours is the table it was written from: names and order of its columns, no clock but
  /// its own. Where something does not fit (another program took topics out), it stays as it is.
  static void as_table(const std::string& columns, Log& log) {
    std::map<std::string, Channel*, std::less<>> by_field;
    for (Channel& channel : log.channels)
      by_field.emplace(channel.name.substr(channel.name.find('.') + 1), &channel);
    std::vector<Channel*> wanted;
    std::string_view rest = columns;
    while (!rest.empty()) {
      const std::string_view field = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(rest.size(), field.size() + 1));
      const auto found = by_field.find(field);
      if (found == by_field.end()) return;
      wanted.push_back(found->second);
      by_field.erase(found);
      if (log.clocks[wanted.back()->clock] != log.clocks[wanted.front()->clock]) return;
    }
    if (wanted.empty()) return;
    std::vector<Channel> out;
    for (Channel* channel : wanted) {
      channel->name = channel->name.substr(channel->name.find('.') + 1);
      channel->clock = 0;
      out.push_back(std::move(*channel));
    }
    log.channels = std::move(out);
    log.clocks.clear();
    log.in_rows = true;
  }

  std::string_view bytes_;
  const std::string& name_;
  std::size_t may_unpack_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, std::optional<std::size_t>> channels_;  ///< their topics, if read
  std::map<std::tuple<std::string, std::string, std::uint16_t>, std::optional<std::size_t>> known_;
  std::vector<DecodedTopic> topics_;
  std::vector<std::string> notes_;
  std::map<std::string, std::string> metadata_;
};

}  // namespace

bool is_mcap(std::string_view bytes) { return bytes.starts_with(kMcapMagic); }

FileTopics topics_of_mcap(std::string_view bytes, const std::string& name) {
  return Reader(bytes, name).topics();
}

Log parse_mcap(std::string_view bytes, const std::string& name) {
  return Reader(bytes, name).read();
}

}  // namespace recording
