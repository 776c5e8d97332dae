#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "base/error.h"
#include "base/json_text.h"
#include "recording/log.h"
#include "recording/mcap.h"
#include "support/mcap_file.h"

namespace recording {
namespace write_mcap_test {

/// A reader from the specification, for this test: it goes through every record, and from the
/// footer back through the indexes.
class Parsed {
 public:
  explicit Parsed(const std::string& bytes) : bytes_(bytes) {
    const std::string magic("\x89MCAP0\r\n", 8);
    EXPECT_TRUE(bytes.starts_with(magic));
    EXPECT_TRUE(bytes.ends_with(magic));
    std::size_t at = 8;
    while (at < bytes.size() - 8) {
      order.push_back(static_cast<unsigned char>(bytes[at]));
      starts.push_back(at);
      at += 9 + number<std::uint64_t>(at + 1);
    }
    EXPECT_EQ(at, bytes.size() - 8);
  }
  template <class T>
  T number(std::size_t at) const {
    T value{};
    EXPECT_LE(at + sizeof(T), bytes_.size());
    std::memcpy(&value, bytes_.data() + at, sizeof(T));
    return value;
  }
  std::string text(std::size_t at) const {
    return bytes_.substr(at + 4, number<std::uint32_t>(at));
  }
  std::string content(std::size_t at) const {
    return bytes_.substr(at + 9, number<std::uint64_t>(at + 1));
  }

  std::vector<int> order;
  std::vector<std::size_t> starts;

 private:
  const std::string& bytes_;
};

std::string unpacked_chunk(const Parsed& parsed, std::size_t at) {
  EXPECT_EQ(parsed.text(at + 9 + 28), "zstd");
  const std::size_t size = parsed.number<std::uint64_t>(at + 9 + 16);
  const std::string packed = parsed.content(at).substr(28 + 8 + 8);
  EXPECT_EQ(packed.size(), parsed.number<std::uint64_t>(at + 9 + 28 + 8));
  std::string out(size, '\0');
  EXPECT_EQ(ZSTD_decompress(out.data(), size, packed.data(), packed.size()), size);
  EXPECT_EQ(support::crc_of(out), parsed.number<std::uint32_t>(at + 9 + 24));
  return out;
}

struct Drive {
  std::vector<double> time, a, b, c;
  std::string bytes;
};

Drive drive(std::size_t rows) {
  Drive out;
  for (std::size_t i = 0; i < rows; ++i) {
    const double t = 0.01 * static_cast<double>(i);
    out.time.push_back(t);
    out.a.push_back(std::sin(t) * 1e-3 / 3);
    out.b.push_back(i % 3 == 0 ? std::numeric_limits<double>::quiet_NaN() : 1e300 * t);
    out.c.push_back(-t);
  }
  const std::vector<WrittenTopic> topics{{"/one", {"time_s", "a"}, {out.time.data(), out.a.data()}},
                                         {"/two", {"b", "c \"q\""}, {out.b.data(), out.c.data()}}};
  out.bytes = format_mcap(out.time, topics, {"c \"q\"", "time_s", "b", "a"}, "# made by a test\n");
  return out;
}

TEST(WriteMcap, ReadsBackTheSameBitsNamesAndOrder) {
  const Drive d = drive(20000);
  const Log log = parse_log(d.bytes, "log");
  ASSERT_EQ(log.channels.size(), 4u);
  EXPECT_TRUE(log.in_rows);
  EXPECT_TRUE(log.notes.empty());
  const std::vector<const std::vector<double>*> wanted{&d.c, &d.time, &d.b, &d.a};
  const char* const names[] = {"c \"q\"", "time_s", "b", "a"};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(log.channels[k].name, names[k]);
    ASSERT_EQ(log.channels[k].values.size(), 20000u);
    for (std::size_t i = 0; i < 20000; ++i)
      EXPECT_TRUE(log.channels[k].values[i] == (*wanted[k])[i] ||
                  (std::isnan(log.channels[k].values[i]) && std::isnan((*wanted[k])[i])));
    EXPECT_NEAR(log.channels[k].rate_hz, k == 2 ? 100 * 2 / 3.0 : 100, 0.1);
  }
}

TEST(WriteMcap, HoldsWhatTheSpecificationAsks) {
  const Drive d = drive(20000);
  const Parsed parsed(d.bytes);
  EXPECT_EQ(parsed.order.front(), 1);
  EXPECT_EQ(parsed.order.back(), 2);
  const auto end = std::find(parsed.order.begin(), parsed.order.end(), 15);
  ASSERT_NE(end, parsed.order.end());
  const std::size_t data_end = parsed.starts[static_cast<std::size_t>(end - parsed.order.begin())];
  EXPECT_EQ(parsed.number<std::uint32_t>(data_end + 9),
            support::crc_of(d.bytes.substr(0, data_end)));
  const std::size_t footer = parsed.starts.back();
  const std::size_t summary = parsed.number<std::uint64_t>(footer + 9),
                    offsets = parsed.number<std::uint64_t>(footer + 17);
  EXPECT_EQ(summary, data_end + 13);
  EXPECT_EQ(parsed.number<std::uint32_t>(footer + 25),
            support::crc_of(d.bytes.substr(summary, footer + 25 - summary)));
  EXPECT_EQ(d.bytes[offsets], 14);

  std::map<std::size_t, std::size_t> chunks;  // place, length
  std::size_t messages = 0;
  std::map<int, std::size_t> groups;  // of the summary: opcode, place
  for (std::size_t k = 0; k < parsed.order.size(); ++k) {
    const std::size_t at = parsed.starts[k];
    if (parsed.order[k] == 6) chunks[at] = 9 + parsed.content(at).size();
    if (parsed.order[k] == 14) groups[d.bytes[at + 9]] = parsed.number<std::uint64_t>(at + 10);
  }
  EXPECT_GT(chunks.size(), 1u);
  for (const auto& [opcode, place] : groups) EXPECT_EQ(d.bytes[place], opcode);
  EXPECT_EQ(groups.size(), 5u);

  // From the chunk indexes to every message.
  for (std::size_t k = 0; k < parsed.order.size(); ++k) {
    if (parsed.order[k] != 8) continue;
    const std::size_t at = parsed.starts[k] + 9;
    const auto first = parsed.number<std::uint64_t>(at),
               last = parsed.number<std::uint64_t>(at + 8);
    const std::size_t place = parsed.number<std::uint64_t>(at + 16);
    ASSERT_TRUE(chunks.contains(place));
    EXPECT_EQ(parsed.number<std::uint64_t>(at + 24), chunks[place]);
    const std::string records = unpacked_chunk(parsed, place);
    const std::string indexes = parsed.text(at + 32);
    EXPECT_EQ(indexes.size(), 20u);  // of two channels
    std::size_t indexes_bytes = 0;
    for (std::size_t i = 0; i < indexes.size(); i += 10) {
      std::uint64_t index_at = 0;
      std::memcpy(&index_at, indexes.data() + i + 2, 8);
      EXPECT_EQ(d.bytes[index_at], 7);
      indexes_bytes += 9 + parsed.content(index_at).size();
      const std::string entries = parsed.text(index_at + 11);
      for (std::size_t e = 0; e < entries.size(); e += 16) {
        std::uint64_t ns = 0, offset = 0, logged = 0;
        std::memcpy(&ns, entries.data() + e, 8);
        std::memcpy(&offset, entries.data() + e + 8, 8);
        ASSERT_LT(offset, records.size());
        EXPECT_EQ(records[offset], 5);
        std::memcpy(&logged, records.data() + offset + 9 + 6, 8);
        EXPECT_EQ(logged, ns);
        EXPECT_GE(ns, first);
        EXPECT_LE(ns, last);
        ++messages;
      }
    }
    EXPECT_EQ(parsed.number<std::uint64_t>(at + 32 + 4 + 20), indexes_bytes);
  }
  EXPECT_EQ(messages, 40000u);
  const std::size_t statistics = groups[11] + 9;
  EXPECT_EQ(parsed.number<std::uint64_t>(statistics), 40000u);
  EXPECT_EQ(parsed.number<std::uint16_t>(statistics + 8), 2);
  EXPECT_EQ(parsed.number<std::uint32_t>(statistics + 22), chunks.size());
  EXPECT_EQ(parsed.number<std::uint64_t>(statistics + 34), 199990000000ull);
}

TEST(WriteMcap, EveryMessageFitsItsSchema) {
  const Drive d = drive(10);
  const Parsed parsed(d.bytes);
  const std::string records = unpacked_chunk(parsed, parsed.starts[1]);
  std::map<int, std::set<std::string>> properties;
  for (std::size_t at = 0; at < records.size();) {
    std::uint64_t length = 0;
    std::uint16_t id = 0;
    std::memcpy(&length, records.data() + at + 1, 8);
    std::memcpy(&id, records.data() + at + 9, 2);
    const std::string content = records.substr(at + 9, length);
    if (records[at] == 3) {
      const nlohmann::json schema =
          base::parse_json<nlohmann::json>(content.substr(content.find('{')));
      EXPECT_EQ(schema["type"], "object");
      for (const auto& [name, type] : schema["properties"].items()) {
        EXPECT_EQ(type["type"], "number");
        properties[id].insert(name);
      }
    }
    if (records[at] == 5)
      for (const nlohmann::json message = base::parse_json<nlohmann::json>(content.substr(22));
           const auto& [name, value] : message.items()) {
        EXPECT_TRUE(value.is_number());
        EXPECT_TRUE(properties[id + 1].contains(name)) << name;
      }
    at += 9 + length;
  }
  EXPECT_EQ(properties.size(), 2u);
}

TEST(WriteMcap, MomentsBelowZeroBeginAtTheEarliest) {
  const std::vector<double> time{-1.5, -1.0, std::nan(""), 0.5};
  const std::string bytes = format_mcap(time, {{"/t", {"time_s"}, {time.data()}}}, {"time_s"}, "");
  const Log log = parse_log(bytes, "log");
  EXPECT_EQ(log.channels[0].values.size(), 4u);
  EXPECT_EQ(log.channels[0].values[0], -1.5);
  EXPECT_THROW(
      (void)format_mcap(std::vector<double>{1e11}, {{"/t", {"time_s"}, {time.data()}}}, {}, ""),
      base::Error);
}

TEST(WriteMcap, ADriveWithoutRowsIsAFileToo) {
  const std::vector<double> none;
  const std::string bytes = format_mcap(none, {{"/t", {"time_s"}, {none.data()}}}, {"time_s"}, "");
  const Parsed parsed(bytes);
  EXPECT_EQ(parsed.order.back(), 2);
}

}  // namespace write_mcap_test
}  // namespace recording
