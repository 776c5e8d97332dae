#include "deviations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "inspect/validate.h"

namespace road {
namespace {

constexpr std::size_t kMost = 100;  // per kind; the map shows them all

/// Cells that belong together.
struct Piece {
  std::size_t row_low, row_high, column_low, column_high, cells;
  float worst;
};

/// Pieces of cells that `take` chooses, joined over their neighbours.
template <typename Take>
std::vector<Piece> join_cells(const Comparison& c, const Take& take) {
  const std::size_t columns = c.v_m.size();
  std::vector<std::uint8_t> seen(c.error_m.size(), 0);
  std::vector<Piece> pieces;
  std::vector<std::size_t> stack;
  for (std::size_t start = 0; start < c.error_m.size(); ++start) {
    if (seen[start] || !take(start)) continue;
    Piece piece{start / columns, start / columns, start % columns, start % columns, 0, 0.0f};
    stack.assign(1, start);
    seen[start] = 1;
    while (!stack.empty()) {
      const std::size_t k = stack.back(), i = k / columns, j = k % columns;
      stack.pop_back();
      ++piece.cells;
      piece.row_low = std::min(piece.row_low, i), piece.row_high = std::max(piece.row_high, i);
      piece.column_low = std::min(piece.column_low, j),
      piece.column_high = std::max(piece.column_high, j);
      if (std::abs(c.error_m[k]) > std::abs(piece.worst)) piece.worst = c.error_m[k];
      for (std::size_t p = i > 0 ? i - 1 : 0; p <= std::min(c.rows - 1, i + 1); ++p) {
        for (std::size_t q = j > 0 ? j - 1 : 0; q <= std::min(columns - 1, j + 1); ++q) {
          const std::size_t next = p * columns + q;
          if (seen[next] || !take(next)) continue;
          seen[next] = 1;
          stack.push_back(next);
        }
      }
    }
    pieces.push_back(piece);
  }
  return pieces;
}

double v_cell_of(const Comparison& c) { return c.v_m.size() > 1 ? c.v_m[1] - c.v_m[0] : 1.0; }

/// Cells on kerbs: they are told by the kerb's crest.
std::vector<std::uint8_t> cells_on_kerbs(const ReferenceKerbs& reference,
                                         const Comparison& result) {
  const std::size_t columns = result.v_m.size();
  std::vector<std::uint8_t> on_kerb(result.error_m.size(), 0);
  for (const std::vector<KerbRow>& rows : reference.kerbs.rows) {
    for (const KerbRow& row : rows) {
      const auto i = static_cast<std::size_t>(
          std::clamp((reference.map.u_of(row.row) - result.u_begin_m) / result.u_cell_m, 0.0,
                     static_cast<double>(result.rows - 1)));
      const auto [low, high] = std::minmax(row.v_begin_m, row.v_end_m);
      for (std::size_t j = 0; j < columns; ++j) {
        if (result.v_m[j] < low - 0.3 || result.v_m[j] > high + 0.3) continue;
        for (std::size_t p = i > 0 ? i - 1 : 0; p <= std::min(result.rows - 1, i + 1); ++p)
          on_kerb[p * columns + j] = 1;
      }
    }
  }
  return on_kerb;
}

void place_finding(Finding f, const Piece& piece, Comparison& result) {
  const double v_cell_m = v_cell_of(result);
  f.u_begin_m = result.u_begin_m + static_cast<double>(piece.row_low) * result.u_cell_m;
  f.u_end_m = result.u_begin_m + static_cast<double>(piece.row_high + 1) * result.u_cell_m;
  f.v_begin_m = result.v_m[piece.column_low] - 0.5 * v_cell_m;
  f.v_end_m = result.v_m[piece.column_high] + 0.5 * v_cell_m;
  result.findings.push_back(std::move(f));
}

/// A narrow long piece that lies lower where the reference has a ridge has lost a kerb that was not
/// recognised as one (run-off that rises behind it, say).
bool is_lost_ridge(const Piece& p, const HeightMap& reference, const CompareOptions& options,
                   const Comparison& result) {
  const double v_cell_m = v_cell_of(result);
  const double low_m = result.v_m[p.column_low] - 0.5 * v_cell_m,
               high_m = result.v_m[p.column_high] + 0.5 * v_cell_m;
  const double length_m = static_cast<double>(p.row_high - p.row_low + 1) * result.u_cell_m;
  if (p.worst > 0.0f || high_m - low_m > 3.0 || length_m < 2.0 * (high_m - low_m)) return false;
  const double u_m =
      result.u_begin_m + 0.5 * static_cast<double>(p.row_low + p.row_high + 1) * result.u_cell_m;
  const auto row = static_cast<std::size_t>(
      std::clamp((u_m - reference.line.u_begin_m) / reference.line.u_step_m, 0.0,
                 static_cast<double>(reference.rows() - 1)));
  const auto column_at = [&](double v_m) {
    return std::min(
        reference.columns() - 1,
        static_cast<std::size_t>(std::lower_bound(reference.v_m.begin(), reference.v_m.end(), v_m) -
                                 reference.v_m.begin()));
  };
  const std::size_t a = column_at(low_m - 0.4), b = column_at(high_m + 0.4);
  for (std::size_t j = a + 1; j < b; ++j) {
    const double t = (reference.v_m[j] - reference.v_m[a]) / (reference.v_m[b] - reference.v_m[a]);
    const double chord = (1.0 - t) * static_cast<double>(reference.at(row, a)) +
                         t * static_cast<double>(reference.at(row, b));
    if (static_cast<double>(reference.at(row, j)) - chord >= options.min_kerb_loss_m) return true;
  }
  return false;
}

/// Pieces off the reference, the farthest first.
std::vector<Piece> pieces_off(const ReferenceKerbs& reference, const CompareOptions& options,
                              const Comparison& result) {
  const double cell_m2 = v_cell_of(result) * result.u_cell_m;
  const std::vector<std::uint8_t> on_kerb = cells_on_kerbs(reference, result);
  // Three quarters of the bound keep together what scatter around the bound would cut into many
  // pieces.
  std::vector<Piece> off = join_cells(result, [&](std::size_t k) {
    return !on_kerb[k] &&
           std::abs(static_cast<double>(result.error_m[k])) > 0.75 * options.min_deviation_m;
  });
  std::erase_if(off, [&](const Piece& p) {
    return static_cast<double>(std::abs(p.worst)) <= options.min_deviation_m ||
           static_cast<double>(p.cells) * cell_m2 < options.min_deviation_area_m2 ||
           p.column_low == p.column_high || p.row_low == p.row_high;
  });
  std::stable_sort(off.begin(), off.end(), [](const Piece& a, const Piece& b) {
    return std::abs(a.worst) > std::abs(b.worst);
  });
  return off;
}

void find_bare(const std::string& name, const CompareOptions& options, Comparison& result) {
  const double cell_m2 = v_cell_of(result) * result.u_cell_m;
  std::vector<Piece> bare =
      join_cells(result, [&](std::size_t k) { return result.without_reference[k] != 0; });
  std::erase_if(bare, [&](const Piece& p) {
    return static_cast<double>(p.cells) * cell_m2 < 2.0 * options.min_deviation_area_m2;
  });
  std::stable_sort(bare.begin(), bare.end(),
                   [](const Piece& a, const Piece& b) { return a.cells > b.cells; });
  for (std::size_t k = 0; k < std::min(bare.size(), kMost); ++k) {
    const double area_m2 = static_cast<double>(bare[k].cells) * cell_m2;
    place_finding(
        make_finding(
            "no_reference", area_m2, "m2", Severity::remark,
            fmt::format(
                "{:.1f} m2 of road from u = {:.1f} m lie where the {} has no surface within reach",
                area_m2, result.u_begin_m + static_cast<double>(bare[k].row_low) * result.u_cell_m,
                name)),
        bare[k], result);
  }
}

/// The limits of validate() hold for the whole road.
void check_limits(const std::string& name, const HeightMap& map, const CompareOptions& options,
                  Comparison& result) {
  if (!options.limits) return;
  const ValidateLimits& limits = *options.limits;
  std::vector<float> off_m;
  std::size_t without = 0;
  for (std::size_t i = 0; i < result.rows; ++i) {
    const double u_m = result.u_begin_m + (static_cast<double>(i) + 0.5) * result.u_cell_m;
    const auto row = static_cast<std::size_t>(std::clamp(
        (u_m - map.line.u_begin_m) / map.line.u_step_m, 0.0, static_cast<double>(map.rows() - 1)));
    for (std::size_t j = 0; j < result.v_m.size(); ++j) {
      const std::size_t k = i * result.v_m.size() + j;
      if (!options.edges.has(row, result.v_m[j])) continue;
      without += result.without_reference[k];
      if (!std::isnan(result.error_m[k])) off_m.push_back(std::abs(result.error_m[k]));
    }
  }
  const double share = static_cast<double>(without) /
                       static_cast<double>(std::max<std::size_t>(1, without + off_m.size()));
  const double p99_m = off_m.empty() ? 0.0 : static_cast<double>(base::quantile(off_m, 0.99));
  const auto whole = [&](const char* kind, double value, const char* unit, std::string text) {
    Finding f = make_finding(kind, value, unit, Severity::error, std::move(text));
    f.u_begin_m = result.u_begin_m;
    f.u_end_m = result.u_begin_m + static_cast<double>(result.rows) * result.u_cell_m;
    f.v_begin_m = result.v_m.front();
    f.v_end_m = result.v_m.back();
    result.findings.push_back(std::move(f));
  };
  if (p99_m > limits.max_z_error_p99_m) {
    whole("deviation", p99_m, "m",
          fmt::format(
              "1 % of the road lies more than {:.0f} mm off the {}; at most {:.0f} mm are accepted",
              1000.0 * p99_m, name, 1000.0 * limits.max_z_error_p99_m));
  }
  if (share > limits.max_share_without_mesh) {
    whole("no_reference", share, "1",
          fmt::format("{:.2f} % of the road have no surface of the {} within reach; at most {:.2f} "
                      "% are accepted",
                      100.0 * share, name, 100.0 * limits.max_share_without_mesh));
  }
}

}  // namespace

void find_deviations(const HeightMap& map, const ReferenceKerbs& reference, const std::string& name,
                     const CompareOptions& options, Comparison& result) {
  const double cell_m2 = v_cell_of(result) * result.u_cell_m;
  const std::vector<Piece> off = pieces_off(reference, options, result);
  for (std::size_t k = 0; k < std::min(off.size(), kMost); ++k) {
    const Piece& p = off[k];
    if (is_lost_ridge(p, reference.map, options, result)) {
      const double u_m = result.u_begin_m + static_cast<double>(p.row_low) * result.u_cell_m;
      place_finding(
          make_finding(
              "kerb_loss", -static_cast<double>(p.worst), "m",
              std::abs(p.worst) > options.max_deviation_m && options.reference_is_truth
                  ? Severity::error
                  : Severity::remark,
              fmt::format(
                  "A ridge of the {} is up to {:.0f} mm lower in the file from u = {:.1f} m", name,
                  1000.0 * std::abs(p.worst), u_m)),
          p, result);
      continue;
    }
    place_finding(
        make_finding(
            "deviation", static_cast<double>(p.worst), "m",
            std::abs(p.worst) > options.max_deviation_m && options.reference_is_truth
                ? Severity::error
                : Severity::remark,
            fmt::format("The road lies up to {:.0f} mm {} the {} over {:.1f} m2 from u = {:.1f} m",
                        1000.0 * std::abs(p.worst), p.worst > 0 ? "above" : "below", name,
                        static_cast<double>(p.cells) * cell_m2,
                        result.u_begin_m + static_cast<double>(p.row_low) * result.u_cell_m)),
        p, result);
  }
  if (!options.reference_is_truth) return;
  find_bare(name, options, result);
  check_limits(name, map, options, result);
}

}  // namespace road
