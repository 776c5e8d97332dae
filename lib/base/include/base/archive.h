// Values as bytes and back, for what Kerbstone itself reads again: caches, states, summaries, and
// what one process hands to another. The bytes are: a name and a line feed, a version (32 bits),
// the values one behind the other as they lie in memory (little-endian), a checksum of 64 bits over
// all before it. Counts are 32 bits and stand before what they count.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace base {

static_assert(std::endian::native == std::endian::little, "the bytes are those of the machine");

/// What an archive holds.
struct ArchiveKind {
  std::string_view name;  ///< one line
  std::uint32_t version;
};

/// Every bit moves all those above it, and the fold brings them down again: one changed byte always
/// shows, any other damage but once in 2^64.
inline std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t out = 0x9E3779B97F4A7C15ull ^ bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, bytes.size() - at < 8 ? bytes.size() - at : 8);
    out = (out ^ word) * 0xBF58476D1CE4E5B9ull;
    out ^= out >> 29;
  }
  return out;
}

namespace archive {

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// A matrix or vector of Eigen with a fixed size, without knowing Eigen.
template <class T>
concept FixedMatrix = requires(T& value) {
  requires T::SizeAtCompileTime >
  0;
  requires Number<typename T::Scalar>;
  value.data();
};

/// A rotation of Eigen: its four numbers.
template <class T>
concept Quaternion = requires(T& value) {
  value.coeffs().data(), value.toRotationMatrix();
};

template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t N>
inline constexpr bool is_array<std::array<T, N>> = true;

/// May be copied by the thousand: only numbers, and no gaps.
template <class T>
constexpr bool lies_flat() {
  if constexpr (std::is_same_v<T, bool>)
    return false;  // of its 256 values two are good
  else if constexpr (Number<T>)
    return true;
  else if constexpr (is_array<T>)
    return lies_flat<typename T::value_type>();
  else if constexpr (FixedMatrix<T>)
    return sizeof(T) == T::SizeAtCompileTime * sizeof(typename T::Scalar);
  else
    return false;
}

}  // namespace archive

/// Puts values one behind the other: numbers, enumerations, texts, optionals, arrays, vectors, maps
/// by text, matrices of fixed size, and every struct that has a function
/// `template <class Archive, class Value> void fields(Archive&, Value&)` beside it, which calls the
/// archive with its members.
class ArchiveWriter {
 public:
  explicit ArchiveWriter(ArchiveKind kind) : bytes_(kind.name) {
    bytes_ += '\n';
    put(kind.version);
  }
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  /// All bytes, with the checksum behind. The writer is empty then.
  std::string finish() {
    put(checksum(bytes_));
    return std::move(bytes_);
  }

 private:
  void raw(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  void count(std::size_t n) {
    if (n > std::numeric_limits<std::uint32_t>::max())
      throw std::length_error("more than 2^32 values in one list of an archive");
    put(static_cast<std::uint32_t>(n));
  }
  template <class T>
  void put(const T& value) {
    if constexpr (archive::lies_flat<T>() || std::is_same_v<T, bool>)
      raw(&value, sizeof value);
    else if constexpr (archive::is_array<T>)
      for (const auto& part : value) put(part);
    else if constexpr (archive::FixedMatrix<T>)
      raw(value.data(), T::SizeAtCompileTime * sizeof(typename T::Scalar));
    else if constexpr (archive::Quaternion<T>)
      put(value.coeffs());
    else
      fields(*this, value);
  }
  void put(const std::string& text) {
    count(text.size());
    bytes_ += text;
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    count(values.size());
    if constexpr (archive::lies_flat<T>())
      raw(values.data(), values.size() * sizeof(T));
    else
      for (const T& value : values) put(value);
  }
  template <class T>
  void put(const std::map<std::string, T>& values) {
    count(values.size());
    for (const auto& [name, value] : values) put(name), put(value);
  }

  std::string bytes_;
};

/// Takes the same values from bytes of anybody. Where they are not what the kind says, good() is
/// false from then on, values keep what they have, and problem() says why. Never makes more room
/// than the bytes pay for: a list is as long as its bytes allow, or refused. Whether the values
/// make sense is for the caller to look at, enumerations among them.
class ArchiveReader {
 public:
  ArchiveReader(std::string_view bytes, ArchiveKind kind) : left_(bytes) { open(bytes, kind); }
  template <class... T>
  void operator()(T&... values) {
    (take(values), ...);
  }
  bool good() const { return problem_.empty(); }
  /// After the last value: whether all was good, and nothing is left.
  bool finish() {
    if (good() && !left_.empty()) fail("more bytes seen than wanted");
    return good();
  }
  const std::string& problem() const { return problem_; }

 private:
  static constexpr const char* kCutShort = "fewer bytes seen than wanted: damaged or cut short";

  void open(std::string_view bytes, ArchiveKind kind) {
    if (!bytes.starts_with(kind.name) || bytes.substr(kind.name.size(), 1) != "\n")
      return fail("it does not begin with '" + std::string(kind.name) + "'");
    left_.remove_prefix(kind.name.size() + 1);
    std::uint32_t version = 0;
    take(version);
    if (!good()) return;
    if (version != kind.version)
      return fail("version " + std::to_string(version) + " seen, " + std::to_string(kind.version) +
                  " wanted");
    std::uint64_t check = 0;
    if (left_.size() < sizeof check) return fail(kCutShort);
    std::memcpy(&check, bytes.data() + bytes.size() - sizeof check, sizeof check);
    left_.remove_suffix(sizeof check);
    if (check != checksum(bytes.substr(0, bytes.size() - sizeof check)))
      fail("damaged or cut short: its checksum is not that of its bytes");
  }
  void fail(std::string why) { problem_ = std::move(why); }
  /// Whether there are so many bytes; then they may be taken.
  bool has(std::size_t size) {
    if (good() && size > left_.size()) fail(kCutShort);
    return good();
  }
  void raw(void* to, std::size_t size) {
    if (!has(size) || size == 0) return;
    std::memcpy(to, left_.data(), size);
    left_.remove_prefix(size);
  }
  /// Of things that take at least so many bytes each.
  std::size_t count(std::size_t least_bytes) {
    std::uint32_t n = 0;
    take(n);
    return has(n * least_bytes) ? n : 0;
  }
  template <class T>
  void take(T& value) {
    if constexpr (archive::lies_flat<T>())
      raw(&value, sizeof value);
    else if constexpr (archive::is_array<T>)
      for (auto& part : value) take(part);
    else if constexpr (archive::FixedMatrix<T>)
      raw(value.data(), T::SizeAtCompileTime * sizeof(typename T::Scalar));
    else if constexpr (archive::Quaternion<T>)
      take(value.coeffs());
    else
      fields(*this, value);
  }
  void take(bool& value) {
    std::uint8_t seen = value ? 1 : 0;
    take(seen);
    if (seen > 1) fail("a mark of " + std::to_string(seen) + " seen, 0 or 1 wanted");
    if (good()) value = seen == 1;
  }
  void take(std::string& text) {
    const std::size_t size = count(1);
    if (!good()) return;
    text.resize(size);
    raw(text.data(), size);
  }
  template <class T>
  void take(std::optional<T>& value) {
    bool there = false;
    take(there);
    if (!good()) return;
    value.reset();
    if (!there) return;
    T inside{};  // not in place: gcc 12 takes what emplace() then destroys for uninitialised
    take(inside);
    value = std::move(inside);
  }
  template <class T>
  void take(std::vector<T>& values) {
    if constexpr (archive::lies_flat<T>()) {
      const std::size_t size = count(sizeof(T));
      if (!good()) return;
      values.resize(size);
      raw(values.data(), size * sizeof(T));
    } else {
      const std::size_t size = count(1);
      if (!good()) return;
      values.clear();
      for (std::size_t i = 0; i < size && good(); ++i) take(values.emplace_back());
    }
  }
  template <class T>
  void take(std::map<std::string, T>& values) {
    const std::size_t size = count(1);
    for (std::size_t i = 0; i < size && good(); ++i) {
      std::string name;
      take(name);
      if (good()) take(values[name]);
    }
  }

  std::string_view left_;
  std::string problem_;
};

}  // namespace base
