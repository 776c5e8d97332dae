// Packs a .las into a .laz by an encoder of its own: what lib/cloud unpacks is checked against it,
// and it against files that LASzip wrote, byte for byte.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace support {

struct LazOptions {
  int version = 0;  ///< of the items: 1 or 2 for point formats 0 to 3, 3 or 4 for 6 to 8; 0: 2 or 3
  std::uint32_t chunk_points = 50000;
  std::vector<std::uint32_t> chunks = {};  ///< their points, one by one; in place of chunk_points
  bool chunked = true;                     ///< false: compressor 1
  bool table_at_end = false;               ///< as a writer that cannot go back
};

/// `las`: point formats 0 to 3 and 6 to 10, extra bytes too; waveforms of 9 and 10 are no code.
std::string as_laz(const std::string& las, const LazOptions& options = {});

/// A .las in which every field of every point moves: pulses of several returns, several scanner
/// channels, clocks that jump, coordinates at the ends of their range. `channels`: 1 to 4.
std::string busy_las(int format, std::size_t extra_bytes, std::size_t points, unsigned seed,
                     unsigned channels = 4);

}  // namespace support
