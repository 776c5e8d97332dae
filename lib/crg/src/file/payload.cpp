// Binary payloads come through a small buffer and not through a memory map: a map would count twice
// (file and grid), and a file that another process shortens while it is mapped kills the reader.
#include "payload.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "big_endian.h"
#include "crg/error.h"
#include "crg/huge_pages.h"
#include "text.h"

namespace crg {
namespace {

constexpr double kMaxValue = 1e9;  // heights and angles beyond it are damage, not road
constexpr std::size_t kChunkBytes = 1 << 16;

bool take(const char* bytes, std::size_t count, float* to) {
  return take_floats(bytes, count, static_cast<float>(kMaxValue), to);
}
bool take(const char* bytes, std::size_t count, double* to) {
  return take_doubles(bytes, count, kMaxValue, to);
}

// Index of the first value that is out of bounds, or how many there are if there is none.
template <typename Value>
std::size_t first_beyond(const std::vector<Value>& row) {
  const auto beyond = [](Value value) {
    return !std::isnan(value) && !(std::abs(value) <= static_cast<Value>(kMaxValue));
  };
  return static_cast<std::size_t>(std::find_if(row.begin(), row.end(), beyond) - row.begin());
}

// Puts rows of values, in file order, into the channels of a Crg.
class RowSink {
 public:
  RowSink(Header& header, std::size_t expected_rows) : crg_(header.crg), columns_(header.columns) {
    first_height_ = columns_.size();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].kind == Column::Kind::Height) first_height_ = std::min(first_height_, c);
    }
    in_order_ = true;
    const std::size_t heights = crg_.grid.v_m.size();
    for (std::size_t j = 0; j < heights && in_order_; ++j) {
      const std::size_t c = first_height_ + j;
      in_order_ =
          c < columns_.size() && columns_[c].kind == Column::Kind::Height && columns_[c].index == j;
    }
    reserve_huge(crg_.grid.z_m, expected_rows * heights);
    for (const Column& column : columns_) {
      if (std::vector<double>* channel = channel_of(column)) channel->reserve(expected_rows);
    }
  }

  // Of values within bounds.
  template <typename Value>
  void add(const Value* row) {
    const std::size_t heights = crg_.grid.v_m.size();
    std::vector<float>& z_m = crg_.grid.z_m;
    const std::size_t start = z_m.size();
    if (std::is_same_v<Value, float> && in_order_) {
      z_m.insert(z_m.end(), row + first_height_, row + first_height_ + heights);
    } else {
      z_m.resize(start + heights);
    }
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const Column& column = columns_[c];
      if (column.kind != Column::Kind::Height) {
        channel_of(column)->push_back(static_cast<double>(row[c]));
      } else if (std::is_same_v<Value, float>) {
        if (in_order_) {
          c = first_height_ + heights - 1;
        } else {
          z_m[start + column.index] = static_cast<float>(row[c]);
        }
      } else {
        add_double(start, column.index, static_cast<double>(row[c]));
      }
    }
    if (!crg_.z_double_m.empty()) crg_.z_double_m.resize(z_m.size());
  }

  std::size_t rows() const { return crg_.grid.rows(); }

  void drop_rows_from(std::size_t row) {
    crg_.grid.z_m.resize(row * crg_.grid.v_m.size());
    if (!crg_.z_double_m.empty()) crg_.z_double_m.resize(crg_.grid.z_m.size());
    for (const Column& column : columns_) {
      if (std::vector<double>* channel = channel_of(column)) channel->resize(row);
    }
  }

 private:
  void add_double(std::size_t start, std::size_t index, double value) {
    std::vector<float>& z_m = crg_.grid.z_m;
    const float rounded = static_cast<float>(value);
    z_m[start + index] = rounded;
    // LRFI is a format of floats, whatever its digits say.
    if (crg_.format == Format::LRFI) return;
    if (crg_.z_double_m.empty() && (std::isnan(value) || static_cast<double>(rounded) == value))
      return;
    if (crg_.z_double_m.empty()) {
      crg_.z_double_m.reserve(z_m.capacity());
      crg_.z_double_m.assign(z_m.begin(), z_m.end());
    }
    crg_.z_double_m.resize(z_m.size());
    crg_.z_double_m[start + index] = value;
  }

  std::vector<double>* channel_of(const Column& column) {
    switch (column.kind) {
      case Column::Kind::Heading:
        return &crg_.heading_rad;
      case Column::Kind::Slope:
        return &crg_.slope;
      case Column::Kind::Banking:
        return &crg_.banking;
      case Column::Kind::X:
        return &crg_.x_m;
      case Column::Kind::Y:
        return &crg_.y_m;
      case Column::Kind::U:
        return &crg_.u_m;
      case Column::Kind::Other:
        return &crg_.other_channels[column.index].values;
      case Column::Kind::Height:
        break;
    }
    return nullptr;
  }

  Crg& crg_;
  const std::vector<Column>& columns_;
  std::size_t first_height_ = 0;
  bool in_order_ = false;
};

// Rows according to START_U, END_U and INCREMENT; 0 when END_U is not given.
std::size_t announced_rows(const Crg& crg, const std::string& name) {
  const double begin = find_value(crg.road, "REFERENCE_LINE_START_U").value_or(0.0);
  const auto end = find_value(crg.road, "REFERENCE_LINE_END_U");
  if (!end) return 0;
  const double steps = (*end - begin) / crg.grid.u_step_m;
  if (!(steps >= 0.5 && steps < 1e12)) {
    throw Error(name + ": REFERENCE_LINE_START_U = " + shortest(begin) +
                ", END_U = " + shortest(*end) + ", INCREMENT = " + shortest(crg.grid.u_step_m) +
                ": want END_U at least one increment behind START_U");
  }
  return static_cast<std::size_t>(std::llround(steps)) + 1;
}

void note(Crg& crg, const std::string& message) { crg.notes.push_back(message); }

[[noreturn]] void fail_short(const std::string& place, std::size_t rows, std::size_t wanted) {
  throw Error(place + ": the payload ends after " + std::to_string(rows) +
              " rows, but END_U announces " + std::to_string(wanted) +
              "; correct END_U or restore the data");
}

template <typename Value>
void read_binary(Header& header, Input& input, std::string_view begun, std::size_t announced) {
  const std::size_t columns = header.columns.size();
  const std::size_t row_bytes = columns * sizeof(Value);
  const std::size_t payload =
      input.size() > header.end_offset ? input.size() - header.end_offset : 0;
  const std::size_t available = payload / row_bytes;
  if (announced > available) {
    fail_short(input.name() + ": byte " + std::to_string(input.size()), available, announced);
  }
  const std::size_t rows = announced != 0 ? announced : available;
  RowSink sink(header, rows);

  std::vector<char> buffer(std::max(kChunkBytes / row_bytes, std::size_t{1}) * row_bytes);
  std::vector<Value> values(columns);
  std::size_t offset = header.end_offset;
  while (sink.rows() < rows) {
    const std::size_t wanted = std::min(buffer.size(), (rows - sink.rows()) * row_bytes);
    const std::size_t from_begun = std::min(wanted, begun.size());
    std::memcpy(buffer.data(), begun.data(), from_begun);
    begun.remove_prefix(from_begun);
    if (from_begun + input.read(buffer.data() + from_begun, wanted - from_begun) != wanted) {
      throw Error(input.name() + ": byte " + std::to_string(offset) +
                  ": the file became shorter while it was read");
    }
    for (std::size_t at = 0; at < wanted; at += row_bytes) {
      const char* bytes = buffer.data() + at;
      if (!take(bytes, columns, values.data())) {
        const std::size_t bad = first_beyond(values);
        throw Error(input.name() + ": byte " + std::to_string(offset + at + bad * sizeof(Value)) +
                    ": value " + shortest(static_cast<double>(values[bad])) + " in row " +
                    std::to_string(sink.rows()) + ", channel " + std::to_string(bad + 1) +
                    ": want at most 1e9 in magnitude; is the format or the row count right?");
      }
      sink.add(values.data());
    }
    offset += wanted;
  }

  // Without END_U the padding to a multiple of 80 bytes may look like further rows of NaN.
  if (announced == 0 && rows > 0) {
    const std::size_t padding = std::min(rows - 1, 79 / row_bytes);
    std::size_t kept = rows;
    const Crg& crg = header.crg;
    const std::size_t heights = crg.grid.v_m.size();
    while (kept > rows - padding) {
      const float* last = crg.grid.z_m.data() + (kept - 1) * heights;
      if (!std::all_of(last, last + heights, [](float z) { return std::isnan(z); })) break;
      --kept;
    }
    if (kept < rows) sink.drop_rows_from(kept);
  }
  const std::size_t used = (announced != 0 ? announced : sink.rows()) * row_bytes;
  if (payload - used >= std::max<std::size_t>(80, row_bytes) && announced != 0) {
    note(header.crg, std::to_string((payload - used) / row_bytes) +
                         " rows behind END_U in the payload were ignored");
  }
}

double parse_field(std::string_view field, const std::string& place) {
  if (field.find_first_not_of("0123456789+-.eEdD ") != std::string_view::npos) {
    return field == "**unused**" ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  }
  std::string_view rest;
  const std::optional<double> value = parse_number(field, &rest);
  if (!value || !trim(rest).empty()) {
    throw Error(place + ": \"" + std::string(field) +
                "\" is not a number; NaN is written with an asterisk");
  }
  return *value;
}

// The line in which each row begins.
std::vector<std::size_t> read_text(Header& header, const std::string& name,
                                   std::string_view payload, std::size_t announced) {
  const std::size_t columns = header.columns.size();
  const bool wide = header.crg.format == Format::LDFI;
  const std::size_t width = wide ? 20 : 10;
  const std::size_t per_record = 80 / width;
  // A field may be cut short only at the end of a line, so a row takes at least a byte per record.
  const std::size_t records = (columns + per_record - 1) / per_record;
  const std::size_t at_most = payload.size() / (columns + records) + 1;
  if (announced > at_most)
    fail_short(name + ": byte " + std::to_string(header.end_offset), at_most, announced);

  RowSink sink(header, announced != 0 ? announced : 0);
  std::vector<double> values(columns);
  std::size_t line_number = header.line_count;
  std::size_t offset = 0;
  const auto next_line = [&](std::string_view& line) {
    if (offset >= payload.size()) return false;
    const std::size_t newline = payload.find('\n', offset);
    const std::size_t end = newline == std::string_view::npos ? payload.size() : newline;
    line = payload.substr(offset, end - offset);
    offset = newline == std::string_view::npos ? payload.size() : newline + 1;
    ++line_number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return true;
  };
  std::size_t extra_rows = 0;
  std::vector<std::size_t> row_lines;
  while (true) {
    std::string_view line;
    std::size_t c = 0, first_line = 0;
    while (c < columns && next_line(line)) {
      if (c == 0 && trim(line).empty()) continue;
      if (c == 0) first_line = line_number;
      const std::string place = name + ":" + std::to_string(line_number);
      if (line.size() > 80 && !trim(line.substr(80)).empty()) {
        throw Error(place + ": a record of " + std::to_string(line.size()) +
                    " characters: want at most 80");
      }
      for (std::size_t k = 0; k < per_record && c < columns; ++k, ++c) {
        if (k * width >= line.size()) {
          throw Error(place + ": the record ends before channel " + std::to_string(c + 1) + " of " +
                      std::to_string(columns));
        }
        values[c] = parse_field(line.substr(k * width, width), place);
      }
    }
    if (c == 0) break;
    if (c < columns) {
      throw Error(name + ":" + std::to_string(line_number) + ": the last row ends after " +
                  std::to_string(c) + " of " + std::to_string(columns) + " channels");
    }
    if (announced != 0 && sink.rows() == announced) {
      ++extra_rows;
      continue;
    }
    row_lines.push_back(first_line);
    if (const std::size_t bad = first_beyond(values); bad != columns) {
      throw Error(name + ":" + std::to_string(line_number) + ": value " + shortest(values[bad]) +
                  " in channel " + std::to_string(bad + 1) + ": want at most 1e9 in magnitude");
    }
    sink.add(values.data());
  }
  if (sink.rows() < announced) {
    fail_short(name + ":" + std::to_string(line_number), sink.rows(), announced);
  }
  if (extra_rows > 0)
    note(header.crg, std::to_string(extra_rows) + " rows behind END_U in the payload were ignored");
  if (row_lines.empty()) row_lines.push_back(line_number);
  return row_lines;
}

// Values without which nothing can be evaluated. `place_of(row)`: where a row of the payload
// begins.
template <typename PlaceOf>
void check_channels(const Crg& crg, const PlaceOf& place_of) {
  if (crg.grid.rows() < 2) {
    throw Error(place_of(0) + ": the payload holds " + std::to_string(crg.grid.rows()) +
                " rows: want at least 2");
  }
  const auto want_numbers = [&](const std::vector<double>& channel, const char* what,
                                std::size_t first) {
    for (std::size_t i = first; i < channel.size(); ++i) {
      if (std::isnan(channel[i])) {
        throw Error(place_of(i) + ": row " + std::to_string(i) + ": " + what +
                    " is NaN: want a number in every row" + (first == 1 ? " but the first" : ""));
      }
    }
  };
  want_numbers(crg.heading_rad, "reference line phi", 1);
  want_numbers(crg.slope, "reference line slope", 1);
  want_numbers(crg.banking, "reference line banking", 0);
  want_numbers(crg.x_m, "reference line x", 0);
  want_numbers(crg.y_m, "reference line y", 0);
}

}  // namespace

void read_payload(Header& header, Input& input, std::string begun) {
  Crg& crg = header.crg;
  const std::size_t announced = announced_rows(crg, input.name());
  const std::string_view rest = std::string_view(begun).substr(header.end_offset);
  if (crg.format == Format::KRBI || crg.format == Format::KDBI) {
    const bool single = crg.format == Format::KRBI;
    (single ? read_binary<float> : read_binary<double>)(header, input, rest, announced);
    const std::size_t row_bytes = header.columns.size() * (single ? sizeof(float) : sizeof(double));
    check_channels(crg, [&](std::size_t row) {
      return input.name() + ": byte " + std::to_string(header.end_offset + row * row_bytes);
    });
  } else {
    begun.erase(0, header.end_offset);
    const std::size_t before = begun.size();
    begun.resize(std::max(before, input.size() - header.end_offset));
    begun.resize(before + input.read(begun.data() + before, begun.size() - before));
    const std::vector<std::size_t> row_lines = read_text(header, input.name(), begun, announced);
    check_channels(
        crg, [&](std::size_t row) { return input.name() + ":" + std::to_string(row_lines[row]); });
  }
}

}  // namespace crg
