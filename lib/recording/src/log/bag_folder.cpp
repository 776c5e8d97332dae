// Folders that rosbag2 records into: metadata.yaml and the files that it names.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/read_file.h"
#include "readers.h"
#include "topics.h"
#include "unpack.h"

namespace recording {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadataName = "metadata.yaml";
constexpr std::size_t kLargestMetadataBytes = std::size_t{1} << 24, kMostFiles = 10000;

[[noreturn]] void refuse(const fs::path& metadata, const std::string& why) {
  throw base::Error(fmt::format("{}: {}", metadata.string(), why));
}

/// Names of the files, in order; none leads out of the folder.
std::vector<std::string> files_of(const fs::path& metadata) {
  const std::string text = base::read_file(metadata.string(), kLargestMetadataBytes);
  std::vector<std::string> out;
  try {
    const YAML::Node list = YAML::Load(text)["rosbag2_bagfile_information"]["relative_file_paths"];
    if (!list || !list.IsSequence() || list.size() == 0)
      refuse(
          metadata,
          "no list rosbag2_bagfile_information: relative_file_paths; `ros2 bag reindex` makes it");
    if (list.size() > kMostFiles)
      refuse(metadata, fmt::format("{} files, wanted at most {}", list.size(), kMostFiles));
    for (const YAML::Node& file : list) out.push_back(file.as<std::string>());
  } catch (const YAML::Exception& error) {
    refuse(metadata, fmt::format("line {}: {}", error.mark.line + 1, error.msg));
  }
  for (const std::string& name : out) {
    const fs::path path(name);
    const bool leads_out =
        path.empty() || path.is_absolute() ||
        std::any_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
    if (leads_out)
      refuse(metadata,
             fmt::format("file '{}': wanted a name within the folder", name.substr(0, 200)));
  }
  return out;
}

/// A recording packed as a whole stands beside its name, or under it with .zstd behind.
fs::path found(const fs::path& folder, const std::string& name) {
  fs::path path = folder / name;
  if (fs::exists(path)) return path;
  fs::path packed = path;
  packed += ".zstd";
  if (fs::exists(packed)) return packed;
  refuse(folder / kMetadataName,
         fmt::format("names {}, which is not there; copy it too, or take its line out",
                     name.substr(0, 200)));
}

FileTopics topics_of(const fs::path& path) {
  std::string bytes = base::read_file(path.string(), kLargestFileBytes);
  if (is_zstd(bytes)) bytes = unpacked_file(bytes, path.string());
  if (is_mcap(bytes)) return topics_of_mcap(bytes, path.string());
  if (is_rosbag2(bytes)) return topics_of_rosbag2(bytes, path.string());
  throw base::Error(path.string() + ": neither an SQLite database nor MCAP, as rosbag2 records");
}

std::size_t cells_of(const std::vector<Topic>& topics) {
  std::size_t cells = 0;
  for (const Topic& topic : topics) cells += (topic.columns.size() + 1) * topic.times_ns.size();
  return cells;
}

}  // namespace

Log read_bag_folder(const std::string& folder) {
  const fs::path metadata = fs::path(folder) / kMetadataName;
  if (!fs::exists(metadata))
    throw base::Error(fmt::format(
        "{}: a folder without {}, so none that rosbag2 recorded; give one of its files, or let "
        "`ros2 bag reindex` make it",
        folder, kMetadataName));
  FileTopics all;
  for (const std::string& name : files_of(metadata)) {
    const fs::path path = found(folder, name);
    FileTopics one = topics_of(path);
    append_topics(all.topics, std::move(one.topics));
    for (const std::string& note : one.notes) {
      const std::string said = fmt::format("{}: {}", name, note);
      if (all.notes.size() < 100) all.notes.push_back(said);
    }
    if (cells_of(all.topics) > kMostCells)
      throw base::Error(folder + ": more than 2 GB of samples; give its files one by one");
  }
  return log_of_file(std::move(all), "rosbag2", folder);
}

}  // namespace recording
