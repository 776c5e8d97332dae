// What results rest on, as JSON of these commands.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "cloud/provenance.h"
#include "command/version.h"

namespace lidar2mesh {

using cloud::hashed, cloud::Options;

inline std::string program() { return std::string("lidar2mesh ") + command::version(); }

/// schema, program, inputs (role, path, sha256), options: the head of every summary.
inline nlohmann::ordered_json head_of(const std::vector<road::InputFile>& inputs,
                                      const Options& options) {
  return base::parse_json<nlohmann::ordered_json>(cloud::head_json(program(), inputs, options));
}

/// The same as lines for the header of a cloud.
inline std::vector<std::string> comments_of(const std::vector<road::InputFile>& inputs,
                                            const Options& options) {
  return cloud::comments_of(program(), inputs, options);
}

}  // namespace lidar2mesh
