// The files that a mesh refers to. Private to the mesh readers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raw_mesh.h"

namespace road {

/// What a reader wants beside the mesh: seen while it reads.
class Companions {
 public:
  /// Files may lie anywhere if `allow_outside`, else below the folder of the mesh. `opened` is told
  /// the size of each that is read.
  Companions(const std::string& mesh_path, bool allow_outside,
             std::function<void(std::size_t)> opened);

  /// Whether it is there and may be read; if not, keeps its name.
  bool exists(const std::string& path);

  /// Its bytes, or nothing: it is not there, may not be read or cannot be; which of them is kept.
  std::optional<std::string> read(const std::string& path,
                                  std::size_t most_bytes = kLargestMeshFile);

  /// Throws for a file with geometry that lies outside; gives a remark for each that is for looks
  /// only.
  std::vector<std::string> remarks_on_outside() const;

  const std::filesystem::path& folder() const { return folder_; }  ///< of the mesh, canonical
  const std::vector<MeshFile>& files() const { return files_; }    ///< as in MeshReadReport
  /// One sentence for each that is there and could not be read.
  const std::vector<std::string>& problems() const { return problems_; }
  const std::vector<std::string>& outside() const { return outside_; }

 private:
  bool may_open(const std::string& path);
  void add(const std::string& path, const std::string& sha256);

  std::string mesh_path_;
  std::filesystem::path folder_;
  bool allow_outside_;
  std::function<void(std::size_t)> opened_;
  std::vector<MeshFile> files_;
  std::vector<std::string> problems_, outside_;
};

/// What a mesh calls a picture -> its bytes, where the mesh file itself holds it.
using EmbeddedPicture = std::function<std::optional<std::string_view>(const std::string& name)>;

/// Gives the objects their colours from their looks, reads pictures for it, adds these to the files
/// of the mesh and one remark where some tell no colour. The bytes and pixels of all together are
/// bounded; never throws for a picture.
void put_colours(const std::string& mesh_path, bool allow_outside,
                 const std::function<void(std::size_t)>& opened, const EmbeddedPicture& embedded,
                 RawMesh& mesh);

/// The remark on files that are missing; `names` are joined by commas.
std::string remark_on_missing(const std::string& names);

}  // namespace road
