#include "base/output_set.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "unfinished.h"

namespace base {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kManifest = "manifest.json";
constexpr const char* kUnfinishedManifest = ".manifest.unfinished";
constexpr std::size_t kLargestManifest = 64'000'000;

struct Entry {
  std::size_t bytes = 0;
  std::string sha256;  ///< empty: differs from run to run
};

struct Manifest {
  std::string command, program_sha256, name;
  bool complete = true;
  std::map<std::string, Entry> files;
};

/// A name that lies in the folder itself.
bool is_plain(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && name != "." && name != "..";
}

std::string text_of(const Manifest& manifest) {
  Json files = Json::array();
  for (const auto& [name, entry] : manifest.files) {
    const bool hashed = !entry.sha256.empty();
    files.push_back({{"file", name},
                     {"bytes", hashed ? Json(entry.bytes) : Json()},
                     {"sha256", hashed ? Json(entry.sha256) : Json()}});
  }
  const Json out = {{"schema", 1},
                    {"command", manifest.command},
                    {"program_sha256", manifest.program_sha256},
                    {"name", manifest.name},
                    {"complete", manifest.complete},
                    {"files", files}};
  return json_text(out);
}

std::optional<Manifest> read_manifest(const std::string& folder) {
  const auto text = try_read_file(folder + "/" + kManifest, kLargestManifest);
  if (!text) return std::nullopt;
  try {
    const Json json = base::parse_json<Json>(*text);
    Manifest manifest{json.at("command").get<std::string>(),
                      json.at("program_sha256").get<std::string>(),
                      json.at("name").get<std::string>(),
                      json.at("complete").get<bool>(),
                      {}};
    for (const Json& file : json.at("files")) {
      const auto name = file.at("file").get<std::string>();
      if (!is_plain(name)) return std::nullopt;
      Entry& entry = manifest.files[name];
      if (!file.at("sha256").is_null())
        entry = {file.at("bytes").get<std::size_t>(), file.at("sha256").get<std::string>()};
    }
    if (text_of(manifest) != *text) return std::nullopt;
    return manifest;
  } catch (const Json::exception&) {  // whatever else lies under this name
    return std::nullopt;
  }
}

Entry entry_of(const std::string& path, bool hashed) {
  return hashed ? Entry{static_cast<std::size_t>(fs::file_size(path)), sha256_of_file(path)}
                : Entry{};
}

void flush_folder(const std::string& folder) {
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return;
  ::fsync(opened);
  ::close(opened);
}

/// To its place; through a link or into what is no file.
void move_in(const std::string& from, const std::string& to) {
  std::error_code none;
  const fs::file_type there = fs::symlink_status(to, none).type();
  if (there != fs::file_type::not_found && there != fs::file_type::regular) {
    write_file(to, read_file(from));
    return;
  }
  if (::rename(from.c_str(), to.c_str()) != 0)
    throw Error(fmt::format("{}: cannot rename to the final name: {}", to, std::strerror(errno)));
}

[[noreturn]] void refuse_half(const std::string& folder, const Manifest& manifest) {
  throw Error(fmt::format(
      "{}: 'complete' is false: '{}' was killed, or still is, while it moved its files in, and "
      "those beside it are of two runs; run it again",
      (fs::path(folder) / kManifest).string(), manifest.command));
}

/// What the manifest beside a file says of it. Nothing where it does not name it: then no run that
/// was killed has touched it.
std::optional<Entry> entry_in_whole_set(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  const std::string there = folder.empty() ? "." : folder.string();
  const std::optional<Manifest> manifest = read_manifest(there);
  if (!manifest) return std::nullopt;
  const auto found = manifest->files.find(fs::path(path).filename().string());
  if (found == manifest->files.end()) return std::nullopt;
  if (!manifest->complete) refuse_half(there, *manifest);
  return found->second;
}

}  // namespace

FolderLock::FolderLock(const std::string& folder, const std::string& command)
    : folder_(folder), path_(folder + "/.kerbstone.lock") {
  const auto refuse = [&](const std::string& why) {
    remove_made();
    throw Error(fmt::format(
        "{}: cannot write into this folder: {}; give a folder that can be written with -o", folder_,
        why));
  };
  // Another process may remove the folder or the lock between two of these steps: then once more.
  for (int attempt = 0; attempt < 100; ++attempt) {
    const std::lock_guard guard(
        unfinished_guard());  // nobody interrupts before all that is made is known
    std::error_code problem;
    std::vector<std::string> missing;
    for (fs::path at = fs::absolute(folder).lexically_normal();
         !fs::exists(at, problem) && at.has_relative_path(); at = at.parent_path())
      if (at.has_filename()) missing.push_back(at.string());
    fs::create_directories(folder, problem);
    if (problem && problem.value() != ENOENT) refuse(problem.message());
    made_.insert(made_.end(), missing.begin(), missing.end());
    for (auto made = missing.rbegin(); made != missing.rend(); ++made) add_made_folder(*made);
    const int file =
        ::open(path_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    if (file < 0 && errno == ENOENT) continue;
    if (file < 0) refuse(std::strerror(errno));
    if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      char who[200];
      const ssize_t count = ::pread(file, who, sizeof who, 0);
      ::close(file);
      remove_made();
      throw Error(fmt::format(
          "{}: {} is writing into this folder; wait until it has ended, or give another folder "
          "with -o",
          folder_,
          count > 0 ? std::string(who, static_cast<std::size_t>(count)) : "another process"));
    }
    struct stat mine {
    }, there{};
    if (::fstat(file, &mine) == 0 && ::stat(path_.c_str(), &there) == 0 &&
        mine.st_ino == there.st_ino && mine.st_dev == there.st_dev) {
      descriptor_ = file;
      add_unfinished(path_);
      const std::string who = fmt::format("{} (process {})", command, ::getpid());
      if (::ftruncate(file, 0) != 0 || ::pwrite(file, who.data(), who.size(), 0) < 0) {
      }  // only words
      return;
    }
    ::close(file);
  }
  refuse("other processes come and go in it");
}

FolderLock::~FolderLock() {
  const std::lock_guard guard(unfinished_guard());
  ::unlink(path_.c_str());
  ::close(descriptor_);
  drop_unfinished(path_);
  remove_made();
}

void FolderLock::remove_made() {
  const std::lock_guard guard(unfinished_guard());
  for (const std::string& made : made_) {
    ::rmdir(made.c_str());  // fails where something lies in it
    drop_unfinished(made);
  }
}

OutputSet::OutputSet(const std::string& folder, const std::string& command)
    : folder_(folder),
      command_(command),
      staging_(folder + "/.kerbstone.new"),
      lock_(folder, command) {
  const std::lock_guard guard(unfinished_guard());
  std::error_code problem;
  fs::remove_all(staging_, problem);
  if (!problem) fs::create_directory(staging_, problem);
  if (problem)
    throw Error(
        fmt::format("{}: cannot make this folder: {}; give a folder that can be written with -o",
                    staging_, problem.message()));
  add_unfinished(staging_);
}

OutputSet::~OutputSet() {
  const std::lock_guard guard(unfinished_guard());
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  drop_unfinished(staging_);
}

std::string OutputSet::path(const std::string& name) const {
  return (fs::path(folder_) / name).string();
}

std::vector<std::string> OutputSet::confirmed(
    const std::vector<std::string>& may_be_missing) const {
  const std::optional<Manifest> manifest = read_manifest(folder_);
  if (!manifest || !manifest->complete || manifest->command != command_ ||
      manifest->program_sha256 != sha256_of_program())
    return {};
  std::vector<std::string> names;
  for (const auto& [name, entry] : manifest->files) {
    std::error_code problem;
    const bool there = fs::is_regular_file(path(name), problem);
    if (!there &&
        std::find(may_be_missing.begin(), may_be_missing.end(), name) != may_be_missing.end())
      continue;
    if (!there) return {};
    if (!entry.sha256.empty() && (fs::file_size(path(name), problem) != entry.bytes ||
                                  sha256_of_file(path(name)) != entry.sha256))
      return {};
    names.push_back(name);
  }
  return names;
}

void OutputSet::commit(const std::string& name, const std::vector<std::string>& kept,
                       const std::vector<std::string>& unhashed) {
  const auto hashed = [&](const std::string& file) {
    return std::find(unhashed.begin(), unhashed.end(), file) == unhashed.end();
  };
  Manifest now{command_, sha256_of_program(), name, true, {}};
  std::vector<std::string> made;
  for (const auto& file : fs::directory_iterator(staging_))
    made.push_back(file.path().filename().string());
  for (const std::string& file : made) {
    check_writable(path(file));
    now.files[file] = entry_of(staged(file), hashed(file));
  }
  for (const std::string& file : kept) now.files[file] = entry_of(path(file), hashed(file));

  // What lies here of an earlier run and does not belong to this one.
  std::vector<std::string> gone;
  if (const std::optional<Manifest> before = read_manifest(folder_);
      before && before->command == command_) {
    for (const auto& [file, entry] : before->files)
      if (!now.files.contains(file) &&
          (before->name == name || !file.starts_with(before->name + ".")))
        gone.push_back(file);
  }
  Manifest between = now;
  between.complete = false;
  for (const std::string& file : gone) between.files[file];
  write_file(staged(kUnfinishedManifest), text_of(between));
  write_file(staged(kManifest), text_of(now));

  // Whoever interrupts comes before all of this or after.
  const std::lock_guard guard(unfinished_guard());
  move_in(staged(kUnfinishedManifest), path(kManifest));
  flush_folder(folder_);
  for (const std::string& file : made) move_in(staged(file), path(file));
  for (const std::string& file : gone) ::unlink(path(file).c_str());
  flush_folder(folder_);
  move_in(staged(kManifest), path(kManifest));
  flush_folder(folder_);
}

std::optional<std::map<std::string, std::string>> files_of_set(const std::string& folder) {
  const std::optional<Manifest> manifest = read_manifest(folder);
  if (!manifest) return std::nullopt;
  if (!manifest->complete) refuse_half(folder, *manifest);
  std::map<std::string, std::string> out;
  for (const auto& [name, entry] : manifest->files) out[name] = entry.sha256;
  return out;
}

void check_set_is_whole(const std::string& path) { (void)entry_in_whole_set(path); }

void check_in_set(const std::string& path) {
  const std::optional<Entry> entry = entry_in_whole_set(path);
  if (!entry || entry->sha256.empty()) return;
  check_sha256(path, entry->sha256,
               "make it again by the command that manifest.json beside it names; where it was "
               "changed on purpose, put it into another folder");
}

void check_sha256(const std::string& path, const std::string& wanted, const std::string& way_out) {
  const std::string seen = sha256_of_file(path);
  if (seen != wanted)
    throw Error(fmt::format("{}: SHA-256 {} seen, {} wanted; {}", path, seen, wanted, way_out));
}

}  // namespace base
