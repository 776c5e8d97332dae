// LAS 1.0-1.4. Source: ASPRS LAS 1.4 R15, tables 3, 7-17; GeoKeys: GeoTIFF 1.1 (OGC 19-008r4).
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "cloud/error.h"
#include "laz.h"
#include "records.h"
#include "wkt.h"

namespace cloud {
namespace {

static_assert(std::endian::native == std::endian::little);

template <typename T>
T at(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

// Record length and place of GPS time per point format (0: none).
struct PointFormat {
  std::size_t length, time;
};
constexpr PointFormat kFormats[] = {{20, 0},  {28, 20}, {26, 0},  {34, 20}, {57, 20}, {63, 20},
                                    {30, 22}, {36, 22}, {38, 22}, {59, 22}, {67, 22}};

std::optional<LengthUnit> unit_of(int epsg) {
  if (epsg == 9001) return length_unit("m", 1.0);
  if (epsg == 9002) return length_unit("ft", 0.3048);
  if (epsg == 9003) return length_unit("US survey ft", 1200.0 / 3937.0);
  return std::nullopt;
}

CoordinateSystem read_geo_keys(std::string_view record) {
  const std::size_t keys = record.size() / 8;
  int system = 0;
  CoordinateSystem out;
  for (std::size_t k = 1; k < keys; ++k) {
    const auto id = at<std::uint16_t>(record, 8 * k), place = at<std::uint16_t>(record, 8 * k + 2);
    const auto value = at<std::uint16_t>(record, 8 * k + 6);
    if (place != 0) continue;
    if (id == 3072 || (id == 2048 && system == 0)) system = value;
    out.in_degrees |= id == 1024 && value == 2;
    if (id == 3076) out.plan = unit_of(value);
    if (id == 4099) out.height = unit_of(value);
  }
  if (system != 0 && system != 32767) out.name = fmt::format("EPSG:{}", system);
  out.in_degrees |= system == 4326;
  return out;
}

/// What records of variable length hold.
struct VariableRecords {
  std::string_view laszip;
  CoordinateSystem by_keys, by_text;
};

/// Extended ones stand behind the points and count their bytes with 64 bits.
void read_variable_records(std::string_view bytes, std::size_t begin, std::size_t count,
                           std::size_t end, bool extended, VariableRecords& out,
                           CloudReadReport& report) {
  const std::size_t head = extended ? 60 : 54;
  std::size_t here = begin;
  for (std::size_t k = 0; k < count; ++k) {
    if (here > end || end - here < head) {
      report.remarks.push_back(
          fmt::format("{} of {} variable length records lie beyond the {} and were passed over",
                      count - k, count, extended ? "end of the file" : "header area"));
      return;
    }
    const std::string_view user = bytes.substr(here + 2, 16);
    const auto id = at<std::uint16_t>(bytes, here + 18);
    const std::uint64_t length =
        extended ? at<std::uint64_t>(bytes, here + 20) : at<std::uint16_t>(bytes, here + 20);
    if (length > end - here - head) {
      report.remarks.push_back(
          fmt::format("a variable length record is longer than the {} and was passed over",
                      extended ? "file" : "header area"));
      return;
    }
    const std::string_view record = bytes.substr(here + head, length);
    if (user.starts_with("LASF_Projection")) {
      if (id == 34735) out.by_keys = read_geo_keys(record);
      if (id == 2112) out.by_text = read_wkt(record.substr(0, record.find('\0')));
    }
    if (user.starts_with("laszip encoded")) out.laszip = record;
    here += head + length;
  }
}

/// A file with both means the same by them; the text says more.
void use_coordinate_system(const VariableRecords& records, CloudReadReport& report) {
  const CoordinateSystem &text = records.by_text, &keys = records.by_keys;
  report.coordinate_system = text.name.empty() ? keys.name : text.name;
  if (text.in_degrees || keys.in_degrees)
    refuse_degrees("are degrees of longitude and latitude" +
                   (keys.name.empty() ? "" : " (" + keys.name + ")"));
  const std::optional<LengthUnit> plan = text.plan ? text.plan : keys.plan,
                                  height = text.height ? text.height : keys.height;
  if (!plan && !report.coordinate_system.empty())
    report.remarks.push_back(
        fmt::format("the coordinate system '{}' names no unit for the plan; without --unit (map, "
                    "grid: --cloud-unit) it is metres",
                    report.coordinate_system.substr(0, 60)));
  if (!plan && !height) return;
  const LengthUnit flat = plan.value_or(LengthUnit{"m", 1.0}), up = height.value_or(flat);
  report.unit = flat.name;
  report.metres_per_unit = flat.metres;
  report.metres_per_height_unit = up.metres;
  report.unit_from_file = plan.has_value();
  if (up.metres != flat.metres)
    report.remarks.push_back(fmt::format(
        "heights are in {}, the plan is in {}, as the coordinate system says", up.name, flat.name));
}

/// What the header says of the points.
struct LasHeader {
  int major = 0, minor = 0, format = 0;  ///< the latter of the points, without marks
  bool packed = false;
  std::size_t size = 0, data = 0, variable_records = 0, length = 0;  ///< length: of a point
  std::uint64_t points = 0, extended = 0, extended_records = 0;
};

Error fail(const std::string& name, const std::string& text) { return Error(name + ": " + text); }

/// Throws where it contradicts itself or the file.
LasHeader read_las_header(std::string_view bytes, const std::string& name) {
  if (bytes.size() < 227)
    throw fail(name, fmt::format("LAS header truncated: {} bytes seen, 227 wanted; copy the file "
                                 "again",
                                 bytes.size()));
  LasHeader out;
  out.major = at<std::uint8_t>(bytes, 24), out.minor = at<std::uint8_t>(bytes, 25);
  if (out.major != 1 || out.minor > 4)
    throw fail(name,
               fmt::format("LAS version {}.{} seen, 1.0 to 1.4 wanted", out.major, out.minor));
  out.size = at<std::uint16_t>(bytes, 94), out.data = at<std::uint32_t>(bytes, 96);
  out.variable_records = at<std::uint32_t>(bytes, 100);
  const int marked_format = at<std::uint8_t>(bytes, 104);
  out.packed = marked_format & 0xC0, out.format = marked_format & 0x3F;
  if (out.format > 10)
    throw fail(name, fmt::format("point format {} seen, 0 to 10 wanted", out.format));
  out.length = at<std::uint16_t>(bytes, 105);
  if (out.length < kFormats[out.format].length)
    throw fail(name, fmt::format("point format {} wants records of {} bytes, the header says {}",
                                 out.format, kFormats[out.format].length, out.length));
  if (out.size < 227 || out.size > bytes.size() || out.data < out.size || out.data > bytes.size())
    throw fail(
        name, fmt::format("corrupt header: header of {} bytes, points at byte {}, file of {} bytes",
                          out.size, out.data, bytes.size()));
  out.points = at<std::uint32_t>(bytes, 107);
  if (out.minor == 4 && out.size >= 375) {
    const auto points64 = at<std::uint64_t>(bytes, 247);
    if (points64 != 0) out.points = points64;
    out.extended = at<std::uint64_t>(bytes, 235),
    out.extended_records = at<std::uint32_t>(bytes, 243);
  }
  if (out.points == 0) throw fail(name, "no points in this file");
  return out;
}

std::shared_ptr<LazReader> unpacker(std::string_view bytes, const LasHeader& header,
                                    std::string_view laszip, const std::string& name) {
  const int format = header.format;
  if (format == 4 || format == 5)
    throw fail(name,
               fmt::format("compressed points of format {} with waveforms are not read; leave "
                           "those out, as with 'las2las -i in.laz -set_point_type {} -o "
                           "out.laz'",
                           format, format == 4 ? 1 : 3));
  if (laszip.empty())
    throw fail(name,
               "its points are marked as compressed, but there is no record 'laszip encoded'; "
               "copy the file again");
  return std::make_shared<LazReader>(
      bytes, LazLayout{laszip, format, header.data, header.length, header.points}, name);
}

/// x, y or z, of records that begin at `begin`.
Field coordinate(std::string_view bytes, std::size_t axis, std::size_t begin, std::size_t length,
                 const std::string& name) {
  Field field{static_cast<Role>(axis), FieldType::i32, begin + 4 * axis, length};
  field.scale = at<double>(bytes, 131 + 8 * axis);
  field.add = at<double>(bytes, 155 + 8 * axis);
  if (!std::isfinite(field.scale) || field.scale == 0.0 || !std::isfinite(field.add))
    throw fail(name,
               fmt::format(
                   "scale {} and offset {} of axis {} seen, finite numbers wanted, the scale not 0",
                   field.scale, field.add, "xyz"[axis]));
  return field;
}

std::vector<Field> fields_of(std::string_view bytes, const LasHeader& header, std::size_t begin,
                             const std::string& name) {
  const std::size_t length = header.length, time = kFormats[header.format].time;
  std::vector<Field> fields;
  for (std::size_t axis = 0; axis < 3; ++axis)
    fields.push_back(coordinate(bytes, axis, begin, length, name));
  fields.push_back({Role::intensity, FieldType::u16, begin + 12, length});
  Field classes{Role::classification, FieldType::u8, begin + (header.format < 6 ? 15u : 16u),
                length};
  if (header.format < 6) classes.mask = 0x1f;  // the upper bits are flags
  fields.push_back(classes);
  // Version 1.0 knows no marks.
  const auto mark = [&](Role role, std::uint8_t mask) {
    if (header.minor > 0)
      fields.push_back({role, FieldType::u8, begin + 15, length, 1.0, 0.0, mask});
  };
  const bool old = header.format < 6;
  mark(Role::withheld, old ? 0x80 : 0x04);
  mark(Role::synthetic, old ? 0x20 : 0x01);
  if (!old) mark(Role::overlap, 0x08);  // before, class 12 was for that
  const auto returns = [&](Role role, std::uint8_t mask) {
    fields.push_back({role, FieldType::u8, begin + 14, length, 1.0, 0.0, mask});
  };
  returns(Role::return_number, old ? 0x07 : 0x0f);
  returns(Role::returns, old ? 0x38 : 0xf0);
  if (time != 0) fields.push_back({Role::time, FieldType::f64, begin + time, length});
  return fields;
}

}  // namespace

Records las_records(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  const LasHeader header = read_las_header(bytes, name);
  VariableRecords variable;
  try {
    read_variable_records(bytes, header.size, header.variable_records, header.data, false, variable,
                          report);
    read_variable_records(bytes, header.extended, header.extended_records, bytes.size(), true,
                          variable, report);
    use_coordinate_system(variable, report);
  } catch (const Error& error) {
    throw fail(name, error.what());
  }
  const std::string_view laszip = variable.laszip;
  Records records;
  records.bytes = bytes;
  records.count = header.points;
  const std::size_t room = (bytes.size() - header.data) / header.length;
  if (header.packed || !laszip.empty())
    records.laz = unpacker(bytes, header, laszip, name);
  else if (header.points > room)
    throw fail(name, fmt::format("truncated: the header promises {} points, {} fit into the {} "
                                 "bytes; copy the file again",
                                 header.points, room, bytes.size()));
  records.fields = fields_of(bytes, header, records.laz ? 0 : header.data, name);
  report.format = fmt::format("{} {}.{}, point format {}", records.laz ? "LAZ" : "LAS",
                              header.major, header.minor, header.format);
  return records;
}

}  // namespace cloud
