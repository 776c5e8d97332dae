#include "inspect/matlab_file.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <functional>
#include <string_view>

#include "mesh/error.h"

namespace road {
namespace {

// Kinds of data elements and the class of an array of doubles (MAT-File Format, level 5).
constexpr std::uint32_t kInt8 = 1, kInt32 = 5, kUint32 = 6, kDouble = 9, kMatrix = 14;
constexpr std::uint32_t kDoubleClass = 6;
constexpr std::size_t kMostBytes = 0x7fffffff;

template <typename Unsigned>
void put_bytes(std::string& to, Unsigned value) {
  for (std::size_t byte = 0; byte < sizeof value; ++byte)
    to.push_back(static_cast<char>((value >> (8 * byte)) & 0xffU));
}

void put_tag(std::string& to, std::uint32_t kind, std::size_t bytes) {
  put_bytes(to, kind);
  put_bytes(to, static_cast<std::uint32_t>(bytes));
}

void pad(std::string& to) {
  while (to.size() % 8 != 0) to.push_back('\0');
}

/// rows x columns numbers, column by column.
void put_matrix(std::string& to, std::string_view name, std::size_t rows, std::size_t columns,
                const std::function<double(std::size_t, std::size_t)>& value) {
  const std::size_t number_bytes = 8 * rows * columns, name_bytes = (name.size() + 7) / 8 * 8;
  put_tag(to, kMatrix, 16 + 16 + 8 + name_bytes + 8 + number_bytes);
  put_tag(to, kUint32, 8);
  put_bytes(to, kDoubleClass);
  put_bytes(to, std::uint32_t{0});
  put_tag(to, kInt32, 8);
  put_bytes(to, static_cast<std::uint32_t>(rows));
  put_bytes(to, static_cast<std::uint32_t>(columns));
  put_tag(to, kInt8, name.size());
  to += name;
  pad(to);
  put_tag(to, kDouble, number_bytes);
  for (std::size_t j = 0; j < columns; ++j)
    for (std::size_t i = 0; i < rows; ++i) put_bytes(to, std::bit_cast<std::uint64_t>(value(i, j)));
}

}  // namespace

std::string matlab_file(const crg::Surface& road) {
  const crg::ReferenceLine& line = road.reference_line();
  const crg::Grid& grid = road.grid();
  const std::size_t rows = grid.rows(), columns = grid.columns();
  if (rows > kMostBytes / 8 / columns)
    throw Error(fmt::format(
        "{} rows of {} columns are more than 2 GB of doubles, which MAT files of level 5 cannot "
        "hold; crop or resample the road",
        rows, columns));
  std::string bytes = "MATLAB 5.0 MAT-file, a road (OpenCRG): metres, radians; z_m(row, column)";
  bytes.resize(124, ' ');
  bytes.replace(116, 8, 8, '\0');  // no subsystem's data
  put_bytes(bytes, std::uint16_t{0x0100});
  bytes += "IM";
  const auto scalar = [&](std::string_view name, double value) {
    put_matrix(bytes, name, 1, 1, [&](std::size_t, std::size_t) { return value; });
  };
  const auto column = [&](std::string_view name, const std::vector<double>& values) {
    put_matrix(bytes, name, rows, 1, [&](std::size_t i, std::size_t) { return values[i]; });
  };
  scalar("u_begin_m", line.u_begin_m);
  scalar("u_step_m", line.u_step_m);
  scalar("closed", line.closed ? 1.0 : 0.0);
  column("x_m", line.x_m);
  column("y_m", line.y_m);
  column("heading_rad", line.heading_rad);
  put_matrix(bytes, "v_m", 1, columns, [&](std::size_t, std::size_t j) { return grid.v_m[j]; });
  put_matrix(bytes, "z_m", rows, columns, [&](std::size_t i, std::size_t j) {
    const double lift = line.z_m.empty() ? 0.0 : line.z_m[i],
                 banking = line.banking.empty() ? 0.0 : line.banking[i];
    return static_cast<double>(grid.z_m[i * columns + j]) + lift + banking * grid.v_m[j];
  });
  return bytes;
}

}  // namespace road
