// iRacing's .ibt, little-endian: a header of 112 bytes, one of 32 about the disk file, descriptions
// of 144 bytes for every variable, then records of equal length.
#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "readers.h"

namespace recording {
namespace {

constexpr std::size_t kHeaderBytes = 144, kVariableBytes = 144;

struct Variable {
  int type;
  std::size_t offset, count;
};

constexpr std::size_t kTypeBytes[] = {1, 1, 4, 4, 4, 8};

double value_at(std::string_view bytes, std::size_t at, int type) {
  switch (type) {
    case 0:
    case 1:
      return static_cast<unsigned char>(bytes[at]);
    case 2:
      return little<std::int32_t>(bytes, at);
    case 3:
      return little<std::uint32_t>(bytes, at);
    case 4:
      return static_cast<double>(little<float>(bytes, at));
    default:
      return little<double>(bytes, at);
  }
}

/// A count or place of the header; they are signed in the file.
std::size_t whole_at(std::string_view bytes, std::size_t at, const char* what,
                     const std::string& name) {
  const auto value = little<std::int32_t>(bytes, at);
  if (value < 0)
    throw base::Error(
        fmt::format("{}: {} is {}, wanted 0 or more; the file is damaged", name, what, value));
  return static_cast<std::size_t>(value);
}

Variable variable_at(std::string_view bytes, std::size_t at, std::size_t record_bytes,
                     const std::string& name) {
  const int type = little<std::int32_t>(bytes, at);
  const std::string word = field(bytes, at + 16, 32);
  if (type < 0 || type > 5)
    throw base::Error(
        fmt::format("{}: variable '{}' is of type {}, wanted 0 to 5; the file is "
                    "damaged or newer than this reader",
                    name, word, type));
  const Variable out{type, whole_at(bytes, at + 4, "a variable's place", name),
                     whole_at(bytes, at + 8, "a variable's count", name)};
  if (out.offset > record_bytes ||
      out.count > (record_bytes - out.offset) / kTypeBytes[static_cast<std::size_t>(type)])
    throw base::Error(
        fmt::format("{}: variable '{}' ends beyond its record of {} bytes; the file "
                    "is damaged",
                    name, word, record_bytes));
  return out;
}

}  // namespace

bool is_iracing_ibt(std::string_view bytes) {
  if (bytes.size() < 40) return false;
  const auto version = little<std::int32_t>(bytes, 0), status = little<std::int32_t>(bytes, 4),
             rate = little<std::int32_t>(bytes, 8), buffers = little<std::int32_t>(bytes, 32);
  return version >= 1 && version <= 3 && status >= 0 && status <= 255 && rate > 0 &&
         rate <= 10000 && buffers >= 1 && buffers <= 4;
}

Log parse_iracing_ibt(std::string_view bytes, const std::string& name) {
  if (bytes.size() < kHeaderBytes)
    throw base::Error(
        fmt::format("{}: {} bytes, an iRacing log begins with {}; the file was cut "
                    "off",
                    name, bytes.size(), kHeaderBytes));
  if (const auto buffers = little<std::int32_t>(bytes, 32); buffers > 1)
    throw base::Error(fmt::format(
        "{}: an image of the simulator's live memory, with {} buffers of one moment each, no "
        "recording; record with its telemetry logging, which writes .ibt files",
        name, buffers));
  const std::size_t variables = whole_at(bytes, 24, "the number of variables", name),
                    first = whole_at(bytes, 28, "the place of the variables", name),
                    record_bytes = whole_at(bytes, 36, "the length of a record", name),
                    data = whole_at(bytes, 52, "the place of the records", name);
  if (first > bytes.size() || variables > (bytes.size() - first) / kVariableBytes)
    throw base::Error(
        fmt::format("{}: {} variables described from byte {} on, the file ends at {}; "
                    "the file is damaged",
                    name, variables, first, bytes.size()));
  if (record_bytes == 0 || data > bytes.size() || bytes.size() - data < record_bytes)
    throw base::Error(
        fmt::format("{}: no whole record: one has {} bytes, they begin at byte {}, "
                    "the file ends at {}; nothing was recorded or it was cut off",
                    name, record_bytes, data, bytes.size()));
  // The header's count is not written where the simulator ended by force.
  const std::size_t records = (bytes.size() - data) / record_bytes;
  const double rate_hz = little<std::int32_t>(bytes, 8);

  Log log{"iRacing .ibt", {}, true};
  std::size_t cells = 0, used_bytes = 0;
  for (std::size_t k = 0; k < variables; ++k) {
    const std::size_t at = first + k * kVariableBytes;
    const Variable v = variable_at(bytes, at, record_bytes, name);
    used_bytes += v.count * kTypeBytes[static_cast<std::size_t>(v.type)];
    if (used_bytes > record_bytes)  // each may lie in the record, but not all beside each other
      throw base::Error(
          fmt::format("{}: the first {} of {} variables have {} bytes, but a record has {}; the "
                      "file is damaged",
                      name, k + 1, variables, used_bytes, record_bytes));
    cells += v.count * records;
    if (cells > kMostCells)
      throw base::Error(name + ": more than 2 GB of samples; cut the log or the file is damaged");
    const std::string word = field(bytes, at + 16, 32);
    for (std::size_t i = 0; i < v.count; ++i) {
      Channel channel;
      channel.name = v.count == 1 ? word : fmt::format("{}.{}", word, i);
      channel.unit = field(bytes, at + 112, 32);
      channel.rate_hz = rate_hz;
      const std::size_t place = data + v.offset + i * kTypeBytes[static_cast<std::size_t>(v.type)];
      channel.values.reserve(records);
      for (std::size_t r = 0; r < records; ++r) {
        const double value = value_at(bytes, place + r * record_bytes, v.type);
        channel.values.push_back(std::isfinite(value) ? value : std::nan(""));
      }
      log.channels.push_back(std::move(channel));
    }
  }
  if (log.channels.empty()) throw base::Error(name + ": an iRacing log without variables");
  number_names(log.channels);
  return log;
}

}  // namespace recording
