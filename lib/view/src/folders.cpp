#include "view/folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include "base/error.h"

namespace view {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 8;
constexpr std::size_t kMostYaml = 65536;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The first bytes of a file: a stranger's may be of any size, in one line.
std::string head_of(const fs::path& path, std::size_t bytes) {
  std::string head(bytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

/// Whether a .ply is of points alone: its header, as far as this reads, names no faces.
bool is_cloud(const fs::path& path) {
  const std::string head = head_of(path, 4096);
  const std::size_t end = head.find("end_header");
  return end != std::string::npos && head.find("element vertex") < end &&
         head.find("element face") == std::string::npos;
}

std::string without_remarks(const std::string& yaml) {
  std::string out;
  bool remark = false;
  for (const char c : yaml) {
    remark = c != '\n' && (remark || c == '#');
    if (!remark) out += c;
  }
  return out;
}

/// Whether a file of this name stands there, not as the end of a longer name.
bool names(const std::string& text, const std::string& file) {
  for (std::size_t at = text.find(file); at != std::string::npos; at = text.find(file, at + 1)) {
    const char before = at == 0 ? ' ' : text[at - 1];
    if (std::isspace(static_cast<unsigned char>(before)) != 0 || before == '"' || before == '\'' ||
        before == '/' || before == '[')
      return true;
  }
  return false;
}

/// What a .yaml is by its keys, as far as this reads: sensors that look at the road, a car, a
/// recipe. Mappings, sheets, circuits and others are nothing that the page opens.
std::optional<Kind> kind_of_yaml(const std::string& text) {
  const std::string head = '\n' + text;
  const auto has = [&](const char* key) { return head.find(key) != std::string::npos; };
  if (has("\nscans:") || has("\nedges:")) return Kind::devices;
  if (has("\ntyres") || has("\nchassis")) return Kind::car;
  if (has("\nmesh:")) return Kind::recipe;
  return std::nullopt;
}

std::optional<Kind> kind_of(const fs::path& path) {
  static const std::map<std::string, Kind> endings = {
      {".yaml", Kind::recipe}, {".obj", Kind::mesh},  {".fbx", Kind::mesh}, {".glb", Kind::mesh},
      {".gltf", Kind::mesh},   {".dae", Kind::mesh},  {".ply", Kind::mesh}, {".stl", Kind::mesh},
      {".3ds", Kind::mesh},    {".ac", Kind::mesh},   {".acc", Kind::mesh}, {".b3d", Kind::mesh},
      {".crg", Kind::road},    {".csv", Kind::table}, {".ld", Kind::log},   {".vbo", Kind::log},
      {".ibt", Kind::log},     {".mcap", Kind::log},  {".db3", Kind::log},  {".las", Kind::scan},
      {".laz", Kind::scan},    {".pcd", Kind::scan},  {".xyz", Kind::scan}, {".fmu", Kind::unit},
      {".png", Kind::picture}};
  const std::string name = lower(path.filename().string());
  if (name == "report.html") return Kind::report;
  if (name == "findings.json") return Kind::findings;
  if (name == "tiles.json") return Kind::tiles;
  const auto found = endings.find(lower(path.extension().string()));
  if (found == endings.end()) return std::nullopt;
  if (found->second == Kind::recipe) return kind_of_yaml(head_of(path, kMostYaml));
  if (found->first == ".ply" && is_cloud(path)) return Kind::scan;
  return found->second;
}

double since_1970_s(fs::file_time_type time) {
  const auto moment = std::chrono::file_clock::to_sys(time);
  return std::chrono::duration<double>(moment.time_since_epoch()).count();
}

/// Whether `path` is `root` or lies below it; both without links and "..".
bool is_below(const fs::path& root, const fs::path& path) {
  return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

}  // namespace

const char* to_string(Kind kind) {
  static constexpr const char* kNames[] = {"recipe",  "mesh",    "road", "log",    "findings",
                                           "scan",    "tiles",   "unit", "report", "table",
                                           "picture", "devices", "car"};
  return kNames[static_cast<std::size_t>(kind)];
}

Folders::Folders(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    std::error_code error;
    const fs::path whole = fs::canonical(path, error);
    if (error || !fs::is_directory(whole))
      throw base::Error(
          fmt::format("{}: a folder wanted{}", path, error ? ": " + error.message() : ""));
    if (std::find(roots_.begin(), roots_.end(), whole.string()) == roots_.end())
      roots_.push_back(whole.string());
  }
  if (roots_.empty()) throw base::Error("no folder to show");
}

void Folders::leave_out_maps(std::vector<Entry>& entries) const {
  // What is written in each folder's cars, but for remarks, which name recordings, too.
  std::map<fs::path, std::string> cars;
  for (const Entry& entry : entries)
    if (entry.kind == Kind::car) {
      const fs::path below = entry.id.substr(entry.id.find('/') + 1);
      const std::size_t number = std::stoul(entry.id);
      cars[fs::path(entry.id).parent_path()] +=
          without_remarks(head_of(fs::path(roots_[number]) / below, kMostYaml));
    }
  std::erase_if(entries, [&](const Entry& entry) {
    const fs::path id = entry.id;
    const auto car = cars.find(id.parent_path());
    return entry.kind == Kind::table && car != cars.end() &&
           names(car->second, id.filename().string());
  });
}

Listing Folders::list() const {
  Listing listing;
  for (std::size_t number = 0; number < roots_.size(); ++number) {
    std::error_code error;
    auto at = fs::recursive_directory_iterator(
        roots_[number], fs::directory_options::skip_permission_denied, error);
    for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
      const std::string name = at->path().filename().string();
      std::error_code vanished;
      if (at->is_directory(vanished)) {
        if (name.starts_with('.') || name == "node_modules" || at.depth() >= kDeepest)
          at.disable_recursion_pending();
        continue;
      }
      if (name.starts_with('.') || !at->is_regular_file(vanished)) continue;
      const auto kind = kind_of(at->path());
      if (!kind) continue;
      if (listing.entries.size() == kMostEntries) {
        listing.is_whole = false;
        break;
      }
      const auto bytes = at->file_size(vanished);
      const auto time = at->last_write_time(vanished);
      if (vanished) continue;
      listing.entries.push_back(
          {fmt::format("{}/{}", number, at->path().lexically_relative(roots_[number]).string()),
           *kind, bytes, since_1970_s(time)});
    }
  }
  std::sort(listing.entries.begin(), listing.entries.end(),
            [](const Entry& a, const Entry& b) { return a.id < b.id; });
  leave_out_maps(listing.entries);
  return listing;
}

std::string Folders::path_of(const std::string& id, bool may_be_new) const {
  const auto refuse = [&](const char* why) { throw base::Error(fmt::format("'{}': {}", id, why)); };
  const std::size_t slash = id.find('/');
  std::size_t number = 0;
  const char* const end = id.data() + std::min(slash, id.size());
  const auto [last, wrong] = std::from_chars(id.data(), end, number);
  if (slash == std::string::npos || wrong != std::errc{} || last != end ||
      number >= roots_.size() || id.find('\0') != std::string::npos)
    refuse("no file of these folders");
  const fs::path below = id.substr(slash + 1), root = roots_[number];
  if (below.empty() || below.is_absolute() || !below.has_filename() ||
      std::any_of(below.begin(), below.end(),
                  [](const fs::path& p) { return p == ".." || p == "."; }))
    refuse("no file of these folders");
  std::error_code error;
  const fs::path folder = fs::canonical((root / below).parent_path(), error);
  if (error || !is_below(root, folder)) refuse("no file of these folders");
  const fs::path path = folder / below.filename();
  const auto status = fs::symlink_status(path, error);
  if (!fs::exists(status)) {
    if (!may_be_new) refuse("is not there any more");
    return path.string();
  }
  const fs::path whole = fs::canonical(path, error);
  if (error || !is_below(root, whole) || !fs::is_regular_file(whole, error))
    refuse("no file of these folders");
  return whole.string();
}

void Folders::check_link(const std::string& path) const {
  std::error_code error;
  if (!fs::is_symlink(fs::symlink_status(path, error))) return;
  const fs::path whole = fs::canonical(path, error);
  const bool stays = !error && std::any_of(roots_.begin(), roots_.end(),
                                           [&](const auto& root) { return is_below(root, whole); });
  if (!stays)
    throw base::Error(
        fmt::format("{}: a link that leads out of the folders of this page; nothing is "
                    "written through it: remove it, or give the folder that it leads to",
                    path));
}

void Folders::check_written(const std::string& below) const {
  fs::path at = roots_.front();
  for (const fs::path& part : fs::path(below)) check_link((at /= part).string());
  std::error_code error;
  for (fs::recursive_directory_iterator inside(at, error), end; !error && inside != end;
       inside.increment(error))
    check_link(inside->path().string());
}

}  // namespace view
