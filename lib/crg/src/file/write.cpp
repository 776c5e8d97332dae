#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>

#include "crg/error.h"
#include "crg/file.h"
#include "round_channels.h"
#include "text.h"

namespace crg {
namespace {

constexpr std::size_t kMaxColumns = 72;  // of a header line
constexpr std::string_view kClosing =
    "$!******10********20********30********40********50********60********70*\n";

// Free text as header lines: newlines end a line, long lines are broken between words, and no line
// can be taken for the start of a section.
void append_free_text(std::string& out, std::string_view text, std::string_view prefix) {
  while (true) {
    const std::size_t newline = text.find('\n');
    std::string_view line = text.substr(0, newline);
    do {
      std::size_t length = std::min(line.size(), kMaxColumns - prefix.size() - 1);
      if (length < line.size()) {
        const std::size_t blank = line.rfind(' ', length);
        if (blank != std::string_view::npos && blank > 0) length = blank;
      }
      out += prefix;
      if (prefix.empty() && line.starts_with('$')) out += ' ';
      out += line.substr(0, length);
      out += '\n';
      line.remove_prefix(length);
      if (line.starts_with(' ')) line.remove_prefix(1);
    } while (!line.empty());
    if (newline == std::string_view::npos) return;
    text.remove_prefix(newline + 1);
  }
}

void append_entries(std::string& out, std::string_view section,
                    const std::vector<HeaderEntry>& entries) {
  out += section;
  out += '\n';
  for (const HeaderEntry& entry : entries) {
    if (entry.key == "*") {
      append_free_text(out, entry.text, "*");
      continue;
    }
    // In the first column these would end the section or start a comment.
    std::string line =
        entry.key.starts_with('$') || entry.key.starts_with('*') ? " " + entry.key : entry.key;
    line.resize(std::max<std::size_t>(line.size(), 24), ' ');
    line += " = " + (entry.text.empty() ? shortest(entry.value) : entry.text);
    if (!entry.comment.empty()) {
      if (line.size() + 3 + entry.comment.size() <= kMaxColumns) {
        line += " ! " + entry.comment;
      } else {
        append_free_text(out, entry.comment, "* ");
      }
    }
    out += line + '\n';
  }
  out += kClosing;
}

bool regular(const std::vector<double>& v_m, double step) {
  for (std::size_t j = 0; j < v_m.size(); ++j) {
    if (std::abs(v_m.front() + static_cast<double>(j) * step - v_m[j]) >
        1e-12 * std::max(1.0, std::abs(v_m[j]))) {
      return false;
    }
  }
  return true;
}

// A column of the payload: a channel of doubles, or column `height` of the grid.
struct Source {
  const std::vector<double>* channel = nullptr;
  std::size_t height = 0;
};

struct Payload {
  const Crg& crg;
  std::vector<Source> sources;
  bool doubles = false;  // take z_double_m

  double value(std::size_t row, const Source& source) const {
    if (source.channel != nullptr) return (*source.channel)[row];
    const std::size_t at = row * crg.grid.columns() + source.height;
    return doubles ? crg.z_double_m[at] : static_cast<double>(crg.grid.z_m[at]);
  }
};

void append_definitions(std::string& out, const Crg& crg, Format format, bool numbered,
                        Payload& payload) {
  constexpr const char* kNames[] = {"KRBI", "KDBI", "LRFI", "LDFI"};
  out += "$KD_DEFINITION\n#:";
  out += kNames[static_cast<int>(format)];
  out += '\n';
  for (const std::string& text : crg.virtual_channels) out += "U:" + text + '\n';
  const auto add = [&](const std::vector<double>& channel, const std::string& definition) {
    if (channel.empty()) return;
    out += "D:" + definition + '\n';
    payload.sources.push_back({&channel, 0});
  };
  add(crg.u_m, "reference line u,m");
  add(crg.x_m, "reference line x,m");
  add(crg.y_m, "reference line y,m");
  add(crg.heading_rad, "reference line phi,rad");
  add(crg.slope, "reference line slope,m/m");
  add(crg.banking, "reference line banking,m/m");
  for (const Channel& channel : crg.other_channels) add(channel.values, channel.definition);
  for (std::size_t j = 0; j < crg.grid.columns(); ++j) {
    out += numbered ? "D:long section " + std::to_string(j + 1) + ",m\n"
                    : "D:long section at v = " + shortest(crg.grid.v_m[j]) + ",m\n";
    payload.sources.push_back({nullptr, j});
  }
  out += kClosing;
}

template <typename Word>
void append_big_endian(std::string& out, Word word) {
  char bytes[sizeof word];
  for (std::size_t k = 0; k < sizeof word; ++k) {
    bytes[k] = static_cast<char>(word >> (8 * (sizeof word - 1 - k)) & 0xff);
  }
  out.append(bytes, sizeof word);
}

void append_binary(std::string& out, const Payload& payload, bool wide) {
  const std::size_t start = out.size();
  const auto append = [&](double value) {
    if (wide) {
      append_big_endian(out, std::bit_cast<std::uint64_t>(value));
    } else {
      append_big_endian(out, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
    }
  };
  for (std::size_t row = 0; row < payload.crg.grid.rows(); ++row) {
    for (const Source& source : payload.sources) append(payload.value(row, source));
  }
  while ((out.size() - start) % 80 != 0) append(std::numeric_limits<double>::quiet_NaN());
}

// The decimal with the most digits that fits `width` characters.
std::string fixed_width(double value, std::size_t width, bool wide) {
  if (std::isnan(value)) return std::string(width - 9, ' ') + "*missing*";
  char buffer[64];
  std::to_chars_result end =
      wide ? std::to_chars(buffer, buffer + sizeof buffer, value)
           : std::to_chars(buffer, buffer + sizeof buffer, static_cast<float>(value));
  for (int digits = 17; static_cast<std::size_t>(end.ptr - buffer) > width && digits > 0;
       --digits) {
    end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
  }
  const std::string text(buffer, end.ptr);
  return std::string(width - text.size(), ' ') + text;
}

void append_text(std::string& out, const Payload& payload, bool wide) {
  const std::size_t width = wide ? 20 : 10;
  const std::size_t per_record = 80 / width;
  for (std::size_t row = 0; row < payload.crg.grid.rows(); ++row) {
    for (std::size_t c = 0; c < payload.sources.size(); ++c) {
      out += fixed_width(payload.value(row, payload.sources[c]), width, wide);
      if ((c + 1) % per_record == 0 || c + 1 == payload.sources.size()) out += '\n';
    }
  }
}

// Where the format holds fewer digits than the headings have, headings whose integral stays on the
// same line.
void round_to_format(Crg& crg, Format format) {
  if (crg.heading_rad.empty() || !crg.x_m.empty() || format == Format::KDBI ||
      format == Format::LDFI)
    return;
  const auto round = [&](double value) {
    if (format == Format::KRBI) return static_cast<double>(static_cast<float>(value));
    return parse_number(fixed_width(value, 10, false)).value_or(value);
  };
  const bool exact = std::all_of(crg.heading_rad.begin() + 1, crg.heading_rad.end(),
                                 [&](double heading) { return round(heading) == heading; });
  if (!exact) {
    const ReferenceLine line = integrate_reference_line(crg);
    RoundedLine rounded = round_headings(line, round);
    rounded.heading_rad[0] = crg.heading_rad[0];
    crg.heading_rad = std::move(rounded.heading_rad);
  }
  if (!crg.slope.empty()) {
    const bool exact_slope = std::all_of(crg.slope.begin() + 1, crg.slope.end(),
                                         [&](double slope) { return round(slope) == slope; });
    if (!exact_slope) {
      const ReferenceLine line = integrate_reference_line(crg);
      double end = 0.0;
      std::vector<double> slope = round_slopes(line.z_m, line.u_step_m, round, end);
      slope[0] = crg.slope[0];
      crg.slope = std::move(slope);
    }
  }
}

void want_writable(const Crg& crg) {
  const std::size_t rows = crg.grid.rows();
  if (rows < 2 || crg.grid.columns() < 2 || crg.grid.z_m.size() != rows * crg.grid.columns()) {
    throw Error("write: a grid of " + std::to_string(rows) + " x " +
                std::to_string(crg.grid.columns()) + " with " +
                std::to_string(crg.grid.z_m.size()) + " values: want at least 2 x 2, all filled");
  }
  const auto want_rows = [&](const std::vector<double>& channel, const char* name,
                             std::size_t wanted) {
    if (!channel.empty() && channel.size() != wanted) {
      throw Error(std::string("write: ") + name + " has " + std::to_string(channel.size()) +
                  " values: want none or " + std::to_string(wanted));
    }
  };
  want_rows(crg.heading_rad, "heading_rad", rows);
  want_rows(crg.slope, "slope", rows);
  want_rows(crg.banking, "banking", rows);
  want_rows(crg.x_m, "x_m", rows);
  want_rows(crg.y_m, "y_m", rows);
  want_rows(crg.u_m, "u_m", rows);
  want_rows(crg.z_double_m, "z_double_m", crg.grid.z_m.size());
  for (const Channel& channel : crg.other_channels)
    want_rows(channel.values, channel.definition.c_str(), rows);
}

}  // namespace

std::string to_bytes(const Crg& given, Format format) {
  want_writable(given);
  // Only what may need rounding is copied, never the grid.
  Crg head;
  head.road = given.road;
  head.options = given.options;
  head.heading_rad = given.heading_rad;
  head.slope = given.slope;
  head.x_m = given.x_m;
  head.y_m = given.y_m;
  head.grid.u_begin_m = given.grid.u_begin_m;
  head.grid.u_step_m = given.grid.u_step_m;
  head.grid.v_m = {0.0};
  head.grid.z_m.resize(given.grid.rows());
  round_to_format(head, format);

  const Grid& grid = given.grid;
  std::vector<HeaderEntry> road = std::move(head.road);
  const double step =
      (grid.v_m.back() - grid.v_m.front()) / static_cast<double>(grid.columns() - 1);
  const double given_step = find_value(road, "LONG_SECTION_V_INCREMENT").value_or(step);
  const bool numbered_as_given = regular(grid.v_m, given_step);
  const bool numbered = numbered_as_given || regular(grid.v_m, step);
  set_value(road, "REFERENCE_LINE_START_U", grid.u_begin_m);
  set_value(road, "REFERENCE_LINE_END_U", grid.u_of(grid.rows() - 1));
  set_value(road, "REFERENCE_LINE_INCREMENT", grid.u_step_m);
  set_value(road, "LONG_SECTION_V_RIGHT", grid.v_m.front());
  set_value(road, "LONG_SECTION_V_LEFT", grid.v_m.back());
  if (numbered) {
    set_value(road, "LONG_SECTION_V_INCREMENT", numbered_as_given ? given_step : step);
  } else {
    erase_key(road, "LONG_SECTION_V_INCREMENT");
  }

  std::string out = "$CT\n";
  for (const std::string& line : given.comment) append_free_text(out, line, "");
  out += kClosing;
  append_entries(out, "$ROAD_CRG", road);
  if (given.has_option_section || !given.options.empty())
    append_entries(out, "$ROAD_CRG_OPTS", given.options);
  if (given.has_modifier_section || !given.modifiers.empty())
    append_entries(out, "$ROAD_CRG_MODS", given.modifiers);
  if (!given.projection.empty()) append_entries(out, "$ROAD_CRG_MPRO", given.projection);
  for (const Section& section : given.other_sections) {
    out += section.name + '\n';
    for (const std::string& line : section.lines) out += line + '\n';
    out += kClosing;
  }
  const bool wide = format == Format::KDBI || format == Format::LDFI;
  Payload payload{given, {}, wide && !given.z_double_m.empty()};
  append_definitions(out, given, format, numbered, payload);
  for (Source& source : payload.sources) {
    if (source.channel == &given.heading_rad) source.channel = &head.heading_rad;
    if (source.channel == &given.slope) source.channel = &head.slope;
  }
  out += "$$$$$$$$10$$$$$$$$20$$$$$$$$30$$$$$$$$40$$$$$$$$50$$$$$$$$60$$$$$$$$70$\n";
  const bool binary = format == Format::KRBI || format == Format::KDBI;
  const std::size_t values = grid.rows() * payload.sources.size();
  out.reserve(out.size() + values * (binary ? (wide ? 8 : 4) : (wide ? 21 : 11)) + 80);
  if (binary) {
    append_binary(out, payload, wide);
  } else {
    append_text(out, payload, wide);
  }
  return out;
}

void write(const Crg& crg, const std::string& path, Format format) {
  namespace fs = std::filesystem;
  const std::string bytes = to_bytes(crg, format);
  std::error_code problem;
  const fs::file_type type = fs::status(path, problem).type();
  if (type != fs::file_type::not_found && type != fs::file_type::regular &&
      type != fs::file_type::fifo && type != fs::file_type::character) {
    throw Error(path + ": is " +
                (type == fs::file_type::directory ? "a folder" : "no file that can be written") +
                ": want the name of a file");
  }
  const bool through = type == fs::file_type::fifo || type == fs::file_type::character;
  // A link stays a link; the file that it names is replaced.
  std::string target = path;
  for (int links = 0; !through && fs::is_symlink(target, problem); ++links) {
    if (links == 40) throw Error(path + ": links to itself: want the name of a file");
    const fs::path next = fs::read_symlink(target, problem);
    target = (next.is_absolute() ? next : fs::path(target).parent_path() / next).string();
  }
  // A name of its own per process and call: two writers never share a temporary file, and O_EXCL
  // follows no link that somebody laid there.
  static std::atomic<unsigned> count{0};
  std::string temporary = target;
  int file = -1;
  do {
    if (!through) {
      const fs::path wanted(target);
      const std::string name = "." + wanted.filename().string().substr(0, 200) + "." +
                               std::to_string(::getpid()) + "-c" + std::to_string(count++) +
                               ".part";
      temporary = (wanted.parent_path() / name).string();
    }
    file = ::open(temporary.c_str(),
                  through ? O_WRONLY | O_CLOEXEC : O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (file < 0 && errno == EEXIST);
  const auto fail = [&](const char* what) {
    const std::string reason = std::strerror(errno);
    if (file >= 0) ::close(file);
    if (file >= 0 && !through) ::unlink(temporary.c_str());
    throw Error(path + ": cannot " + what + " " + temporary + ": " + reason);
  };
  if (file < 0) fail(through ? "open" : "create");
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write");
    done += static_cast<std::size_t>(written);
  }
  if (!through && ::fsync(file) != 0) fail("flush");
  ::close(file);
  if (!through && std::rename(temporary.c_str(), target.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    ::unlink(temporary.c_str());
    throw Error(path + ": cannot rename " + temporary + " to it: " + reason);
  }
}

}  // namespace crg
