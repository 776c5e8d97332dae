// What the page may see: files below the folders that were given, and nothing else.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace view {

enum class Kind : std::uint8_t {
  recipe,
  mesh,
  road,
  log,
  findings,
  scan,
  tiles,
  unit,
  report,
  table,
  picture,
  devices,
  car
};
const char* to_string(Kind kind);

struct Entry {
  std::string id;  ///< "0/tracks/aalborg/track.yaml": number of the folder, path below it
  Kind kind = Kind::mesh;
  std::uint64_t bytes = 0;
  double modified_s = 0.0;  ///< since 1970
};

struct Listing {
  std::vector<Entry> entries;  ///< by id
  bool is_whole = true;        ///< false: there are more than kMostEntries
};
constexpr std::size_t kMostEntries = 20'000;

class Folders {
 public:
  /// Throws Error where one is no folder.
  explicit Folders(const std::vector<std::string>& paths);

  /// Files of a known kind, by their names, and .yaml by their keys; nothing in hidden folders, in
  /// node_modules, or more than eight folders down, and no tables that a car beside them names.
  Listing list() const;

  /// The file that `id` means, links followed. Throws Error where it lies outside the folders, is
  /// missing or no regular file; with `may_be_new` its folder has to exist, itself not.
  std::string path_of(const std::string& id, bool may_be_new = false) const;

  /// Throws Error where writing `below` the first folder, a file or a folder of files, would lead
  /// out of the folders by a link. What is not there yet leads nowhere.
  void check_written(const std::string& below) const;

  /// Absolute, links followed; of the folder with this number.
  const std::string& root(std::size_t number) const { return roots_.at(number); }
  std::size_t size() const { return roots_.size(); }

 private:
  void leave_out_maps(std::vector<Entry>& entries) const;
  void check_link(const std::string& path) const;

  std::vector<std::string> roots_;
};

}  // namespace view
