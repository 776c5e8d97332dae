#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/sha256.h"
#include "cloud/read_cloud.h"
#include "commands.h"
#include "crg/surface.h"
#include "inspect/write_report.h"
#include "make/summary.h"
#include "mesh/error.h"

namespace crgbuild {
namespace {

/// The points of a cloud that a comparison looks at: over or under the road by 1 m or less.
std::vector<Eigen::Vector3d> points_near(const std::string& crg_path, const std::string& cloud_path,
                                         Terminal& terminal) {
  const crg::Surface surface(crg::read(crg_path));
  std::vector<Eigen::Vector3d> near;
  std::size_t seen = 0;
  crg::Cursor cursor;
  for (const std::string& path : cloud::cloud_files(cloud_path)) {
    const cloud::CloudReadReport read = cloud::read_chunks(path, {}, [&](cloud::Cloud&& chunk) {
      seen += chunk.size();
      for (std::size_t i = 0; i < chunk.size(); ++i) {
        const Eigen::Vector3d point = chunk.origin_m + chunk.point(i);
        const double z_m = surface.z_at_xy(point.x(), point.y(), cursor);
        if (std::abs(point.z() - z_m) <= 1.0) near.push_back(point);
      }
    });
    for (const std::string& remark : read.remarks)
      terminal.remark(fmt::format("{}: {}", path, remark));
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
      return fmt::format("usable with {} remark{}", files.remarks, files.remarks == 1 ? "" : "s");
    case road::Verdict::not_usable:
      return fmt::format("not usable: {} error{}, {} remark{}", files.errors.size(),
                         files.errors.size() == 1 ? "" : "s", files.remarks,
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
    road::place_mesh(make_recipe(command.mesh, command.flags), request);
  } else if (!command.flags.empty()) {
    road::place_mesh(make_recipe(command.flags), request);
    request.mesh_path.clear();
  }
  request.crg_path = command.crg;
  road::BuiltBeside built = road::built_beside(command.crg);
  request.edges = std::move(built.edges);
  request.failures = std::move(built.failures);
  request.published = std::move(built.published);
  request.against_path = command.against;
  request.before_path = command.before;
  request.grip_path = command.grip;
  request.command_line = road::command_line("report",
                                            {{"", command.crg},
                                             {"--mesh", command.mesh},
                                             {"--against", command.against},
                                             {"--cloud", command.cloud},
                                             {"--before", command.before},
                                             {"--grip", command.grip},
                                             {"-o", command.output_dir}},
                                            command.flags);
  const std::vector<Eigen::Vector3d> points =
      command.cloud.empty() ? std::vector<Eigen::Vector3d>{}
                            : points_near(command.crg, command.cloud, terminal);
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
                                               {"errors", files.errors.size()},
                                               {"remarks", files.remarks},
                                               {"report_json", files.json_path},
                                               {"report_html", files.page_path}}));
  } else {
    terminal.print(fmt::format("{}: {}\n", command.crg, sentence(files)));
    if (!files.page_path.empty()) terminal.print(fmt::format("report   {}\n", files.page_path));
    terminal.print(fmt::format("numbers  {}\n", files.json_path));
  }
  if (files.page_path.empty()) terminal.remark(kNoPage);
  if (const std::string why = road::not_usable(command.crg, files); !why.empty())
    throw NotValid(why);
  return kOk;
}

void print_report(const road::ReportFiles& files, Terminal& terminal) {
  if (!terminal.json) {
    terminal.print(fmt::format("report   {} ({})\n",
                               files.page_path.empty() ? files.json_path : files.page_path,
                               sentence(files)));
  }
  if (files.page_path.empty()) terminal.remark(kNoPage);
}

}  // namespace crgbuild
