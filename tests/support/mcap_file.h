// MCAP files for tests, laid out from the format's specification and from nothing of ours.
#pragma once

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

namespace support {

template <class T>
std::string raw(T value) {
  std::string out(sizeof(T), '\0');
  std::memcpy(out.data(), &value, sizeof(T));
  return out;
}

inline std::string counted(std::string_view text) {
  return raw(static_cast<std::uint32_t>(text.size())) + std::string(text);
}

inline std::string record(int opcode, const std::string& content) {
  return static_cast<char>(opcode) + raw(static_cast<std::uint64_t>(content.size())) + content;
}

inline std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const unsigned char*>(bytes.data()),
                                          static_cast<uInt>(bytes.size())));
}

inline std::string packed(const std::string& bytes, const std::string& packer) {
  if (packer.empty()) return bytes;
  std::string out(ZSTD_compressBound(bytes.size()) + LZ4F_compressFrameBound(bytes.size(), nullptr),
                  '\0');
  const std::size_t size =
      packer == "zstd"
          ? ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3)
          : LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
  if (size > out.size()) throw std::runtime_error("packing failed");
  out.resize(size);
  return out;
}

inline std::string mcap_schema(int id, const std::string& name, const std::string& encoding,
                               const std::string& text) {
  return record(
      3, raw(static_cast<std::uint16_t>(id)) + counted(name) + counted(encoding) + counted(text));
}

inline std::string mcap_channel(int id, int schema, const std::string& topic,
                                const std::string& encoding) {
  return record(4, raw(static_cast<std::uint16_t>(id)) + raw(static_cast<std::uint16_t>(schema)) +
                       counted(topic) + counted(encoding) + counted(""));
}

inline std::string mcap_message(int channel, std::uint64_t logged_ns, const std::string& data) {
  return record(5, raw(static_cast<std::uint16_t>(channel)) + raw(std::uint32_t{0}) +
                       raw(logged_ns) + raw(logged_ns) + data);
}

inline std::string mcap_chunk(const std::string& records, const std::string& packer = "",
                              std::uint32_t crc = 1) {
  const std::string bytes = packed(records, packer);
  return record(6, raw(std::uint64_t{0}) + raw(std::uint64_t{0}) +
                       raw(static_cast<std::uint64_t>(records.size())) +
                       raw(crc == 1 ? crc_of(records) : crc) + counted(packer) +
                       raw(static_cast<std::uint64_t>(bytes.size())) + bytes);
}

/// A whole file around its data: header, data end with the data's CRC, footer.
inline std::string mcap_file(const std::string& data, bool with_crc = true) {
  const std::string magic("\x89MCAP0\r\n", 8);
  const std::string head = magic + record(1, counted("") + counted("a test")) + data;
  return head + record(15, raw(with_crc ? crc_of(head) : 0u)) +
         record(2, raw(std::uint64_t{0}) + raw(std::uint64_t{0}) + raw(std::uint32_t{0})) + magic;
}

}  // namespace support
