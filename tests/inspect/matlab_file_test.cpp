// The bytes, walked by the format's own description. tests/python/exports_test.py has scipy read
// them.
#include "inspect/matlab_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>

#include "crg/file.h"

namespace matlab_file_test {

struct Matrix {
  std::int32_t rows, columns;
  std::vector<double> by_column;
};

std::map<std::string, Matrix> walk(const std::string& bytes) {
  const auto number = [&](std::size_t at) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  };
  EXPECT_EQ(bytes.substr(124, 4), std::string("\0\1IM", 4));
  std::map<std::string, Matrix> all;
  for (std::size_t at = 128; at < bytes.size();) {
    EXPECT_EQ(number(at), 14U);
    const std::size_t end = at + 8 + number(at + 4);
    EXPECT_EQ(number(at + 16), 6U) << "doubles, neither complex nor logical";
    Matrix matrix{
        static_cast<std::int32_t>(number(at + 32)), static_cast<std::int32_t>(number(at + 36)), {}};
    const std::size_t length = number(at + 44);
    const std::string name = bytes.substr(at + 48, length);
    std::size_t data = at + 48 + (length + 7) / 8 * 8;
    EXPECT_EQ(number(data), 9U);
    matrix.by_column.resize(number(data + 4) / 8);
    std::memcpy(matrix.by_column.data(), bytes.data() + data + 8, 8 * matrix.by_column.size());
    EXPECT_EQ(data + 8 + 8 * matrix.by_column.size(), end);
    EXPECT_EQ(matrix.by_column.size(), static_cast<std::size_t>(matrix.rows * matrix.columns));
    all[name] = matrix;
    at = end;
  }
  return all;
}

TEST(MatlabFile, HasEveryHeightInItsPlace) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.5;
  grid.v_m = {-2.0, -0.5, 1.0, 3.0};
  for (int i = 0; i < 6; ++i) {
    line.x_m.push_back(10.0 + 0.5 * i);
    line.y_m.push_back(20.0);
    line.heading_rad.push_back(0.0);
    line.z_m.push_back(100.0 + i);
    line.banking.push_back(0.01 * i);
    for (int j = 0; j < 4; ++j)
      grid.z_m.push_back(i == 2 && j == 3 ? NAN : static_cast<float>(0.25 * i + 0.125 * j));
  }
  const crg::Surface road(crg::make_crg(line, grid));
  const auto all = walk(road::matlab_file(road));
  ASSERT_EQ(all.size(), 8U);
  const Matrix& z = all.at("z_m");
  ASSERT_EQ(z.rows, 6);
  ASSERT_EQ(z.columns, 4);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 4; ++j) {
      const double here = z.by_column[static_cast<std::size_t>(j * 6 + i)];
      if (i == 2 && j == 3) {
        EXPECT_TRUE(std::isnan(here));
      } else {
        EXPECT_NEAR(here, road.z_at_uv(0.5 * i, grid.v_m[static_cast<std::size_t>(j)]), 1e-9);
      }
    }
  EXPECT_EQ(all.at("v_m").by_column, grid.v_m);
  EXPECT_EQ(all.at("x_m").rows, 6);
  EXPECT_NEAR(all.at("x_m").by_column[5], 12.5, 1e-9);
  EXPECT_EQ(all.at("closed").by_column[0], 0.0);
  EXPECT_EQ(all.at("u_step_m").by_column[0], 0.5);
}

}  // namespace matlab_file_test
