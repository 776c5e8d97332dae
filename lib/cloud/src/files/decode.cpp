#include "decode.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace cloud {
namespace {

template <typename T>
double value_of(const char* from, bool swap) {
  T value;
  std::memcpy(&value, from, sizeof value);
  if (swap) {
    char bytes[sizeof value];
    std::memcpy(bytes, from, sizeof value);
    std::reverse(bytes, bytes + sizeof value);
    std::memcpy(&value, bytes, sizeof value);
  }
  return static_cast<double>(value);
}

template <typename T>
void decode(const char* from, const Field& field, std::size_t count, bool swap, double* out) {
  for (std::size_t i = 0; i < count; ++i, from += field.stride)
    *out++ = value_of<T>(from, swap) * field.scale + field.add;
}

/// `from`: the field of the first of `count` points.
void decode(const char* from, const Field& field, std::size_t count, bool swap, double* out) {
  switch (field.type) {
    case FieldType::i8:
      return decode<std::int8_t>(from, field, count, swap, out);
    case FieldType::u8:
      return decode<std::uint8_t>(from, field, count, swap, out);
    case FieldType::i16:
      return decode<std::int16_t>(from, field, count, swap, out);
    case FieldType::u16:
      return decode<std::uint16_t>(from, field, count, swap, out);
    case FieldType::i32:
      return decode<std::int32_t>(from, field, count, swap, out);
    case FieldType::u32:
      return decode<std::uint32_t>(from, field, count, swap, out);
    case FieldType::i64:
      return decode<std::int64_t>(from, field, count, swap, out);
    case FieldType::u64:
      return decode<std::uint64_t>(from, field, count, swap, out);
    case FieldType::f32:
      return decode<float>(from, field, count, swap, out);
    case FieldType::f64:
      return decode<double>(from, field, count, swap, out);
  }
}

/// First field of each role that matters.
std::vector<Field> wanted_fields(const Records& records) {
  std::vector<Field> wanted;
  bool seen[kRoles] = {};
  for (const Field& field : records.fields) {
    if (field.role == Role::none || seen[static_cast<std::size_t>(field.role)]) continue;
    seen[static_cast<std::size_t>(field.role)] = true;
    wanted.push_back(field);
  }
  return wanted;
}

}  // namespace

void read_binary(const Records& records, std::size_t chunk_points, Emitter& emit,
                 const std::function<void(std::size_t)>& done) {
  const std::vector<Field> fields = wanted_fields(records);
  Raw raw;
  std::string unpacked;
  for (std::size_t begin = 0; begin < records.count; begin += chunk_points) {
    const std::size_t end = std::min(records.count, begin + chunk_points);
    raw.size = end - begin;
    if (records.laz) records.laz->read(raw.size, unpacked);
    for (const Field& field : fields) {
      std::vector<double>& out = raw.of[static_cast<std::size_t>(field.role)];
      out.resize(raw.size);
      const char* const from =
          records.laz ? unpacked.data() : records.bytes.data() + begin * field.stride;
      decode(from + field.offset, field, raw.size, records.big_endian, out.data());
      if (field.mask != 0xff)
        for (double& v : out)
          v = static_cast<double>((static_cast<std::uint8_t>(v) & field.mask) >>
                                  std::countr_zero(field.mask));
    }
    emit(raw, static_cast<double>(end) / static_cast<double>(records.count));
    if (records.laz)
      done(records.laz->chunk_begin());
    else if (records.owned.empty())
      done(fields.front().offset + end * fields.front().stride);
  }
}

}  // namespace cloud
