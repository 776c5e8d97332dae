// Which sections are being read: the means of one are made when others have taken its place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace cloud {

/// The last eight sections that points came for are open. One that comes again after it was closed
/// (scans that go over the road file by file) begins another visit, whose means are its own.
class Visits {
 public:
  explicit Visits(std::size_t sections) : number_(sections, 0) {}
  struct Seen {
    std::uint8_t number = 0;            ///< of the section's visit, modulo 256: two in a row differ
    std::optional<std::size_t> closed;  ///< the section that had to make room
  };
  /// A point of this section came.
  Seen operator()(std::size_t section);

 private:
  std::map<std::size_t, std::uint64_t> last_use_;  ///< of those open
  std::vector<std::uint8_t> number_;
  std::uint64_t clock_ = 0;
};

}  // namespace cloud
