#include "sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "cloud/error.h"
#include "verge.h"
#include "visits.h"

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
  std::uint8_t visit = 0;
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
  Collector(const RoadFrame& frame, const MapOptions& options, Look& look)
      : frame_(frame),
        options_(options),
        sections_(look.sections),
        standing_(look.standing),
        visits_(look.sections.list.size()) {
    across_ =
        static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) + 1;
    along_ = static_cast<std::size_t>(2.0 * kReach_m / kSectionCell_m);
  }

  /// A point of a section came, whether add() wants it or not. `visit`: its number where that is
  /// known from elsewhere.
  void come(std::size_t index, const std::uint8_t* visit) {
    const Visits::Seen seen = visits_(index);
    if (seen.closed) close_one(*seen.closed);
    visit_ = visit != nullptr ? *visit : seen.number;
    const auto open = open_.find(index);
    if (open != open_.end() && open->second.visit != visit_) close_one(index);
  }

  /// The point that came last.
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
  }

 private:
  OpenSection& open_section(std::size_t index) {
    const auto found = open_.find(index);
    if (found != open_.end()) return found->second;
    OpenSection& open = open_[index];
    open.sums.assign(along_ * across_, {});
    open.position_m = sections_.list[index].position_m;
    open.row = sections_.list[index].row;
    open.visit = visit_;
    return open;
  }

  void close_one(std::size_t index) {
    const auto found = open_.find(index);
    if (found == open_.end()) return;
    close(index, found->second);
    open_.erase(found);
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
  Standing& standing_;
  std::size_t across_ = 0, along_ = 0;
  Visits visits_;
  std::uint8_t visit_ = 0;  ///< of the point that came last
  std::map<std::size_t, OpenSection> open_;
};

}  // namespace

Sections empty_sections(const RoadFrame& frame, const RoadTrajectory* trajectory) {
  Sections sections;
  if (trajectory == nullptr) {
    sections.first_of_piece = {0};
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
    sections.first_of_piece.push_back(sections.list.size());
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

std::size_t Sections::index_at(int piece, double driven_m) const {
  const auto p = static_cast<std::size_t>(piece);
  const std::size_t first = first_of_piece[p],
                    next = p + 1 < first_of_piece.size() ? first_of_piece[p + 1] : list.size();
  const auto along = static_cast<std::size_t>(
      std::max(0.0, (driven_m - (centre_m[first] - 0.5 * kSectionLength_m)) / kSectionLength_m));
  return std::min(first + along, next - 1);
}

Eigen::Matrix3d rotation_of(const Correction& c, const Eigen::Matrix3d& axes) {
  const Eigen::Vector3d turn = axes * c.tail<3>();
  if (turn.norm() == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

Look look_at(const CloudSource& source, const RoadFrame& frame, const RoadTrajectory* trajectory,
             const MapOptions& options, bool visits_known) {
  Sections empty = empty_sections(frame, trajectory);
  Standing standing(frame, empty.list.size());
  Look look{std::move(empty), std::move(standing)};
  Sections& sections = look.sections;
  Collector collector(frame, options, look);
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
    if (visits_known && chunk.classification.size() != chunk.size())
      throw Error("points of a tile have no numbers of their visits");
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
      const auto came = [&] {
        const int piece = trajectory == nullptr ? 0 : trajectory->poses.piece[point.pose];
        const std::size_t index = sections.index_at(piece, point.driven_m);
        collector.come(index, visits_known ? &chunk.classification[k * every] : nullptr);
        return index;
      };
      // With a trajectory which visit a point belongs to is a matter of time alone.
      std::size_t index = 0;
      if (trajectory != nullptr) index = came();
      sections.min_m = sections.min_m.cwiseMin(point.map_m.head<2>()),
      sections.max_m = sections.max_m.cwiseMax(point.map_m.head<2>());
      if (seen[k].how == Placed::off_road) {
        ++sections.off_road;
        continue;
      }
      if (std::abs(point.above_base_m) > options.gate_m) ++sections.far_from_base;
      if (point.above_base_m < -options.gate_m) continue;
      if (trajectory == nullptr) index = came();
      collector.add(index, point);
    }
  });
  collector.close_all();
  return look;
}

void join(Look& all, Look&& part) {
  Sections &to = all.sections, &from = part.sections;
  for (std::size_t s = 0; s < to.list.size(); ++s) {
    if (!from.list[s].has_data()) continue;
    if (to.list[s].has_data())
      throw Error(fmt::format("section {} of the trajectory was read twice", s + 1));
    to.list[s].cells = std::move(from.list[s].cells);
    all.standing.kept[s] = std::move(part.standing.kept[s]);
  }
  for (std::size_t k = 0; k < all.standing.seen.size(); ++k)
    all.standing.seen[k].standing += part.standing.seen[k].standing,
        all.standing.seen[k].clear += part.standing.seen[k].clear;
  to.points += from.points, to.without_pose += from.without_pose;
  to.off_road += from.off_road, to.far_from_base += from.far_from_base;
  to.on_obstacles += from.on_obstacles;
  to.time_begin_s = std::min(to.time_begin_s, from.time_begin_s);
  to.time_end_s = std::max(to.time_end_s, from.time_end_s);
  to.min_m = to.min_m.cwiseMin(from.min_m), to.max_m = to.max_m.cwiseMax(from.max_m);
}

Sections judged(Look&& look, const RoadFrame& frame, bool drifting) {
  look.standing.leave_out_feet(look.sections);
  look.sections.on_grass = leave_out_verge(look.sections, frame, drifting);
  return std::move(look.sections);
}

}  // namespace cloud
