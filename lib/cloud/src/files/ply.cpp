// PLY as a cloud: element vertex, ascii and both binaries; other elements are passed over.
#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <sstream>

#include "cloud/error.h"
#include "records.h"

namespace cloud {
namespace {

std::optional<FieldType> ply_type(const std::string& word) {
  if (word == "char" || word == "int8") return FieldType::i8;
  if (word == "uchar" || word == "uint8") return FieldType::u8;
  if (word == "short" || word == "int16") return FieldType::i16;
  if (word == "ushort" || word == "uint16") return FieldType::u16;
  if (word == "int" || word == "int32") return FieldType::i32;
  if (word == "uint" || word == "uint32") return FieldType::u32;
  if (word == "float" || word == "float32") return FieldType::f32;
  if (word == "double" || word == "float64") return FieldType::f64;
  return std::nullopt;
}

std::optional<std::size_t> count_of(const std::string& word) {
  std::size_t value = 0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (problem != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

Records ply_records(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  Records records;
  records.bytes = bytes;
  std::size_t here = 0, line_number = 0, stride = 0, before = 0;
  std::string format;
  std::vector<std::string> origin;
  bool in_vertex = false, seen_vertex = false, ended = false;
  const auto fail = [&](const std::string& text) {
    return Error(fmt::format("{}:{}: {}", name, line_number, text));
  };
  while (here < bytes.size() && line_number < 1000) {
    const std::size_t end = bytes.find('\n', here);
    if (end == std::string_view::npos || end - here > 4096) break;
    std::string line(bytes.substr(here, end - here));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    here = end + 1;
    ++line_number;
    std::istringstream words(line);
    std::string word, a, b, c;
    words >> word >> a >> b >> c;
    if (word == "format") format = a;
    if (word == "comment" && a == "origin_m") {
      std::string d;
      words >> d;
      origin = {a, b, c, d};
    }
    if (word == "element") {
      const std::optional<std::size_t> count = count_of(b);
      if (!count)
        throw fail(fmt::format("'{}' seen, 'element NAME COUNT' wanted", line.substr(0, 60)));
      in_vertex = a == "vertex" && !seen_vertex;
      if (in_vertex)
        records.count = *count, seen_vertex = true;
      else if (!seen_vertex && *count > 0)
        ++before;
    }
    if (word == "property" && in_vertex) {
      const std::optional<FieldType> type = ply_type(a);
      if (!type)
        throw fail(fmt::format("'{}' seen; properties of a vertex must be single numbers",
                               line.substr(0, 60)));
      records.fields.push_back({role_of(b), *type, stride, 0});
      records.columns.push_back(role_of(b));
      stride += size_of(*type);
    }
    if (word == "end_header") {
      ended = true;
      break;
    }
  }
  if (!ended) throw fail("PLY header without end_header; the file is truncated or no PLY");
  if (!seen_vertex) throw fail("no 'element vertex' in the header; a cloud is wanted");
  if (before > 0) throw fail("the vertices do not come first; write them first");
  if (records.count == 0) throw fail("no points in this file");
  report.format = "PLY " + format;
  if (format == "ascii") {
    records.text = true, records.counted = true;
    records.text_begin = here;
    records.first_line = line_number + 1;
    if (!origin.empty())
      report.remarks.push_back("the comment origin_m holds for binary points only; not added");
    if (records.count > (bytes.size() - here) / 2 + 1)
      throw fail(fmt::format("truncated: {} points promised, {} bytes left", records.count,
                             bytes.size() - here));
    return records;
  }
  if (format != "binary_little_endian" && format != "binary_big_endian")
    throw fail(
        fmt::format("format '{}' seen; ascii, binary_little_endian or binary_big_endian wanted",
                    format.substr(0, 60)));
  records.big_endian = format == "binary_big_endian";
  if (stride == 0 || records.count > (bytes.size() - here) / stride)
    throw fail(
        fmt::format("truncated: {} points of {} bytes promised, {} bytes left; copy the file again",
                    records.count, stride, bytes.size() - here));
  for (Field& field : records.fields) field.offset += here, field.stride = stride;
  add_origin(origin, records);
  return records;
}

}  // namespace cloud
