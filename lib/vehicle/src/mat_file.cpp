// The only file that knows matio.
#include <fmt/format.h>
#include <matio.h>

#include <memory>

#include "map_file.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

template <class T>
void copy_transposed(const void* data, Matrix& out) {
  const T* const from = static_cast<const T*>(data);
  for (std::size_t r = 0; r < out.rows; ++r)
    for (std::size_t c = 0; c < out.columns; ++c)
      out.values[r * out.columns + c] = static_cast<double>(from[c * out.rows + r]);
}

}  // namespace

Matrix read_mat_variable(const std::string& path, const std::string& name) {
  constexpr std::size_t kMostValues = 10'000'000;
  const std::unique_ptr<mat_t, int (*)(mat_t*)> file(Mat_Open(path.c_str(), MAT_ACC_RDONLY),
                                                     &Mat_Close);
  if (!file) throw Error(path + ": cannot open as a MATLAB file");
  const auto free_variable = [](matvar_t* v) { Mat_VarFree(v); };
  const std::unique_ptr<matvar_t, decltype(free_variable)> info(
      Mat_VarReadInfo(file.get(), name.c_str()), free_variable);
  if (!info) throw Error(fmt::format("{}: no variable '{}'", path, name));
  if (info->rank != 2 || info->isComplex != 0 || info->dims == nullptr)
    throw Error(fmt::format("{}: '{}' is not a real matrix of two dimensions", path, name));
  Matrix out;
  out.rows = info->dims[0];
  out.columns = info->dims[1];
  if (out.rows == 0 || out.columns == 0 || out.rows > kMostValues / out.columns)
    throw Error(fmt::format("{}: '{}' is {} x {}, wanted 1 to {} values", path, name, out.rows,
                            out.columns, kMostValues));
  const std::unique_ptr<matvar_t, decltype(free_variable)> variable(
      Mat_VarRead(file.get(), name.c_str()), free_variable);
  if (!variable || variable->data == nullptr ||
      variable->nbytes < out.rows * out.columns * static_cast<std::size_t>(variable->data_size))
    throw Error(fmt::format("{}: cannot read '{}'; the file is damaged or cut off", path, name));
  out.values.resize(out.rows * out.columns);
  switch (variable->data_type) {
    case MAT_T_DOUBLE:
      copy_transposed<double>(variable->data, out);
      break;
    case MAT_T_SINGLE:
      copy_transposed<float>(variable->data, out);
      break;
    case MAT_T_INT32:
      copy_transposed<std::int32_t>(variable->data, out);
      break;
    case MAT_T_UINT32:
      copy_transposed<std::uint32_t>(variable->data, out);
      break;
    case MAT_T_INT16:
      copy_transposed<std::int16_t>(variable->data, out);
      break;
    case MAT_T_UINT16:
      copy_transposed<std::uint16_t>(variable->data, out);
      break;
    case MAT_T_INT8:
      copy_transposed<std::int8_t>(variable->data, out);
      break;
    case MAT_T_UINT8:
      copy_transposed<std::uint8_t>(variable->data, out);
      break;
    default:
      throw Error(fmt::format("{}: '{}' does not hold numbers of a known type", path, name));
  }
  return out;
}

}  // namespace vehicle
