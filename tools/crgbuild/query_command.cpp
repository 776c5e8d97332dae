#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "base/parallel.h"
#include "base/read_file.h"
#include "base/table_form.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/surface.h"
#include "mesh/error.h"
#include "settings.h"

namespace crgbuild {
namespace {

constexpr std::size_t kBlockBytes = 16 << 20;  // input in memory at a time
constexpr std::size_t kChunkLines = 8192;      // one unit of parallel work
constexpr std::string_view kHeader = "x_m,y_m,u_m,v_m,z_m,heading_rad,curvature_1pm,dzdx,dzdy\n";

/// Where the two coordinates stand and which they are.
struct Columns {
  std::size_t first = 0, second = 0;
  bool map = true;  ///< x_m, y_m; otherwise u_m, v_m
};

Columns find_columns(const base::TableForm& form, std::string_view header,
                     const std::string& place) {
  const auto both = [&](const char* a, const char* b) {
    return std::max(form.column(a), form.column(b)) < form.names().size();
  };
  if (both("x_m", "y_m")) return {form.column("x_m"), form.column("y_m"), true};
  if (both("u_m", "v_m")) return {form.column("u_m"), form.column("v_m"), false};
  throw road::Error(fmt::format("{}: the columns '{}' seen, x_m and y_m (or u_m and v_m) wanted",
                                place, one_line(std::string(header.substr(0, 80)))));
}

void append(std::string& out, double value, char after = ',') {
  if (std::isfinite(value)) {
    char digits[32];
    const auto result = std::to_chars(digits, digits + sizeof digits, value);
    out.append(digits, result.ptr);
  }
  out += after;
}

struct Answers {
  std::string text;
  std::size_t rows = 0;
};

/// Answers the lines of one chunk; line numbers are for messages.
class Asker {
 public:
  Asker(const crg::Surface& surface, const Columns& columns, const base::TableForm& form)
      : surface_(surface), columns_(columns), form_(form) {}

  Answers operator()(const std::vector<std::string_view>& lines, std::size_t begin, std::size_t end,
                     std::size_t first_number) const {
    Answers out;
    out.text.reserve((end - begin) * 140);
    crg::Cursor cursor;
    std::vector<std::string_view> cells;
    for (std::size_t i = begin; i < end; ++i) {
      if (base::is_blank_or_remark(lines[i]) && !form_.is_row(lines[i])) continue;
      const std::size_t number = first_number + i;
      form_.split(lines[i], number, cells);
      // NaN for an empty cell: no road there.
      const double a = form_.number(cells[columns_.first], columns_.first, number);
      const double b = form_.number(cells[columns_.second], columns_.second, number);
      answer(a, b, cursor, out.text);
      ++out.rows;
    }
    return out;
  }

 private:
  void answer(double a, double b, crg::Cursor& cursor, std::string& out) const {
    crg::Sample s{};
    if (std::isfinite(a) && std::isfinite(b))
      s = columns_.map ? surface_.at_xy(a, b, cursor) : surface_.at_uv(a, b);
    append(out, columns_.map ? a : s.x_m);
    append(out, columns_.map ? b : s.y_m);
    append(out, columns_.map ? s.u_m : a);
    append(out, columns_.map ? s.v_m : b);
    append(out, s.z_m);
    append(out, s.heading_rad);
    append(out, s.curvature_1pm);
    append(out, s.dzdx);
    append(out, s.dzdy, '\n');
  }

  const crg::Surface& surface_;
  Columns columns_;
  const base::TableForm& form_;
};

/// The points, from a file or a pipe.
std::ifstream open_points(const QueryCommand& command) {
  const bool standard_input = command.points == "-";
  if (!standard_input) base::want_regular_file(command.points);
  std::ifstream points(standard_input ? "/dev/stdin" : command.points, std::ios::binary);
  if (!points)
    throw road::Error(
        fmt::format("{}: cannot be opened: {}; give a CSV file with the columns x_m and "
                    "y_m (or u_m and v_m)",
                    command.points, std::strerror(errno)));
  return points;
}

/// The first line that is neither blank nor a remark; `line` becomes its number.
std::string header_of(std::ifstream& points, const std::string& path, std::size_t& line) {
  std::string text;
  do {
    std::getline(points, text);
    if (++line == 1) text.erase(0, text.size() - base::behind_byte_order_mark(text, path).size());
  } while (points && base::is_blank_or_remark(text));
  return text;
}

}  // namespace

int run_query(const QueryCommand& command, Terminal& terminal) {
  std::ifstream points = open_points(command);
  points.seekg(0, std::ios::end);
  const double size = std::max(1.0, static_cast<double>(points.tellg()));
  points.clear();  // a pipe has no end to look for
  if (size > 1.0) points.seekg(0);
  const auto want_read = [&] {  // a disk or a pipe that fails is no end of the file
    if (points.bad())
      throw road::Error(
          fmt::format("{}: cannot be read to its end; look at the disk or the program "
                      "that it comes from",
                      command.points == "-" ? "standard input" : command.points));
  };
  std::size_t first_number = 0;
  const std::string header = header_of(points, command.points, first_number);
  want_read();
  const base::TableForm form(header, first_number, command.points, {"x_m", "y_m", "u_m", "v_m"});
  const Columns columns =
      find_columns(form, header, fmt::format("{}:{}", command.points, first_number++));

  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  const crg::ModifierUse use = command.modifiers == "none" ? crg::ModifierUse::None
                               : command.modifiers == "reference"
                                   ? crg::ModifierUse::ReferenceDefaults
                                   : crg::ModifierUse::AsInFile;
  const crg::Surface surface(with_settings(crg::read(command.crg), use, command.settings));
  const Asker ask(surface, columns, form);
  base::FileWriter output(command.output);
  output.append(kHeader);

  std::string block, rest;
  std::vector<std::string_view> lines;
  std::vector<Answers> answers;
  std::size_t rows = 0;
  double done = static_cast<double>(header.size());
  while (points) {
    block = std::move(rest);
    const std::size_t kept = block.size();
    block.resize(kept + kBlockBytes);
    points.read(block.data() + kept, static_cast<std::streamsize>(kBlockBytes));
    block.resize(kept + static_cast<std::size_t>(points.gcount()));
    done += static_cast<double>(points.gcount());
    // An unfinished last line waits for the next block.
    const std::size_t last = points ? block.rfind('\n') + 1 : block.size();
    rest = block.substr(last);
    if (rest.size() > kBlockBytes)
      throw road::Error(
          fmt::format("{}:{}: no end of the line within {} bytes; is this a CSV file?",
                      command.points, first_number, kBlockBytes));
    lines.clear();
    for (std::size_t at = 0; at < last;) {
      const std::size_t end = std::min(block.find('\n', at), last);
      lines.push_back(std::string_view(block).substr(at, end - at));
      at = end + 1;
    }
    answers.assign((lines.size() + kChunkLines - 1) / kChunkLines, {});
    base::parallel_for(lines.size(), kChunkLines, command.threads,
                       [&](std::size_t begin, std::size_t end) {
                         answers[begin / kChunkLines] = ask(lines, begin, end, first_number);
                       });
    for (const Answers& part : answers) {
      output.append(part.text);
      rows += part.rows;
    }
    first_number += lines.size();
    progress("query", std::min(1.0, done / size));
  }
  want_read();
  output.commit();
  terminal.progress_done();
  if (terminal.json)
    terminal.print(fmt::format("{{\"points\": {}}}\n", rows));
  else
    terminal.print(fmt::format("{} points\nanswers  {}\n", rows, command.output));
  return kOk;
}

}  // namespace crgbuild
