#include "collector.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace cloud {
namespace {

constexpr double kReach_m = 35.0;           // of a section along the road, both ways
constexpr double kObstacleTop_m = 2.2;      // higher things (gantries, trees) hang over the road
constexpr std::uint32_t kFirst = 3;         // points of a cell, kept apart as strays are
constexpr std::uint32_t kMostKept = 32;     // points of a cell
constexpr std::uint32_t kEnoughAlone = 12;  // of them have a plane of their own
// Cells along the road whose points have one plane together, before and behind; columns that blades
// hang over.
constexpr std::size_t kWindow = 2, kOverhang = 3;
// Beyond the lane's own: what a base with another shape scatters, and what no asphalt does.
constexpr double kCalm_m = 0.001, kGrass_m = 0.004;

std::size_t cells_across(const RoadFrame& frame) {
  return static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) + 1;
}

}  // namespace

CellSlopes::CellSlopes(const RoadFrame& frame, unsigned threads)
    : v_begin_m_(frame.v_m().front()),
      along_(std::max<std::size_t>(1, static_cast<std::size_t>(frame.length_m() / kSectionCell_m))),
      across_(cells_across(frame)) {
  cell_rows_ = static_cast<double>(frame.rows() - 1) / static_cast<double>(along_);
  slopes_.resize(along_ * across_);
  base::parallel_for(along_, 64, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = 0; j < across_; ++j) {
        const GridPlace middle{(static_cast<double>(i) + 0.5) * cell_rows_,
                               v_begin_m_ + (static_cast<double>(j) + 0.5) * kSectionCell_m};
        const Eigen::Vector2d slope = frame.gradient(middle, kSectionCell_m);
        slopes_[i * across_ + j] =
            slope.allFinite() ? slope.cast<float>() : Eigen::Vector2f(0.0f, 0.0f);
      }
  });
}

Eigen::Vector2d CellSlopes::at(const GridPlace& place) const {
  const auto i = static_cast<std::size_t>(std::max(0.0, place.row / cell_rows_)),
             j = static_cast<std::size_t>(std::max(0.0, (place.v_m - v_begin_m_) / kSectionCell_m));
  return slopes_[std::min(i, along_ - 1) * across_ + std::min(j, across_ - 1)].cast<double>();
}

Collector::Collector(const RoadFrame& frame, const RoadTrajectory* trajectory,
                     const MapOptions& options, bool visits_known, Look& look)
    : frame_(frame),
      trajectory_(trajectory),
      gate_m_(options.gate_m),
      edge_m_(options.edge_m),
      visits_known_(visits_known),
      sections_(look.sections),
      standing_(look.standing),
      slopes_(frame, options.threads),
      across_(cells_across(frame)),
      along_(static_cast<std::size_t>(2.0 * kReach_m / kSectionCell_m)),
      visits_(look.sections.list.size()) {}

Fall Collector::fall_of(Placer& placer, const Cloud& chunk, std::size_t i) const {
  Fall fall;
  RoadPoint point;
  const Placed placed = placer(chunk, i, point);
  if (placed == Placed::no_pose) return fall;
  fall.how = Fall::off_road;
  fall.place_m = point.map_m;
  if (visits_known_) fall.visit = chunk.classification[i];
  // Without a trajectory where a point was driven past is known on the road only.
  if (trajectory_ == nullptr && placed == Placed::off_road) return fall;
  const int piece = trajectory_ == nullptr ? 0 : trajectory_->poses.piece[point.pose];
  const std::size_t index = sections_.index_at(piece, point.driven_m);
  const Section& section = sections_.list[index];
  fall.section = static_cast<std::uint32_t>(index);
  if (placed == Placed::off_road) return fall;
  fall.height_m = point.above_base_m;
  fall.how = Fall::too_low;
  if (point.above_base_m < -gate_m_) return fall;
  fall.how = Fall::beside;
  double ahead = point.place.row - section.row;
  const auto period = static_cast<double>(frame_.rows() - 1);
  if (frame_.closed() && 2.0 * std::abs(ahead) >= period)
    ahead -= period * std::round(ahead / period);
  const double ahead_m = ahead * frame_.u_step_m() + kReach_m,
               across_m = point.place.v_m - frame_.v_m().front();
  if (!(ahead_m >= 0.0 && ahead_m < 2.0 * kReach_m)) return fall;
  const auto cell = static_cast<double>(static_cast<std::ptrdiff_t>(ahead_m / kSectionCell_m));
  if (cell >= static_cast<double>(along_)) return fall;
  const auto column = static_cast<std::size_t>(across_m / kSectionCell_m);
  fall.cell = static_cast<std::uint32_t>(static_cast<std::size_t>(cell) * across_ +
                                         std::min(column, across_ - 1));
  fall.how = point.above_base_m > gate_m_ ? Fall::above_cell : Fall::on_cell;
  fall.on_m = point.driven_m - sections_.centre_m[index];
  fall.a_m = ahead_m - (cell + 0.5) * kSectionCell_m;
  fall.b_m = across_m - (static_cast<double>(column) + 0.5) * kSectionCell_m;
  if (trajectory_ == nullptr) return fall;
  const Eigen::Vector3d& ray_m = point.ray_m;
  const double across = ray_m.z() - slopes_.at(point.place).dot(ray_m.head<2>()),
               range2 = ray_m.squaredNorm();
  if (range2 > 0.0) fall.sine2 = std::min(1.0, across * across / range2);
  return fall;
}

void Collector::come(const Fall& fall) {
  if (came_ == fall.section && (!visits_known_ || fall.visit == visit_)) return;
  const Visits::Seen seen = visits_(fall.section);
  if (seen.closed) close_one(*seen.closed);
  came_ = fall.section, visit_ = visits_known_ ? fall.visit : seen.number;
  const auto open = open_.find(fall.section);
  if (open != open_.end() && open->second.visit != visit_) close_one(fall.section);
  open_here_ = nullptr;
}

void Collector::add(const Fall& fall) {
  ++sections_.points;
  if (fall.how == Fall::no_pose) {
    ++sections_.without_pose;
    return;
  }
  sections_.min_m = sections_.min_m.cwiseMin(fall.place_m.head<2>()),
  sections_.max_m = sections_.max_m.cwiseMax(fall.place_m.head<2>());
  // With a trajectory which visit a point belongs to is a matter of time alone.
  if (trajectory_ != nullptr || fall.how >= Fall::beside) come(fall);
  if (fall.how == Fall::off_road) {
    ++sections_.off_road;
    return;
  }
  if (std::abs(fall.height_m) > gate_m_) ++sections_.far_from_base;
  if (fall.how < Fall::on_cell) return;
  if (open_here_ == nullptr) open_here_ = &open_section(fall.section);
  Sum& sum = open_here_->sums[fall.cell];
  if (fall.how == Fall::above_cell) {
    if (fall.height_m >= kObstacleTop_m) return;
    std::vector<Tall>& tall = open_here_->tall;
    if (sum.tall < 0)
      sum.tall = static_cast<std::int32_t>(tall.size()), tall.push_back({fall.cell, 0, {}});
    Tall& here = tall[static_cast<std::size_t>(sum.tall)];
    ++here.points;
    here.box.add(static_cast<float>(fall.a_m), static_cast<float>(fall.b_m));
    here.b += fall.b_m, here.bb += fall.b_m * fall.b_m;
    return;
  }
  const Section& section = sections_.list[fall.section];
  const bool is_stray =
      sum.points < kFirst || std::abs(fall.height_m - sum.height / sum.points) > kStray_m;
  const bool is_kept = (fall.sine2 > 0.0 || trajectory_ == nullptr) && sum.kept < kMostKept;
  add(fall, section, sum);
  if (!is_stray && !is_kept) return;
  std::vector<KeptPoint>& points = open_here_->points;
  const auto at = static_cast<std::int32_t>(points.size());
  points.push_back({fall, sum.last, sum.last_stray});
  if (is_stray) sum.last_stray = at;
  if (is_kept) sum.last = at, ++sum.kept;
}

void Collector::add(const Fall& fall, const Section& section, Sum& sum) const {
  const Eigen::Vector3d p = fall.place_m - section.position_m;
  sum.x += p.x(), sum.y += p.y(), sum.z += p.z();
  sum.driven += fall.on_m, sum.driven2 += fall.on_m * fall.on_m;
  sum.height += fall.height_m, sum.height2 += fall.height_m * fall.height_m;
  sum.a += fall.a_m, sum.b += fall.b_m;
  sum.aa += fall.a_m * fall.a_m, sum.ab += fall.a_m * fall.b_m, sum.bb += fall.b_m * fall.b_m;
  sum.ah += fall.a_m * fall.height_m, sum.bh += fall.b_m * fall.height_m;
  sum.sine2 += fall.sine2;
  ++sum.points;
}

void Collector::close_all() {
  for (auto& [index, open] : open_) close(index, open);
  open_.clear();
  came_.reset(), open_here_ = nullptr;
}

Collector::OpenSection& Collector::open_section(std::size_t index) {
  const auto found = open_.find(index);
  if (found != open_.end()) return found->second;
  OpenSection& open = open_[index];
  if (!spare_.empty()) {
    open = std::move(spare_.back());
    spare_.pop_back();
  }
  open.sums.assign(along_ * across_, {});
  open.points.clear(), open.tall.clear();
  open.visit = visit_;
  return open;
}

void Collector::close_one(std::size_t index) {
  const auto found = open_.find(index);
  if (found == open_.end()) return;
  close(index, found->second);
  spare_.push_back(std::move(found->second));
  open_.erase(found);
}

/// Sum of the squares of heights about their plane.
double Collector::about_plane(const Sum& s) {
  const double n = s.points;
  Eigen::Matrix2d m;
  m << s.aa - s.a * s.a / n, s.ab - s.a * s.b / n, s.ab - s.a * s.b / n, s.bb - s.b * s.b / n;
  const Eigen::Vector2d right(s.ah - s.a * s.height / n, s.bh - s.b * s.height / n);
  const double all = s.height2 - s.height * s.height / n;
  // Points in a line have no plane: what is left then is taken about the slope along it.
  m.diagonal().array() += 1e-6 * n;
  return std::max(0.0, all - right.dot(m.ldlt().solve(right)));
}

/// With fewer than 4 points about the base as it is tilted: thin scans have nothing else.
double Collector::square_of(const Sum& sum) {
  if (sum.points >= 4) return about_plane(sum);
  return std::max(0.0, sum.height2 - sum.height * sum.height / sum.points);
}

double Collector::freedom_of(const Sum& sum) { return sum.points - (sum.points >= 4 ? 3.0 : 1.0); }

double Collector::v_of(std::size_t column) const {
  return frame_.v_m().front() + (static_cast<double>(column) + 0.5) * kSectionCell_m;
}

bool Collector::in_lane(std::size_t column, const Section& section) const {
  return std::abs(v_of(column) - section.v_m) < kLane_m;
}

LaneScatter Collector::lane_of(const Section& section, const OpenSection& open) const {
  LaneScatter lane;
  for (std::size_t k = 0; k < open.sums.size(); ++k) {
    const Sum& sum = open.sums[k];
    if (sum.points < 4 || !in_lane(k % across_, section) ||
        near_obstacle(open, k / across_, k % across_))
      continue;
    SectionCell cell;
    cell.square_m2 = static_cast<float>(square_of(sum)),
    cell.freedom = static_cast<float>(freedom_of(sum));
    cell.sine2 = static_cast<float>(sum.sine2 / sum.points);
    lane.add(cell);
  }
  lane.close();
  return lane;
}

std::vector<EdgePoint> Collector::points_in(const OpenSection& open, std::size_t cell,
                                            std::size_t reach) const {
  std::vector<EdgePoint> points;
  points.reserve(kMostKept * (1 + 2 * reach));
  const std::size_t i = cell / across_;
  const auto gather = [&](std::size_t row) {
    const double ahead_m = (static_cast<double>(row) - static_cast<double>(i)) * kSectionCell_m;
    for (std::int32_t k = open.sums[row * across_ + cell % across_].last; k >= 0;
         k = open.points[static_cast<std::size_t>(k)].before) {
      const Fall& fall = open.points[static_cast<std::size_t>(k)].fall;
      points.push_back({static_cast<float>(ahead_m + fall.a_m), static_cast<float>(fall.b_m),
                        static_cast<float>(fall.height_m)});
    }
  };
  gather(i);
  for (std::size_t away = 1; away <= reach; ++away) {
    if (i >= away) gather(i - away);
    if (i + away < along_) gather(i + away);
  }
  return points;
}

double Collector::noise_m(const Section& section, const LaneScatter& lane, const OpenSection& open,
                          std::size_t cell) const {
  SectionCell seen;
  seen.sine2 = static_cast<float>(open.sums[cell].sine2 / open.sums[cell].points);
  const double ahead_m = (static_cast<double>(cell / across_) + 0.5) * kSectionCell_m - kReach_m;
  const GridPlace place{frame_.wrapped(section.row + ahead_m / frame_.u_step_m()),
                        v_of(cell % across_)};
  return std::hypot(std::sqrt(lane.at_m2(seen)), scatter_of_bend_m(bend_of(frame_, place)));
}

std::vector<Collector::Scatter> Collector::scatter_of(const Section& section,
                                                      const LaneScatter& lane,
                                                      const OpenSection& open) const {
  std::vector<Scatter> out(open.sums.size(), Scatter::unknown);
  for (std::size_t k = 0; k < open.sums.size(); ++k) {
    const Sum& sum = open.sums[k];
    if (sum.points < 4) continue;
    const double noise2_m2 = std::pow(noise_m(section, lane, open, k), 2),
                 mean2_m2 = square_of(sum) / freedom_of(sum);
    out[k] = mean2_m2 > 4.0 * noise2_m2 + kGrass_m * kGrass_m ? Scatter::as_grass
             : mean2_m2 > 2.0 * noise2_m2 + kCalm_m * kCalm_m ? Scatter::some
                                                              : Scatter::calm;
  }
  return out;
}

bool Collector::before_grass(const std::vector<Scatter>& scatter, std::size_t cell,
                             bool to_left) const {
  const std::size_t i = cell / across_, j = cell % across_;
  for (std::size_t row = i - std::min(i, kWindow); row <= std::min(i + kWindow, along_ - 1); ++row)
    for (std::size_t out = 0; out <= kOverhang; ++out) {
      if (to_left ? j + out >= across_ : out > j) break;
      if (scatter[row * across_ + (to_left ? j + out : j - out)] == Scatter::as_grass) return true;
    }
  return false;
}

Collector::Sum Collector::ground_of(const Section& section, const OpenSection& open,
                                    std::size_t cell, double noise_m, Scatter scatter) const {
  Sum all = open.sums[cell];
  std::vector<std::uint8_t> ground;
  if (all.kept >= kEnoughAlone) ground = ground_among(points_in(open, cell, 0), noise_m);
  if (ground.empty()) ground = ground_among(points_in(open, cell, kWindow), noise_m);
  if (ground.empty()) {
    all.doubtful = scatter != Scatter::some;
    return all;
  }
  Sum left;
  std::size_t at = 0;  // the cell's own points come first
  for (std::int32_t k = all.last; k >= 0; k = open.points[static_cast<std::size_t>(k)].before)
    if (ground[at++] != 0) add(open.points[static_cast<std::size_t>(k)].fall, section, left);
  if (left.points == all.kept) return all;
  left.cut_above_m = static_cast<float>(most_above_ground_m(noise_m)),
  left.cut_points = static_cast<float>(all.kept - left.points);
  left.obstacle = all.obstacle, left.beside = all.beside;
  return left;
}

void Collector::leave_out_overhang(const Section& section, OpenSection& open) const {
  const LaneScatter lane = lane_of(section, open);
  std::vector<Scatter> scatter = scatter_of(section, lane, open);
  for (std::size_t k = 0; k < scatter.size(); ++k)
    if (scatter[k] == Scatter::as_grass && std::abs(v_of(k % across_)) < edge_m_)
      scatter[k] = Scatter::some;
  std::vector<std::pair<std::size_t, Sum>> changed;  // each is judged by what its neighbours were
  for (std::size_t k = 0; k < open.sums.size(); ++k) {
    if (open.sums[k].kept == 0 || scatter[k] == Scatter::calm || in_lane(k % across_, section))
      continue;
    if (!before_grass(scatter, k, v_of(k % across_) > section.v_m)) continue;
    const double noise = noise_m(section, lane, open, k);
    if (noise > 0.0) changed.emplace_back(k, ground_of(section, open, k, noise, scatter[k]));
  }
  for (const auto& [k, sum] : changed) open.sums[k] = sum;
}

void Collector::close(std::size_t index, OpenSection& open) {
  Section& section = sections_.list[index];
  find_obstacles(open);
  leave_out_drops(section, open);
  leave_out_obstacles(section, open);
  if (trajectory_ != nullptr) leave_out_overhang(section, open);
  for (std::size_t i = 0; i < along_; ++i)
    for (std::size_t j = 0; j < across_; ++j) {
      const Sum& sum = open.sums[i * across_ + j];
      if (sum.points < 2) continue;
      const double ahead_m = (static_cast<double>(i) + 0.5) * kSectionCell_m - kReach_m;
      const std::size_t road_cell = standing_.cell_at(section.row, ahead_m, j);
      standing_.saw(road_cell, sum.obstacle || sum.beside);
      if (sum.obstacle) {
        sections_.on_obstacles += sum.points;
        continue;
      }
      const double n = sum.points;
      standing_.keep(index, road_cell);
      section.cells.push_back({static_cast<float>(sum.x / n), static_cast<float>(sum.y / n),
                               static_cast<float>(sum.z / n), static_cast<float>(n),
                               static_cast<float>(sum.driven / n),
                               static_cast<float>(sum.driven2 / n)});
      SectionCell& cell = section.cells.back();
      cell.sine2 = static_cast<float>(sum.sine2 / n);
      cell.square_m2 = static_cast<float>(square_of(sum)),
      cell.freedom = static_cast<float>(freedom_of(sum));
      cell.cut_above_m = sum.cut_above_m, cell.cut_points = sum.cut_points;
      cell.sheet = sum.sheet;
      cell.doubtful = sum.doubtful, cell.beside = sum.beside;
    }
}

}  // namespace cloud
