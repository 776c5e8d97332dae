// MATLAB files of level 4 and 5 (save -v4, -v6, -v7): "MAT-File Format", The MathWorks, R2023b. By
// hand because libmatio reserves and clears what a damaged file promises: gigabytes, for minutes.
// The only file that knows zlib.
#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "base/read_file.h"
#include "map_file.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

constexpr std::size_t kLargestMatBytes = 64u << 20, kMostValues = 1'000'000,
                      kMostUnpacked = 64u << 20;

enum Type : std::uint32_t {
  kInt8 = 1,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kSingle,
  kDouble = 9,
  kInt64 = 12,
  kUint64,
  kMatrix,
  kPacked
};

/// Numbers out of bytes; `swap` where the file has the other order.
template <class T>
T number_at(std::string_view bytes, std::size_t offset, bool swap) {
  char raw[sizeof(T)];
  for (std::size_t k = 0; k < sizeof(T); ++k)
    raw[k] = bytes[offset + (swap ? sizeof(T) - 1 - k : k)];
  return std::bit_cast<T>(raw);
}

/// Numbers of one type, column after column, as rows.
class Reader {
 public:
  Reader(std::string path, std::string name) : path_(std::move(path)), name_(std::move(name)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}: {}", path_, what));
  }

  Matrix matrix(std::uint64_t rows, std::uint64_t columns, std::uint32_t type,
                std::string_view data, bool swap) const {
    if (rows == 0 || columns == 0 || rows > kMostValues || columns > kMostValues / rows)
      fail(
          fmt::format("'{}' is {} x {}, wanted 1 to {} values", name_, rows, columns, kMostValues));
    Matrix out;
    out.rows = rows, out.columns = columns;
    switch (type) {
      case kInt8:
        return filled<std::int8_t>(out, data, swap);
      case kUint8:
        return filled<std::uint8_t>(out, data, swap);
      case kInt16:
        return filled<std::int16_t>(out, data, swap);
      case kUint16:
        return filled<std::uint16_t>(out, data, swap);
      case kInt32:
        return filled<std::int32_t>(out, data, swap);
      case kUint32:
        return filled<std::uint32_t>(out, data, swap);
      case kSingle:
        return filled<float>(out, data, swap);
      case kDouble:
        return filled<double>(out, data, swap);
      case kInt64:
        return filled<std::int64_t>(out, data, swap);
      case kUint64:
        return filled<std::uint64_t>(out, data, swap);
      default:
        fail(fmt::format("'{}' does not hold numbers of a known type", name_));
    }
  }

  const std::string& name() const { return name_; }

 private:
  template <class T>
  Matrix filled(Matrix& out, std::string_view data, bool swap) const {
    if (data.size() / sizeof(T) < out.rows * out.columns)
      fail(fmt::format("cannot read '{}'; the file is damaged or cut off", name_));
    out.values.resize(out.rows * out.columns);
    for (std::size_t r = 0; r < out.rows; ++r)
      for (std::size_t c = 0; c < out.columns; ++c)
        out.values[r * out.columns + c] =
            static_cast<double>(number_at<T>(data, (c * out.rows + r) * sizeof(T), swap));
    return std::move(out);
  }
  std::string path_, name_;
};

/// Level 4: one variable after the other, 5 integers, the name, the values.
std::optional<Matrix> find_level4(std::string_view bytes, const Reader& reader) {
  constexpr std::uint32_t kTypes[] = {kDouble, kSingle, kInt32, kInt16, kUint16, kUint8};
  constexpr std::size_t kSizes[] = {8, 4, 4, 2, 2, 1};
  while (bytes.size() >= 20) {
    std::uint32_t head[5];
    const bool swap = number_at<std::uint32_t>(bytes, 0, false) > 9999;
    for (std::size_t k = 0; k < 5; ++k) head[k] = number_at<std::uint32_t>(bytes, 4 * k, swap);
    const std::uint32_t numbers = head[0] / 1000, format = head[0] % 100 / 10, kind = head[0] % 10;
    if (head[0] > 4052 || head[0] % 1000 / 100 != 0 || format > 5 || head[3] > 1 ||
        head[4] > bytes.size() - 20)
      reader.fail("no MATLAB file of level 4, 5 or 7, or a damaged one; save it with -v7");
    if (numbers > 1)  // 0 and 1 are IEEE's, little and big-endian
      reader.fail(fmt::format("numbers of a {}, wanted those of IEEE; save it with -v7",
                              numbers == 4 ? "Cray" : "VAX"));
    std::string_view name = bytes.substr(20, head[4]);
    name = name.substr(0, name.find('\0'));
    bytes.remove_prefix(20 + head[4]);
    if (name == reader.name()) {
      if (kind != 0 || head[3] != 0)
        reader.fail(fmt::format("'{}' is not a real matrix of two dimensions", name));
      return reader.matrix(head[1], head[2], kTypes[format], bytes, swap);
    }
    // Two factors below 2^32 and at most 16 bytes each: divide, so that nothing runs over.
    const std::size_t each = kSizes[format] * (head[3] + 1);
    if (head[1] != 0 && head[2] > bytes.size() / each / head[1]) return std::nullopt;
    bytes.remove_prefix(each * head[1] * head[2]);
  }
  return std::nullopt;
}

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

/// Level 5: takes the next element off; nothing at the end or where it is cut off.
std::optional<Element> take_element(std::string_view& bytes, bool swap) {
  if (bytes.size() < 8) return std::nullopt;
  const auto first = number_at<std::uint32_t>(bytes, 0, swap);
  Element element{first & 0xffff, {}};
  if (const std::uint32_t small = first >> 16; small != 0) {
    if (small > 4) return std::nullopt;
    element.data = bytes.substr(4, small);
    bytes.remove_prefix(8);
    return element;
  }
  const auto size = number_at<std::uint32_t>(bytes, 4, swap);
  if (size > bytes.size() - 8) return std::nullopt;
  element.data = bytes.substr(8, size);
  const std::size_t padded = element.type == kPacked ? size : (std::size_t{size} + 7) / 8 * 8;
  bytes.remove_prefix(std::min(bytes.size(), 8 + padded));
  return element;
}

std::optional<Matrix> matrix_of_element(std::string_view bytes, bool swap, const Reader& reader) {
  const auto flags = take_element(bytes, swap), size = take_element(bytes, swap),
             name = take_element(bytes, swap);
  if (!flags || !size || !name || flags->data.size() < 8 || name->data != reader.name())
    return std::nullopt;
  const auto word = number_at<std::uint32_t>(flags->data, 0, swap);
  constexpr std::uint32_t kFirstNumeric = 6, kLastNumeric = 15, kComplex = 0x800;
  if ((word & 0xff) < kFirstNumeric || (word & 0xff) > kLastNumeric || (word & kComplex) != 0 ||
      size->data.size() != 8)
    reader.fail(fmt::format("'{}' is not a real matrix of two dimensions", reader.name()));
  const auto values = take_element(bytes, swap);
  return reader.matrix(
      number_at<std::uint32_t>(size->data, 0, swap), number_at<std::uint32_t>(size->data, 4, swap),
      values ? values->type : kDouble, values ? values->data : std::string_view(), swap);
}

std::string unpacked(std::string_view packed, std::size_t& room, const Reader& reader) {
  std::string out;
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  char block[1 << 14];
  int state = Z_OK;
  while (state == Z_OK && out.size() <= room) {
    stream.next_out = reinterpret_cast<Bytef*>(block);
    stream.avail_out = sizeof block;
    state = inflate(&stream, Z_NO_FLUSH);
    out.append(block, sizeof block - stream.avail_out);
  }
  inflateEnd(&stream);
  if (out.size() > room)
    reader.fail(fmt::format("more than {} bytes when unpacked, wanted a map", kMostUnpacked));
  room -= out.size();
  return out;  // as far as it goes: what is missing shows where it is read
}

std::optional<Matrix> find_level5(std::string_view bytes, const Reader& reader) {
  const bool swap = bytes.substr(126, 2) == "MI";
  if (!swap && bytes.substr(126, 2) != "IM")
    reader.fail("a damaged MATLAB file, or one of level 7.3; save it with -v7");
  bytes.remove_prefix(128);
  std::size_t room = kMostUnpacked;
  while (const auto element = take_element(bytes, swap)) {
    std::optional<Matrix> found;
    if (element->type == kMatrix) found = matrix_of_element(element->data, swap, reader);
    if (element->type == kPacked) {
      const std::string whole = unpacked(element->data, room, reader);
      std::string_view inner = whole;
      if (const auto packed = take_element(inner, swap); packed && packed->type == kMatrix)
        found = matrix_of_element(packed->data, swap, reader);
    }
    if (found) return found;
  }
  return std::nullopt;
}

}  // namespace

Matrix read_mat_variable(const std::string& path, const std::string& name) {
  const std::string bytes = base::read_file(path, kLargestMatBytes);
  const Reader reader(path, name);
  if (bytes.size() < 20) reader.fail("too short for a MATLAB file");
  // Level 5 begins with text, level 4 with a number that has a zero byte.
  const bool text = std::string_view(bytes).substr(0, 4).find('\0') == std::string_view::npos;
  if (text && bytes.size() < 128) reader.fail("too short for a MATLAB file");
  std::optional<Matrix> found = text ? find_level5(bytes, reader) : find_level4(bytes, reader);
  if (!found) reader.fail(fmt::format("no variable '{}', or the file is damaged before it", name));
  return std::move(*found);
}

}  // namespace vehicle
