#include "cloud/provenance.h"

#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/sha256.h"
#include "cloud/read_cloud.h"

namespace cloud {

using Json = nlohmann::ordered_json;

std::vector<road::InputFile> hashed(const std::string& role, const std::string& path) {
  std::vector<road::InputFile> inputs;
  if (path.empty()) return inputs;
  for (const std::string& file : cloud_files(path))
    inputs.push_back({role, file, base::sha256_of_file(file)});
  return inputs;
}

namespace {

Json head_of(const std::string& program, const std::vector<road::InputFile>& inputs,
             const Options& options) {
  Json files = Json::array(), values = Json::object();
  for (const road::InputFile& file : inputs)
    files.push_back({{"role", file.role}, {"path", file.path}, {"sha256", file.sha256}});
  for (const auto& [name, value] : options)
    values[name] = value.empty()         ? Json()
                   : Json::accept(value) ? base::parse_json<Json>(value)
                                         : Json(value);
  return {{"schema", 1}, {"program", program}, {"inputs", files}, {"options", values}};
}

}  // namespace

std::string head_json(const std::string& program, const std::vector<road::InputFile>& inputs,
                      const Options& options) {
  return base::json_text(head_of(program, inputs, options));
}

std::string joined_summary(const std::string& head, const std::optional<Eigen::Vector3d>& origin_m,
                           const std::string& rest) {
  Json out = base::parse_json<Json>(head);
  if (origin_m) out["origin_m"] = {origin_m->x(), origin_m->y(), origin_m->z()};
  out.update(base::parse_json<Json>(rest));
  return base::json_text(out);
}

std::vector<std::string> comments_of(const std::string& program,
                                     const std::vector<road::InputFile>& inputs,
                                     const Options& options) {
  const Json head = head_of(program, inputs, options);
  std::vector<std::string> lines{"program " + head["program"].get<std::string>()};
  for (const road::InputFile& file : inputs)
    lines.push_back("input " + file.role + " " + file.sha256 + " " + file.path);
  lines.push_back("options " + head["options"].dump(-1, ' ', true, Json::error_handler_t::replace));
  return lines;
}

}  // namespace cloud
