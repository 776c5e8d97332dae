// Zip archives in memory, as units are.
#pragma once

#include <string>
#include <vector>

namespace fmu {

struct ArchiveFile {
  std::string name;  ///< path within the archive, with /
  std::string bytes;
};

/// A zip of these files in this order, deflated, dated 1980-01-01: the same files give the same
/// bytes. Throws base::Error when zip cannot hold them.
std::string make_archive(const std::vector<ArchiveFile>& files);

}  // namespace fmu
