#include "provenance.h"

#include "base/sha256.h"
#include "cloud/read_cloud.h"
#include "command/version.h"

namespace lidar2mesh {

using Json = nlohmann::ordered_json;

std::vector<road::InputFile> hashed(const std::string& role, const std::string& path) {
  std::vector<road::InputFile> inputs;
  if (path.empty()) return inputs;
  for (const std::string& file : cloud::cloud_files(path))
    inputs.push_back({role, file, base::sha256_of_file(file)});
  return inputs;
}

Json head_of(const std::vector<road::InputFile>& inputs, const Options& options) {
  Json files = Json::array(), values = Json::object();
  for (const road::InputFile& file : inputs)
    files.push_back({{"role", file.role}, {"path", file.path}, {"sha256", file.sha256}});
  for (const auto& [name, value] : options)
    values[name] = value.empty() ? Json() : Json::accept(value) ? Json::parse(value) : Json(value);
  return {{"schema", 1},
          {"program", std::string("lidar2mesh ") + command::version()},
          {"inputs", files},
          {"options", values}};
}

std::vector<std::string> comments_of(const std::vector<road::InputFile>& inputs,
                                     const Options& options) {
  const Json head = head_of(inputs, options);
  std::vector<std::string> lines{"program " + head["program"].get<std::string>()};
  for (const road::InputFile& file : inputs)
    lines.push_back("input " + file.role + " " + file.sha256 + " " + file.path);
  lines.push_back("options " + head["options"].dump(-1, ' ', true, Json::error_handler_t::replace));
  return lines;
}

}  // namespace lidar2mesh
