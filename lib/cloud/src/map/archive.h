// Values as bytes, for files that only the same program reads again. One function names the fields
// of a struct for both ways.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "cloud/error.h"

namespace cloud {

static_assert(std::endian::native == std::endian::little, "the bytes are those of the machine");

template <typename T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Appends values to bytes.
class Keeper {
 public:
  template <typename... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  std::string bytes;

 private:
  template <Plain T>
  void put(const T& value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  }
  template <typename T, int Rows, int Columns>
  void put(const Eigen::Matrix<T, Rows, Columns>& value) {
    for (Eigen::Index k = 0; k < value.size(); ++k) put(value.data()[k]);
  }
  void put(const Eigen::Quaterniond& value) { put(value.coeffs()); }
  template <typename T, std::size_t N>
  void put(const std::array<T, N>& values) {
    for (const T& value : values) put(value);
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    put(values.size());
    for (const T& value : values) put(value);
  }
  void put(const std::string& value) {
    put(value.size());
    bytes += value;
  }
  template <typename T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  /// A struct: by its fields().
  template <typename T>
  requires requires(Keeper& keeper, T& value) { fields(keeper, value); }
  void put(const T& value) { fields(*this, value); }
};

/// Takes the same values from bytes. Throws Error where these end too early; never makes more room
/// than the bytes fill.
class Taker {
 public:
  explicit Taker(std::string_view bytes) : left_(bytes) {}
  template <typename... T>
  void operator()(T&... values) {
    (take(values), ...);
  }
  /// Throws Error where bytes are left.
  void finish() const {
    if (!left_.empty()) throw Error("more bytes seen than wanted: of another version");
  }

 private:
  const char* next(std::size_t size) {
    if (size > left_.size()) throw Error("fewer bytes seen than wanted: damaged, or cut short");
    const char* const at = left_.data();
    left_.remove_prefix(size);
    return at;
  }
  template <Plain T>
  void take(T& value) {
    std::memcpy(&value, next(sizeof value), sizeof value);
  }
  template <typename T, int Rows, int Columns>
  void take(Eigen::Matrix<T, Rows, Columns>& value) {
    for (Eigen::Index k = 0; k < value.size(); ++k) take(value.data()[k]);
  }
  void take(Eigen::Quaterniond& value) { take(value.coeffs()); }
  template <typename T, std::size_t N>
  void take(std::array<T, N>& values) {
    for (T& value : values) take(value);
  }
  template <typename T>
  void take(std::vector<T>& values) {
    std::size_t size = 0;
    take(size);
    if (size > left_.size()) next(size);  // every value has a byte at least
    values.clear();
    for (std::size_t k = 0; k < size; ++k) take(values.emplace_back());
  }
  void take(std::string& value) {
    std::size_t size = 0;
    take(size);
    value.assign(next(size), size);
  }
  template <typename T>
  void take(std::optional<T>& value) {
    bool there = false;
    take(there);
    value.reset();
    if (there) take(value.emplace());
  }
  template <typename T>
  requires requires(Taker& taker, T& value) { fields(taker, value); }
  void take(T& value) { fields(*this, value); }

  std::string_view left_;
};

}  // namespace cloud
