#include "sim/unpack.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <minizip/unzip.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/one_line.h"
#include "base/read_file.h"
#include "base/write_file.h"
#include "fmu/export_unit.h"

namespace sim {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 20'000, kLongestName = 1000;
constexpr std::uint64_t kMostUnpackedBytes = 2'000'000'000, kLargestDescription = 100'000'000;
constexpr const char* kDescription = "modelDescription.xml";

bool leads_out(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find('\\') != std::string::npos ||
      name.find('\0') != std::string::npos)
    return true;
  const fs::path path(name);
  return std::any_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

bool is_needed(const std::string& name) {
  return name == kDescription || name.starts_with("resources/") ||
         name.starts_with("binaries/linux64/") || name.starts_with("binaries/x86_64-linux/");
}

/// Calls `take` with name and a source of bytes for each wanted file.
class Zip {
 public:
  explicit Zip(const std::string& path) : path_(path) {
    base::want_regular_file(path);
    file_ = unzOpen64(path.c_str());
    if (file_ == nullptr)
      throw base::Error(path + ": no Functional Mock-up Unit: it cannot be opened as a zip");
  }
  Zip(const Zip&) = delete;
  Zip& operator=(const Zip&) = delete;
  ~Zip() { unzClose(file_); }

  void each(const std::function<void(const std::string& name)>& take) {
    using Contents = std::pair<std::uint64_t, std::uint64_t>;
    std::map<std::string, Contents> names;
    std::size_t entries = 0;
    for (int code = unzGoToFirstFile(file_); code != UNZ_END_OF_LIST_OF_FILE;
         code = unzGoToNextFile(file_)) {
      want(code, "its list of files");
      unz_file_info64 info{};
      std::array<char, kLongestName + 1> text{};
      want(unzGetCurrentFileInfo64(file_, &info, text.data(), text.size(), nullptr, 0, nullptr, 0),
           "its list of files");
      if (info.size_filename > kLongestName)
        throw base::Error(path_ + ": a file's name is longer than 1000 characters");
      const std::string name(text.data(), info.size_filename);
      if (leads_out(name))
        throw base::Error(fmt::format("{}: the file '{}' would lie outside of the unit's folder",
                                      path_, base::visible(name.substr(0, 80))));
      const Contents contents{info.uncompressed_size, info.crc};
      // Programs that pack folders one by one may name a file or folder twice.
      const auto [known, is_new] = names.emplace(name, contents);
      if (known->second != contents)
        throw base::Error(path_ + ": two files are called '" + base::visible(name) + "'");
      if (++entries > kMostFiles)
        throw base::Error(fmt::format("{}: more than {} files", path_, kMostFiles));
      if (is_new) take(name);
    }
  }

  /// The current file, piece by piece.
  void read(const std::string& name, std::uint64_t most,
            const std::function<void(std::string_view)>& take) {
    want(unzOpenCurrentFile(file_), name);
    std::vector<char> piece(1 << 16);
    std::uint64_t all = 0;
    while (true) {
      const int count =
          unzReadCurrentFile(file_, piece.data(), static_cast<unsigned>(piece.size()));
      if (count < 0) want(count, name);
      if (count == 0) break;
      all += static_cast<std::uint64_t>(count);
      if (all > most)
        throw base::Error(fmt::format("{}: {} unpacks to more than {} MB; no unit needs that",
                                      path_, name, most / 1'000'000));
      take({piece.data(), static_cast<std::size_t>(count)});
    }
    want(unzCloseCurrentFile(file_), name);  // its checksum
  }

 private:
  void want(int code, const std::string& what) const {
    if (code != UNZ_OK)
      throw base::Error(
          fmt::format("{}: {} is damaged (minizip: {})", path_, base::visible(what), code));
  }

  std::string path_;
  unzFile file_;
};

fmu::UnitInPlace car_of(const std::string& path, const std::string& road_path) {
  fmu::ExportOptions options;
  options.vehicle_path = path;
  options.road_path = road_path;
  options.generation_tool = "kerbstone";
  return fmu::unit_in_place(options);
}

constexpr std::string_view kFolderName = "kerbstone-unit-", kAnyEnding = "XXXXXX";

std::string temporary_folder() {
  std::error_code problem;
  const fs::path folder = fs::temp_directory_path(problem);
  if (!problem) return folder.string();
  const char* const said = std::getenv("TMPDIR");
  throw base::Error(fmt::format("TMPDIR is '{}', which is no folder; name one that is there",
                                base::visible(said == nullptr ? "" : said)));
}

/// Locked; -1 where it is no folder of this user, or somebody else has it.
int lock_folder(const std::string& path) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  struct stat status {};
  if (folder >= 0 && ::fstat(folder, &status) == 0 && status.st_uid == ::geteuid() &&
      ::flock(folder, LOCK_EX | LOCK_NB) == 0 && ::fstat(folder, &status) == 0 &&
      status.st_nlink > 0)
    return folder;
  if (folder >= 0) ::close(folder);
  return -1;
}

/// Of runs that were killed together with their guardians.
void remove_left_folders(const std::string& below) {
  std::error_code problem;
  for (fs::directory_iterator entry(below, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    if (name.size() != kFolderName.size() + kAnyEnding.size() || !name.starts_with(kFolderName))
      continue;
    const base::Descriptor lock(lock_folder(entry->path().string()));
    std::error_code ignored;
    if (lock.value >= 0) fs::remove_all(entry->path(), ignored);
  }
}

/// Made anew and locked.
std::string make_folder(int& lock) {
  const std::string below = temporary_folder();
  remove_left_folders(below);
  for (;;) {
    std::string made = (fs::path(below) / fmt::format("{}{}", kFolderName, kAnyEnding)).string();
    if (::mkdtemp(made.data()) == nullptr)
      throw base::Error(made + ": the folder cannot be made; TMPDIR names where");
    lock = lock_folder(made);
    if (lock >= 0) return made;
    // Another process took it for a left one before it was locked: it removes it.
    if (errno != EWOULDBLOCK && fs::exists(made))
      throw base::Error(made + ": the folder cannot be locked; TMPDIR names another place");
  }
}

}  // namespace

bool is_vehicle_file(const std::string& path) {
  return path.ends_with(".yaml") || path.ends_with(".yml");
}

UnpackedUnit::UnpackedUnit(const std::string& path, const std::string& road_path) : path_(path) {
  if (is_vehicle_file(path)) {
    const std::string unit_file = car_of(path, road_path).unit_file;
    folder_ = make_folder(lock_.value);
    try {
      fs::create_directories(folder_ + "/resources");
      base::write_file(folder_ + "/resources/unit.txt", unit_file);
    } catch (...) {
      std::error_code ignored;
      fs::remove_all(folder_, ignored);
      throw;
    }
    return;
  }
  Zip zip(path);
  folder_ = make_folder(lock_.value);
  try {
    std::uint64_t left = kMostUnpackedBytes;
    bool described = false;
    zip.each([&](const std::string& name) {
      described = described || name == kDescription;
      if (!is_needed(name) || name.back() == '/') return;
      const fs::path target = fs::path(folder_) / name;
      fs::create_directories(target.parent_path());
      base::FileWriter file(target.string());
      zip.read(name, left, [&](std::string_view bytes) {
        file.append(bytes);
        left -= bytes.size();
      });
      file.commit();
    });
    if (!described)
      throw base::Error(path + ": no Functional Mock-up Unit: no " + kDescription + " in it");
  } catch (const fs::filesystem_error& error) {
    fs::remove_all(folder_);
    throw base::Error(path + ": cannot be unpacked: " + error.what());
  } catch (...) {
    fs::remove_all(folder_);
    throw;
  }
}

UnpackedUnit::~UnpackedUnit() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string model_description_of(const std::string& path, const std::string& road_path) {
  if (is_vehicle_file(path)) return car_of(path, road_path).description;
  Zip zip(path);
  std::string xml;
  bool found = false;
  zip.each([&](const std::string& name) {
    if (name != kDescription) return;
    found = true;
    zip.read(name, kLargestDescription, [&](std::string_view bytes) { xml += bytes; });
  });
  if (!found)
    throw base::Error(path + ": no Functional Mock-up Unit: no " + std::string(kDescription) +
                      " in it");
  return xml;
}

}  // namespace sim
