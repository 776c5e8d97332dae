#include "sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "cloud/error.h"
#include "collector.h"
#include "verge.h"

namespace cloud {
namespace {

constexpr std::size_t kAtOnce = 16'384, kPerThread = 2048;  // points

}  // namespace

std::size_t verge_column(const RoadFrame& frame, double row, double v_m) {
  const double first_m = frame.v_m().front();
  const auto along = static_cast<std::size_t>(row * frame.u_step_m() / kVergeStretch_m),
             column = static_cast<std::size_t>(std::max(0.0, (v_m - first_m) / kSectionCell_m)),
             across = static_cast<std::size_t>((frame.v_m().back() - first_m) / kSectionCell_m) + 1;
  return along * across + std::min(column, across - 1);
}

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
  Collector collector(frame, trajectory, options, visits_known, look);
  std::vector<Fall> falls;
  const auto every = static_cast<std::size_t>(std::max(1, options.estimate_every));
  source([&](Cloud&& chunk) {
    if (trajectory != nullptr && chunk.time_s.empty())
      throw Error(
          "the points have no time, so they cannot be placed on the trajectory; a property 'time' "
          "is wanted, or --frame map for a registered cloud");
    if (visits_known && chunk.classification.size() != chunk.size())
      throw Error("points of a tile have no numbers of their visits");
    const std::size_t count = (chunk.size() + every - 1) / every;
    for (std::size_t first = 0; first < count; first += kAtOnce) {
      falls.resize(std::min(kAtOnce, count - first));
      base::parallel_for(falls.size(), kPerThread, options.threads,
                         [&](std::size_t begin, std::size_t end) {
                           Placer place(frame, trajectory);
                           for (std::size_t k = begin; k < end; ++k)
                             falls[k] = collector.fall_of(place, chunk, (first + k) * every);
                         });
      for (const Fall& fall : falls) collector.add(fall);
    }
    if (chunk.time_s.empty()) return;
    for (std::size_t k = 0; k < chunk.size(); k += every)
      sections.time_begin_s = std::min(sections.time_begin_s, chunk.time_s[k]),
      sections.time_end_s = std::max(sections.time_end_s, chunk.time_s[k]);
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

Sections judged(Look&& look, const RoadFrame& frame, bool drifting, double edge_m) {
  look.standing.leave_out_feet(look.sections);
  look.sections.on_grass = leave_out_verge(look.sections, frame, drifting, edge_m);
  return std::move(look.sections);
}

}  // namespace cloud
