#include "text_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstring>
#include <limits>

#include "cloud/error.h"

namespace cloud {
namespace {

bool is_gap(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\r'; }

bool is_angle(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name.starts_with("longitude") || name.starts_with("latitude") || name == "lon" ||
         name == "lat" || name == "lng" || name == "lon_deg" || name == "lat_deg";
}

/// A line cut at its gaps.
std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words(1);
  for (const char c : line) {
    if (!is_gap(c))
      words.back() += c;
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// Of a table without names: x y z [intensity].
std::vector<Role> columns_by_number(std::size_t columns, const std::string& where) {
  if (columns < 3) throw Error(fmt::format("{}: {} columns seen, x y z wanted", where, columns));
  std::vector<Role> roles(std::min<std::size_t>(columns, 4), Role::intensity);
  roles[0] = Role::x, roles[1] = Role::y, roles[2] = Role::z;
  return roles;
}

/// By names; of those that mean the same the first, but x, y and z are kept, to be refused.
std::vector<Role> columns_by_name(const std::vector<std::string>& words, const std::string& name) {
  std::vector<Role> roles;
  bool seen[kRoles + 1] = {};
  for (const std::string& word : words) {
    if (is_angle(word)) refuse_angle(name, word);
    Role role = role_of(word);
    if (seen[static_cast<std::size_t>(role)] && role > Role::z) role = Role::none;
    seen[static_cast<std::size_t>(role)] = true;
    roles.push_back(role);
  }
  return roles;
}

/// Where a line's text begins, behind gaps and a byte order mark; its end, where there is none.
std::size_t begin_of_text(std::string_view line) {
  std::size_t first = 0;
  while (first < line.size() && (is_gap(line[first]) || line[first] == '\xEF' ||
                                 line[first] == '\xBB' || line[first] == '\xBF'))
    ++first;
  return first;
}

bool begins_with_number(const std::vector<std::string>& words) {
  if (words.empty()) return false;
  double ignored = 0.0;
  const char* at = words[0].data();
  return number_at(at, at + words[0].size(), ignored);
}

/// One per role, of a line's numbers.
std::array<double, kRoles> values_in(const char* at, const char* line_end,
                                     const std::vector<Role>& columns, bool no_more,
                                     const std::string& name, std::size_t line_number) {
  std::array<double, kRoles> values{};
  const char* const begin = at;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    double value = 0.0;
    if (!number_at(at, line_end, value))
      throw Error(fmt::format("{}:{}: {} numbers wanted, number {} is '{}'", name, line_number,
                              columns.size(), k + 1, std::string(at, std::min(line_end, at + 20))));
    if (columns[k] != Role::none) values[static_cast<std::size_t>(columns[k])] = value;
  }
  // Between blanks what nobody named is no doubt; commas may be decimal ones.
  if (double more = 0.0;
      no_more && std::find(begin, line_end, ',') != line_end && number_at(at, line_end, more))
    throw Error(
        fmt::format("{}:{}: more numbers than the {} columns that the header names; write decimals "
                    "with points, and a name for each column",
                    name, line_number, columns.size()));
  return values;
}

}  // namespace

bool number_at(const char*& here, const char* end, double& value) {
  while (here < end && is_gap(*here)) ++here;
  if (here < end && *here == '+') ++here;
  const auto [behind, problem] = std::from_chars(here, end, value);
  if (problem == std::errc::result_out_of_range) {
    value = std::numeric_limits<double>::quiet_NaN();
  } else if (problem != std::errc()) {
    return false;
  }
  here = behind;
  return here == end || is_gap(*here);
}

Records xyz_records(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  Records records;
  records.bytes = bytes;
  records.text = true;
  std::size_t here = 0, line_number = 0;
  while (here < bytes.size()) {
    const std::size_t end = std::min(bytes.find('\n', here), bytes.size()),
                      next = std::min(end + 1, bytes.size());
    const std::string_view line = bytes.substr(here, std::min<std::size_t>(end - here, 4096));
    const std::size_t first = begin_of_text(line);
    ++line_number;
    // So CloudCompare begins the line of names.
    const bool is_slashed = line.substr(first).starts_with("//"),
               is_comment = is_slashed || line.substr(first).starts_with('#');
    if (first == line.size() ||
        (is_comment &&
         line.find_first_of(is_slashed ? ",xX" : ",x", first) == std::string_view::npos)) {
      here = next;
      continue;
    }
    const std::vector<std::string> words = words_of(line.substr(first + (is_slashed   ? 2
                                                                         : is_comment ? 1
                                                                                      : 0)));
    if (begins_with_number(words)) {
      records.columns = columns_by_number(words.size(), fmt::format("{}:{}", name, line_number));
    } else {
      records.columns = columns_by_name(words, name);
      records.named = true;
      here = next;
      ++line_number;
    }
    break;
  }
  records.text_begin = here;
  records.first_line = line_number;
  report.format = "text";
  require_xyz(records.columns,
              name + (records.columns.empty() ? "" : ": column names of the first line"));
  return records;
}

void read_text(const Records& records, const std::string& name, std::size_t chunk_points,
               Emitter& emit) {
  const char* here = records.bytes.data() + records.text_begin;
  const char* const end = records.bytes.data() + records.bytes.size();
  Raw raw;
  std::size_t line_number = records.first_line - 1, read = 0;
  while (here < end && !(records.counted && read == records.count)) {
    const char* line_end =
        static_cast<const char*>(std::memchr(here, '\n', static_cast<std::size_t>(end - here)));
    if (line_end == nullptr) line_end = end;
    ++line_number;
    const char* at = here;
    while (at < line_end && is_gap(*at)) ++at;
    here = line_end + (line_end < end ? 1 : 0);
    if (at == line_end || *at == '#' || *at == '/') continue;
    const std::array<double, kRoles> values =
        values_in(at, line_end, records.columns, records.named, name, line_number);
    for (const Role role : records.columns)
      if (role != Role::none)
        raw.of[static_cast<std::size_t>(role)].push_back(values[static_cast<std::size_t>(role)]);
    ++raw.size, ++read;
    if (raw.size == chunk_points) {
      emit(raw, static_cast<double>(here - records.bytes.data()) /
                    static_cast<double>(records.bytes.size()));
      raw = {};
    }
  }
  if (raw.size > 0) emit(raw, 1.0);
  if (records.counted && read < records.count)
    throw Error(fmt::format("{}: truncated: {} points promised, {} seen; copy the file again", name,
                            records.count, read));
}

}  // namespace cloud
