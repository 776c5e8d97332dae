#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cloud/ground.h"
#include "cloud/read_cloud.h"
#include "cloud/register.h"
#include "commands.h"
#include "files/json_text.h"

namespace lidar2mesh {

int run_ground(const GroundCommand& command, Terminal& terminal) {
  cloud::require_cloud_ending(command.output);
  cloud::CloudReadOptions read;
  read.metres_per_unit = metres_per_unit(command.unit);
  cloud::CloudReadReport report;
  const files::Progress progress = terminal.progress();
  read.progress = [&](double share) { progress("read", 0.2 * share); };
  cloud::Cloud cloud = cloud::read_cloud(command.cloud, read, &report);
  progress("ground", 0.2);
  cloud::GroundOptions options;
  options.cell_m = command.cell_m, options.max_window_m = command.window_m,
  options.slope = command.slope, options.height_m = command.height_m;
  options.progress = [&](const std::string& stage, double share) {
    progress(stage, 0.2 + 0.7 * share);
  };
  const std::vector<std::uint8_t> ground = cloud::classify_ground(cloud, options);
  std::size_t count = 0;
  cloud.classification.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.classification[i] = ground[i] ? 2 : 1;  // ASPRS: ground, unclassified
    count += ground[i];
  }
  progress("write", 0.9);
  const std::vector<road::InputFile> inputs = hashed("cloud", command.cloud);
  cloud::write_cloud(cloud, command.output, command.doubles,
                     comments_of(inputs, command.options));
  if (terminal.json) {
    nlohmann::ordered_json out = head_of(inputs, command.options);
    out.update(nlohmann::ordered_json{
        {"points", cloud.size()},
        {"ground", count},
        {"cloud", command.output},
        {"origin_m", {cloud.origin_m.x(), cloud.origin_m.y(), cloud.origin_m.z()}},
        {"remarks", report.remarks}});
    terminal.print(files::json_text(out));
    return kOk;
  }
  terminal.print(fmt::format("{} of {} points are ground (class 2)\n", count, cloud.size()));
  for (const std::string& remark : report.remarks)
    terminal.print(fmt::format("note: {}\n", one_line(remark)));
  if (!command.doubles && !cloud.origin_m.isZero())
    terminal.print(
        fmt::format("note: coordinates are relative to {} {} {} (origin_m in the header)\n",
                    cloud.origin_m.x(), cloud.origin_m.y(), cloud.origin_m.z()));
  terminal.print(fmt::format("cloud    {}\n", command.output));
  return kOk;
}

int run_register(const RegisterCommand& command, Terminal& terminal) {
  if (!command.output.empty()) cloud::require_cloud_ending(command.output);
  cloud::CloudReadOptions read;
  read.metres_per_unit = metres_per_unit(command.unit);
  const files::Progress progress = terminal.progress();
  progress("read", 0.0);
  const cloud::Cloud target = cloud::read_cloud(command.target, read),
                     source = cloud::read_cloud(command.source, read);
  cloud::RegisterOptions options;
  options.voxel_m = command.voxel_m, options.max_distance_m = command.reach_m,
  options.threads = command.threads, options.progress = progress;
  cloud::RegisterReport facts;
  const Eigen::Isometry3d T = cloud::register_clouds(target, source, options, &facts);
  std::vector<road::InputFile> inputs = hashed("target", command.target);
  for (const road::InputFile& file : hashed("source", command.source)) inputs.push_back(file);
  if (!command.output.empty()) {
    cloud::Cloud moved = source;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const Eigen::Vector3d p = T * (source.origin_m + source.point(i)) - source.origin_m;
      moved.x_m[i] = p.x(), moved.y_m[i] = p.y(), moved.z_m[i] = p.z();
    }
    cloud::write_cloud(moved, command.output, command.doubles,
                       comments_of(inputs, command.options));
  }
  if (terminal.json) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (int i = 0; i < 4; ++i) rows.push_back({T(i, 0), T(i, 1), T(i, 2), T(i, 3)});
    nlohmann::ordered_json out = head_of(inputs, command.options);
    out.update(nlohmann::ordered_json{{"T_target_source", rows},
                                                           {"converged", facts.converged},
                                                           {"iterations", facts.iterations},
                                                           {"points", facts.points},
                                                           {"inliers", facts.inliers},
                                                           {"rms_before_m", facts.rms_before_m},
                                                           {"rms_after_m", facts.rms_after_m},
                                                           {"information", facts.information},
                                                           {"unfixed", facts.unfixed}});
    terminal.print(files::json_text(out));
    return facts.converged ? kOk : kNotValid;
  }
  terminal.print(fmt::format(
      "{} after {} iterations, {} of {} points paired, rms {:.4f} -> {:.4f} m\nT_target_source\n",
      facts.converged ? "converged" : "NOT converged", facts.iterations, facts.inliers,
      facts.points, facts.rms_before_m, facts.rms_after_m));
  for (int i = 0; i < 4; ++i)
    terminal.print(fmt::format("  {:12.8f} {:12.8f} {:12.8f} {:12.6f}\n", T(i, 0), T(i, 1), T(i, 2), T(i, 3)));
  terminal.print(fmt::format("information per pair, smallest first: {:.4f}\n", fmt::join(facts.information, " ")));
  for (const std::string& direction : facts.unfixed)
    terminal.print(fmt::format("note: not fixed by the data, left alone: {}\n", direction));
  return facts.converged ? kOk : kNotValid;
}

}  // namespace lidar2mesh
