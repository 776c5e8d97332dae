#include "verge.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "lane_scatter.h"
#include "overhang.h"
#include "verge_columns.h"

namespace cloud {
namespace {

// Grass of 5 mm mean height scatters by 3 mm, a road 8 m beside the sensor by 1 to 1.5 mm.
constexpr double kTimes = 2.0, kFloor_m = 0.001, kDriftingFloor_m = 0.002;
// Beside grass less will do.
constexpr double kTimesBeside = 1.4, kFloorBeside_m = 0.0003;
constexpr int kGrow = 6;
constexpr float kNoSurface_m = 0.03f;    // a cell that scatters more is none, wherever it lies
constexpr double kMostScattering = 0.4;  // of a column must scatter: a car that passed is no grass
constexpr double kEnoughFreedom = 12.0;
constexpr std::size_t kWideRun = 3;  // columns: wider than the steep part of a kerb

/// Of a section's cell.
struct Where {
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t column = kNone;
  bool in_lane = false;
};

/// What lies beyond grass as seen from the lane.
void look_beyond(VergeColumn* row, std::size_t across) {
  const std::size_t lane = lane_of(row, across);
  if (lane == across) return;
  bool passed = false;
  for (std::size_t j = lane; j < across; ++j) row[j].beyond = passed |= row[j].grass;
  passed = false;
  for (std::size_t j = lane; j-- > 0;) row[j].beyond = passed |= row[j].grass;
}

/// Grass grows over columns beside it that scatter a little, not into the lane.
void grow(std::vector<VergeColumn>& columns, std::size_t along, std::size_t across, bool closed) {
  const std::vector<VergeColumn> before = columns;
  const auto grass = [&](std::size_t i, std::size_t j) { return before[i * across + j].grass; };
  for (std::size_t i = 0; i < along; ++i)
    for (std::size_t j = 0; j < across; ++j) {
      VergeColumn& column = columns[i * across + j];
      if (column.grass || column.paved || column.lane > 0.0 || column.is == VergeColumn::unknown)
        continue;
      const bool back = i > 0 ? grass(i - 1, j) : closed && grass(along - 1, j);
      const bool forth = i + 1 < along ? grass(i + 1, j) : closed && grass(0, j);
      const bool beside = (j > 0 && grass(i, j - 1)) || (j + 1 < across && grass(i, j + 1));
      if (!back && !forth && !beside) continue;
      // Along the foot of a kerb, whose bend would explain the blades as well, it goes on.
      const bool at_kerb = beside && (back || forth) && column.bent_m2 > 0.5 * column.expected_m2;
      column.grass =
          column.square_m2 >
              kTimesBeside * (column.expected_m2 - (at_kerb ? column.bent_m2 : 0.0)) +
                  kFloorBeside_m * kFloorBeside_m * column.freedom &&
          (at_kerb || column.scattering > kMostScattering * (column.freedom + column.overhung));
    }
}

/// Cells of two or three points have no plane of their own: they count in scans that have hardly
/// anything else. Whether these are such scans.
bool forget_thin_cells(Sections& sections) {
  std::size_t thin = 0, all = 0;
  for (const Section& section : sections.list)
    for (const SectionCell& cell : section.cells) ++all, thin += cell.points < 4.0f ? 1 : 0;
  if (2 * thin > all) return true;
  for (Section& section : sections.list)
    for (SectionCell& cell : section.cells)
      if (cell.points < 4.0f) cell.square_m2 = cell.freedom = 0.0f;
  return false;
}

/// Scatters or calm, by its own cells, or where these are few by those of up to 50 m of road before
/// and behind.
void judge(std::vector<VergeColumn>& columns, std::size_t along, std::size_t across, bool closed,
           double floor_m) {
  constexpr std::size_t kReach = 5;
  for (std::size_t i = 0; i < along; ++i)
    for (std::size_t j = 0; j < across; ++j) {
      VergeColumn& column = columns[i * across + j];
      if (column.points == 0.0) continue;
      if (column.paved) {
        column.is = VergeColumn::calm;
        continue;
      }
      VergeColumn sum = column;
      for (std::size_t away = 1; away <= kReach && sum.freedom < kEnoughFreedom; ++away) {
        const auto add = [&](const VergeColumn& other) {
          sum.freedom += other.freedom, sum.square_m2 += other.square_m2;
          sum.expected_m2 += other.expected_m2, sum.scattering += other.scattering;
          sum.overhung += other.overhung;
        };
        if (2 * away >= along) break;
        if (closed || i >= away) add(columns[(i + along - away) % along * across + j]);
        if (closed || i + away < along) add(columns[(i + away) % along * across + j]);
      }
      if (sum.freedom < kEnoughFreedom) continue;
      column.is = sum.square_m2 > kTimes * sum.expected_m2 + floor_m * floor_m * sum.freedom &&
                          sum.scattering > kMostScattering * (sum.freedom + sum.overhung)
                      ? VergeColumn::scatters
                      : VergeColumn::calm;
    }
}

/// What nothing is known about on the far side of grass is grass as well.
void follow_grass(VergeColumn* row, std::size_t across) {
  for (std::size_t j = 1; j < across; ++j)
    row[j].grass |= row[j].beyond && row[j].is == VergeColumn::unknown && row[j - 1].grass;
  for (std::size_t j = across - 1; j-- > 0;)
    row[j].grass |= row[j].beyond && row[j].is == VergeColumn::unknown && row[j + 1].grass;
}

/// Runs of scattering columns that are grass, and what lies beyond them as seen from the lane.
void mark(VergeColumn* row, std::size_t across) {
  for (std::size_t j = 0; j < across;) {
    if (row[j].is != VergeColumn::scatters) {
      ++j;
      continue;
    }
    std::size_t end = j, count = 0;  // columns without enough points neither begin nor end a run
    bool bends = false;
    for (std::size_t k = j; k < across && row[k].is != VergeColumn::calm; ++k)
      if (row[k].is == VergeColumn::scatters)
        end = k + 1, ++count, bends |= row[k].relief_m > kRelief_m;
    bool left = false, right = false;
    for (std::size_t k = 0; k < j; ++k) right |= row[k].is == VergeColumn::calm;
    for (std::size_t k = end; k < across; ++k) left |= row[k].is == VergeColumn::calm;
    if (count >= kWideRun || (!bends && !(left && right)))
      for (std::size_t k = j; k < end; ++k) row[k].grass = true;
    j = end;
  }
  look_beyond(row, across);
}

/// Columns of the road, kVergeStretch_m along and kSectionCell_m across, row after row.
struct Columns {
  std::size_t along = 0, across = 0;
  std::vector<VergeColumn> all;
  LaneScatter lane;
  bool with_sensor = false;

  explicit Columns(const RoadFrame& frame)
      : along(static_cast<std::size_t>(frame.length_m() / kVergeStretch_m) + 1),
        across(
            static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) +
            1),
        all(along * across) {}

  template <typename Each>
  void each_row(const Each& each) {
    for (std::size_t i = 0; i < along; ++i) each(all.data() + i * across, across);
  }
  /// Counts the cells of all sections; where each lies.
  std::vector<std::vector<Where>> gather(const Sections& sections, const RoadFrame& frame);
  /// What each should scatter as the lane does, at the same angle of view.
  void expect_by_lane(const Sections& sections, const std::vector<std::vector<Where>>& where,
                      bool drifting);
  /// Without a sensor: as the calmest quarter of all does, or the middle of the road, where beams
  /// that come down steeply scatter more.
  void expect_by_calmest(const RoadFrame& frame);
  /// Nothing up to so far to both sides of the line is grass.
  void pave(const RoadFrame& frame, double edge_m);
  /// The freedom of cells that scatter by themselves.
  void count_scattering(const Sections& sections, const std::vector<std::vector<Where>>& where);

 private:
  Where add(const SectionCell& cell, const Section& section, const RoadFrame& frame);
};

Where Columns::add(const SectionCell& cell, const Section& section, const RoadFrame& frame) {
  Where where;
  const Eigen::Vector3d p = section.position_m + Eigen::Vector3d(static_cast<double>(cell.x_m),
                                                                 static_cast<double>(cell.y_m),
                                                                 static_cast<double>(cell.z_m));
  const std::optional<GridPlace> place = frame.project(p.x(), p.y(), section.row);
  if (!place) return where;
  const double b = (place->v_m - frame.v_m().front()) / kSectionCell_m;
  if (!(b >= 0.0 && b < static_cast<double>(across))) return where;
  const std::size_t row = std::min(
      static_cast<std::size_t>(place->row * frame.u_step_m() / kVergeStretch_m), along - 1);
  where.column = row * across + static_cast<std::size_t>(b);
  if (cell.beside) return where;  // judges nothing: feet are in it
  VergeColumn& column = all[where.column];
  column.points += static_cast<double>(cell.points);
  column.relief_m = std::max(column.relief_m, bend_of(frame, *place));
  column.freedom += static_cast<double>(cell.freedom);
  column.square_m2 += static_cast<double>(cell.square_m2);
  column.overhung += static_cast<double>(cell.cut_points);
  if (cell.doubtful) {
    column.doubtful_freedom += static_cast<double>(cell.freedom);
    column.doubtful_m2 += static_cast<double>(cell.square_m2);
  }
  with_sensor |= cell.sine2 > 0.0f;
  if (cell.sine2 > 0.0f && std::abs(place->v_m - section.v_m) < kLane_m) {
    where.in_lane = true;
    column.lane += static_cast<double>(cell.points);
    lane.add(cell);
  }
  return where;
}

std::vector<std::vector<Where>> Columns::gather(const Sections& sections, const RoadFrame& frame) {
  std::vector<std::vector<Where>> where(sections.list.size());
  for (std::size_t s = 0; s < sections.list.size(); ++s)
    for (const SectionCell& cell : sections.list[s].cells)
      where[s].push_back(add(cell, sections.list[s], frame));
  lane.close();
  return where;
}

void Columns::expect_by_lane(const Sections& sections, const std::vector<std::vector<Where>>& where,
                             bool drifting) {
  std::vector<double> lane_square(along, 0.0), lane_expected(along, 0.0);
  for (std::size_t s = 0; s < sections.list.size(); ++s)
    for (std::size_t k = 0; k < where[s].size(); ++k) {
      const SectionCell& cell = sections.list[s].cells[k];
      const Where& at = where[s][k];
      if (at.column == Where::kNone || cell.beside) continue;
      const double expected_m2 =
          static_cast<double>(cell.freedom) * (drifting ? lane.in_bin_m2(cell) : lane.at_m2(cell));
      all[at.column].expected_m2 += expected_m2;
      if (!at.in_lane) continue;
      lane_square[at.column / across] += static_cast<double>(cell.square_m2);
      lane_expected[at.column / across] += expected_m2;
    }
  // Where the poses are still off, as at the ends of the drive, the lane itself scatters more
  // than elsewhere, and what lies beside it yet more.
  for (std::size_t i = 0; i < along; ++i) {
    double square = 0.0, expected = 0.0;
    for (std::size_t k = i - std::min<std::size_t>(i, 1); k <= std::min(i + 1, along - 1); ++k)
      square += lane_square[k], expected += lane_expected[k];
    const double more = expected > 0.0 ? std::max(1.0, square / expected) : 1.0;
    for (std::size_t j = 0; j < across; ++j) all[i * across + j].expected_m2 *= more * more;
  }
}

void Columns::expect_by_calmest(const RoadFrame& frame) {
  std::vector<double> scatters, of_middle;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const VergeColumn& column = all[k];
    if (column.freedom < kEnoughFreedom) continue;
    scatters.push_back(column.square_m2 / column.freedom);
    const double v_m =
        frame.v_m().front() + (static_cast<double>(k % across) + 0.5) * kSectionCell_m;
    if (std::abs(v_m) < kLane_m) of_middle.push_back(scatters.back());
  }
  std::sort(scatters.begin(), scatters.end());
  const double calm_m2 = scatters.empty() ? 0.0
                                          : std::max(scatters[scatters.size() / 4],
                                                     base::median_or(0.0, std::move(of_middle)));
  for (VergeColumn& column : all)
    column.expected_m2 = column.freedom * calm_m2, column.lane = column.points;
}

void Columns::pave(const RoadFrame& frame, double edge_m) {
  for (std::size_t k = 0; k < all.size(); ++k)
    all[k].paved = std::abs(frame.v_m().front() +
                            (static_cast<double>(k % across) + 0.5) * kSectionCell_m) < edge_m;
}

void Columns::count_scattering(const Sections& sections,
                               const std::vector<std::vector<Where>>& where) {
  for (std::size_t s = 0; s < sections.list.size(); ++s)
    for (std::size_t k = 0; k < where[s].size(); ++k) {
      const SectionCell& cell = sections.list[s].cells[k];
      if (where[s][k].column == Where::kNone || cell.beside) continue;
      VergeColumn& column = all[where[s][k].column];
      const auto own = static_cast<double>(cell.freedom);
      if (static_cast<double>(cell.square_m2) >
          own * (kTimesBeside * column.expected_m2 / std::max(1.0, column.freedom) +
                 kFloorBeside_m * kFloorBeside_m))
        column.scattering += own, column.scattering_m2 += static_cast<double>(cell.square_m2);
    }
}

/// Beside grass, on what is none: doubtful cells go, and no longer count.
void forget_doubtful(std::vector<VergeColumn>& columns) {
  for (VergeColumn& column : columns) {
    if (column.grass || column.doubtful_freedom == 0.0) continue;
    const double left = std::max(0.0, column.freedom - column.doubtful_freedom);
    column.expected_m2 *= left / column.freedom, column.bent_m2 *= left / column.freedom;
    column.square_m2 = std::max(0.0, column.square_m2 - column.doubtful_m2), column.freedom = left;
  }
}

/// How much more than expected calm columns scatter, m^2. In thin scans chance alone makes some of
/// them do so.
std::vector<float> excess_of(const std::vector<VergeColumn>& columns, std::size_t across,
                             bool thin) {
  std::vector<float> excess(columns.size(), 0.0f);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const VergeColumn& column = columns[k];
    excess[k] = static_cast<float>(column.excess_m2);
    if (column.is != VergeColumn::calm || column.freedom < kEnoughFreedom) continue;
    if (column.excess_m2 != 0.0) continue;
    // A few cells that scatter much are no grass: the others say how high it stands.
    const bool few =
        column.square_m2 > kTimes * column.expected_m2 + kFloor_m * kFloor_m * column.freedom;
    const double left = few ? std::max(0.0, column.freedom - column.scattering) : column.freedom;
    if (left < kEnoughFreedom) continue;
    // Beside grass what is allowed for a bend of the base may be the blades' of its edge.
    const auto is_grass = [&](std::size_t n) { return n < columns.size() && columns[n].grass; };
    const bool beside =
        (k % across > 0 && is_grass(k - 1)) || (k % across + 1 < across && is_grass(k + 1));
    const double square_m2 = column.square_m2 - (few ? column.scattering_m2 : 0.0),
                 expected_m2 = column.expected_m2 - (beside ? column.bent_m2 : 0.0),
                 times = 1.2 + (thin ? 2.0 * std::sqrt(2.0 / left) : 0.0);
    excess[k] =
        static_cast<float>(std::max(0.0, square_m2 / left - times * expected_m2 / column.freedom));
  }
  return excess;
}

/// Cells on grass, and those that are no surface; marks what lies beyond grass. Returns how many
/// points were on grass.
std::size_t take_out(const std::vector<std::vector<Where>>& where,
                     const std::vector<VergeColumn>& columns, Sections& sections) {
  double on_grass = 0.0;
  for (std::size_t s = 0; s < sections.list.size(); ++s) {
    std::vector<SectionCell>& cells = sections.list[s].cells;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const bool known = where[s][k].column != Where::kNone;
      if (known && columns[where[s][k].column].grass) {
        on_grass += static_cast<double>(cells[k].points);
        continue;
      }
      if (cells[k].doubtful) continue;
      if (cells[k].points >= 4.0f &&  // fewer have no plane of their own: the base may be wrong
          cells[k].square_m2 > cells[k].freedom * kNoSurface_m * kNoSurface_m)
        continue;
      cells[kept] = cells[k];
      cells[kept++].beyond = known && columns[where[s][k].column].beyond;
    }
    cells.resize(kept);
  }
  return static_cast<std::size_t>(on_grass);
}

}  // namespace

std::size_t leave_out_verge(Sections& sections, const RoadFrame& frame, bool drifting,
                            double edge_m) {
  const bool thin = forget_thin_cells(sections);
  Columns road(frame);
  road.pave(frame, edge_m);
  const std::vector<std::vector<Where>> where = road.gather(sections, frame);
  if (road.with_sensor)
    road.expect_by_lane(sections, where, drifting);
  else
    road.expect_by_calmest(frame);
  // A kerb that the base has wrong is no plane.
  for (VergeColumn& column : road.all) {
    column.bent_m2 = column.freedom * std::pow(scatter_of_bend_m(column.relief_m), 2);
    column.expected_m2 += column.bent_m2;
  }
  road.count_scattering(sections, where);
  judge(road.all, road.along, road.across, frame.closed(), drifting ? kDriftingFloor_m : kFloor_m);
  road.each_row(mark);
  if (!drifting) {
    for (int round = 0; round < kGrow; ++round)
      grow(road.all, road.along, road.across, frame.closed());
    road.each_row(look_beyond);
    forget_doubtful(road.all);
    look_for_low_grass(road.all, road.along, road.across, frame.closed());
  }
  road.each_row(follow_grass);
  sections.excess_m2 = excess_of(road.all, road.across, thin);
  sections.grass.clear();
  for (const VergeColumn& column : road.all) sections.grass.push_back(column.grass ? 1 : 0);
  return take_out(where, road.all, sections);
}

}  // namespace cloud
