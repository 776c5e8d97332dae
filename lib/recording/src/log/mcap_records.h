// What readers and writers of MCAP share: the magic, the records, their CRCs.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string_view>

namespace recording {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

enum Opcode {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 11,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd
};

inline std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

}  // namespace recording
