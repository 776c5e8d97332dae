#include "explain/short_waves.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mechanisms/mechanism.h"
#include "search.h"
#include "selection.h"
#include "vehicle/error.h"
#include "vehicle/recording.h"
#include "vehicle/road.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kBinU_m = 0.2, kBinV_m = 0.5, kCell_m = 10.0, kHalf_s = 0.4;
constexpr std::array<const char*, 4> kWheel{"fl", "fr", "rl", "rr"};

/// One wheel at one sample.
struct Look {
  double u_m, v_m, measured_m, file_m, strip_m;
  double raw_m;    ///< measured minus file with all slow parts in it
  std::size_t pass;  ///< one wheel on one lap
  int half;        ///< of the laps: even, odd
};

/// x without its local parabola over +-half samples; empty at the ends.
std::vector<double> without_slow(const std::vector<double>& x, std::size_t half) {
  std::vector<double> out(x.size(), kNaN);
  double m2 = 0, m4 = 0;
  const double n = 2.0 * static_cast<double>(half) + 1;
  const auto scale = static_cast<double>(half);
  for (std::size_t k = 0; k <= 2 * half; ++k) {
    const double d = (static_cast<double>(k) - scale) / scale;
    m2 += d * d;
    m4 += d * d * d * d;
  }
  for (std::size_t i = half; i + half < x.size(); ++i) {
    double s0 = 0, s2 = 0;
    for (std::size_t k = 0; k <= 2 * half; ++k) {
      const double d = (static_cast<double>(k) - scale) / scale, value = x[i - half + k] - x[i];
      s0 += value;
      s2 += value * d * d;
    }
    out[i] = -(m4 * s0 - m2 * s2) / (n * m4 - m2 * m2);
  }
  return out;
}

/// Heights under the wheels of one recording; appends to `out`. A sentence when it cannot.
std::string look(const RecordedLog& log, const Mapping& mapping, const crg::Surface& surface, const vehicle::Vehicle& car, int first_lap, bool strip,
                 const std::vector<bool>& only_cells, std::vector<Look>& out) {
  const vehicle::Recording recording = vehicle::make_recording(*log.table, log.signals->name, mapping);
  const auto channel = [&](const std::string& name) -> const std::vector<double>* { return recording.table.find(name); };
  std::vector<std::string> wanted{"az_mps2", "roll_rate_radps", "pitch_rate_radps", "x_m", "y_m", "yaw_rad"};
  for (const char* wheel : kWheel) wanted.push_back(fmt::format("suspension_{}_m", wheel)), wanted.push_back(fmt::format("fz_{}_n", wheel));
  for (const std::string& name : wanted)
    if (channel(name) == nullptr) return fmt::format("needs {}: az, roll and pitch rate, suspension travel and wheel loads of all wheels", name);
  if (!(recording.step_s <= 1.0 / 79)) return fmt::format("needs 80 samples a second or more, the log has {:.0f}", 1 / recording.step_s);
  const std::vector<double>& time = *channel("time_s");
  const double a = car.parameters[P::chassis_cog_behind_front_m], b = car.parameters[P::chassis_wheelbase_m] - a;
  const auto half = static_cast<std::size_t>(std::lround(kHalf_s / recording.step_s));
  const vehicle::Road road(surface);
  vehicle::RoadCursors cursors{};
  std::array<vehicle::Cams, 2> cams;
  const vehicle::StripShape shape;
  for (std::size_t axle = 0; strip && axle < 2; ++axle) {
    const auto made = vehicle::make_car(car.files, car.parameters, car.terms, vehicle::Contact::kStrip, shape);
    cams[axle] = made.cams[axle];
  }
  for (const vehicle::Stretch& stretch : recording.stretches) {
    const std::size_t n = stretch.end - stretch.begin;
    if (n < 4 * half) continue;
    const auto part = [&](const std::string& name) {
      const std::vector<double> filled = vehicle::fill_gaps(time, *channel(name));
      return std::vector<double>(filled.begin() + static_cast<std::ptrdiff_t>(stretch.begin), filled.begin() + static_cast<std::ptrdiff_t>(stretch.end));
    };
    const auto integrated = [&](const std::vector<double>& x) {
      double mean = 0;
      for (const double v : x) mean += v / static_cast<double>(x.size());
      std::vector<double> sum(x.size(), 0.0);
      for (std::size_t i = 1; i < x.size(); ++i) sum[i] = sum[i - 1] + 0.5 * (x[i] + x[i - 1] - 2 * mean) * recording.step_s;
      return sum;
    };
    const std::vector<double> z = integrated(integrated(part("az_mps2"))), roll = integrated(part("roll_rate_radps")), pitch = integrated(part("pitch_rate_radps"));
    const std::vector<double> x = part("x_m"), y = part("y_m"), yaw = part("yaw_rad");
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      const std::size_t axle = wheel / 2;
      const double lx = axle == 0 ? a : -b, ly = (wheel % 2 == 0 ? 0.5 : -0.5) * car.parameters.axle(axle, P::front_track_m);
      const double stiffness = car.files.tyre[axle].vertical_stiffness_npm;
      const std::vector<double> travel = part(fmt::format("suspension_{}_m", kWheel[wheel])), load = part(fmt::format("fz_{}_n", kWheel[wheel]));
      std::vector<double> measured(n), file(n), seen(n), u(n, kNaN), v(n, kNaN);
      crg::Cursor cursor;
      for (std::size_t i = 0; i < n; ++i) {
        const double c = std::cos(yaw[i]), s = std::sin(yaw[i]), wx = x[i] + lx * c - ly * s, wy = y[i] + lx * s + ly * c;
        const crg::Sample at = surface.at_xy(wx, wy, cursor);
        u[i] = at.u_m - surface.reference_line().u_begin_m;
        v[i] = at.v_m;
        measured[i] = z[i] - lx * pitch[i] + ly * roll[i] + travel[i] + load[i] / stiffness;
        file[i] = std::isfinite(at.z_m) ? at.z_m : (i > 0 ? file[i - 1] : 0.0);
        seen[i] = file[i];
        const auto cell = static_cast<std::size_t>(std::max(0.0, u[i]) / kCell_m);
        if (strip && cell < only_cells.size() && only_cells[cell]) {
          const vehicle::RoadPoint point = road.under_strip(wx, wy, file[i], yaw[i], shape, cams[axle], wheel, cursors);
          if (std::isfinite(point.z_m)) seen[i] = point.z_m;
        }
      }
      const std::vector<double> m = without_slow(measured, half), f = without_slow(file, half), p = strip ? without_slow(seen, half) : f;
      for (std::size_t i = half; i + half < n; ++i) {
        const auto k = static_cast<std::size_t>((time[stretch.begin + i] - time.front()) / Signals::kStep_s);
        if (k >= log.signals->n || !std::isfinite(log.signals->u_m[k]) || !std::isfinite(u[i])) continue;
        const int lap = first_lap + log.signals->lap[k];
        out.push_back({u[i], v[i], m[i], f[i], p[i], measured[i] - file[i], static_cast<std::size_t>(lap) * 4 + wheel, lap % 2});
      }
    }
  }
  return "";
}

/// Means of a difference over places, per half of the laps.
struct Plane {
  std::size_t rows, columns;
  double right_m;
  std::array<std::vector<double>, 2> sum, count;
  Plane(double length_m, double right, double left)
      : rows(static_cast<std::size_t>(length_m / kBinU_m) + 1), columns(static_cast<std::size_t>((left - right) / kBinV_m) + 1), right_m(right) {
    for (auto& s : sum) s.assign(rows * columns, 0.0);
    for (auto& c : count) c.assign(rows * columns, 0.0);
  }
  std::size_t bin(double u, double v) const {
    const double i = u / kBinU_m, j = (v - right_m) / kBinV_m;
    if (!(i >= 0) || !(j >= 0) || i >= static_cast<double>(rows) || j >= static_cast<double>(columns)) return rows * columns;
    return static_cast<std::size_t>(i) * columns + static_cast<std::size_t>(j);
  }
  double mean(std::size_t half, std::size_t k) const { return count[half][k] > 0 ? sum[half][k] / count[half][k] : kNaN; }
  double both(std::size_t k) const {
    const double n = count[0][k] + count[1][k];
    return n > 0 ? (sum[0][k] + sum[1][k]) / n : kNaN;
  }
};

struct Agreement {
  std::vector<double> product, energy, n;  ///< per cell
};
/// Products of the halves' means per cell, one of them moved by `shift` bins.
Agreement agree(const Plane& plane, std::size_t shift) {
  const auto cells = static_cast<std::size_t>(static_cast<double>(plane.rows) * kBinU_m / kCell_m) + 1;
  Agreement out;
  for (auto* v : {&out.product, &out.energy, &out.n}) v->assign(cells, 0.0);
  std::vector<double> aa(cells, 0.0), bb(cells, 0.0);
  for (std::size_t i = 0; i < plane.rows; ++i) {
    const std::size_t other = (i + shift) % plane.rows;
    const auto cell = static_cast<std::size_t>(static_cast<double>(i) * kBinU_m / kCell_m);
    for (std::size_t j = 0; j < plane.columns; ++j) {
      const double x = plane.mean(0, i * plane.columns + j), y = plane.mean(1, other * plane.columns + j);
      if (!std::isfinite(x) || !std::isfinite(y)) continue;
      out.product[cell] += x * y;
      aa[cell] += x * x;
      bb[cell] += y * y;
      out.n[cell] += 1;
    }
  }
  for (std::size_t k = 0; k < cells; ++k) out.energy[k] = std::sqrt(aa[k] * bb[k]);
  return out;
}

std::vector<Place> joined(const std::vector<bool>& cells) {
  std::vector<Place> out;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (!cells[k]) continue;
    const double begin = static_cast<double>(k) * kCell_m;
    if (!out.empty() && begin - out.back().u_end_m < 1.5 * kCell_m) out.back().u_end_m = begin + kCell_m;
    else out.push_back({begin, begin + kCell_m, {}});
  }
  return out;
}

/// The difference between road and file on these places with their means: what drifts is taken from
/// 25 m before and after each place, where the file is right, per pass of a wheel.
Plane anchored(const std::vector<Look>& looks, const std::vector<Place>& places, const std::vector<bool>& cells, const Plane& like) {
  Plane out = like;
  for (auto& s : out.sum) std::fill(s.begin(), s.end(), 0.0);
  for (auto& c : out.count) std::fill(c.begin(), c.end(), 0.0);
  constexpr double kFlank_m = 25.0, kEdge_m = 2.0;
  for (const Place& place : places) {
    std::map<std::size_t, std::vector<const Look*>> passes;
    for (const Look& l : looks)
      if (l.u_m > place.u_begin_m - kFlank_m && l.u_m < place.u_end_m + kFlank_m) passes[l.pass].push_back(&l);
    const double middle = 0.5 * (place.u_begin_m + place.u_end_m), reach = 0.5 * (place.u_end_m - place.u_begin_m) + kFlank_m;
    for (const auto& [pass, samples] : passes) {
      Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
      Eigen::Vector4d right = Eigen::Vector4d::Zero();
      std::array<int, 2> flank{};
      const auto powers = [&](double u) {
        const double d = (u - middle) / reach;
        return Eigen::Vector4d(1, d, d * d, d * d * d);
      };
      for (const Look* l : samples) {
        const auto cell = static_cast<std::size_t>(std::max(0.0, l->u_m) / kCell_m);
        if (l->u_m > place.u_begin_m - kEdge_m && l->u_m < place.u_end_m + kEdge_m) continue;
        if (cell < cells.size() && cells[cell]) continue;
        const Eigen::Vector4d x = powers(l->u_m);
        normal += x * x.transpose();
        right += x * l->raw_m;
        ++flank[l->u_m > middle ? 1 : 0];
      }
      if (flank[0] < 20 || flank[1] < 20) continue;
      const Eigen::Vector4d base = normal.ldlt().solve(right);
      for (const Look* l : samples) {
        if (l->u_m < place.u_begin_m - kEdge_m || l->u_m > place.u_end_m + kEdge_m) continue;
        const std::size_t k = out.bin(l->u_m, l->v_m);
        if (k >= out.rows * out.columns) continue;
        out.sum[static_cast<std::size_t>(l->half)][k] += l->raw_m - base.dot(powers(l->u_m));
        out.count[static_cast<std::size_t>(l->half)][k] += 1;
      }
    }
  }
  return out;
}

}  // namespace

void add_short_waves(Findings& findings, const std::vector<RecordedLog>& logs, const Mapping& mapping, const crg::Surface& surface, const vehicle::Vehicle& car) {
  for (const char* id : {kKerbOrRoughness, kMultiPointContact}) forget_untestable(findings, id);
  const auto cannot = [&](const std::string& reason) {
    findings.untestable.push_back({kKerbOrRoughness, reason});
    findings.untestable.push_back({kMultiPointContact, reason});
  };
  std::vector<Look> looks;
  const auto look_at = [&](bool strip, const std::vector<bool>& cells) {
    looks.clear();
    int lap = 0;
    for (const RecordedLog& log : logs) {
      if (const std::string reason = look(log, mapping, surface, car, lap, strip, cells, looks); !reason.empty()) return reason;
      lap += log.signals->lap.empty() ? 1 : log.signals->lap.back() + 1;
    }
    return lap < 2 ? std::string("one lap cannot say what comes back every lap") : std::string();
  };
  if (const std::string reason = look_at(false, {}); !reason.empty()) return cannot(reason);
  const double length = logs.front().signals->length_m;
  const auto& v = surface.file().grid.v_m;
  Plane plane(length, v.front(), v.back());
  for (const Look& l : looks) {
    const std::size_t k = plane.bin(l.u_m, l.v_m);
    if (k >= plane.rows * plane.columns) continue;
    plane.sum[static_cast<std::size_t>(l.half)][k] += l.measured_m - l.file_m;
    plane.count[static_cast<std::size_t>(l.half)][k] += 1;
  }
  // Which cells agree more than any cell does when one half is moved along the road?
  const Agreement here = agree(plane, 0);
  std::vector<double> most;
  Dice dice{311};
  for (int draw = 0; draw < 300; ++draw) {
    const auto away = static_cast<std::size_t>((0.05 + 0.9 * dice.roll()) * static_cast<double>(plane.rows));
    const Agreement moved = agree(plane, away);
    double largest = 0;
    for (std::size_t k = 0; k < moved.n.size(); ++k)
      if (moved.n[k] >= 20 && moved.energy[k] > 0) largest = std::max(largest, moved.product[k] / moved.energy[k]);
    most.push_back(largest);
  }
  std::sort(most.begin(), most.end());
  const double threshold = most[static_cast<std::size_t>(selection::kWavesQuantile * static_cast<double>(most.size() - 1))];
  std::vector<bool> cells(here.n.size(), false);
  double product = 0, n = 0, z = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (here.n[k] < 20 || !(here.energy[k] > 0)) continue;
    const double height2 = here.product[k] / here.n[k];
    cells[k] = here.product[k] / here.energy[k] > threshold && height2 > selection::kLeastWave_m * selection::kLeastWave_m;
    if (cells[k]) product += here.product[k], n += here.n[k], z = std::max(z, here.product[k] / here.energy[k]);
  }
  findings.evidence.push_back({kKerbOrRoughness, "", fmt::format("agreement of even and odd laps in cells of 10 m; threshold {:.2f}", threshold),
                               n > 0 ? std::sqrt(product / n) : 0.0, z, 0.0, "m"});
  if (n == 0) return;

  // Through the strip, in the cells found and beside them.
  std::vector<bool> wide = cells;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (cells[k])
      for (int d = -2; d <= 2; ++d) wide[(k + cells.size() + static_cast<std::size_t>(d + 2) - 2) % cells.size()] = true;
  const bool strip = car.contact == vehicle::Contact::kSinglePoint;
  if (strip) look_at(true, wide);
  else findings.untestable.push_back({kMultiPointContact, "the stated tyre already touches the road in more than one point"});
  double point2 = 0, strip2 = 0, patch2 = 0, flat2 = 0, count = 0;
  for (const Look& l : looks) {
    const auto cell = static_cast<std::size_t>(std::max(0.0, l.u_m) / kCell_m);
    const std::size_t k = plane.bin(l.u_m, l.v_m);
    if (cell >= cells.size() || !cells[cell] || k >= plane.rows * plane.columns) continue;
    const double other = plane.mean(1 - static_cast<std::size_t>(l.half), k);  // learned on the other laps
    if (!std::isfinite(other)) continue;
    const double d = l.measured_m - l.file_m, s = l.measured_m - l.strip_m;
    point2 += d * d;
    strip2 += s * s;
    patch2 += (d - other) * (d - other);
    flat2 += l.measured_m * l.measured_m;
    count += 1;
  }
  if (!(count > 0)) return;
  const double patch_gain = 1 - patch2 / point2, strip_gain = strip ? 1 - strip2 / point2 : 0.0;
  // New heights can imitate any contact; a contact cannot imitate any height.
  const bool contact = strip_gain > selection::kContactShare * patch_gain && strip_gain > selection::kContactLeast;
  Finding f = finding_of(*find_mechanism(contact ? kMultiPointContact : kKerbOrRoughness));
  f.where = joined(cells);
  f.statistic = z;
  f.threshold = threshold;
  f.cv_gain = (point2 - (contact ? strip2 : patch2)) / (patch2 / count) / 10;
  HeldOut h;
  h.channel = "height under the wheels";
  h.unit = "m";
  h.horizon_s = 0.0;
  h.rmse_before = std::sqrt(point2 / count);
  h.rmse_after = std::sqrt((contact ? strip2 : patch2) / count);
  h.trivial_rmse = std::sqrt(flat2 / count);
  h.drop_low = h.drop_high = 1 - h.rmse_after / h.rmse_before;
  f.held_out.push_back(h);
  const std::string experiment = "survey the kerb, or pass it on a tyre of another size";
  if (contact) {
    f.parameters.push_back({"share of the error in short waves that it takes away", "1", strip_gain, strip_gain, strip_gain});
    f.rivals.push_back({kKerbOrRoughness, "", experiment, patch_gain, strip_gain > selection::kContactAlone * patch_gain});
  } else {
    // Spread between blocks of 2 m, drawn again.
    std::vector<std::pair<double, double>> blocks;
    for (std::size_t i = 0; i < plane.rows; ++i) {
      const auto cell = static_cast<std::size_t>(static_cast<double>(i) * kBinU_m / kCell_m);
      if (cell >= cells.size() || !cells[cell]) continue;
      if (i % 10 == 0 || blocks.empty()) blocks.emplace_back(0.0, 0.0);
      for (std::size_t j = 0; j < plane.columns; ++j) {
        const double p = plane.mean(0, i * plane.columns + j), q = plane.mean(1, i * plane.columns + j);
        if (std::isfinite(p) && std::isfinite(q)) blocks.back().first += p * q, blocks.back().second += 1;
      }
    }
    std::vector<double> draws;
    for (int draw = 0; draw < 400; ++draw) {
      double s = 0, c = 0;
      for (std::size_t k = 0; k < blocks.size(); ++k) {
        const auto& one = blocks[static_cast<std::size_t>(dice.roll() * static_cast<double>(blocks.size()))];
        s += one.first, c += one.second;
      }
      draws.push_back(c > 0 ? std::sqrt(std::max(0.0, s / c)) : 0.0);
    }
    std::sort(draws.begin(), draws.end());
    f.parameters.push_back({"RMS height that is missing", "m", std::sqrt(product / n), draws[20], draws[379]});
    if (strip) f.rivals.push_back({kMultiPointContact, "", experiment, strip_gain, true});
    const Plane whole = anchored(looks, f.where, cells, plane);
    HeightPatch& patch = f.patch;
    patch.u_step_m = kBinU_m;
    patch.v_step_m = kBinV_m;
    patch.right_m = plane.right_m;
    patch.columns = plane.columns;
    patch.dz_m.assign(plane.rows * plane.columns, 0.0);
    for (std::size_t i = 0; i < plane.rows; ++i) {
      const auto cell = static_cast<std::size_t>(static_cast<double>(i) * kBinU_m / kCell_m);
      if (cell >= cells.size() || !cells[cell]) continue;
      double mean = 0, seen = 0;
      for (std::size_t j = 0; j < plane.columns; ++j) {
        // Where nobody drove, what was measured within a metre beside it.
        double value = whole.both(i * plane.columns + j);
        for (std::size_t d = 1; d <= 2 && !std::isfinite(value); ++d) {
          if (j >= d) value = whole.both(i * plane.columns + j - d);
          if (!std::isfinite(value) && j + d < plane.columns) value = whole.both(i * plane.columns + j + d);
        }
        if (!std::isfinite(value)) continue;
        patch.dz_m[i * plane.columns + j] = value;
        mean += value, seen += 1;
      }
      f.profile.push_back({(static_cast<double>(i) + 0.5) * kBinU_m, seen > 0 ? mean / seen : 0.0, h.rmse_after});
    }
    const double step = surface.file().grid.u_step_m;
    if (step > 0.25) findings.remarks.push_back(fmt::format("the road's rows are {:.2g} m apart: waves shorter than {:.2g} m cannot be written back; crgbuild resample makes them closer", step, 2 * step));
  }
  findings.findings.push_back(f);
}

}  // namespace explain
