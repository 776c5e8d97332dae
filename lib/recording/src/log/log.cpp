#include "recording/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <set>

#include "base/error.h"
#include "base/read_file.h"
#include "base/stand_in.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "base/utf8.h"
#include "laps.h"
#include "readers.h"
#include "unpack.h"

namespace recording {
namespace {

constexpr std::size_t kLargestLdxBytes = std::size_t{1} << 24;

/// The samples of `channel` in `rows` rows of `step_s`.
std::vector<double> spread(const Channel& channel, std::size_t rows, double step_s) {
  std::vector<double> out(rows, std::numeric_limits<double>::quiet_NaN());
  const std::vector<double>& x = channel.values;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double row = std::round(static_cast<double>(k) / channel.rate_hz / step_s);
    if (!(row < static_cast<double>(rows))) break;
    // Where the row lies beside the sample, in samples.
    const double beside = row * step_s * channel.rate_hz - static_cast<double>(k);
    double value = x[k];
    if (beside > 1e-9 && k + 1 < x.size()) value += beside * (x[k + 1] - x[k]);
    if (beside < -1e-9 && k > 0) value -= beside * (x[k - 1] - x[k]);
    out[static_cast<std::size_t>(row)] = value;
  }
  return out;
}

/// Text in UTF-16 behind its mark of byte order, as Windows writes it, in UTF-8. Halves of pairs
/// that stand alone become the character for what is unknown.
std::string from_utf16(std::string_view bytes) {
  const std::size_t low = bytes.starts_with("\xFF\xFE") ? 0 : 1;
  const auto unit = [&](std::size_t at) -> std::uint32_t {
    return at + 1 < bytes.size() ? static_cast<unsigned char>(bytes[at + low]) |
                                       static_cast<unsigned char>(bytes[at + 1 - low]) << 8
                                 : 0;
  };
  std::string out;
  out.reserve(bytes.size() / 2);
  for (std::size_t at = 2; at + 1 < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >> 11 == 0x1B) {  // half of a pair
      const std::uint32_t second = unit(at + 2);
      const bool pair = code < 0xDC00 && second >> 10 == 0x37;
      code = pair ? 0x10000 + ((code - 0xD800) << 10) + (second - 0xDC00) : 0xFFFD;
      at += pair ? 2 : 0;
    }
    const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    constexpr std::uint32_t kFirst[] = {0, 0xC0, 0xE0, 0xF0};
    out += static_cast<char>(kFirst[more] | code >> (6 * more));
    for (int k = more - 1; k >= 0; --k) out += static_cast<char>(0x80 | (code >> (6 * k) & 0x3F));
  }
  return out;
}

/// Whether zeros do no more than fill the cells of a text, as receivers with columns of fixed width
/// write them: behind each stands another, or the end of a cell.
bool fills_cells_with_zeros(std::string_view text) {
  std::size_t zeros = 0;
  for (std::size_t k = text.find('\0'); k != text.npos; k = text.find('\0', k + 1), ++zeros)
    if (k + 1 < text.size() && std::string_view("\0,;\t\r\n", 6).find(text[k + 1]) == text.npos)
      return false;
  return zeros > 0 && 2 * zeros < text.size();
}

Log parse_plain(std::string_view bytes, const std::string& name) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"))
    return parse_plain(from_utf16(bytes), name);
  if (is_motec_ld(bytes)) return parse_motec_ld(bytes, name);
  if (is_iracing_ibt(bytes)) return parse_iracing_ibt(bytes, name);
  if (is_mcap(bytes)) return parse_mcap(bytes, name);
  if (is_rosbag2(bytes)) return parse_rosbag2(bytes, name);
  if (is_racelogic_vbo(bytes)) return parse_racelogic_vbo(bytes, name);
  refuse_what_is_not_read(bytes, name);
  base::want_no_web_page(bytes, name);
  bytes = base::behind_byte_order_mark(bytes, name);
  if (fills_cells_with_zeros(bytes)) {
    std::string text(bytes);
    std::replace(text.begin(), text.end(), '\0', ' ');
    return parse_plain(text, name);
  }
  if (bytes.substr(0, 4096).find('\0') != std::string_view::npos)
    throw base::Error(fmt::format(
        "{}: binary, and none of MoTeC .ld, iRacing .ibt, MCAP, rosbag2; export it as CSV", name));
  if (is_haltech_csv(bytes)) return parse_haltech_csv(bytes, name);
  const std::string by_commas = blanks_to_commas(bytes);
  Log log = parse_csv(by_commas.empty() ? bytes : by_commas, name);
  if (std::all_of(log.channels.begin(), log.channels.end(), [](const Channel& channel) {
        return channel.words > 0 && channel.words == channel.values.size();
      }))
    throw base::Error(
        fmt::format("{}: words and no number in any column, so it is no log; a line of names and "
                    "rows of numbers are wanted, between commas, semicolons, tabs or blanks",
                    name));
  return log;
}

}  // namespace

std::string field(std::string_view bytes, std::size_t at, std::size_t length) {
  std::string_view text = bytes.substr(at, length);
  text = text.substr(0, text.find('\0'));
  return std::string(base::trimmed(text));
}

void number_names(std::vector<Channel>& channels) {
  std::set<std::string> seen;
  for (const Channel& channel : channels) seen.insert(channel.name);
  std::map<std::string, int> count;
  for (Channel& channel : channels) {
    const std::string name = channel.name.empty() ? "unnamed" : channel.name;
    int& number = count[name];
    if (++number == 1 && !channel.name.empty()) continue;
    do channel.name = fmt::format("{} #{}", name, number);
    while (!seen.insert(channel.name).second && ++number > 0);
  }
}

void set_rates(Log& log, const std::vector<double>& time_s) {
  std::vector<double> steps;  // the median: clocks have gaps and jumps
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (time_s[i] > time_s[i - 1]) steps.push_back(time_s[i] - time_s[i - 1]);
  if (steps.empty()) return;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  for (Channel& channel : log.channels) {
    const auto measured = std::count_if(channel.values.begin(), channel.values.end(),
                                        [](double v) { return std::isfinite(v); });
    channel.rate_hz =
        static_cast<double>(measured) / static_cast<double>(channel.values.size()) / *middle;
  }
}

std::string unpacked_file(std::string_view bytes, const std::string& name) {
  try {
    return unpack_zstd(bytes, std::min(most_unpacked(bytes.size()), kLargestFileBytes));
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", name, error.what()));
  }
}

Log parse_log(std::string_view bytes, const std::string& name) {
  Log log =
      is_zstd(bytes) ? parse_plain(unpacked_file(bytes, name), name) : parse_plain(bytes, name);
  for (Channel& channel : log.channels) {
    channel.name = base::in_utf8(channel.name);
    channel.unit = base::in_utf8(channel.unit);
  }
  for (std::string& note : log.notes) note = base::in_utf8(note);
  return log;
}

Log read_log(const std::string& path) {
  if (std::filesystem::is_directory(path)) return read_bag_folder(path);
  Log log = parse_log(base::read_file(path, kLargestFileBytes), path);
  if (log.format == "MoTeC .ld")
    for (const char* ending : {".ldx", ".LDX"}) {
      const auto beside = std::filesystem::path(path).replace_extension(ending);
      if (!std::filesystem::is_regular_file(beside)) continue;
      if (std::filesystem::file_size(beside) > kLargestLdxBytes)
        log.notes.push_back(beside.string() + ": more than 16 MiB: read without laps");
      else
        add_laps_of_ldx(log, base::read_file(beside, kLargestLdxBytes), beside.string());
      break;
    }
  return log;
}

namespace {

void want_cells(std::size_t rows, std::size_t channels, const std::string& name) {
  if (rows > kMostCells / (channels + 1))
    throw base::Error(fmt::format("{}: {} rows of {} channels, more than 2 GB; cut the log", name,
                                  rows, channels));
}

/// A channel of the clock `from` in rows of the clock `to`: every sample in the nearest row, no
/// further than a step of that clock away, brought there by the straight line to its neighbour
/// (but for an angle that jumps by a turn).
std::vector<double> spread(const Channel& channel, const std::vector<double>& from,
                           const std::vector<double>& to, double step_s) {
  const std::vector<double>& values = channel.values;
  const double most = channel.unit == "rad" ? 3.0 : std::numeric_limits<double>::infinity();
  std::vector<double> out(to.size(), std::numeric_limits<double>::quiet_NaN());
  std::size_t row = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isnan(values[k])) continue;
    while (row + 1 < to.size() && std::abs(to[row + 1] - from[k]) <= std::abs(to[row] - from[k]))
      ++row;
    const double beside = to[row] - from[k];
    if (!(std::abs(beside) <= step_s)) continue;
    const std::size_t other = beside > 0 ? std::min(k + 1, values.size() - 1) : k - (k > 0 ? 1 : 0);
    const double run = from[other] - from[k];
    double value = values[k];
    if (std::abs(run) >= std::abs(beside) && run != 0 && std::abs(values[other] - value) <= most)
      value += beside / run * (values[other] - value);
    out[row] = value;
  }
  return out;
}

Log in_rows_of_clock(Log log, const std::string& name) {
  const auto most =
      std::max_element(log.clocks.begin(), log.clocks.end(),
                       [](const auto& a, const auto& b) { return a.size() < b.size(); });
  const std::vector<double> clock = *most;
  want_cells(clock.size(), log.channels.size(), name);
  std::vector<double> steps;
  for (std::size_t i = 1; i < clock.size(); ++i) steps.push_back(clock[i] - clock[i - 1]);
  std::sort(steps.begin(), steps.end());
  const double step_s = steps.empty() ? 0.0 : steps[steps.size() / 2];
  Log out{log.format, {}, true, {}, std::move(log.notes)};
  out.channels.push_back({"log time", "s", step_s > 0 ? 1.0 / step_s : 0.0, clock, 0});
  for (Channel& channel : log.channels) {
    const std::vector<double>& own = log.clocks[channel.clock];
    if (own != clock) channel.values = spread(channel, own, clock, step_s);
    channel.clock = 0;
    out.channels.push_back(std::move(channel));
  }
  number_names(out.channels);
  return out;
}

}  // namespace

Log in_rows(Log log, const std::string& name) {
  if (!log.in_rows && !log.clocks.empty()) return in_rows_of_clock(std::move(log), name);
  if (log.in_rows) return log;
  // The one with most samples: a short one with a high rate would ask for rows without end.
  const auto fastest = std::max_element(
      log.channels.begin(), log.channels.end(),
      [](const Channel& a, const Channel& b) { return a.values.size() < b.values.size(); });
  if (fastest == log.channels.end() || !(fastest->rate_hz > 0))
    throw base::Error(name + ": no channel with samples");
  const std::size_t rows = fastest->values.size();
  const double rate_hz = fastest->rate_hz;
  want_cells(rows, log.channels.size(), name);
  Log out{log.format, {}, true};
  Channel clock{"log time", "s", rate_hz, {}, 0};
  for (std::size_t i = 0; i < rows; ++i) clock.values.push_back(static_cast<double>(i) / rate_hz);
  out.channels.push_back(std::move(clock));
  for (Channel& channel : log.channels) {
    if (channel.values.size() != rows || channel.rate_hz != rate_hz)
      channel.values = spread(channel, rows, 1.0 / rate_hz);
    out.channels.push_back(std::move(channel));
  }
  number_names(out.channels);
  return out;
}

}  // namespace recording
