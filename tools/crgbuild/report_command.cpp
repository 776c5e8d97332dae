#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/sha256.h"
#include "cloud/read_cloud.h"
#include "commands.h"
#include "crg/surface.h"
#include "road/build.h"
#include "road/error.h"
#include "road/write_report.h"

namespace crgbuild {
namespace {

std::string command_line(const std::string& subcommand,
                         const std::vector<std::pair<std::string, std::string>>& words,
                         const RecipeFlags& flags) {
  std::string text = "crgbuild " + subcommand;
  for (const auto& [flag, value] : words) {
    if (value.empty()) continue;
    text += (flag.empty() ? " " : " " + flag + " ") + shell_word(value);
  }
  const auto stands_alone = [](const std::string& name) {
    const std::vector<road::RecipeKey>& keys = road::recipe_keys();
    return std::any_of(keys.begin(), keys.end(), [&](const road::RecipeKey& key) {
      return key.name == name && is_switch(key);
    });
  };
  for (const auto& [name, value] : flags)
    text += " " + flag_of(name) + (stands_alone(name) ? "" : " " + shell_word(value));
  return text;
}

void place_mesh(const road::Recipe& recipe, road::ReportRequest& request) {
  request.mesh_path = recipe.mesh_path;
  request.read = recipe.read;
  request.threads = recipe.sample.threads;
  request.align = recipe.align;
  request.validate = recipe.validate;
  if (recipe.control_points_path)
    request.control_points =
        road::read_control_point_file(*recipe.control_points_path, recipe.projection).points;
  if (recipe.T_global_mesh) request.T_global_mesh = *recipe.T_global_mesh;
}

/// The points of a cloud that a comparison looks at: over or under the road by 1 m or less.
std::vector<Eigen::Vector3d> points_near(const std::string& crg_path,
                                         const std::string& cloud_path) {
  const crg::Surface surface(crg::read(crg_path));
  std::vector<Eigen::Vector3d> near;
  std::size_t seen = 0;
  crg::Cursor cursor;
  for (const std::string& path : cloud::cloud_files(cloud_path)) {
    cloud::read_chunks(path, {}, [&](cloud::Cloud&& chunk) {
      seen += chunk.size();
      for (std::size_t i = 0; i < chunk.size(); ++i) {
        const Eigen::Vector3d point = chunk.origin_m + chunk.point(i);
        const double z_m = surface.z_at_xy(point.x(), point.y(), cursor);
        if (std::abs(point.z() - z_m) <= 1.0) near.push_back(point);
      }
    });
  }
  if (near.empty()) {
    throw road::Error(
        fmt::format("{}: none of its {} points lies within 1 m of the road {}; give a cloud in the "
                    "frame and unit of the road",
                    cloud_path, seen, crg_path));
  }
  return near;
}

std::string sentence(const road::ReportFiles& files) {
  switch (files.verdict) {
    case road::Verdict::usable:
      return "usable";
    case road::Verdict::usable_with_remarks:
      return fmt::format("usable with {} remarks", files.remarks);
    case road::Verdict::not_usable:
      return fmt::format("not usable: {} error{}, {} remark{}", files.errors,
                         files.errors == 1 ? "" : "s", files.remarks,
                         files.remarks == 1 ? "" : "s");
  }
  return "";
}

constexpr const char* kNoPage =
    "this build has no report page, only report.json was written; run scripts/setup and build "
    "again for report.html";

}  // namespace

int run_report(const ReportCommand& command, Terminal& terminal) {
  const road::Progress progress = terminal.progress();
  progress("report", 0.0);
  road::ReportRequest request;
  if (!command.mesh.empty()) {
    place_mesh(make_recipe(command.mesh, command.flags), request);
  } else if (!command.flags.empty()) {
    place_mesh(make_recipe(command.flags), request);
    request.mesh_path.clear();
  }
  request.crg_path = command.crg;
  request.against_path = command.against;
  request.before_path = command.before;
  request.grip_path = command.grip;
  request.command_line = command_line("report",
                                      {{"", command.crg},
                                       {"--mesh", command.mesh},
                                       {"--against", command.against},
                                       {"--cloud", command.cloud},
                                       {"--before", command.before},
                                       {"--grip", command.grip},
                                       {"-o", command.output_dir}},
                                      command.flags);
  const std::vector<Eigen::Vector3d> points = command.cloud.empty()
                                                  ? std::vector<Eigen::Vector3d>{}
                                                  : points_near(command.crg, command.cloud);
  request.cloud_path = command.cloud;
  request.cloud_points_m = points;
  if (!command.cloud.empty()) {
    for (const std::string& path : cloud::cloud_files(command.cloud))
      request.sources.push_back({"cloud", path, base::sha256_of_file(path)});
  }
  const base::FolderLock lock(command.output_dir, "crgbuild report");
  const road::ReportFiles files = road::write_report(request, command.output_dir);
  terminal.progress_done();
  if (terminal.json) {
    terminal.print(
        base::json_text(nlohmann::ordered_json{{"verdict", road::to_string(files.verdict)},
                                               {"errors", files.errors},
                                               {"remarks", files.remarks},
                                               {"report_json", files.json_path},
                                               {"report_html", files.page_path}}));
  } else {
    terminal.print(fmt::format("{}: {}\n", command.crg, sentence(files)));
    if (!files.page_path.empty()) terminal.print(fmt::format("report   {}\n", files.page_path));
    terminal.print(fmt::format("numbers  {}\n", files.json_path));
  }
  if (files.page_path.empty()) terminal.remark(kNoPage);
  refuse_if_not_usable(command.crg, files);
  return kOk;
}

void refuse_if_not_usable(const std::string& crg_path, const road::ReportFiles& files) {
  if (files.verdict != road::Verdict::not_usable) return;
  throw NotValid(fmt::format("{}: not usable, {} error{}; see {}", crg_path, files.errors,
                             files.errors == 1 ? "" : "s",
                             files.page_path.empty() ? files.json_path : files.page_path));
}

void print_report(const road::ReportFiles& files, Terminal& terminal) {
  if (!terminal.json) {
    terminal.print(fmt::format("report   {} ({})\n",
                               files.page_path.empty() ? files.json_path : files.page_path,
                               sentence(files)));
  }
  if (files.page_path.empty()) terminal.remark(kNoPage);
}

road::ReportFiles report_build(const BuildCommand& command, const road::Recipe& recipe,
                               const road::BuildResult& result, const road::BuildEvidence& evidence,
                               const base::OutputSet& outputs) {
  road::ReportRequest request;
  place_mesh(recipe, request);
  const auto staged = [&](const std::string& path) {
    return path.empty() ? "" : outputs.staged(std::filesystem::path(path).filename().string());
  };
  request.crg_path = staged(result.crg_path);
  request.shown_folder = command.output_dir;
  request.title = recipe.name;
  request.mesh = &evidence.mesh;
  request.provenance = &evidence.provenance;
  if (evidence.before) request.before = &*evidence.before;
  request.grip_path = staged(result.friction_path);
  request.command_line =
      command_line("build", {{"", command.input}, {"-o", command.output_dir}}, command.flags);
  const auto summary = nlohmann::json::parse(result.summary_json);
  if (const std::string bound = smoothing_bound(summary); !bound.empty())
    request.remarks.push_back(bound);
  const auto& align = summary["align"];
  if (!align.is_null() &&
      (align["by"] == "trajectory" || align["by"] == "guide")) {  // by the build
    request.T_global_mesh.yaw_rad = align["yaw_deg"].get<double>() * M_PI / 180.0;
    for (int k = 0; k < 3; ++k)
      request.T_global_mesh.translation_m[k] =
          align["translation_m"][static_cast<std::size_t>(k)].get<double>();
  }
  request.validated = evidence.validate;
  request.kerbs = evidence.kerbs;
  request.road_width_m = evidence.road_width_m;
  for (const auto& input : summary["inputs"]) {
    if (input["role"] == "mesh" || input["sha256"] == "")
      continue;  // the report reads and hashes it itself; missing
    request.sources.push_back({input["role"].get<std::string>(), input["path"].get<std::string>(),
                               input["sha256"].get<std::string>()});
  }
  road::ReportFiles files = road::write_report(request, outputs.staged(""));
  for (std::string* path : {&files.json_path, &files.page_path})
    if (!path->empty()) *path = outputs.path(std::filesystem::path(*path).filename().string());
  return files;
}

}  // namespace crgbuild
