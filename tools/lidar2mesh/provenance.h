// What results rest on: the bytes of every file that was read and every option.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "road/summary.h"

namespace lidar2mesh {

/// Name and value, as command::options_used() tells them.
using Options = std::vector<std::pair<std::string, std::string>>;

/// A file, or the clouds of a folder, with their hashes; nothing for an empty path.
std::vector<road::InputFile> hashed(const std::string& role, const std::string& path);

/// schema, program, inputs (role, path, sha256), options: the head of every summary.
nlohmann::ordered_json head_of(const std::vector<road::InputFile>& inputs, const Options& options);

/// The same as lines for the header of a cloud.
std::vector<std::string> comments_of(const std::vector<road::InputFile>& inputs,
                                     const Options& options);

}  // namespace lidar2mesh
