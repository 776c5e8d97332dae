// A cloud file as records: where the fields of point i lie in its bytes. One decoder serves all
// binary formats; each header reader only fills this in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/read_cloud.h"
#include "laz.h"

namespace cloud {

enum class FieldType : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };
std::size_t size_of(FieldType type);

/// Which value of a point a field holds.
enum class Role : std::uint8_t {
  x,
  y,
  z,
  time,
  intensity,
  classification,  ///< numbered as ASPRS does
  sigma,
  label,  ///< a class of whatever numbering
  withheld,
  synthetic,
  overlap,  ///< this and the two before: not 0 for yes
  return_number,
  returns,  ///< of the pulse
  none
};
/// "x", "X", "x_m", "time", "gps_time", "t", "timestamp", "intensity", "classification",
/// "sigma", "label", "withheld" ...
Role role_of(std::string name);

/// For coordinates in degrees: what was seen, and the way out.
[[noreturn]] void refuse_degrees(const std::string& seen);
/// The same for a file with such a column.
[[noreturn]] void refuse_angle(const std::string& name, const std::string& column);

/// Throws Error naming `name` unless there is one of x, of y and of z.
void require_xyz(const std::vector<Role>& roles, const std::string& name);

struct Records;
/// "origin_m X Y Z" in a comment of the header, as write_cloud() leaves it: added to x, y, z.
void add_origin(const std::vector<std::string>& words, Records& records);

struct Field {
  Role role = Role::none;
  FieldType type = FieldType::f32;
  std::size_t offset = 0;  ///< of point 0's value from the begin of the bytes
  std::size_t stride = 0;  ///< from one point to the next
  double scale = 1.0, add = 0.0;
  std::uint8_t mask = 0xff;  ///< bits of a byte that are the value
};

struct Records {
  std::string_view bytes;  ///< of the file, or of `owned`
  std::string owned;       ///< what had to be unpacked first
  /// Hands out the records piece by piece; fields' offsets are then those in a record.
  std::shared_ptr<LazReader> laz;
  std::size_t count = 0;
  bool big_endian = false;
  std::vector<Field> fields;
  bool text = false;  ///< numbers in lines instead; columns[k] is the role of column k
  std::vector<Role> columns;
  std::size_t text_begin = 0;
  std::size_t first_line = 1;
  bool named = false;    ///< of text: columns by a header, which rows are as long as
  bool counted = false;  ///< text: `count` points are promised
};

/// Each throws Error naming `name`. They fill in the report's format, unit and remarks.
Records las_records(std::string_view bytes, const std::string& name, CloudReadReport& report);
Records ply_records(std::string_view bytes, const std::string& name, CloudReadReport& report);
Records pcd_records(std::string_view bytes, const std::string& name, CloudReadReport& report);

}  // namespace cloud
