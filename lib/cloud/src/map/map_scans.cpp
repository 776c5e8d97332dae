#include "cloud/map_scans.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "cloud/error.h"
#include "cloud/read_cloud.h"

namespace cloud {
namespace {

constexpr double kDegree = 0.017453292519943295;

double bytes_of(const std::string& file) {
  return static_cast<double>(std::filesystem::file_size(file));
}

/// The points no farther from the sensor than this.
Cloud within(Cloud&& cloud, double range_m) {
  std::size_t kept = 0;
  const auto keep = [&](auto& values, std::size_t k) {
    if (!values.empty()) values[kept] = values[k];
  };
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    if (!((cloud.origin_m + cloud.point(k)).norm() <= range_m)) continue;
    keep(cloud.x_m, k), keep(cloud.y_m, k), keep(cloud.z_m, k);
    keep(cloud.time_s, k), keep(cloud.intensity, k), keep(cloud.classification, k),
        keep(cloud.sigma_m, k);
    ++kept;
  }
  const auto cut = [&](auto& values) {
    if (!values.empty()) values.resize(kept);
  };
  cut(cloud.time_s), cut(cloud.intensity), cut(cloud.classification), cut(cloud.sigma_m);
  cut(cloud.x_m), cut(cloud.y_m), cut(cloud.z_m);
  return std::move(cloud);
}

/// Of files that gave no point.
[[noreturn]] void refuse_marked(const std::vector<std::string>& files, const MarkedPoints& marked,
                                bool some_not_finite) {
  const char* const assign = marked.noise > 0      ? "Classification=1"
                             : marked.withheld > 0 ? "Withheld=0"
                             : marked.overlap > 0  ? "Overlap=0"
                                                   : "NumberOfReturns=1";
  throw Error(fmt::format(
      "{}{}: all points are marked as noise (class 7 or 18: {}), withheld ({}), overlap ({}) or "
      "not "
      "the last return ({}){}; take the marks off where they are wrong, as with 'pdal translate "
      "in.las out.las assign --filters.assign.value=\"{}\" --writers.las.forward=all'{}",
      files.front(), files.size() > 1 ? fmt::format(" and {} more", files.size() - 1) : "",
      marked.noise, marked.withheld, marked.overlap, marked.not_last,
      some_not_finite ? ", or without finite coordinates" : "", assign,
      marked.overlap > 0 ? " (class 12: Classification=1)" : ""));
}

/// Such marks spare what others show as well: most points cannot be that.
void want_few_in_overlap(const MarkedPoints& marked, std::size_t points) {
  if (marked.overlap <= points) return;
  throw Error(fmt::format(
      "{} points are marked as overlap of swaths (the flag, or class 12), only {} are not: left "
      "out they would leave holes; where all swaths are good, take the marks off, as with 'pdal "
      "translate in.las out.las assign --filters.assign.value=\"Overlap=0\" "
      "--writers.las.forward=all' (class 12: Classification=1)",
      marked.overlap, points));
}

}  // namespace

std::optional<double> metres_per_unit(const std::string& unit) {
  if (unit == "m") return 1.0;
  if (unit == "cm") return 0.01;
  if (unit == "mm") return 0.001;
  if (unit == "ft") return 0.3048;
  if (unit == "us-ft") return 1200.0 / 3937.0;
  return std::nullopt;
}

Eigen::Isometry3d sensor_in_poses(const std::vector<double>& extrinsic) {
  const std::vector<double>& e = extrinsic;
  if (e.size() != 6) return Eigen::Isometry3d::Identity();
  return Eigen::Translation3d(e[0], e[1], e[2]) *
         Eigen::AngleAxisd(e[5] * kDegree, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(e[4] * kDegree, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(e[3] * kDegree, Eigen::Vector3d::UnitX());
}

bool points_lie_in_map(const RefineRequest& request) {
  const bool in_map =
      request.frame == "map" || (request.frame.empty() && request.trajectory.empty());
  if (!in_map && request.trajectory.empty())
    throw Error("points in the sensor's frame need a trajectory: --trajectory T.csv");
  if (in_map && request.max_range_m)
    throw Error(
        "--max-range-m wants points in the sensor's frame: those in the map frame do not say from "
        "where they were measured");
  return in_map;
}

std::vector<std::string> scan_files(const RefineRequest& request) {
  std::vector<std::string> files;
  for (const std::string& scan : request.scans)
    for (const std::string& file : cloud_files(scan)) files.push_back(file);
  return files;
}

MapScans::MapScans(const RefineRequest& request, std::vector<std::string> files,
                   base::Progress progress)
    : request_(request), files_(std::move(files)), progress_(std::move(progress)) {
  options_.metres_per_unit = metres_per_unit(request.unit);
  options_.leave_out_marked = true;
  options_.progress = [this](double share) { show(share); };
  for (const std::string& file : files_) bytes_in_all_ += bytes_of(file);
}

CloudSource MapScans::source() {
  return [this](const ChunkSink& sink) { read(sink); };
}

void MapScans::enter(const std::string& stage, double begin_share, double end_share) {
  stage_ = stage, stage_begin_ = begin_share, stage_end_ = end_share;
  read_share_ = 0.0;
}

void MapScans::show(double share_of_file) {
  read_share_ = (bytes_before_ + share_of_file * bytes_here_) / bytes_in_all_;
  if (std::this_thread::get_id() == owner_) tell();
}

void MapScans::tell() const {
  progress_(stage_, stage_begin_ + (stage_end_ - stage_begin_) * read_share_);
}

void MapScans::read(const ChunkSink& sink) {
  const auto near = [&](Cloud&& chunk) {
    if (request_.max_range_m) chunk = within(std::move(chunk), *request_.max_range_m);
    if (chunk.size() > 0) sink(std::move(chunk));
  };
  remarks_.clear();
  bytes_before_ = 0.0;
  MarkedPoints marked;
  std::size_t points = 0, not_finite = 0;
  std::vector<std::string> said;  // once, however many files it is true of
  std::vector<std::size_t> files;
  for (const std::string& file : files_) {
    bytes_here_ = bytes_of(file);
    const CloudReadReport report = read_chunks(file, options_, near);
    for (const std::string& remark : report.remarks) {
      const auto at =
          static_cast<std::size_t>(std::find(said.begin(), said.end(), remark) - said.begin());
      if (at == said.size()) said.push_back(remark), files.push_back(0), remarks_.push_back(file);
      ++files[at];
    }
    marked.add(report.marked);
    points += report.points, not_finite += report.not_finite;
    bytes_before_ += bytes_here_;
  }
  if (points == 0 && !files_.empty()) refuse_marked(files_, marked, not_finite > 0);
  want_few_in_overlap(marked, points);
  for (std::size_t k = 0; k < said.size(); ++k)
    remarks_[k] += (files[k] > 1 ? fmt::format(" and {} more: ", files[k] - 1) : ": ") + said[k];
  for (const std::string& remark : remarks_of(marked, true)) remarks_.push_back(remark);
}

}  // namespace cloud
