#include "explain/short_waves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "mechanism.h"
#include "selection.h"
#include "wave_plane.h"
#include "wheel_heights.h"

namespace explain {
namespace {

/// The heights under the wheels of all recordings. A sentence when they do not say enough.
std::string all_heights(const std::vector<RecordedLog>& logs, const Mapping& mapping,
                        const crg::Surface& surface, const vehicle::Vehicle& car, bool strip,
                        const std::vector<bool>& cells, std::vector<WheelHeight>& heights) {
  heights.clear();
  int lap = 0;
  for (const RecordedLog& log : logs) {
    if (const std::string reason =
            wheel_heights(log, mapping, surface, car, lap, strip, cells, heights);
        !reason.empty())
      return reason;
    lap += log.signals->lap.empty() ? 1 : log.signals->lap.back() + 1;
  }
  return lap < 2 ? std::string("one lap cannot say what comes back every lap") : std::string();
}

/// How much cells agree by chance: what no cell reaches when one half is moved along the road.
double agreement_by_chance(const Plane& plane, base::Random& dice) {
  std::vector<double> most;
  for (int draw = 0; draw < 300; ++draw) {
    const auto away =
        static_cast<std::size_t>((0.05 + 0.9 * dice.uniform()) * static_cast<double>(plane.rows));
    const Agreement moved = agree(plane, away);
    double largest = 0;
    for (std::size_t k = 0; k < moved.n.size(); ++k)
      if (moved.n[k] >= 20 && moved.energy[k] > 0)
        largest = std::max(largest, moved.product[k] / moved.energy[k]);
    most.push_back(largest);
  }
  std::sort(most.begin(), most.end());
  return most[static_cast<std::size_t>(selection::kWavesQuantile *
                                       static_cast<double>(most.size() - 1))];
}

/// Where even and odd laps agree on waves that the file does not have.
struct Waves {
  std::vector<bool> cells;
  double product = 0, n = 0, z = 0;  ///< sums over them, and the largest agreement
};

Waves waves_in(const Agreement& here, double threshold) {
  Waves out;
  auto& [cells, product, n, z] = out;
  cells.assign(here.n.size(), false);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (here.n[k] < 20 || !(here.energy[k] > 0)) continue;
    const double height2 = here.product[k] / here.n[k];
    cells[k] = here.product[k] / here.energy[k] > threshold &&
               height2 > selection::kLeastWave_m * selection::kLeastWave_m;
    if (cells[k])
      product += here.product[k], n += here.n[k], z = std::max(z, here.product[k] / here.energy[k]);
  }
  return out;
}

/// The cells and what lies beside them.
std::vector<bool> widened(const std::vector<bool>& cells) {
  std::vector<bool> wide = cells;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (cells[k])
      for (int d = -2; d <= 2; ++d)
        wide[(k + cells.size() + static_cast<std::size_t>(d + 2) - 2) % cells.size()] = true;
  return wide;
}

/// Squared errors against what was measured there: of the file in a point, through the strip, with
/// what the other laps measured, and of a flat road.
struct Squares {
  double point2 = 0, strip2 = 0, patch2 = 0, flat2 = 0, count = 0;
};

Squares squares_of(const std::vector<WheelHeight>& heights, const Plane& plane,
                   const std::vector<bool>& cells) {
  Squares q;
  for (const WheelHeight& l : heights) {
    const auto cell = static_cast<std::size_t>(std::max(0.0, l.u_m) / kWaveCell_m);
    const std::size_t k = plane.bin(l.u_m, l.v_m);
    if (cell >= cells.size() || !cells[cell] || k >= plane.rows * plane.columns) continue;
    const double other =
        plane.mean(1 - static_cast<std::size_t>(l.half), k);  // learned on the other laps
    if (!std::isfinite(other)) continue;
    const double d = l.measured_m - l.file_m, s = l.measured_m - l.strip_m;
    q.point2 += d * d;
    q.strip2 += s * s;
    q.patch2 += (d - other) * (d - other);
    q.flat2 += l.measured_m * l.measured_m;
    q.count += 1;
  }
  return q;
}

HeldOut held_out_of(const Squares& q, bool contact) {
  HeldOut h;
  h.channel = "height under the wheels";
  h.unit = "m";
  h.horizon_s = 0.0;
  h.rmse_before = std::sqrt(q.point2 / q.count);
  h.rmse_after = std::sqrt((contact ? q.strip2 : q.patch2) / q.count);
  h.trivial_rmse = std::sqrt(q.flat2 / q.count);
  h.drop_low = h.drop_high = 1 - h.rmse_after / h.rmse_before;
  return h;
}

/// The RMS height that even and odd laps agree on, with its spread between blocks of 2 m, drawn
/// again.
FoundParameter missing_height(const Plane& plane, const Waves& waves, base::Random& dice) {
  const std::vector<bool>& cells = waves.cells;
  std::vector<std::pair<double, double>> blocks;
  for (std::size_t i = 0; i < plane.rows; ++i) {
    const std::size_t cell = cell_of(i);
    if (cell >= cells.size() || !cells[cell]) continue;
    if (i % 10 == 0 || blocks.empty()) blocks.emplace_back(0.0, 0.0);
    for (std::size_t j = 0; j < plane.columns; ++j) {
      const double p = plane.mean(0, i * plane.columns + j),
                   q = plane.mean(1, i * plane.columns + j);
      if (std::isfinite(p) && std::isfinite(q))
        blocks.back().first += p * q, blocks.back().second += 1;
    }
  }
  std::vector<double> draws;
  for (int draw = 0; draw < 400; ++draw) {
    double s = 0, c = 0;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const auto& one =
          blocks[static_cast<std::size_t>(dice.uniform() * static_cast<double>(blocks.size()))];
      s += one.first, c += one.second;
    }
    draws.push_back(c > 0 ? std::sqrt(std::max(0.0, s / c)) : 0.0);
  }
  std::sort(draws.begin(), draws.end());
  return {"RMS height that is missing", "m", std::sqrt(waves.product / waves.n), draws[20],
          draws[379]};
}

/// The heights that are missing, and their mean along the road.
void put_patch(const std::vector<WheelHeight>& heights, const std::vector<bool>& cells,
               const Plane& plane, double error_m, Finding& f) {
  const Plane whole = anchored(heights, f.where, cells, plane);
  HeightPatch& patch = f.patch;
  patch.u_step_m = kBinU_m;
  patch.v_step_m = kBinV_m;
  patch.right_m = plane.right_m;
  patch.columns = plane.columns;
  patch.dz_m.assign(plane.rows * plane.columns, 0.0);
  for (std::size_t i = 0; i < plane.rows; ++i) {
    const std::size_t cell = cell_of(i);
    if (cell >= cells.size() || !cells[cell]) continue;
    double mean = 0, seen = 0;
    for (std::size_t j = 0; j < plane.columns; ++j) {
      // Where nobody drove, what was measured within a metre beside it.
      double value = whole.both(i * plane.columns + j);
      for (std::size_t d = 1; d <= 2 && !std::isfinite(value); ++d) {
        if (j >= d) value = whole.both(i * plane.columns + j - d);
        if (!std::isfinite(value) && j + d < plane.columns)
          value = whole.both(i * plane.columns + j + d);
      }
      if (!std::isfinite(value)) continue;
      patch.dz_m[i * plane.columns + j] = value;
      mean += value, seen += 1;
    }
    f.profile.push_back(
        {(static_cast<double>(i) + 0.5) * kBinU_m, seen > 0 ? mean / seen : 0.0, error_m});
  }
}

void remark_step(double step, Findings& findings) {
  if (step > 0.25)
    findings.remarks.push_back(
        fmt::format("the road's rows are {:.2g} m apart: waves shorter than {:.2g} m cannot be "
                    "written back; crgbuild resample makes them closer",
                    step, 2 * step));
}

}  // namespace

void add_short_waves(Findings& findings, const std::vector<RecordedLog>& logs,
                     const Mapping& mapping, const crg::Surface& surface,
                     const vehicle::Vehicle& car) {
  for (const char* id : {kKerbOrRoughness, kMultiPointContact}) forget_untestable(findings, id);
  const auto cannot = [&](const std::string& reason) {
    findings.untestable.push_back({kKerbOrRoughness, reason});
    findings.untestable.push_back({kMultiPointContact, reason});
  };
  std::vector<WheelHeight> heights;
  const auto look_at = [&](bool strip, const std::vector<bool>& cells) {
    return all_heights(logs, mapping, surface, car, strip, cells, heights);
  };
  if (const std::string reason = look_at(false, {}); !reason.empty()) return cannot(reason);
  const auto& v = surface.grid().v_m;
  const Plane plane = plane_of(heights, logs.front().signals->length_m, v.front(), v.back());
  base::Random dice(311);
  const double threshold = agreement_by_chance(plane, dice);
  const Waves waves = waves_in(agree(plane, 0), threshold);
  findings.evidence.push_back(
      {kKerbOrRoughness, "",
       fmt::format("agreement of even and odd laps in cells of 10 m; threshold {:.2f}", threshold),
       waves.n > 0 ? std::sqrt(waves.product / waves.n) : 0.0, waves.z, 0.0, "m"});
  if (waves.n == 0) return;

  // Through the strip, in the cells found and beside them.
  const bool strip = car.contact == vehicle::Contact::kSinglePoint;
  if (strip)
    look_at(true, widened(waves.cells));
  else
    findings.untestable.push_back(
        {kMultiPointContact, "the stated tyre already touches the road in more than one point"});
  const Squares q = squares_of(heights, plane, waves.cells);
  if (!(q.count > 0)) return;
  const double patch_gain = 1 - q.patch2 / q.point2,
               strip_gain = strip ? 1 - q.strip2 / q.point2 : 0.0;
  // New heights can imitate any contact; a contact cannot imitate any height.
  const bool contact =
      strip_gain > selection::kContactShare * patch_gain && strip_gain > selection::kContactLeast;
  Finding f = finding_of(*find_mechanism(contact ? kMultiPointContact : kKerbOrRoughness));
  f.where = joined(waves.cells);
  f.statistic = waves.z;
  f.threshold = threshold;
  f.cv_gain = (q.point2 - (contact ? q.strip2 : q.patch2)) / (q.patch2 / q.count) / 10;
  f.held_out.push_back(held_out_of(q, contact));
  const std::string experiment = "survey the kerb, or pass it on a tyre of another size";
  if (contact) {
    f.parameters.push_back({"share of the error in short waves that it takes away", "1", strip_gain,
                            strip_gain, strip_gain});
    f.rivals.push_back({kKerbOrRoughness, "", experiment, patch_gain,
                        strip_gain > selection::kContactAlone * patch_gain});
  } else {
    f.parameters.push_back(missing_height(plane, waves, dice));
    if (strip) f.rivals.push_back({kMultiPointContact, "", experiment, strip_gain, true});
    put_patch(heights, waves.cells, plane, f.held_out.front().rmse_after, f);
    remark_step(surface.grid().u_step_m, findings);
  }
  findings.findings.push_back(f);
}

}  // namespace explain
