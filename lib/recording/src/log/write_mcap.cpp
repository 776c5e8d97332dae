#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/error.h"
#include "base/json_text.h"
#include "mcap_records.h"
#include "recording/mcap.h"

namespace recording {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

template <class T>
void put(std::string& out, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));  // the machines we build for are little-endian
  out.append(raw, sizeof(T));
}
void put8(std::string& out, std::size_t value) { put(out, static_cast<std::uint64_t>(value)); }
void put4(std::string& out, std::size_t value) { put(out, static_cast<std::uint32_t>(value)); }
void put2(std::string& out, std::size_t value) { put(out, static_cast<std::uint16_t>(value)); }
void put_text(std::string& out, std::string_view text) {
  put4(out, text.size());
  out += text;
}
void put_record(std::string& out, Opcode opcode, std::string_view content) {
  out += static_cast<char>(opcode);
  put8(out, content.size());
  out += content;
}

/// A name in quotes.
std::string quoted(const std::string& name) { return base::dump_json(nlohmann::json(name)); }

std::string schema_text(const WrittenTopic& topic) {
  std::string properties;
  for (const std::string& field : topic.fields)
    properties +=
        fmt::format("{}{}:{{\"type\":\"number\"}}", properties.empty() ? "" : ",", quoted(field));
  return fmt::format("{{\"type\":\"object\",\"properties\":{{{}}}}}", properties);
}

/// Whatever stands in a record of its own in the data and again in the summary.
std::string schemas_of(const std::vector<WrittenTopic>& topics) {
  std::string out;
  for (std::size_t t = 0; t < topics.size(); ++t) {
    std::string content;
    put2(content, t + 1);
    put_text(content, "kerbstone" + topics[t].name);
    put_text(content, "jsonschema");
    put_text(content, schema_text(topics[t]));
    put_record(out, kSchema, content);
  }
  return out;
}

std::string channels_of(const std::vector<WrittenTopic>& topics) {
  std::string out;
  for (std::size_t t = 0; t < topics.size(); ++t) {
    std::string content;
    put2(content, t);
    put2(content, t + 1);
    put_text(content, topics[t].name);
    put_text(content, "json");
    put4(content, 0);  // no metadata
    put_record(out, kChannel, content);
  }
  return out;
}

class Writer {
 public:
  Writer(std::span<const double> time_s, const std::vector<WrittenTopic>& topics)
      : topics_(topics), indexes_(topics.size()) {
    for (const WrittenTopic& topic : topics) {
      names_.emplace_back();
      for (const std::string& field : topic.fields) names_.back().push_back(quoted(field));
    }
    double first = 0.0;
    for (const double t : time_s)
      if (std::isfinite(t)) first = std::min(first, t);
    for (const double t : time_s) {
      const double ns = std::round((std::isfinite(t) ? t - first : 0.0) * 1e9);
      if (!(ns < 9e18))
        throw base::Error(fmt::format("a moment at {} s is beyond what MCAP can hold", t));
      times_ns_.push_back(static_cast<std::uint64_t>(ns));
    }
  }

  std::string write(const std::vector<std::string>& columns, const std::string& about) {
    out_ = kMcapMagic;
    std::string header;
    put_text(header, "");
    put_text(header, "kerbstone");
    put_record(out_, kHeader, header);
    begin_chunk();
    for (std::size_t row = 0; row < times_ns_.size(); ++row) {
      for (std::size_t t = 0; t < topics_.size(); ++t) add_message(t, row);
      if (chunk_.size() >= kChunkBytes) end_chunk();
    }
    end_chunk();
    add_metadata(columns, about);
    std::string end;
    put4(end, crc_of(out_));
    put_record(out_, kDataEnd, end);
    add_summary();
    out_ += kMcapMagic;
    return std::move(out_);
  }

 private:
  void begin_chunk() {
    chunk_ = chunk_indexes_.empty() ? schemas_of(topics_) + channels_of(topics_) : "";
    for (std::string& index : indexes_) index.clear();
  }

  void add_message(std::size_t t, std::size_t row) {
    const WrittenTopic& topic = topics_[t];
    message_.clear();
    put2(message_, t);
    put4(message_, row);
    put8(message_, times_ns_[row]);
    put8(message_, times_ns_[row]);
    char separator = '{';
    for (std::size_t c = 0; c < topic.fields.size(); ++c) {
      const double value = topic.columns[c][row];
      if (!std::isfinite(value)) continue;
      fmt::format_to(std::back_inserter(message_), "{}{}:{}", separator, names_[t][c], value);
      separator = ',';
    }
    message_ += separator == '{' ? "{}" : "}";
    put8(indexes_[t], times_ns_[row]);
    put8(indexes_[t], chunk_.size());
    put_record(chunk_, kMessage, message_);
    first_ns_ = messages_ == 0 ? times_ns_[row] : std::min(first_ns_, times_ns_[row]);
    last_ns_ = std::max(last_ns_, times_ns_[row]);
    ++messages_;
    ++counts_[t];
  }

  /// The first and last moment of a chunk, from its message indexes.
  std::pair<std::uint64_t, std::uint64_t> span_of_chunk() const {
    std::uint64_t first = ~std::uint64_t{0}, last = 0;
    for (const std::string& index : indexes_)
      for (std::size_t at = 0; at < index.size(); at += 16) {
        std::uint64_t ns = 0;
        std::memcpy(&ns, index.data() + at, 8);
        first = std::min(first, ns);
        last = std::max(last, ns);
      }
    return {first > last ? 0 : first, last};
  }

  void end_chunk() {
    if (chunk_.empty()) return;
    const auto [first, last] = span_of_chunk();
    std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
    const std::size_t size =
        ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), 3);
    if (ZSTD_isError(size) != 0) throw base::Error(std::string("zstd: ") + ZSTD_getErrorName(size));
    packed.resize(size);
    std::string content;
    put(content, first);
    put(content, last);
    put8(content, chunk_.size());
    put4(content, crc_of(chunk_));
    put_text(content, "zstd");
    put8(content, packed.size());
    content += packed;
    const std::size_t begin = out_.size();
    put_record(out_, kChunk, content);
    const std::size_t end = out_.size();
    std::string places;  // of the message indexes
    for (std::size_t t = 0; t < topics_.size(); ++t) {
      if (indexes_[t].empty()) continue;
      put2(places, t);
      put8(places, out_.size());
      std::string index;
      put2(index, t);
      put_text(index, indexes_[t]);
      put_record(out_, kMessageIndex, index);
    }
    std::string index;
    put(index, first);
    put(index, last);
    put8(index, begin);
    put8(index, end - begin);
    put_text(index, places);
    put8(index, out_.size() - end);
    put_text(index, "zstd");
    put8(index, packed.size());
    put8(index, chunk_.size());
    put_record(chunk_indexes_, kChunkIndex, index);
    ++chunks_;
    begin_chunk();
  }

  void add_metadata(const std::vector<std::string>& columns, const std::string& about) {
    std::string names;
    for (const std::string& column : columns) names += column + '\n';
    std::string entries, content, index;
    for (const auto& [key, text] :
         {std::pair<std::string, std::string>{"about", about}, {"columns", names}}) {
      put_text(entries, key);
      put_text(entries, text);
    }
    put_text(content, "kerbstone");
    put_text(content, entries);
    put8(index, out_.size());
    put_record(out_, kMetadata, content);
    put8(index, content.size() + 9);
    put_text(index, "kerbstone");
    put_record(metadata_index_, kMetadataIndex, index);
  }

  std::string statistics() const {
    std::string content, counts, out;
    put8(content, messages_);
    put2(content, topics_.size());
    put4(content, topics_.size());
    put4(content, 0);  // attachments
    put4(content, 1);  // metadata
    put4(content, chunks_);
    put(content, first_ns_);
    put(content, last_ns_);
    for (const auto& [t, count] : counts_) {
      put2(counts, t);
      put8(counts, count);
    }
    put_text(content, counts);
    put_record(out, kStatistics, content);
    return out;
  }

  void add_summary() {
    const std::size_t begin = out_.size();
    std::string offsets;
    const auto add = [&](Opcode opcode, const std::string& records) {
      std::string content(1, static_cast<char>(opcode));
      put8(content, out_.size());
      put8(content, records.size());
      put_record(offsets, kSummaryOffset, content);
      out_ += records;
    };
    add(kSchema, schemas_of(topics_));
    add(kChannel, channels_of(topics_));
    add(kStatistics, statistics());
    add(kChunkIndex, chunk_indexes_);
    add(kMetadataIndex, metadata_index_);
    const std::size_t offsets_begin = out_.size();
    out_ += offsets;
    out_ += static_cast<char>(kFooter);
    put8(out_, 20);
    put8(out_, begin);
    put8(out_, offsets_begin);
    put4(out_, crc_of(std::string_view(out_).substr(begin)));
  }

  const std::vector<WrittenTopic>& topics_;
  std::vector<std::vector<std::string>> names_;  ///< of the fields, in quotes
  std::vector<std::uint64_t> times_ns_;
  std::string out_, chunk_, message_, chunk_indexes_, metadata_index_;
  std::vector<std::string> indexes_;  ///< of the chunk's messages, by topic
  std::map<std::size_t, std::size_t> counts_;
  std::size_t messages_ = 0, chunks_ = 0;
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
};

}  // namespace

std::string format_mcap(std::span<const double> time_s, const std::vector<WrittenTopic>& topics,
                        const std::vector<std::string>& columns, const std::string& about) {
  return Writer(time_s, topics).write(columns, about);
}

}  // namespace recording
