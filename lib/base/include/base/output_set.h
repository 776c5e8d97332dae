// The outputs of one run, which belong together, in one folder.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace base {

/// The right to write into a folder, which is made where it is missing. At most one process has it:
/// a file .kerbstone.lock in the folder, locked by flock, so that it ends with the process, however
/// that ends.
class FolderLock {
 public:
  /// `command` ("crgbuild build") is what another process is told. Throws Error: another process
  /// has the folder (it is named), or the folder cannot be made or written.
  FolderLock(const std::string& folder, const std::string& command);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  /// Removes the lock, and the folders that the constructor made where nothing lies in them.
  ~FolderLock();

 private:
  void remove_made();

  std::string folder_, path_;
  std::vector<std::string> made_;  ///< folders, the innermost first
  int descriptor_ = -1;
};

/// Files that appear together. They are written under .kerbstone.new in the folder and moved in by
/// commit(), which writes manifest.json last (docs/formats.md): name, size and SHA-256 of each.
/// Without commit() the folder stays as it was; what a killed run left is removed by the next one.
/// A run killed inside commit() leaves a manifest that says so, and a set that confirmed() does not
/// believe.
class OutputSet {
 public:
  /// Takes the lock of the folder, removes what a killed run left. Throws Error as FolderLock.
  OutputSet(const std::string& folder, const std::string& command);
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;
  ~OutputSet();

  /// Where an output called `name` (no folder in it) is written before commit().
  std::string staged(const std::string& name) const { return staging_ + "/" + name; }
  /// Where it lies afterwards, and where that of the run before lies until then.
  std::string path(const std::string& name) const;

  /// The names of the files that lie there when a run of the same command and program finished, and
  /// each is as its manifest says or is named in `may_be_missing` and missing. Empty otherwise.
  std::vector<std::string> confirmed(const std::vector<std::string>& may_be_missing = {}) const;

  /// Moves everything in. `kept` are files of the run before that belong to this one too;
  /// `unhashed` are those whose bytes differ from run to run. Files of an earlier run of the same
  /// command that this one did not make are removed, but not those called OTHER.* of a run that was
  /// called OTHER. Throws Error.
  void commit(const std::string& name, const std::vector<std::string>& kept = {},
              const std::vector<std::string>& unhashed = {});

 private:
  std::string folder_, command_, staging_;
  FolderLock lock_;
};

/// What the manifest.json of a folder says of its files: name and SHA-256 (empty: its bytes differ
/// from run to run). Nothing where none that OutputSet wrote lies there. Throws Error where a run
/// was killed while it moved its files in: they are of two runs.
std::optional<std::map<std::string, std::string>> files_of_set(const std::string& folder);

/// For whoever reads a file that may be part of a set. Throws Error where the manifest beside the
/// file names it and says that a run was killed while it moved its files in.
void check_set_is_whole(const std::string& path);

/// The same, and where the manifest names the file with another SHA-256.
void check_in_set(const std::string& path);

/// Throws Error where a file has another SHA-256 than the one that is stored of it.
void check_sha256(const std::string& path, const std::string& wanted, const std::string& way_out);

}  // namespace base
