#include "make/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "grid_stage.h"
#include "stage_json.h"

namespace road {
namespace {

/// What every summary begins and ends with.
template <class Summary>
Json head_of(const Summary& summary) {
  Json out;
  out["schema"] = 1;
  out["program"] = program_name();
  out["versions"] = {
      {"compiler", KERBSTONE_COMPILER}, {"assimp", KERBSTONE_ASSIMP}, {"embree", KERBSTONE_EMBREE}};
  out["name"] = summary.recipe.name;
  out["inputs"] = json_of(summary.inputs);
  return out;
}

template <class Summary>
std::string finished(Json& out, const Summary& summary) {
  if constexpr (requires { summary.outputs; }) {
    Json outputs = Json::array();
    for (const InputFile& file : summary.outputs)
      outputs.push_back({{"role", file.role}, {"file", file.path}, {"sha256", file.sha256}});
    out["outputs"] = outputs;
  }
  // Object names of a mesh need not be UTF-8.
  return base::json_text(out);
}

/// In what unit the mesh was read; where nobody stated it, with what the road would be in feet.
std::string unit_why(const BuildSummary& summary) {
  if (!summary.read.unit_taken) return summary.read.unit;
  const double feet_m = metres_per(Unit::ft);
  return fmt::format(
      "metres, for the file states no unit; were they feet, the road would be {:.1f} m wide and "
      "{:.0f} m long (--unit ft)",
      feet_m * summary.centreline.width_median_m, feet_m * summary.reference_line.length_m);
}

/// Empty for a file that cannot be read, as MeshFile has it.
std::string sha256_if_there(const std::string& path) {
  const auto hash = base::try_sha256_of_file(path);
  return hash ? *hash : "";
}

}  // namespace

std::string program_name() { return fmt::format("crgbuild {}", KERBSTONE_VERSION); }

std::vector<std::string> source_lines(const std::vector<InputFile>& inputs) {
  std::vector<std::string> lines{"made by Kerbstone, " + program_name()};
  for (const InputFile& input : inputs) {
    if (input.role == kMeshFile || input.sha256.empty()) continue;
    lines.push_back(base::one_line(
        input.role + ": " + std::filesystem::path(input.path).filename().string() + ", SHA-256"));
    lines.push_back("  " + input.sha256);
  }
  return lines;
}

std::string summary_json(const BuildSummary& summary) {
  Json out = head_of(summary);
  out["recipe"] = json_of(summary.recipe);
  out["read"] = json_of(summary.read);
  out["read"]["unit_why"] = unit_why(summary);
  out["clean"] = json_of(summary.clean);
  out["centreline"] = json_of(summary.centreline);
  out["reference_line"] = json_of(summary.reference_line);
  out["sample"] = json_of(summary.sample);
  out["road_edges"] = json_of(summary.road_edges, summary.grid.u_step_m);
  for (const GridStage& stage : grid_stages()) stage.report(summary, out);
  out["align"] = summary.placement ? json_of(*summary.placement) : Json(nullptr);
  out["grid"] = json_of(summary.grid);
  out["wgs84"] = json_of(summary.wgs84);
  out["validation"] = json_of(summary.validate, limits_of(summary));
  return finished(out, summary);
}

std::string timing_json(const std::vector<StageSeconds>& seconds, double seconds_total) {
  Json stages = Json::object();
  for (const StageSeconds& stage : seconds) stages[stage.stage] = stage.seconds;
  stages["total"] = seconds_total;
  return base::json_text(
      Json{{"schema", 1}, {"seconds", stages}, {"peak_memory_mb", peak_memory_mb()}});
}

std::optional<std::string> unchanged_summary(const std::string& path, const BuildSummary& fresh) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  // Whatever else lies under this name is no reason not to build.
  try {
    Json old = base::parse_json<Json>(text);
    // What the mesh refers to is known only once it has been read: the list of then, as it is now.
    Json& inputs = old.at("inputs");
    for (std::size_t i = inputs.size(); i-- > 0;) {
      if (inputs[i].at("role") != kMeshFile) continue;
      if (inputs[i].at("sha256") != sha256_if_there(inputs[i].at("path").get<std::string>()))
        return std::nullopt;
      inputs.erase(i);
    }
    const Json head = head_of(fresh);
    for (const auto& [key, value] : head.items())
      if (old.at(key) != value) return std::nullopt;
    if (old.at("recipe") != json_of(fresh.recipe)) return std::nullopt;
    failures_in_summary(text);
    return text;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::vector<std::string> failures_in_summary(const std::string& summary_json) {
  return base::parse_json<Json>(summary_json)
      .at("validation")
      .at("failures")
      .get<std::vector<std::string>>();
}

BuiltBeside built_beside(const std::string& crg_path) {
  const auto path = std::filesystem::path(crg_path).parent_path() / "summary.json";
  if (!std::filesystem::is_regular_file(path)) return {};
  const Json told = Json::parse(base::read_file(path.string()), nullptr, false);
  const auto list = [&](const std::string& pointer) {
    const Json::json_pointer at(pointer);
    return told.contains(at) && told.at(at).is_array() ? told.at(at) : Json::array();
  };
  const auto count = [&](const char* pointer) {
    const Json::json_pointer at(pointer);
    return told.contains(at) && told.at(at).is_number_unsigned() ? told.at(at).get<std::size_t>()
                                                                 : 0;
  };
  const Json outputs = list("/outputs");
  const std::string hash = outputs.empty() ? "" : base::sha256_of_file(crg_path);
  if (std::none_of(outputs.begin(), outputs.end(), [&](const Json& file) {
        return file.is_object() && file.contains("sha256") && file.at("sha256") == hash;
      }))
    return {};
  BuiltBeside out;
  for (const Json& failure : list("/validation/failures"))
    if (failure.is_string()) out.failures.push_back(failure.get<std::string>());
  const auto recipe = [&]<class T>(const char* key, T) {
    const Json::json_pointer at(std::string("/recipe/reference_") + key);
    const bool told_so = told.contains(at) && (std::is_same_v<T, double> ? told.at(at).is_number()
                                                                         : told.at(at).is_string());
    return told_so ? std::optional<T>(told.at(at).get<T>()) : std::nullopt;
  };
  out.published = {recipe("length_m", 0.0), recipe("climb_m", 0.0), recipe("width_m", 0.0),
                   recipe("source", std::string()), recipe("mesh", std::string())};
  const std::size_t every = count("/road_edges/every_rows"), rows = count("/grid/rows");
  const auto numbers = [&](const std::string& of) {
    std::vector<double> values;
    for (const Json& value : list("/road_edges/" + of))
      if (value.is_number()) values.push_back(value.get<double>());
    return values;
  };
  std::vector<double> right_m = numbers("right_m"), left_m = numbers("left_m");
  if (every == 0 || left_m.empty() || right_m.size() != left_m.size() ||
      rows > std::filesystem::file_size(crg_path))
    return out;
  const std::vector<double> row = numbers("changes/row"), from_right_m = numbers("changes/right_m"),
                            from_left_m = numbers("changes/left_m");
  const bool each_row = !row.empty() && row[0] == 0.0 && from_right_m.size() == row.size() &&
                        from_left_m.size() == row.size();
  if (each_row &&
      (rows - 1) % every != 0) {  // the last row lies between: of a circuit it is the first
    right_m.push_back(from_right_m.back());
    left_m.push_back(from_left_m.back());
  }
  const auto between = [&](const std::vector<double>& of, std::size_t i) {
    const std::size_t a = std::min(i / every, of.size() - 1), b = std::min(a + 1, of.size() - 1),
                      begin = a * every, end = std::min(b * every, rows - 1);
    return end > begin
               ? std::lerp(of[a], of[b],
                           static_cast<double>(i - begin) / static_cast<double>(end - begin))
               : of[a];
  };
  for (std::size_t i = 0; i < rows; ++i) {
    out.smooth.right_m.push_back(between(right_m, i));
    out.smooth.left_m.push_back(between(left_m, i));
  }
  if (!each_row) return out;
  for (std::size_t i = 0, k = 0; i < rows; ++i) {
    while (k + 1 < row.size() && row[k + 1] <= static_cast<double>(i)) ++k;
    out.edges.right_m.push_back(from_right_m[k]);
    out.edges.left_m.push_back(from_left_m[k]);
  }
  return out;
}

std::string edges_summary_json(const EdgesSummary& summary) {
  const EdgesReport& edges = summary.edges;
  Json out = head_of(summary);
  out["u_step_m"] = summary.recipe.options.u_step_m;
  out["v_step_m"] = summary.recipe.options.v_step_m;
  out["edges"] = {{"left_points", edges.left_points},
                  {"right_points", edges.right_points},
                  {"dropped_points", edges.dropped_points},
                  {"has_z", edges.has_z},
                  {"right_reversed", edges.right_reversed},
                  {"width_min_m", edges.width_min_m},
                  {"width_median_m", edges.width_median_m},
                  {"width_max_m", edges.width_max_m},
                  {"point_error_p99_m", edges.point_error_p99_m},
                  {"point_error_max_m", edges.point_error_max_m},
                  {"edge_gap_median_m", edges.edge_gap_median_m},
                  {"edge_gap_max_m", edges.edge_gap_max_m},
                  {"folds", json_of(edges.folds)},
                  {"remarks", edges.remarks}};
  out["reference_line"] = {{"length_m", summary.line_length_m},
                           {"closed", edges.closed},
                           {"start_offset_m", edges.start_offset_m}};
  out["grid"] = json_of(summary.grid);
  return finished(out, summary);
}

double peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
    if (word == "VmHWM:") {
      double kib = 0.0;
      status >> kib;
      return kib * 1024.0 / 1e6;
    }
  return 0.0;
}

}  // namespace road
