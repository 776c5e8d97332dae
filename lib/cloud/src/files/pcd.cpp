// PCD 0.6 and 0.7: ascii, binary, binary_compressed. PCL's own reader trusts the header; ours may
// be handed any bytes.
#include <fmt/format.h>
#include <liblzf/lzf.h>

#include <charconv>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>

#include "cloud/error.h"
#include "records.h"

namespace cloud {
namespace {

std::vector<std::string> spaced_words(std::string_view line) {
  std::istringstream in{std::string(line)};
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::size_t number(const std::string& word, const std::string& where) {
  std::size_t value = 0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (problem != std::errc() || end != word.data() + word.size())
    throw Error(fmt::format("{}'{}' seen, a whole number wanted", where, word.substr(0, 60)));
  return value;
}

std::optional<FieldType> pcd_type(const std::string& type, std::size_t size) {
  if (type == "F")
    return size == 4   ? std::optional(FieldType::f32)
           : size == 8 ? std::optional(FieldType::f64)
                       : std::nullopt;
  const bool is_signed = type == "I";
  if (!is_signed && type != "U") return std::nullopt;
  switch (size) {
    case 1:
      return is_signed ? FieldType::i8 : FieldType::u8;
    case 2:
      return is_signed ? FieldType::i16 : FieldType::u16;
    case 4:
      return is_signed ? FieldType::i32 : FieldType::u32;
    case 8:
      return is_signed ? FieldType::i64 : FieldType::u64;
    default:
      return std::nullopt;
  }
}

/// The lines before the points.
struct PcdHeader {
  std::vector<std::string> fields, sizes, types, counts;
  std::vector<std::string> origin;  ///< the words of the comment; empty without one
  std::string data;                 ///< ascii, binary, binary_compressed
  std::size_t points = 0;
  std::size_t end = 0;    ///< byte at which the points begin
  std::size_t lines = 0;  ///< before them
  std::string where;      ///< the last line, for errors
};

PcdHeader read_pcd_header(std::string_view bytes, const std::string& name) {
  PcdHeader out;
  std::size_t width = 0, height = 1;
  out.where = fmt::format("{}:0: ", name);
  while (out.data.empty() && out.end < bytes.size() && out.lines < 1000) {
    const std::size_t end = bytes.find('\n', out.end);
    if (end == std::string_view::npos || end - out.end > 65536) break;
    const std::vector<std::string> words = spaced_words(bytes.substr(out.end, end - out.end));
    out.end = end + 1;
    out.where = fmt::format("{}:{}: ", name, ++out.lines);
    if (words.size() == 5 && words[0] == "#" && words[1] == "origin_m") out.origin = words;
    if (words.size() < 2 || words[0].starts_with("#")) continue;
    const std::vector<std::string> rest(words.begin() + 1, words.end());
    if (words[0] == "FIELDS" || words[0] == "COLUMNS") out.fields = rest;
    if (words[0] == "SIZE") out.sizes = rest;
    if (words[0] == "TYPE") out.types = rest;
    if (words[0] == "COUNT") out.counts = rest;
    if (words[0] == "WIDTH") width = number(rest[0], out.where);
    if (words[0] == "HEIGHT") height = number(rest[0], out.where);
    if (words[0] == "POINTS") out.points = number(rest[0], out.where);
    if (words[0] == "DATA") out.data = rest[0];
  }
  if (out.data.empty())
    throw Error(out.where + "PCD header without a DATA line; the file is truncated or no PCD");
  const std::size_t fields = out.fields.size();
  if (out.counts.empty()) out.counts.assign(fields, "1");
  if (fields == 0 || out.sizes.size() != fields || out.types.size() != fields ||
      out.counts.size() != fields)
    throw Error(fmt::format("{}{} FIELDS, {} SIZE, {} TYPE, {} COUNT seen, equally many wanted",
                            out.where, fields, out.sizes.size(), out.types.size(),
                            out.counts.size()));
  if (out.points == 0) {
    if (height != 0 && width > std::numeric_limits<std::size_t>::max() / height)
      throw Error(out.where + "WIDTH times HEIGHT is too large");
    out.points = width * height;
  }
  if (out.points == 0) throw Error(out.where + "no points in this file");
  return out;
}

/// Fields (or columns) of the records as the header names them, one behind the other. Returns how
/// many bytes of a point each takes.
std::vector<std::size_t> add_fields(const PcdHeader& header, Records& records) {
  std::size_t stride = 0;
  std::vector<std::size_t> widths;
  for (std::size_t k = 0; k < header.fields.size(); ++k) {
    const std::size_t size = number(header.sizes[k], header.where),
                      count = number(header.counts[k], header.where);
    const std::optional<FieldType> type = pcd_type(header.types[k], size);
    if (!type)
      throw Error(fmt::format(
          "{}field {} of type {} and size {} seen; F 4 or 8, I or U 1, 2, 4 or 8 wanted",
          header.where, header.fields[k].substr(0, 60), header.types[k].substr(0, 60), size));
    if (count == 0 || count > 65536)
      throw Error(fmt::format("{}COUNT {} of field {} seen, 1 to 65536 wanted", header.where, count,
                              header.fields[k].substr(0, 60)));
    const Role role = role_of(header.fields[k]);
    records.fields.push_back({role, *type, stride, 0});
    for (std::size_t c = 0; c < count && header.data == "ascii"; ++c)
      records.columns.push_back(c == 0 ? role : Role::none);
    widths.push_back(size * count);
    stride += size * count;
  }
  return widths;
}

Error truncated(const PcdHeader& header, std::size_t left, std::size_t wanted) {
  return Error(
      fmt::format("{}truncated: {} points promised, {} bytes left, {} wanted; copy the file again",
                  header.where, header.points, left, wanted));
}

/// What the compressed points unpack to: field after field, each of all points.
std::string unpacked(std::string_view bytes, const PcdHeader& header, std::size_t point_bytes) {
  const std::size_t left = bytes.size() - header.end;
  if (left < 8) throw truncated(header, left, 8);
  std::uint32_t packed = 0, size = 0;
  std::memcpy(&packed, bytes.data() + header.end, 4);
  std::memcpy(&size, bytes.data() + header.end + 4, 4);
  if (packed > left - 8) throw truncated(header, left, packed);
  // LZF makes at most 264 bytes out of 3; anything beyond is a damaged header.
  if (size / point_bytes < header.points || size / 100 > packed)
    throw Error(fmt::format("{}corrupt: {} points of {} bytes promised, {} bytes packed into {}",
                            header.where, header.points, point_bytes, size, packed));
  std::string out(size, '\0');
  if (lzf_decompress(bytes.data() + header.end + 8, packed, out.data(), size) != size)
    throw Error(header.where + "corrupt: the compressed points do not unpack; copy the file again");
  return out;
}

}  // namespace

Records pcd_records(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  const PcdHeader header = read_pcd_header(bytes, name);
  Records records;
  records.bytes = bytes;
  records.count = header.points;
  const std::vector<std::size_t> widths = add_fields(header, records);
  const std::size_t stride = std::accumulate(widths.begin(), widths.end(), std::size_t{0});
  const std::size_t left = bytes.size() - header.end;
  report.format = "PCD " + header.data;
  if (header.data == "ascii") {
    records.text = true, records.counted = true;
    records.text_begin = header.end;
    records.first_line = header.lines + 1;
    if (!header.origin.empty())
      report.remarks.push_back("the comment origin_m holds for binary points only; not added");
    if (header.points > left / 2 + 1) throw truncated(header, left, 2 * header.points);
    return records;
  }
  if (header.data == "binary") {
    if (header.points > left / stride)
      throw Error(fmt::format(
          "{}truncated: {} points of {} bytes promised, {} bytes left; copy the file again",
          header.where, header.points, stride, left));
    for (Field& field : records.fields) field.offset += header.end, field.stride = stride;
  } else if (header.data == "binary_compressed") {
    records.owned = unpacked(bytes, header, stride);
    records.bytes = records.owned;
    for (std::size_t k = 0; k < widths.size(); ++k)
      records.fields[k].offset *= header.points, records.fields[k].stride = widths[k];
  } else {
    throw Error(fmt::format("{}DATA {} seen; ascii, binary or binary_compressed wanted",
                            header.where, header.data.substr(0, 60)));
  }
  add_origin(header.origin, records);
  return records;
}

}  // namespace cloud
