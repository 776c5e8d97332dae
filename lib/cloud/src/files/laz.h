// Compressed LAS: the records of a .laz as those of a .las. Chunked and layered files (LASzip
// compressors 1 to 3, item versions 1 to 4), point formats 0 to 3 and 6 to 10, extra bytes. What
// points of formats 9 and 10 say of their waveforms is passed over: it is that of the chunk's
// first point.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace cloud {

/// What a header says of its compressed points.
struct LazLayout {
  std::string_view vlr;     ///< the record "laszip encoded"
  int format = 0;           ///< of the points, without the bits that mark compression
  std::size_t data = 0;     ///< byte at which the points begin
  std::size_t length = 0;   ///< of a record, bytes
  std::uint64_t count = 0;  ///< of points
};

/// Unpacks from front to back. Throws Error naming the byte: another compression, a chunk
/// table or layers that do not fit the file, a stream that ends too early, too late or is none.
/// Memory: the chunk table and the models of one chunk.
class LazReader {
 public:
  /// `file` must live as long; `name` is for errors.
  LazReader(std::string_view file, const LazLayout& layout, std::string name);
  ~LazReader();
  /// The next `count` records, one after the other. No more than the layout's count in all.
  void read(std::size_t count, std::string& records);
  /// Where the chunk begins that is being read.
  std::size_t chunk_begin() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloud
