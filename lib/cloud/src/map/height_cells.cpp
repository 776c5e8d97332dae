#include "height_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "drift.h"

namespace cloud {

bool HeightCells::cell_of(const GridPlace& place, std::size_t& i, std::size_t& j) const {
  const double a = place.row / cell_rows, b = (place.v_m - v_begin_m) / cell_m;
  if (!(a >= 0.0 && b >= 0.0 && b < static_cast<double>(across))) return false;
  i = std::min(static_cast<std::size_t>(a), along - 1), j = static_cast<std::size_t>(b);
  return true;
}

bool HeightCells::holds(std::size_t i, std::size_t j, int pass) const {
  const int first = first_pass.empty() ? 0 : static_cast<int>(first_pass[i * across + j]);
  return first == 0 || (pass < first) == older;
}

bool HeightCells::holds(std::size_t i, std::size_t j, int pass, const GridPlace& place,
                        double above_m) const {
  if (holds(i, j, pass)) return true;
  // False where no surface is there.
  return std::abs(above_m - at(place)) < static_cast<double>(agrees_m[i * across + j]);
}

double HeightCells::at(const GridPlace& place) const {
  const double a = place.row / cell_rows - 0.5, b = (place.v_m - v_begin_m) / cell_m - 0.5;
  if (!(b >= 0.0 && b < static_cast<double>(across) - 1.0))
    return std::numeric_limits<double>::quiet_NaN();
  auto i = static_cast<std::ptrdiff_t>(std::floor(a));
  const double f = a - static_cast<double>(i);
  const auto j = static_cast<std::size_t>(b);
  const double g = b - static_cast<double>(j);
  const auto n = static_cast<std::ptrdiff_t>(along);
  std::ptrdiff_t next = i + 1;
  if (closed)
    i = (i + n) % n, next = (next + n) % n;
  else
    i = std::clamp<std::ptrdiff_t>(i, 0, n - 1), next = std::clamp<std::ptrdiff_t>(next, 0, n - 1);
  const float* const p = height_m.data() + static_cast<std::size_t>(i) * across + j;
  const float* const q = height_m.data() + static_cast<std::size_t>(next) * across + j;
  return (1.0 - f) * ((1.0 - g) * static_cast<double>(p[0]) + g * static_cast<double>(p[1])) +
         f * ((1.0 - g) * static_cast<double>(q[0]) + g * static_cast<double>(q[1]));
}

double HeightCells::at_edge(std::size_t i, std::size_t j, double v_m) const {
  const auto height = [&](std::size_t column) {
    return column < across ? static_cast<double>(height_m[i * across + column])
                           : std::numeric_limits<double>::quiet_NaN();
  };
  const double b = (v_m - v_begin_m) / cell_m - 0.5 - static_cast<double>(j);
  const double own = height(j), left = height(j + 1), right = height(j - 1);
  const double on = b > 0.0 ? left : right, back = b > 0.0 ? right : left;
  if (std::isfinite(on)) return own + std::abs(b) * (on - own);
  if (std::isfinite(back)) return own + std::abs(b) * (own - back);
  return own;
}

namespace {

constexpr double kThin_m = 0.05;  // of a wall that curves, seen from passes with different drift

struct Entry {
  std::uint32_t cell;
  float height, points, cut_above;
  Sheet sheet;
};

/// The wall that at least half of a cell's sections see in it.
Sheet sheet_of(const Entry* from, const Entry* to) {
  double count = 0.0, sum = 0.0, sum2 = 0.0;
  for (const Entry* e = from; e != to; ++e) {
    const auto v_m = static_cast<double>(e->sheet.v_m),
               deviation_m = static_cast<double>(e->sheet.deviation_m);
    if (deviation_m > 0.0) count += 1.0, sum += v_m, sum2 += v_m * v_m + deviation_m * deviation_m;
  }
  if (2.0 * count < static_cast<double>(to - from)) return {};
  const double deviation_m = std::sqrt(std::max(0.0, sum2 / count - std::pow(sum / count, 2)));
  if (!(deviation_m < kThin_m)) return {};
  return {static_cast<float>(sum / count), static_cast<float>(deviation_m)};
}

}  // namespace

HeightCells cells_of(const Sections& sections, const std::vector<Correction>& corrections,
                     const RoadFrame& frame, int pass, unsigned threads,
                     std::vector<std::uint16_t> first_pass, bool older) {
  HeightCells cells;
  cells.first_pass = std::move(first_pass), cells.older = older;
  cells.along =
      std::max<std::size_t>(1, static_cast<std::size_t>(frame.length_m() / kSectionCell_m));
  cells.cell_rows = static_cast<double>(frame.rows() - 1) / static_cast<double>(cells.along);
  cells.across =
      static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) + 1;
  cells.v_begin_m = frame.v_m().front();
  cells.closed = frame.closed();
  const std::size_t n = sections.list.size();
  std::vector<std::vector<Entry>> found(n);
  base::parallel_for(n, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Section& section = sections.list[k];
      if (pass >= 0 && section.pass != pass) continue;
      const Mover move(sections, corrections, k);
      for (const SectionCell& cell : section.cells) {
        const Eigen::Vector3d p = move(cell);
        const std::optional<GridPlace> place = frame.project(p.x(), p.y(), section.row);
        std::size_t i = 0, j = 0;
        if (!place || !cells.cell_of(*place, i, j) || !cells.holds(i, j, section.pass)) continue;
        const std::size_t column = verge_column(frame, place->row, place->v_m);
        if (column < sections.grass.size() && sections.grass[column] != 0) continue;
        const double height = p.z() - frame.z_origin_m() - frame.height(*place);
        if (std::isfinite(height))
          found[k].push_back({static_cast<std::uint32_t>(i * cells.across + j),
                              static_cast<float>(height), cell.points, cell.cut_above_m,
                              cell.sheet});
      }
    }
  });
  // Counting sort by cell, then the weighted median of each.
  const std::size_t count = cells.along * cells.across;
  std::vector<std::uint32_t> begin(count + 1, 0);
  for (const auto& list : found)
    for (const Entry& entry : list) ++begin[entry.cell + 1];
  for (std::size_t i = 0; i < count; ++i) begin[i + 1] += begin[i];
  std::vector<Entry> sorted(begin[count]);
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for (const auto& list : found)
    for (const Entry& entry : list) sorted[at[entry.cell]++] = entry;
  cells.height_m.assign(count, std::numeric_limits<float>::quiet_NaN());
  cells.cut_above_m.assign(count, 0.0f);
  cells.sheet.assign(count, Sheet());
  for (const Entry& entry : sorted) {
    if (!(entry.cut_above > 0.0f)) continue;
    const std::size_t i = entry.cell / cells.across, j = entry.cell % cells.across;
    for (std::size_t k = i - std::min<std::size_t>(i, 1); k <= std::min(i + 1, cells.along - 1);
         ++k)
      for (std::size_t l = j - std::min<std::size_t>(j, 1); l <= std::min(j + 1, cells.across - 1);
           ++l)
        cells.cut_above_m[k * cells.across + l] =
            std::max(cells.cut_above_m[k * cells.across + l], entry.cut_above);
  }
  base::parallel_for(count, 4096, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      Entry* const from = sorted.data() + begin[i];
      Entry* const to = sorted.data() + begin[i + 1];
      if (from == to) continue;
      cells.sheet[i] = sheet_of(from, to);
      std::sort(from, to, [](const Entry& a, const Entry& b) { return a.height < b.height; });
      float total = 0.0f, so_far = 0.0f;
      for (const Entry* e = from; e != to; ++e) total += e->points;
      const Entry* e = from;
      while (e + 1 != to && so_far + e->points < 0.5f * total) so_far += e->points, ++e;
      cells.height_m[i] = e->height;
    }
  });
  return cells;
}

}  // namespace cloud
