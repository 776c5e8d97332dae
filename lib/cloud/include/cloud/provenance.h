// What results rest on: the bytes of every file that was read and every option.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "inspect/input_file.h"

namespace cloud {

/// Name and value as text: JSON (numbers, lists, true, false) or a word; empty: found from the
/// inputs.
using Options = std::vector<std::pair<std::string, std::string>>;

/// A file, or the clouds of a folder, with their hashes; nothing for an empty path.
std::vector<road::InputFile> hashed(const std::string& role, const std::string& path);

/// JSON with schema, program, inputs (role, path, sha256), options: the head of every summary.
std::string head_json(const std::string& program, const std::vector<road::InputFile>& inputs,
                      const Options& options);

/// The same as lines for the header of a cloud.
std::vector<std::string> comments_of(const std::string& program,
                                     const std::vector<road::InputFile>& inputs,
                                     const Options& options);

/// One summary of a head, where coordinates begin, and the rest.
std::string joined_summary(const std::string& head, const std::optional<Eigen::Vector3d>& origin_m,
                           const std::string& rest);

}  // namespace cloud
