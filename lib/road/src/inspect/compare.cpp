#include "road/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace road {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Which row segment and how far in it a u lies.
struct RowPlace {
  std::size_t row;
  double share;
};

RowPlace place_of(const HeightMap& map, double u_m) {
  const double at = std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m, 0.0,
                               static_cast<double>(map.rows() - 1));
  const auto row = std::min(map.rows() - 2, static_cast<std::size_t>(at));
  return {row, at - static_cast<double>(row)};
}

/// Positions on one row between nodes: linear in v.
struct RowLine {
  crg::Point2 middle, per_metre;
  crg::Point2 at(double v_m) const {
    return {middle.x_m + v_m * per_metre.x_m, middle.y_m + v_m * per_metre.y_m};
  }
};

RowLine line_of(const HeightMap& map, const RowPlace& place) {
  RowLine line{};
  const auto mix = [&](double v_m) {
    const crg::Point2 a = crg::node_position(map.line, place.row, v_m),
                      b = crg::node_position(map.line, place.row + 1, v_m);
    return crg::Point2{a.x_m + place.share * (b.x_m - a.x_m),
                       a.y_m + place.share * (b.y_m - a.y_m)};
  };
  line.middle = mix(0.0);
  const crg::Point2 one = mix(1.0);
  line.per_metre = {one.x_m - line.middle.x_m, one.y_m - line.middle.y_m};
  return line;
}

double height_at(const HeightMap& map, const RowPlace& place, double v_m) {
  if (v_m < map.v_m.front() || v_m > map.v_m.back()) return kNan;
  const auto j = static_cast<std::size_t>(
      std::upper_bound(map.v_m.begin() + 1, map.v_m.end() - 1, v_m) - map.v_m.begin());
  const double t = (v_m - map.v_m[j - 1]) / (map.v_m[j] - map.v_m[j - 1]);
  const auto across = [&](std::size_t row) {
    const double a = map.at(row, j - 1), b = map.at(row, j);
    return t == 0.0 ? a : t == 1.0 ? b : a + t * (b - a);
  };
  const double low = across(place.row);
  if (place.share == 0.0) return map.z_base_m + low;
  const double high = across(place.row + 1);
  return map.z_base_m + (place.share == 1.0 ? high : low + place.share * (high - low));
}

CrossCut cut(const HeightMap& map, const ReferenceHeights& reference, double u_m, double v_m,
             double v_low_m, double v_high_m) {
  CrossCut result;
  result.u_m = u_m;
  result.v_m = v_m;
  const RowPlace place = place_of(map, u_m);
  const RowLine line = line_of(map, place);
  constexpr double kStep_m = 0.05;
  v_low_m = std::max(v_low_m, map.v_m.front());
  v_high_m = std::min(v_high_m, map.v_m.back());
  const auto count = static_cast<std::size_t>((v_high_m - v_low_m) / kStep_m) + 1;
  std::vector<crg::Point2> points;
  for (std::size_t k = 0; k < count; ++k) {
    const double v = v_low_m + static_cast<double>(k) * kStep_m;
    result.at_v_m.push_back(v);
    result.file_z_m.push_back(height_at(map, place, v));
    points.push_back(line.at(v));
  }
  result.reference_z_m.assign(count, kNan);
  reference(points, result.file_z_m, result.reference_z_m);
  return result;
}

void make_error_map(const HeightMap& map, const ReferenceHeights& reference,
                    const CompareOptions& options, Comparison& result) {
  const double length_m = map.u_end_m() - map.line.u_begin_m,
               width_m = map.v_m.back() - map.v_m.front();
  double u_cell_m = std::max(options.u_cell_m, map.line.u_step_m), v_cell_m = options.v_cell_m;
  while (length_m / u_cell_m * (width_m / v_cell_m) > static_cast<double>(options.max_cells))
    u_cell_m *= 2.0, v_cell_m = std::min(v_cell_m * 1.5, 1.0);
  result.rows = std::max<std::size_t>(1, static_cast<std::size_t>(length_m / u_cell_m));
  const std::size_t columns =
      std::max<std::size_t>(1, static_cast<std::size_t>(width_m / v_cell_m));
  result.u_begin_m = map.line.u_begin_m;
  result.u_cell_m = length_m / static_cast<double>(result.rows);
  for (std::size_t j = 0; j < columns; ++j) {
    result.v_m.push_back(map.v_m.front() +
                         width_m * (static_cast<double>(j) + 0.5) / static_cast<double>(columns));
  }
  result.error_m.assign(result.rows * columns, std::numeric_limits<float>::quiet_NaN());
  result.without_reference.assign(result.rows * columns, 0);
  base::parallel_for(result.rows, 32, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<crg::Point2> points;
    std::vector<double> z, z_reference;
    std::vector<std::size_t> column;
    for (std::size_t i = begin; i < end; ++i) {
      const RowPlace place =
          place_of(map, result.u_begin_m + (static_cast<double>(i) + 0.5) * result.u_cell_m);
      const RowLine line = line_of(map, place);
      points.clear(), z.clear(), column.clear();
      for (std::size_t j = 0; j < columns; ++j) {
        const double height = height_at(map, place, result.v_m[j]);
        if (std::isnan(height)) continue;
        points.push_back(line.at(result.v_m[j]));
        z.push_back(height);
        column.push_back(j);
      }
      z_reference.assign(z.size(), kNan);
      reference(points, z, z_reference);
      for (std::size_t k = 0; k < z.size(); ++k) {
        const double error = z[k] - z_reference[k];
        result.error_m[i * columns + column[k]] = static_cast<float>(error);
        result.without_reference[i * columns + column[k]] = std::isnan(error);
      }
    }
  });
}

void make_statistics(Comparison& result) {
  std::vector<float> sizes;
  double sum = 0.0;
  std::size_t without = 0;
  for (std::size_t k = 0; k < result.error_m.size(); ++k) {
    without += result.without_reference[k];
    const float error = result.error_m[k];
    if (std::isnan(error)) continue;
    sizes.push_back(std::abs(error));
    sum += static_cast<double>(error);
  }
  result.points = sizes.size();
  if (result.points + without > 0)
    result.share_without_reference =
        static_cast<double>(without) / static_cast<double>(result.points + without);
  if (sizes.empty()) return;
  result.mean_error_m = sum / static_cast<double>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  // To the nanometre: what is below is the rounding of heights.
  const auto rounded = [](double length_m) { return std::round(length_m * 1e9) * 1e-9; };
  const auto at = [&](double share) {
    return rounded(static_cast<double>(
        sizes[static_cast<std::size_t>(share * static_cast<double>(sizes.size() - 1))]));
  };
  result.mean_error_m = rounded(result.mean_error_m);
  result.abs_error_m = {at(0.50), at(0.95), at(0.99), at(1.0)};
  // The bins span three times the 95th percentile, so that the shape shows whatever the scale.
  const double reach = std::max(1e-6, 3.0 * result.abs_error_m.p95);
  constexpr std::size_t kBins = 61;
  result.histogram_begin_m = -reach;
  result.histogram_step_m = 2.0 * reach / kBins;
  result.histogram.assign(kBins, 0);
  for (const float error : result.error_m) {
    if (std::isnan(error)) continue;
    const double bin = (static_cast<double>(error) + reach) / result.histogram_step_m;
    ++result.histogram[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
  }
}

std::size_t cell_of(const Comparison& result, const PlaceError& place) {
  const double v_cell_m = result.v_m.size() > 1 ? result.v_m[1] - result.v_m[0] : 1.0;
  const auto index = [](double at, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  };
  return index((place.u_m - result.u_begin_m) / result.u_cell_m, result.rows) * result.v_m.size() +
         index((place.v_m - result.v_m[0]) / v_cell_m + 0.5, result.v_m.size());
}

/// Those of `known` that their cells now show.
std::vector<PlaceError> show_known(std::span<const PlaceError> known, Comparison& result) {
  std::vector<PlaceError> shown;
  for (const PlaceError& place : known) {
    const std::size_t cell = cell_of(result, place);
    // A cell without an error at its middle shows any.
    if (place.error_m == 0.0 ||
        std::abs(place.error_m) <= std::abs(static_cast<double>(result.error_m[cell])))
      continue;
    result.error_m[cell] = static_cast<float>(place.error_m);
    result.without_reference[cell] = 0;
    std::erase_if(shown, [&](const PlaceError& other) { return cell_of(result, other) == cell; });
    shown.push_back(place);
  }
  return shown;
}

void find_worst(const HeightMap& map, const ReferenceHeights& reference,
                const CompareOptions& options, const std::vector<PlaceError>& shown,
                Comparison& result) {
  const std::size_t columns = result.v_m.size();
  // The largest of each row, then rows from large to small with a distance between them.
  std::vector<std::pair<float, std::size_t>> rows;
  for (std::size_t i = 0; i < result.rows; ++i) {
    std::pair<float, std::size_t> best{-1.0f, 0};
    for (std::size_t k = i * columns; k < (i + 1) * columns; ++k) {
      if (std::abs(result.error_m[k]) > best.first) best = {std::abs(result.error_m[k]), k};
    }
    if (best.first >= 0.0f) rows.push_back(best);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [size, k] : rows) {
    if (result.worst.size() == options.worst_places) break;
    double u_m = result.u_begin_m + (static_cast<double>(k / columns) + 0.5) * result.u_cell_m;
    double v_m = result.v_m[k % columns];
    for (const PlaceError& place : shown) {
      if (cell_of(result, place) == k) u_m = place.u_m, v_m = place.v_m;
    }
    if (std::any_of(result.worst.begin(), result.worst.end(), [&](const CrossCut& c) {
          return std::abs(c.u_m - u_m) < options.worst_apart_m;
        }))
      continue;
    CrossCut place = cut(map, reference, u_m, v_m, v_m - 3.0, v_m + 3.0);
    place.error_m = result.error_m[k];
    result.worst.push_back(std::move(place));
  }
}

Finding make_finding(const char* kind, double value, const char* unit, Severity severity,
                     std::string text) {
  Finding f;
  f.kind = kind;
  f.value = value;
  f.unit = unit;
  f.severity = severity;
  f.text = std::move(text);
  return f;
}

/// Crests of the reference's kerbs against the file's, at the nodes of every few rows.
void find_kerb_losses(const HeightMap& map, const ReferenceHeights& reference,
                      const std::string& name, const CompareOptions& options, Comparison& result,
                      KerbStrips& reference_kerbs, HeightMap& reference_map) {
  const auto stride =
      std::max<std::size_t>(1, static_cast<std::size_t>(0.5 / map.line.u_step_m + 0.5));
  reference_map.v_m = map.v_m;
  reference_map.z_base_m = map.z_base_m;
  reference_map.line.u_begin_m = map.line.u_begin_m;
  reference_map.line.u_step_m = map.line.u_step_m * static_cast<double>(stride);
  for (std::size_t i = 0; i < map.rows(); i += stride) {
    reference_map.line.x_m.push_back(map.line.x_m[i]);
    reference_map.line.y_m.push_back(map.line.y_m[i]);
    reference_map.line.heading_rad.push_back(map.line.heading_rad[i]);
  }
  if (reference_map.rows() < 2) return;
  const std::size_t columns = map.columns();
  reference_map.z_m.assign(reference_map.rows() * columns, std::numeric_limits<float>::quiet_NaN());
  base::parallel_for(
      reference_map.rows(), 32, options.threads, [&](std::size_t begin, std::size_t end) {
        std::vector<crg::Point2> points(columns);
        std::vector<double> z(columns), z_reference(columns);
        for (std::size_t i = begin; i < end; ++i) {
          const RowLine line = line_of(map, place_of(map, map.u_of(i * stride)));
          for (std::size_t j = 0; j < columns; ++j) {
            points[j] = line.at(map.v_m[j]);
            z[j] = map.z_base_m + static_cast<double>(map.at(i * stride, j));
          }
          reference(points, z, z_reference);
          for (std::size_t j = 0; j < columns; ++j)
            reference_map.at(i, j) = static_cast<float>(z_reference[j] - map.z_base_m);
        }
      });
  reference_kerbs = find_kerb_strips(reference_map);
  for (std::size_t s = 0; s < reference_kerbs.strips.size(); ++s) {
    const std::vector<KerbRow>& rows = reference_kerbs.rows[s];
    std::size_t begin = 0;
    double worst = 0.0, low_m = 0.0, high_m = 0.0;
    bool open = false;
    for (std::size_t k = 0; k <= rows.size(); ++k) {
      double loss = 0.0;
      if (k < rows.size()) {
        const auto [v_low, v_high] = std::minmax(rows[k].v_begin_m, rows[k].v_end_m);
        float crest_file = -std::numeric_limits<float>::infinity(), crest_reference = crest_file;
        for (std::size_t j = 0; j < columns; ++j) {
          if (map.v_m[j] < v_low - 0.01 || map.v_m[j] > v_high + 0.01) continue;
          const float file = map.at(rows[k].row * stride, j),
                      other = reference_map.at(rows[k].row, j);
          if (std::isnan(file) || std::isnan(other)) continue;
          crest_file = std::max(crest_file, file);
          crest_reference = std::max(crest_reference, other);
        }
        if (crest_reference > -std::numeric_limits<float>::infinity())
          loss = static_cast<double>(crest_reference - crest_file);
        if (loss >= options.min_kerb_loss_m) {
          if (!open) begin = k, worst = 0.0, low_m = v_low, high_m = v_high;
          open = true;
          worst = std::max(worst, loss);
          low_m = std::min(low_m, v_low), high_m = std::max(high_m, v_high);
          continue;
        }
      }
      if (!open) continue;
      open = false;
      const double u_begin_m = reference_map.u_of(rows[begin].row),
                   u_end_m = reference_map.u_of(rows[k - 1].row);
      if (u_end_m - u_begin_m + reference_map.line.u_step_m < options.min_kerb_loss_length_m)
        continue;
      Finding f = make_finding(
          "kerb_loss", worst, "m",
          worst > options.max_deviation_m && options.reference_is_truth ? Severity::error
                                                                        : Severity::remark,
          fmt::format(
              "The {} kerb is up to {:.0f} mm lower than in the {} from u = {:.1f} m to {:.1f} m",
              reference_kerbs.strips[s].left ? "left" : "right", 1000.0 * worst, name, u_begin_m,
              u_end_m));
      f.u_begin_m = u_begin_m;
      f.u_end_m = u_end_m;
      f.v_begin_m = low_m;
      f.v_end_m = high_m;
      result.findings.push_back(std::move(f));
    }
  }
}

/// Pieces of cells that `take` chooses: joined over their neighbours, then given to `done`.
struct Piece {
  std::size_t row_low, row_high, column_low, column_high, cells;
  float worst;
};

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

void find_deviations(const KerbStrips& reference_kerbs, const HeightMap& reference_map,
                     const std::string& name, const CompareOptions& options, Comparison& result) {
  const std::size_t columns = result.v_m.size();
  const double v_cell_m = columns > 1 ? result.v_m[1] - result.v_m[0] : 1.0,
               cell_m2 = v_cell_m * result.u_cell_m;
  // Cells on kerbs are told by the kerb's crest.
  std::vector<std::uint8_t> on_kerb(result.error_m.size(), 0);
  for (const std::vector<KerbRow>& rows : reference_kerbs.rows) {
    for (const KerbRow& row : rows) {
      const auto i = static_cast<std::size_t>(
          std::clamp((reference_map.u_of(row.row) - result.u_begin_m) / result.u_cell_m, 0.0,
                     static_cast<double>(result.rows - 1)));
      const auto [low, high] = std::minmax(row.v_begin_m, row.v_end_m);
      for (std::size_t j = 0; j < columns; ++j) {
        if (result.v_m[j] < low - 0.3 || result.v_m[j] > high + 0.3) continue;
        for (std::size_t p = i > 0 ? i - 1 : 0; p <= std::min(result.rows - 1, i + 1); ++p)
          on_kerb[p * columns + j] = 1;
      }
    }
  }
  const auto place = [&](Finding f, const Piece& piece) {
    f.u_begin_m = result.u_begin_m + static_cast<double>(piece.row_low) * result.u_cell_m;
    f.u_end_m = result.u_begin_m + static_cast<double>(piece.row_high + 1) * result.u_cell_m;
    f.v_begin_m = result.v_m[piece.column_low] - 0.5 * v_cell_m;
    f.v_end_m = result.v_m[piece.column_high] + 0.5 * v_cell_m;
    result.findings.push_back(std::move(f));
  };
  constexpr std::size_t kMost = 100;  // per kind; the map shows them all
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
  // A narrow long piece that lies lower where the reference has a ridge has lost a kerb that was
  // not recognised as one (run-off that rises behind it, say).
  const auto is_lost_ridge = [&](const Piece& p) {
    const double low_m = result.v_m[p.column_low] - 0.5 * v_cell_m,
                 high_m = result.v_m[p.column_high] + 0.5 * v_cell_m;
    const double length_m = static_cast<double>(p.row_high - p.row_low + 1) * result.u_cell_m;
    if (p.worst > 0.0f || high_m - low_m > 3.0 || length_m < 2.0 * (high_m - low_m)) return false;
    const double u_m =
        result.u_begin_m + 0.5 * static_cast<double>(p.row_low + p.row_high + 1) * result.u_cell_m;
    const auto row = static_cast<std::size_t>(
        std::clamp((u_m - reference_map.line.u_begin_m) / reference_map.line.u_step_m, 0.0,
                   static_cast<double>(reference_map.rows() - 1)));
    const auto column_at = [&](double v_m) {
      return std::min(reference_map.columns() - 1,
                      static_cast<std::size_t>(std::lower_bound(reference_map.v_m.begin(),
                                                                reference_map.v_m.end(), v_m) -
                                               reference_map.v_m.begin()));
    };
    const std::size_t a = column_at(low_m - 0.4), b = column_at(high_m + 0.4);
    for (std::size_t j = a + 1; j < b; ++j) {
      const double t = (reference_map.v_m[j] - reference_map.v_m[a]) /
                       (reference_map.v_m[b] - reference_map.v_m[a]);
      const double chord = (1.0 - t) * static_cast<double>(reference_map.at(row, a)) +
                           t * static_cast<double>(reference_map.at(row, b));
      if (static_cast<double>(reference_map.at(row, j)) - chord >= options.min_kerb_loss_m)
        return true;
    }
    return false;
  };
  for (std::size_t k = 0; k < std::min(off.size(), kMost); ++k) {
    const Piece& p = off[k];
    if (is_lost_ridge(p)) {
      const double u_m = result.u_begin_m + static_cast<double>(p.row_low) * result.u_cell_m;
      place(make_finding(
                "kerb_loss", -static_cast<double>(p.worst), "m",
                std::abs(p.worst) > options.max_deviation_m && options.reference_is_truth
                    ? Severity::error
                    : Severity::remark,
                fmt::format(
                    "A ridge of the {} is up to {:.0f} mm lower in the file from u = {:.1f} m",
                    name, 1000.0 * std::abs(p.worst), u_m)),
            p);
      continue;
    }
    place(
        make_finding(
            "deviation", static_cast<double>(p.worst), "m",
            std::abs(p.worst) > options.max_deviation_m && options.reference_is_truth
                ? Severity::error
                : Severity::remark,
            fmt::format("The road lies up to {:.0f} mm {} the {} over {:.1f} m2 from u = {:.1f} m",
                        1000.0 * std::abs(p.worst), p.worst > 0 ? "above" : "below", name,
                        static_cast<double>(p.cells) * cell_m2,
                        result.u_begin_m + static_cast<double>(p.row_low) * result.u_cell_m)),
        p);
  }
  if (!options.reference_is_truth) return;
  std::vector<Piece> bare =
      join_cells(result, [&](std::size_t k) { return result.without_reference[k] != 0; });
  std::erase_if(bare, [&](const Piece& p) {
    return static_cast<double>(p.cells) * cell_m2 < 2.0 * options.min_deviation_area_m2;
  });
  std::stable_sort(bare.begin(), bare.end(),
                   [](const Piece& a, const Piece& b) { return a.cells > b.cells; });
  for (std::size_t k = 0; k < std::min(bare.size(), kMost); ++k) {
    const double area_m2 = static_cast<double>(bare[k].cells) * cell_m2;
    place(
        make_finding(
            "no_reference", area_m2, "m2", Severity::remark,
            fmt::format(
                "{:.1f} m2 of road from u = {:.1f} m lie where the {} has no surface within reach",
                area_m2, result.u_begin_m + static_cast<double>(bare[k].row_low) * result.u_cell_m,
                name)),
        bare[k]);
  }
  // The limits of validate() hold for the whole road.
  const ValidateLimits limits;
  const auto whole = [&](const char* kind, double value, const char* unit, std::string text) {
    Finding f = make_finding(kind, value, unit, Severity::error, std::move(text));
    f.u_begin_m = result.u_begin_m;
    f.u_end_m = result.u_begin_m + static_cast<double>(result.rows) * result.u_cell_m;
    f.v_begin_m = result.v_m.front();
    f.v_end_m = result.v_m.back();
    result.findings.push_back(std::move(f));
  };
  if (result.abs_error_m.p99 > limits.max_z_error_p99_m) {
    whole("deviation", result.abs_error_m.p99, "m",
          fmt::format(
              "1 % of the road lies more than {:.0f} mm off the {}; at most {:.0f} mm are accepted",
              1000.0 * result.abs_error_m.p99, name, 1000.0 * limits.max_z_error_p99_m));
  }
  if (result.share_without_reference > limits.max_share_without_mesh) {
    whole("no_reference", result.share_without_reference, "1",
          fmt::format("{:.2f} % of the road have no surface of the {} within reach; at most {:.2f} "
                      "% are accepted",
                      100.0 * result.share_without_reference, name,
                      100.0 * limits.max_share_without_mesh));
  }
}

}  // namespace

ReferenceHeights reference_of(const RaySurface& mesh, const RotoTranslation& T_global_mesh,
                              double reach_m) {
  const double cosine = std::cos(T_global_mesh.yaw_rad), sine = std::sin(T_global_mesh.yaw_rad);
  const Eigen::Vector3d shift = T_global_mesh.translation_m;
  return [&mesh, cosine, sine, shift, reach_m](std::span<const crg::Point2> points,
                                               std::span<const double> z_near_m,
                                               std::span<double> z_out_m) {
    const Eigen::Vector3d origin = mesh.origin_m();
    RayPacket16 packet;
    packet.max_depth_m = static_cast<float>(2.0 * reach_m);
    std::array<double, 16> x{}, y{};
    for (std::size_t first = 0; first < points.size(); first += 16) {
      const std::size_t count = std::min<std::size_t>(16, points.size() - first);
      for (std::size_t k = 0; k < 16; ++k) {
        const std::size_t i = first + std::min(k, count - 1);
        const double dx = points[i].x_m - shift.x(), dy = points[i].y_m - shift.y();
        x[k] = cosine * dx + sine * dy;
        y[k] = -sine * dx + cosine * dy;
        packet.x_m[k] = static_cast<float>(x[k] - origin.x());
        packet.y_m[k] = static_cast<float>(y[k] - origin.y());
        const double top = z_near_m[i] - shift.z() - origin.z() + reach_m;
        packet.z_top_m[k] = std::isnan(top) ? 0.0f : static_cast<float>(top);
        packet.active[k] = k < count && !std::isnan(top) ? -1 : 0;
      }
      mesh.cast_down(packet);
      for (std::size_t k = 0; k < count; ++k) {
        const double near = z_near_m[first + k] - shift.z();
        double z = packet.active[k] == 0 ? kNan : static_cast<double>(packet.z_m[k]) + origin.z();
        // The first hit from above may be another layer, and a ray through an edge may miss: look
        // again.
        if (packet.active[k] != 0 && !(std::abs(z - near) < 0.005)) {
          const auto hit = mesh.nearest_hit(x[k], y[k], near, reach_m);
          z = hit ? hit->z_m : kNan;
        }
        z_out_m[first + k] = z + shift.z();
      }
    }
  };
}

ReferenceHeights reference_of(const crg::Surface& surface, double reach_m) {
  return [&surface, reach_m](std::span<const crg::Point2> points, std::span<const double> z_near_m,
                             std::span<double> z_out_m) {
    const crg::Grid& grid = surface.file().grid;
    const crg::ReferenceLine& line = surface.reference_line();
    const double u_end_m = line.u_begin_m + static_cast<double>(line.size() - 1) * line.u_step_m;
    constexpr double kEdge_m =
        1e-6;  // nodes on the border of both files must not fall off by rounding
    crg::Cursor cursor;
    for (std::size_t i = 0; i < points.size(); ++i) {
      z_out_m[i] = kNan;
      if (std::isnan(z_near_m[i])) continue;
      const crg::UV uv = surface.uv_of_xy(points[i].x_m, points[i].y_m, cursor);
      if (!(uv.u_m >= line.u_begin_m - kEdge_m && uv.u_m <= u_end_m + kEdge_m &&
            uv.v_m >= grid.v_m.front() - kEdge_m && uv.v_m <= grid.v_m.back() + kEdge_m))
        continue;
      const double z = surface.z_at_uv(std::clamp(uv.u_m, line.u_begin_m, u_end_m),
                                       std::clamp(uv.v_m, grid.v_m.front(), grid.v_m.back()));
      if (std::abs(z - z_near_m[i]) <= reach_m) z_out_m[i] = z;
    }
  };
}

Comparison compare(const HeightMap& map, const KerbStrips& kerbs, const ReferenceHeights& reference,
                   const std::string& name, const CompareOptions& options,
                   std::span<const PlaceError> known) {
  Comparison result;
  make_error_map(map, reference, options, result);
  make_statistics(result);
  KerbStrips reference_kerbs;
  HeightMap reference_map;
  find_kerb_losses(map, reference, name, options, result, reference_kerbs, reference_map);
  find_deviations(reference_kerbs, reference_map, name, options, result);
  const std::vector<PlaceError> shown = show_known(known, result);
  make_statistics(result);
  find_worst(map, reference, options, shown, result);
  for (const KerbStrip& kerb : kerbs.strips) {
    const auto [low, high] = std::minmax(kerb.v_begin_m, kerb.v_end_m);
    result.kerb_cuts.push_back(
        cut(map, reference, kerb.u_of_profile_m, 0.5 * (low + high), low - 1.5, high + 1.5));
  }
  return result;
}

}  // namespace road
