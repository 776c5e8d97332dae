#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json_text.h"
#include "cloud/ground.h"
#include "cloud/pcl.h"
#include "cloud/read_cloud.h"
#include "cloud/register.h"
#include "commands.h"

namespace lidar2mesh {
namespace {

std::vector<std::uint8_t> ground_of(const cloud::Cloud& cloud, const GroundCommand& command,
                                    const base::Progress& progress) {
  if (command.method == "own") {
    cloud::GroundOptions options;
    options.cell_m = command.cell_m, options.height_m = command.height_m;
    options.max_window_m = command.window_m.value_or(options.max_window_m);
    options.slope = command.slope.value_or(options.slope);
    options.progress = progress;
    return cloud::classify_ground(cloud, options);
  }
  cloud::PclGroundOptions options;
  options.cell_m = command.cell_m, options.height_m = command.height_m;
  options.max_window_m = command.window_m.value_or(options.max_window_m);
  options.slope = command.slope.value_or(options.slope);
  options.approximate = command.method == "pmf-grid";
  return cloud::ground_by_pcl(cloud, options);
}

cloud::Cloud without_outliers(const cloud::Cloud& cloud, const cloud::FilterOptions& filter) {
  if (!filter.wanted()) return cloud;
  cloud::Cloud out;
  cloud::filtered([&](const cloud::ChunkSink& sink) { sink(cloud::Cloud(cloud)); }, nullptr,
                  filter)([&](cloud::Cloud&& left) { out = std::move(left); });
  return out;
}

/// By the method that was asked for; the facts are computed alike for both.
Eigen::Isometry3d registered(const cloud::Cloud& target, const cloud::Cloud& source,
                             const cloud::RegisterOptions& options, bool gicp,
                             cloud::RegisterReport& facts) {
  if (!gicp) return cloud::register_clouds(target, source, options, &facts);
  cloud::RegisterReport by_pcl, begin;
  const Eigen::Isometry3d T = cloud::register_by_gicp(target, source, options, &by_pcl);
  cloud::RegisterOptions look = options;
  look.max_iterations = 1, look.progress = {};
  cloud::register_clouds(target, source, look, &begin);
  look.start = T;
  cloud::register_clouds(target, source, look, &facts);
  facts.converged = by_pcl.converged, facts.iterations = by_pcl.iterations;
  facts.rms_before_m = begin.rms_before_m;
  return T;
}

}  // namespace

void want_outliers(const std::vector<double>& outliers) {
  try {
    cloud::want_outliers(outliers);
  } catch (const base::Error& error) {
    throw command::UsageError(error.what());
  }
}

int run_ground(const GroundCommand& command, Terminal& terminal) {
  cloud::require_cloud_ending(command.output);
  if (command.method != "own") cloud::require_pcl("--method " + command.method);
  cloud::CloudReadOptions read;
  read.metres_per_unit = metres_per_unit(command.unit);
  cloud::CloudReadReport report;
  const base::Progress progress = terminal.progress();
  read.progress = [&](double share) { progress("read", 0.2 * share); };
  cloud::Cloud cloud = cloud::read_cloud(command.cloud, read, &report);
  progress("ground", 0.2);
  const base::Progress step = [&](const std::string& stage, double share) {
    progress(stage, 0.2 + 0.7 * share);
  };
  const std::vector<std::uint8_t> ground = ground_of(cloud, command, step);
  std::size_t count = 0;
  cloud.classification.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.classification[i] = ground[i] ? 2 : 1;  // ASPRS: ground, unclassified
    count += ground[i];
  }
  progress("write", 0.9);
  const std::vector<road::InputFile> inputs = hashed("cloud", command.cloud);
  cloud::write_cloud(cloud, command.output, command.doubles, comments_of(inputs, command.options));
  if (terminal.json) {
    nlohmann::ordered_json out = head_of(inputs, command.options);
    out.update(nlohmann::ordered_json{
        {"points", cloud.size()},
        {"ground", count},
        {"cloud", command.output},
        {"origin_m", {cloud.origin_m.x(), cloud.origin_m.y(), cloud.origin_m.z()}},
        {"remarks", report.remarks}});
    terminal.print(base::json_text(out));
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
  const bool gicp = command.method == "gicp";
  const bool robust = command.robust || command.method == "robust";
  if (gicp && robust) throw command::UsageError("--robust is of --method own");
  if (gicp) cloud::require_pcl("--method gicp");
  if (command.coarse) cloud::require_pcl("--coarse");
  want_outliers(command.outliers);
  const cloud::FilterOptions filter = cloud::filter_options(command.outliers, 0.0);
  cloud::CloudReadOptions read;
  read.metres_per_unit = metres_per_unit(command.unit);
  const base::Progress progress = terminal.progress();
  progress("read", 0.0);
  cloud::CloudReadReport of_target, of_source;
  const cloud::Cloud target = cloud::read_cloud(command.target, read, &of_target),
                     source = cloud::read_cloud(command.source, read, &of_source);
  for (const auto& [path, report] :
       {std::pair(&command.target, &of_target), {&command.source, &of_source}})
    for (const std::string& remark : report->remarks)
      terminal.remark(fmt::format("{}: {}", *path, remark));
  cloud::RegisterOptions options;
  options.voxel_m = command.voxel_m, options.max_distance_m = command.reach_m,
  options.threads = command.threads, options.progress = progress, options.robust = robust;
  const cloud::Cloud to = without_outliers(target, filter), from = without_outliers(source, filter);
  cloud::CoarseReport start;
  if (command.coarse) {
    progress("start", 0.1);
    cloud::CoarseOptions coarse;
    coarse.voxel_m = std::max(0.5, 2.0 * command.voxel_m), coarse.seed = command.seed;
    options.start = cloud::coarse_start(to, from, coarse, &start);
  }
  cloud::RegisterReport facts;
  const Eigen::Isometry3d T = registered(to, from, options, gicp, facts);
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
                                      {"method", command.method},
                                      {"coarse_share", start.share},
                                      {"converged", facts.converged},
                                      {"iterations", facts.iterations},
                                      {"points", facts.points},
                                      {"inliers", facts.inliers},
                                      {"rms_before_m", facts.rms_before_m},
                                      {"rms_after_m", facts.rms_after_m},
                                      {"information", facts.information},
                                      {"unfixed", facts.unfixed}});
    terminal.print(base::json_text(out));
    return facts.converged ? kOk : kNotValid;
  }
  if (command.coarse)
    terminal.print(fmt::format("start without a guess: {:.0f} % of {} shapes of {:g} m together\n",
                               100.0 * start.share, start.points, start.voxel_m));
  terminal.print(fmt::format(
      "{} after {} iterations, {} of {} points paired, rms {:.4f} -> {:.4f} m\nT_target_source\n",
      facts.converged ? "converged" : "NOT converged", facts.iterations, facts.inliers,
      facts.points, facts.rms_before_m, facts.rms_after_m));
  for (int i = 0; i < 4; ++i)
    terminal.print(
        fmt::format("  {:12.8f} {:12.8f} {:12.8f} {:12.6f}\n", T(i, 0), T(i, 1), T(i, 2), T(i, 3)));
  terminal.print(fmt::format("information per pair, smallest first: {:.4f}\n",
                             fmt::join(facts.information, " ")));
  for (const std::string& direction : facts.unfixed)
    terminal.print(fmt::format("note: not fixed by the data, {}: {}\n",
                               gicp ? "as --method gicp left it" : "left alone", direction));
  return facts.converged ? kOk : kNotValid;
}

}  // namespace lidar2mesh
