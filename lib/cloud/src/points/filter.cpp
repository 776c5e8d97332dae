#include "cloud/filter.h"

#include <memory>

#include "cloud/pcl.h"

namespace cloud {
namespace {

/// The points that have a place in the map, there; `numbers` are theirs in the chunk.
Cloud in_map(const Cloud& chunk, const Trajectory* trajectory, std::vector<std::size_t>& numbers) {
  Cloud out;
  std::size_t hint = 0;
  for (std::size_t i = 0; i < chunk.size(); ++i) {
    Eigen::Vector3d p = chunk.origin_m + chunk.point(i);
    PosedInstant pose;
    if (trajectory != nullptr) {
      if (i >= chunk.time_s.size() || !pose_at(*trajectory, chunk.time_s[i], hint, pose)) continue;
      p = pose.position_m + pose.orientation * p;
    }
    if (numbers.empty()) out.origin_m = p;
    p -= out.origin_m;
    out.x_m.push_back(p.x()), out.y_m.push_back(p.y()), out.z_m.push_back(p.z());
    numbers.push_back(i);
  }
  return out;
}

Cloud subset(const Cloud& cloud, const std::vector<bool>& kept) {
  Cloud out;
  out.origin_m = cloud.origin_m;
  const auto copy = [&](const auto& from, auto& to) {
    for (std::size_t i = 0; i < from.size(); ++i)
      if (kept[i]) to.push_back(from[i]);
  };
  copy(cloud.x_m, out.x_m), copy(cloud.y_m, out.y_m), copy(cloud.z_m, out.z_m);
  copy(cloud.time_s, out.time_s), copy(cloud.intensity, out.intensity);
  copy(cloud.classification, out.classification), copy(cloud.sigma_m, out.sigma_m);
  return out;
}

std::vector<bool> kept_of(const Cloud& chunk, const Trajectory* trajectory,
                          const FilterOptions& options, FilterReport& report) {
  std::vector<bool> kept(chunk.size(), true);
  std::vector<std::size_t> numbers;
  Cloud points = in_map(chunk, trajectory, numbers);
  const auto leave_out = [&](const std::vector<std::uint8_t>& keep, std::size_t& count) {
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < numbers.size(); ++k)
      if (keep[k])
        left.push_back(numbers[k]);
      else
        kept[numbers[k]] = false, ++count;
    numbers = std::move(left);
    points = subset(points, std::vector<bool>(keep.begin(), keep.end()));
  };
  report.points += chunk.size();
  if (options.outlier_neighbours > 0)
    leave_out(statistical_inliers(points, options.outlier_neighbours, options.outlier_sigma),
              report.outliers);
  if (options.voxel_m > 0.0)
    leave_out(voxel_representatives(points, options.voxel_m), report.thinned);
  return kept;
}

}  // namespace

CloudSource filtered(CloudSource scans, const Trajectory* trajectory, const FilterOptions& options,
                     FilterReport* report) {
  auto known = std::make_shared<std::vector<std::vector<bool>>>();
  return [=](const ChunkSink& sink) {
    std::size_t number = 0;
    scans([&](Cloud&& chunk) {
      if (number == known->size()) {
        FilterReport unused;
        known->push_back(kept_of(chunk, trajectory, options, report != nullptr ? *report : unused));
      }
      Cloud left = subset(chunk, (*known)[number++]);
      if (left.size() > 0) sink(std::move(left));
    });
  };
}

}  // namespace cloud
