// Packed parts of logs, unpacked within bounds.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace recording {

/// Whether the bytes begin as a zstd frame does.
bool is_zstd(std::string_view bytes);

/// The bytes that a zstd stream or an LZ4 frame holds, at most `most` of them: room is made as they
/// come, not on the word of a header. Throws base::Error, without a file's name: "packed by zstd,
/// and damaged".
std::string unpack_zstd(std::string_view bytes, std::size_t most);
std::string unpack_lz4(std::string_view bytes, std::size_t most);

/// How much all packed parts of a file of `bytes` may hold together: no log that is one packs
/// better.
constexpr std::size_t most_unpacked(std::size_t bytes) {
  constexpr std::size_t kSmall = std::size_t{16} << 20, kLargest = std::size_t{8} << 30;
  const std::size_t by_size = bytes > kLargest / 1000 ? kLargest : kSmall + 1000 * bytes;
  return by_size < kLargest ? by_size : kLargest;
}

}  // namespace recording
