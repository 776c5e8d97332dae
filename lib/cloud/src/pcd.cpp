// PCD 0.6 and 0.7: ascii, binary, binary_compressed. PCL's own reader trusts the header; ours may
// be handed any bytes.
#include <fmt/format.h>
#include <liblzf/lzf.h>

#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>

#include "cloud/error.h"
#include "records.h"

namespace cloud {
namespace {

std::vector<std::string> words_of(std::string_view line) {
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

std::optional<FieldType> type_of(const std::string& type, std::size_t size) {
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

}  // namespace

Records pcd_records(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  Records records;
  records.bytes = bytes;
  std::vector<std::string> fields, sizes, types, counts;
  std::size_t here = 0, line_number = 0, width = 0, height = 1, points = 0;
  std::string data;
  std::vector<std::string> origin;
  const auto where = [&] { return fmt::format("{}:{}: ", name, line_number); };
  while (data.empty() && here < bytes.size() && line_number < 1000) {
    const std::size_t end = bytes.find('\n', here);
    if (end == std::string_view::npos || end - here > 65536) break;
    const std::vector<std::string> words = words_of(bytes.substr(here, end - here));
    here = end + 1;
    ++line_number;
    if (words.size() == 5 && words[0] == "#" && words[1] == "origin_m") origin = words;
    if (words.size() < 2 || words[0].starts_with("#")) continue;
    const std::vector<std::string> rest(words.begin() + 1, words.end());
    if (words[0] == "FIELDS" || words[0] == "COLUMNS") fields = rest;
    if (words[0] == "SIZE") sizes = rest;
    if (words[0] == "TYPE") types = rest;
    if (words[0] == "COUNT") counts = rest;
    if (words[0] == "WIDTH") width = number(rest[0], where());
    if (words[0] == "HEIGHT") height = number(rest[0], where());
    if (words[0] == "POINTS") points = number(rest[0], where());
    if (words[0] == "DATA") data = rest[0];
  }
  if (data.empty())
    throw Error(where() + "PCD header without a DATA line; the file is truncated or no PCD");
  if (counts.empty()) counts.assign(fields.size(), "1");
  if (fields.empty() || sizes.size() != fields.size() || types.size() != fields.size() ||
      counts.size() != fields.size())
    throw Error(fmt::format("{}{} FIELDS, {} SIZE, {} TYPE, {} COUNT seen, equally many wanted",
                            where(), fields.size(), sizes.size(), types.size(), counts.size()));
  if (points == 0) {
    if (height != 0 && width > std::numeric_limits<std::size_t>::max() / height)
      throw Error(where() + "WIDTH times HEIGHT is too large");
    points = width * height;
  }
  if (points == 0) throw Error(where() + "no points in this file");
  records.count = points;
  std::size_t stride = 0;
  std::vector<std::size_t> widths;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const std::size_t size = number(sizes[k], where()), count = number(counts[k], where());
    const std::optional<FieldType> type = type_of(types[k], size);
    if (!type)
      throw Error(fmt::format(
          "{}field {} of type {} and size {} seen; F 4 or 8, I or U 1, 2, 4 or 8 wanted", where(),
          fields[k].substr(0, 60), types[k].substr(0, 60), size));
    if (count == 0 || count > 65536)
      throw Error(fmt::format("{}COUNT {} of field {} seen, 1 to 65536 wanted", where(), count,
                              fields[k].substr(0, 60)));
    records.fields.push_back({role_of(fields[k]), *type, stride, 0});
    for (std::size_t c = 0; c < count && data == "ascii"; ++c)
      records.columns.push_back(c == 0 ? role_of(fields[k]) : Role::none);
    widths.push_back(size * count);
    stride += size * count;
  }
  report.format = "PCD " + data;
  const std::size_t left = bytes.size() - here;
  const auto truncated = [&](std::size_t wanted) {
    return Error(fmt::format(
        "{}truncated: {} points promised, {} bytes left, {} wanted; copy the file again", where(),
        points, left, wanted));
  };
  if (data == "ascii") {
    records.text = true, records.counted = true;
    records.text_begin = here;
    records.first_line = line_number + 1;
    if (!origin.empty())
      report.remarks.push_back("the comment origin_m holds for binary points only; not added");
    if (points > left / 2 + 1) throw truncated(2 * points);
    return records;
  }
  if (data == "binary") {
    if (points > left / stride) throw truncated(points);
    for (Field& field : records.fields) field.offset += here, field.stride = stride;
    add_origin(origin, records);
    return records;
  }
  if (data != "binary_compressed")
    throw Error(fmt::format("{}DATA {} seen; ascii, binary or binary_compressed wanted", where(),
                            data.substr(0, 60)));
  if (left < 8) throw truncated(8);
  std::uint32_t packed = 0, unpacked = 0;
  std::memcpy(&packed, bytes.data() + here, 4);
  std::memcpy(&unpacked, bytes.data() + here + 4, 4);
  if (packed > left - 8) throw truncated(packed);
  // LZF makes at most 264 bytes out of 3; anything beyond is a damaged header.
  if (unpacked / stride < points || unpacked / 100 > packed)
    throw Error(fmt::format("{}corrupt: {} points of {} bytes promised, {} bytes packed into {}",
                            where(), points, stride, unpacked, packed));
  records.owned.resize(unpacked);
  if (lzf_decompress(bytes.data() + here + 8, packed, records.owned.data(), unpacked) != unpacked)
    throw Error(where() + "corrupt: the compressed points do not unpack; copy the file again");
  records.bytes = records.owned;
  std::size_t begin = 0;
  for (std::size_t k = 0; k < records.fields.size(); ++k) {
    records.fields[k].offset = begin;
    records.fields[k].stride = widths[k];
    begin += widths[k] * points;
  }
  add_origin(origin, records);
  return records;
}

}  // namespace cloud
