#include "sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "causes.h"
#include "cloud/error.h"
#include "standing.h"
#include "verge.h"

namespace cloud {
namespace {

constexpr double kReach_m = 35.0;       // of a section along the road, both ways
constexpr double kObstacleTop_m = 2.2;  // higher things (gantries, trees) hang over the road

/// Sums of one cell while its section is open.
struct Sum {
  double x = 0.0, y = 0.0, z = 0.0, driven = 0.0, driven2 = 0.0, height = 0.0, height2 = 0.0;
  double a = 0.0, b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0, ah = 0.0, bh = 0.0;  ///< about the middle
  double sine2 = 0.0;
  std::uint32_t points = 0;
  bool obstacle = false;
};

struct OpenSection {
  std::vector<Sum> sums;
  Eigen::Vector3d position_m;
  double row = 0.0;
  std::size_t last_use = 0;
};

/// Sum of the squares of heights about their plane.
double about_plane(const Sum& s) {
  const double n = s.points;
  Eigen::Matrix2d m;
  m << s.aa - s.a * s.a / n, s.ab - s.a * s.b / n, s.ab - s.a * s.b / n, s.bb - s.b * s.b / n;
  const Eigen::Vector2d right(s.ah - s.a * s.height / n, s.bh - s.b * s.height / n);
  const double all = s.height2 - s.height * s.height / n;
  // Points in a line have no plane: what is left then is taken about the slope along it.
  m.diagonal().array() += 1e-6 * n;
  return std::max(0.0, all - right.dot(m.ldlt().solve(right)));
}

class Collector {
 public:
  Collector(const RoadFrame& frame, const MapOptions& options, Sections& sections)
      : frame_(frame),
        options_(options),
        sections_(sections),
        standing_(frame, sections.list.size()) {
    across_ =
        static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) + 1;
    along_ = static_cast<std::size_t>(2.0 * kReach_m / kSectionCell_m);
  }

  void add(std::size_t index, const RoadPoint& point) {
    OpenSection& open = open_section(index);
    double ahead = point.place.row - open.row;
    const auto period = static_cast<double>(frame_.rows() - 1);
    if (frame_.closed()) ahead -= period * std::round(ahead / period);
    const double cell = std::floor((ahead * frame_.u_step_m() + kReach_m) / kSectionCell_m);
    if (!(cell >= 0.0 && cell < static_cast<double>(along_))) return;
    const auto column =
        static_cast<std::size_t>((point.place.v_m - frame_.v_m().front()) / kSectionCell_m);
    Sum& sum = open.sums[static_cast<std::size_t>(cell) * across_ + std::min(column, across_ - 1)];
    if (point.above_base_m > options_.gate_m) {
      sum.obstacle |= point.above_base_m < kObstacleTop_m;
      return;
    }
    const Eigen::Vector3d p = point.map_m - open.position_m;
    const double on = point.driven_m - sections_.centre_m[index];
    sum.x += p.x(), sum.y += p.y(), sum.z += p.z(), sum.driven += on, sum.driven2 += on * on;
    sum.height += point.above_base_m, sum.height2 += point.above_base_m * point.above_base_m;
    const double a = ahead * frame_.u_step_m() + kReach_m - (cell + 0.5) * kSectionCell_m,
                 b = point.place.v_m - frame_.v_m().front() -
                     (static_cast<double>(column) + 0.5) * kSectionCell_m;
    sum.a += a, sum.b += b, sum.aa += a * a, sum.ab += a * b, sum.bb += b * b;
    sum.ah += a * point.above_base_m, sum.bh += b * point.above_base_m;
    sum.sine2 += point.sine2;
    ++sum.points;
  }

  void close_all() {
    for (auto& [index, open] : open_) close(index, open);
    open_.clear();
    standing_.leave_out_feet(sections_);
  }

 private:
  OpenSection& open_section(std::size_t index) {
    ++clock_;
    const auto found = open_.find(index);
    if (found != open_.end()) {
      found->second.last_use = clock_;
      return found->second;
    }
    if (open_.size() >= 8) {
      auto oldest = open_.begin();
      for (auto i = open_.begin(); i != open_.end(); ++i)
        if (i->second.last_use < oldest->second.last_use) oldest = i;
      close(oldest->first, oldest->second);
      open_.erase(oldest);
    }
    OpenSection& open = open_[index];
    open.sums.assign(along_ * across_, {});
    open.position_m = sections_.list[index].position_m;
    open.row = sections_.list[index].row;
    open.last_use = clock_;
    return open;
  }

  bool near_obstacle(const OpenSection& open, std::size_t i, std::size_t j) const {
    constexpr std::size_t kAround = 2;
    for (std::size_t k = i - std::min(i, kAround); k <= std::min(i + kAround, along_ - 1); ++k)
      for (std::size_t l = j - std::min(j, kAround); l <= std::min(j + kAround, across_ - 1); ++l)
        if (open.sums[k * across_ + l].obstacle) return true;
    return false;
  }

  void close(std::size_t index, const OpenSection& open) {
    Section& section = sections_.list[index];
    for (std::size_t i = 0; i < along_; ++i)
      for (std::size_t j = 0; j < across_; ++j) {
        const Sum& sum = open.sums[i * across_ + j];
        if (sum.points < 2) continue;
        const double ahead_m = (static_cast<double>(i) + 0.5) * kSectionCell_m - kReach_m;
        const std::size_t road_cell = standing_.cell_at(open.row, ahead_m, j);
        if (near_obstacle(open, i, j)) {
          standing_.saw_standing(road_cell);
          sections_.on_obstacles += sum.points;
          continue;
        }
        const double n = sum.points;
        standing_.keep(index, road_cell, sum.height / n);
        section.cells.push_back({static_cast<float>(sum.x / n), static_cast<float>(sum.y / n),
                                 static_cast<float>(sum.z / n), static_cast<float>(n),
                                 static_cast<float>(sum.driven / n),
                                 static_cast<float>(sum.driven2 / n)});
        SectionCell& cell = section.cells.back();
        cell.sine2 = static_cast<float>(sum.sine2 / n);
        if (sum.points >= 4)
          cell.square_m2 = static_cast<float>(about_plane(sum)),
          cell.freedom = static_cast<float>(n - 3.0);
        else  // about the base as it is tilted: thin scans have nothing else
          cell.square_m2 =
              static_cast<float>(std::max(0.0, sum.height2 - sum.height * sum.height / n)),
          cell.freedom = static_cast<float>(n - 1.0);
      }
  }

  const RoadFrame& frame_;
  const MapOptions& options_;
  Sections& sections_;
  Standing standing_;
  std::size_t across_ = 0, along_ = 0, clock_ = 0;
  std::map<std::size_t, OpenSection> open_;
};

/// Sections along the trajectory (or along u), with nothing in them yet.
Sections empty_sections(const RoadFrame& frame, const RoadTrajectory* trajectory,
                        std::vector<std::size_t>& first_of_piece) {
  Sections sections;
  if (trajectory == nullptr) {
    first_of_piece = {0};
    for (double u = 0.0; u < frame.length_m(); u += kSectionLength_m) {
      Section section;
      section.row = std::min((u + 0.5 * kSectionLength_m) / frame.u_step_m(),
                             static_cast<double>(frame.rows() - 1));
      const auto k = static_cast<std::size_t>(section.row);
      const Eigen::Vector2d xy = frame.node_position(k, 0.0);
      const double z = frame.height({section.row, 0.0});
      section.position_m = {xy.x(), xy.y(), frame.z_origin_m() + (std::isfinite(z) ? z : 0.0)};
      section.heading_rad = frame.heading_rad(section.row);
      section.axes =
          Eigen::AngleAxisd(section.heading_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      sections.list.push_back(section);
      sections.centre_m.push_back(u + 0.5 * kSectionLength_m);
    }
    return sections;
  }
  const Trajectory& poses = trajectory->poses;
  for (std::size_t i = 0; i < poses.size();) {
    std::size_t end = i;
    while (end < poses.size() && poses.piece[end] == poses.piece[i]) ++end;
    first_of_piece.push_back(sections.list.size());
    const double begin = poses.driven_m[i], length = poses.driven_m[end - 1] - begin;
    // The last one may be half as long or half as long again.
    const auto count =
        static_cast<std::size_t>(std::max(1.0, std::floor(length / kSectionLength_m + 0.5)));
    std::size_t pose = i;
    for (std::size_t k = 0; k < count; ++k) {
      const double centre = begin + (static_cast<double>(k) + 0.5) * kSectionLength_m;
      while (pose + 1 < end && poses.driven_m[pose] < centre) ++pose;
      Section section;
      section.piece = poses.piece[i];
      section.pass = trajectory->pass[pose];
      section.position_m = poses.position_m[pose];
      section.row = trajectory->row[pose], section.v_m = trajectory->v_m[pose];
      const Eigen::Vector3d ahead = poses.orientation[pose] * Eigen::Vector3d::UnitX();
      section.heading_rad = std::atan2(ahead.y(), ahead.x());
      section.axes = poses.orientation[pose].toRotationMatrix();
      std::size_t from = pose, to = pose;
      while (from > i && poses.driven_m[from] > centre - 0.4 * kSectionLength_m) --from;
      while (to + 1 < end && poses.driven_m[to] < centre + 0.4 * kSectionLength_m) ++to;
      const double span = poses.driven_m[to] - poses.driven_m[from];
      if (span > 0.5) {
        section.ahead = (poses.position_m[to] - poses.position_m[from]) / span;
        const Eigen::AngleAxisd turn(poses.orientation[to] * poses.orientation[from].conjugate());
        section.turning_1pm =
            std::remainder(turn.angle(), 2.0 * std::numbers::pi) / span * turn.axis();
      }
      sections.list.push_back(section);
      sections.centre_m.push_back(centre);
    }
    i = end;
  }
  return sections;
}

}  // namespace

Eigen::Matrix3d rotation_of(const Correction& c, const Eigen::Matrix3d& axes) {
  const Eigen::Vector3d turn = axes * c.tail<3>();
  if (turn.norm() == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

RoadTrajectory place_on_road(Trajectory trajectory, const RoadFrame& frame) {
  RoadTrajectory placed;
  const std::size_t n = trajectory.size();
  placed.row.assign(n, 0.0), placed.v_m.assign(n, 0.0), placed.pass.assign(n, 0);
  double row = 0.0, turns_begin = 0.0, unwrapped = 0.0;
  std::size_t beside = 0;
  int pass = 0;
  bool lost = true;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = trajectory.position_m[i];
    const bool new_piece = i == 0 || trajectory.piece[i] != trajectory.piece[i - 1];
    std::optional<GridPlace> place;
    if (!new_piece && !lost) place = frame.project(p.x(), p.y(), row);
    if (!place) place = frame.project(p.x(), p.y(), frame.nearest_row(p.x(), p.y()));
    const bool on =
        place && place->v_m > frame.v_m().front() - 3.0 && place->v_m < frame.v_m().back() + 3.0;
    lost = !on;
    beside += on ? 0 : 1;
    const double here = place ? place->row : row;
    double step = here - row;
    const auto period = static_cast<double>(frame.rows() - 1);
    if (frame.closed()) step -= period * std::round(step / period);
    if (new_piece) {
      pass += i == 0 ? 0 : 1;
      turns_begin = unwrapped = here;
    } else {
      unwrapped += step;
      if (std::abs(unwrapped - turns_begin) >= period) ++pass, turns_begin = unwrapped;
    }
    row = here;
    placed.row[i] = here, placed.v_m[i] = place ? place->v_m : 0.0, placed.pass[i] = pass;
  }
  if (2 * beside > n) {
    Eigen::Vector3d low = trajectory.position_m.front(), high = low;
    for (const Eigen::Vector3d& p : trajectory.position_m)
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    Eigen::Vector2d road_low = frame.node_position(0, 0.0), road_high = road_low;
    for (std::size_t i = 0; i < frame.rows(); ++i)
      road_low = road_low.cwiseMin(frame.node_position(i, 0.0)),
      road_high = road_high.cwiseMax(frame.node_position(i, 0.0));
    const double ratio =
        (road_high - road_low).norm() / std::max(1e-9, (high - low).head<2>().norm());
    std::string hint = "another frame?";
    for (const auto& [factor, unit] : {std::pair{100.0, "cm"}, {1000.0, "mm"}, {3.28084, "ft"}})
      if (std::abs(ratio / factor - 1.0) < 0.1)
        hint = fmt::format("the base is {:.4g} times as large, as if it were in {}; give --unit {}",
                           ratio, unit, unit);
    throw Misfit(
        fmt::format("{} of {} poses lie beside the base: poses x {:.1f} to {:.1f}, y {:.1f} to "
                    "{:.1f} m, base x {:.1f} to {:.1f}, y {:.1f} to {:.1f} m; {}",
                    beside, n, low.x(), high.x(), low.y(), high.y(), road_low.x(), road_high.x(),
                    road_low.y(), road_high.y(), hint));
  }
  placed.poses = std::move(trajectory);
  return placed;
}

Placed Placer::operator()(const Cloud& chunk, std::size_t i, RoadPoint& point) {
  if (trajectory_ != nullptr) {
    PosedInstant pose;
    if (!pose_at(trajectory_->poses, chunk.time_s[i], pose_, pose)) return Placed::no_pose;
    point.map_m = pose.position_m + pose.orientation * (chunk.point(i) + chunk.origin_m);
    point.driven_m = pose.driven_m;
    const Eigen::Vector3d ray = point.map_m - pose.position_m;
    point.range_m = ray.norm();
    point.ray = point.range_m > 0.0 ? Eigen::Vector3d(ray / point.range_m) : ray;
    point.pose = pose_;
    row_ = trajectory_->row[pose_];
  } else {
    point.map_m = chunk.origin_m + chunk.point(i);
  }
  std::optional<GridPlace> place;
  if (row_ >= 0.0) place = frame_.project(point.map_m.x(), point.map_m.y(), row_);
  const auto beside = [&] {
    return !place || place->v_m < frame_.v_m().front() || place->v_m > frame_.v_m().back();
  };
  if (trajectory_ == nullptr && beside())
    place = frame_.project(point.map_m.x(), point.map_m.y(),
                           frame_.nearest_row(point.map_m.x(), point.map_m.y()));
  if (beside()) return Placed::off_road;
  point.place = *place;
  if (trajectory_ == nullptr) row_ = place->row, point.driven_m = place->row * frame_.u_step_m();
  point.above_base_m = point.map_m.z() - frame_.z_origin_m() - frame_.height(*place);
  return std::isfinite(point.above_base_m) ? Placed::on_road : Placed::off_road;
}

Sections collect_sections(const CloudSource& source, const RoadFrame& frame,
                          const RoadTrajectory* trajectory, const MapOptions& options,
                          bool drifting) {
  std::vector<std::size_t> first_of_piece;
  Sections sections = empty_sections(frame, trajectory, first_of_piece);
  sections.time_begin_s = std::numeric_limits<double>::infinity(),
  sections.time_end_s = -sections.time_begin_s;
  Collector collector(frame, options, sections);
  struct Seen {
    Placed how = Placed::off_road;
    RoadPoint point;
  };
  std::vector<Seen> seen;
  const auto every = static_cast<std::size_t>(std::max(1, options.estimate_every));
  source([&](Cloud&& chunk) {
    if (trajectory != nullptr && chunk.time_s.empty())
      throw Error(
          "the points have no time, so they cannot be placed on the trajectory; a property 'time' "
          "is wanted, or --frame map for a registered cloud");
    const std::size_t count = (chunk.size() + every - 1) / every;
    seen.resize(count);
    base::parallel_for(count, 4096, options.threads, [&](std::size_t begin, std::size_t end) {
      Placer place(frame, trajectory);
      for (std::size_t k = begin; k < end; ++k) {
        RoadPoint& point = seen[k].point;
        seen[k].how = place(chunk, k * every, point);
        point.sine2 = 0.0;
        if (seen[k].how != Placed::on_road || point.ray.isZero()) continue;
        const Eigen::Vector2d slope = frame.gradient(point.place, kSectionCell_m);
        const double across =
            slope.allFinite() ? point.ray.z() - slope.dot(point.ray.head<2>()) : point.ray.z();
        point.sine2 = std::min(1.0, across * across);
      }
    });
    for (std::size_t k = 0; k < count; ++k) {
      ++sections.points;
      if (!chunk.time_s.empty())
        sections.time_begin_s = std::min(sections.time_begin_s, chunk.time_s[k * every]),
        sections.time_end_s = std::max(sections.time_end_s, chunk.time_s[k * every]);
      const RoadPoint& point = seen[k].point;
      if (seen[k].how == Placed::no_pose) {
        ++sections.without_pose;
        continue;
      }
      sections.min_m = sections.min_m.cwiseMin(point.map_m.head<2>()),
      sections.max_m = sections.max_m.cwiseMax(point.map_m.head<2>());
      if (seen[k].how == Placed::off_road) {
        ++sections.off_road;
        continue;
      }
      if (std::abs(point.above_base_m) > options.gate_m) ++sections.far_from_base;
      if (point.above_base_m < -options.gate_m) continue;
      const std::size_t piece =
          trajectory == nullptr ? 0 : static_cast<std::size_t>(trajectory->poses.piece[point.pose]);
      const std::size_t first = first_of_piece[piece], next = piece + 1 < first_of_piece.size()
                                                                  ? first_of_piece[piece + 1]
                                                                  : sections.list.size();
      const auto along = static_cast<std::size_t>(
          std::max(0.0, (point.driven_m - (sections.centre_m[first] - 0.5 * kSectionLength_m)) /
                            kSectionLength_m));
      collector.add(std::min(first + along, next - 1), point);
    }
  });
  collector.close_all();
  sections.on_grass = leave_out_verge(sections, frame, drifting);
  return sections;
}

}  // namespace cloud
