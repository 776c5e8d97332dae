// MoTeC's .ld, little-endian: a header that points to a chain of channel descriptions of 84 bytes
// and more, each with its place among the samples, its type, rate and the way to its unit.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "readers.h"

namespace recording {
namespace {

constexpr std::size_t kDescriptionBytes = 84;  // up to the end of the unit

struct ChannelDescription {
  std::uint32_t next, data, samples;
  std::uint16_t kind, bytes, rate_hz;
  std::int16_t shift, factor, divisor, decimals;
};

ChannelDescription description_at(std::string_view bytes, std::size_t at) {
  return {little<std::uint32_t>(bytes, at + 4),  little<std::uint32_t>(bytes, at + 8),
          little<std::uint32_t>(bytes, at + 12), little<std::uint16_t>(bytes, at + 18),
          little<std::uint16_t>(bytes, at + 20), little<std::uint16_t>(bytes, at + 22),
          little<std::int16_t>(bytes, at + 24),  little<std::int16_t>(bytes, at + 26),
          little<std::int16_t>(bytes, at + 28),  little<std::int16_t>(bytes, at + 30)};
}

double half(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const double fraction = bits & 1023;
  double value = std::ldexp(exponent == 0 ? fraction : fraction + 1024, std::max(exponent, 1) - 25);
  if (exponent == 31) value = std::nan("");
  return (bits & 0x8000) != 0 ? -value : value;
}

double sample(std::string_view bytes, std::size_t at, bool floating, std::size_t width) {
  if (floating && width == 2) return half(little<std::uint16_t>(bytes, at));
  if (floating && width == 4) return static_cast<double>(little<float>(bytes, at));
  if (floating) return little<double>(bytes, at);
  if (width == 2) return little<std::int16_t>(bytes, at);
  return little<std::int32_t>(bytes, at);
}

bool is_floating(const ChannelDescription& d) { return d.kind == 7 || d.kind == 8; }

/// Whether samples are integers of 2 or 4 bytes, or floats of 2, 4 or 8.
bool is_known(const ChannelDescription& d) {
  return is_floating(d) ? d.bytes == 2 || d.bytes == 4 || d.bytes == 8
                        : d.kind <= 6 && (d.bytes == 2 || d.bytes == 4);
}

Channel channel_at(std::string_view bytes, std::size_t at, const ChannelDescription& d,
                   const std::string& name) {
  Channel out;
  out.name = field(bytes, at + 32, 32);
  out.unit = field(bytes, at + 72, 12);
  if (d.rate_hz == 0 || d.divisor == 0)
    throw base::Error(
        fmt::format("{}: channel '{}' has {} Hz and divisor {}, wanted others than 0; "
                    "the file is damaged",
                    name, out.name, d.rate_hz, d.divisor));
  if (d.data > bytes.size() || d.samples > (bytes.size() - d.data) / d.bytes)
    throw base::Error(
        fmt::format("{}: channel '{}' has {} samples from byte {} on, the file ends "
                    "at {}; the file was cut off",
                    name, out.name, d.samples, d.data, bytes.size()));
  out.rate_hz = d.rate_hz;
  const double scale = std::pow(10.0, -d.decimals) / d.divisor;
  out.values.reserve(d.samples);
  for (std::size_t k = 0; k < d.samples; ++k) {
    const double raw = sample(bytes, d.data + k * d.bytes, is_floating(d), d.bytes);
    const double value = (raw * scale + d.shift) * d.factor;
    out.values.push_back(std::isfinite(value) ? value : std::nan(""));
  }
  return out;
}

}  // namespace

bool is_motec_ld(std::string_view bytes) {
  return bytes.size() >= 16 && little<std::uint32_t>(bytes, 0) == 0x40 &&
         little<std::uint32_t>(bytes, 4) == 0;
}

Log parse_motec_ld(std::string_view bytes, const std::string& name) {
  Log log{"MoTeC .ld", {}, false};
  std::size_t at = little<std::uint32_t>(bytes, 8), cells = 0;
  // A chain that comes back to itself has more members than the file has room for.
  const std::size_t most = bytes.size() / kDescriptionBytes;
  for (std::size_t seen = 0; at != 0; ++seen) {
    if (seen == most)
      throw base::Error(name +
                        ": the list of channels goes round in a circle; the file is damaged");
    if (bytes.size() < kDescriptionBytes || at > bytes.size() - kDescriptionBytes)
      throw base::Error(
          fmt::format("{}: a channel is described at byte {}, the file ends at {}; "
                      "the file was cut off",
                      name, at, bytes.size()));
    const ChannelDescription d = description_at(bytes, at);
    cells += d.samples;
    if (cells > kMostCells)
      throw base::Error(name + ": more than 2 GB of samples; cut the log or the file is damaged");
    if (d.samples > 0 && !is_known(d))
      log.notes.push_back(
          fmt::format("channel '{}' is left out: samples of type {} with {} bytes are not read",
                      field(bytes, at + 32, 32), d.kind, d.bytes));
    else if (d.samples > 0)
      log.channels.push_back(channel_at(bytes, at, d, name));
    at = d.next;
  }
  if (log.channels.empty())
    throw base::Error(
        fmt::format("{}: a MoTeC log without samples that can be read{}; export it as CSV", name,
                    log.notes.empty() ? "" : ": " + log.notes.front()));
  number_names(log.channels);
  return log;
}

}  // namespace recording
