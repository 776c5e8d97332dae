#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "drive_columns.h"
#include "identify/drive_fits.h"
#include "identify/least_squares.h"
#include "recording/channels.h"
#include "vehicle/laws/suspension.h"
#include "window_fit.h"

namespace identify {
namespace {

using vehicle::kWheels;
using P = vehicle::Parameter;
using vehicle::Term;
constexpr double kFromStop_m = 0.002, kStraight = 2.0;
constexpr double kPiece_s = 0.05;   ///< rates are slopes over so long: less is noise, more no rate
constexpr double kLeast_mps = 5.0;  ///< slower rows are left out
/// Standard deviation of what straight pieces and links leave out: measured on the simulated car.
constexpr double kModelShare = 0.05;
constexpr std::size_t kBump = 9, kRebound = 10, kColumns = 11;

std::string damper_channel_missing(const DriveColumns& c) {
  if (c.load[0] == nullptr) return "no loads of all wheels (fz_fl_n ...)";
  if (c.travel[0] == nullptr) return "no travels of all wheels (suspension_fl_m ...)";
  if (c.vx == nullptr || c.ax == nullptr || c.ay == nullptr)
    return "no vx_mps, ax_mps2 and ay_mps2";
  return {};
}

/// Mean and slope of a channel over rows.
struct Piece {
  double mean = 0.0, slope = 0.0;
  double curve = 0.0;  ///< second derivative
  double off = 0.0;    ///< from the parabola, root mean square with its freedom
};

Piece piece_of(const std::vector<double>& time_s, const std::vector<double>& value,
               std::size_t begin, std::size_t end) {
  const double middle_s = 0.5 * (time_s[begin] + time_s[end - 1]),
               n = static_cast<double>(end - begin);
  Equation e;
  for (std::size_t k = begin; k < end; ++k) {
    const double t = time_s[k] - middle_s;
    e.add({1.0, t, 0.5 * t * t}, value[k]);
  }
  const std::vector<double> f = linear_fit(e);
  Piece out{0.0, f[1], f[2], 0.0};
  for (std::size_t r = 0; r < e.wanted.size(); ++r) {
    out.mean += e.wanted[r] / n;
    out.off += std::pow(e.wanted[r] - f[0] - f[1] * e.columns[1][r] - f[2] * e.columns[2][r], 2.0);
  }
  out.off = std::sqrt(out.off / std::max(1.0, n - 3.0));
  return out;
}

/// The damper of the vehicle file at a rate, N, and whether it is a map.
double stated_n(const vehicle::Car<double>& car, std::size_t axle, double rate_mps) {
  const vehicle::Map1& map = car.files->damper_n[axle];
  return map.empty() ? vehicle::laws::damper_force(car.parameters, axle, rate_mps)
                     : vehicle::evaluate(map, rate_mps);
}

/// What one axle's wheels say.
struct Collected {
  Equation equation;
  std::vector<std::size_t> block;
  std::vector<double> rate_mps;
};

class DamperCollector {
 public:
  DamperCollector(const vehicle::Car<double>& car, const recording::Recording& recording,
                  const DriveColumns& c)
      : car_(car), recording_(recording), c_(c) {
    for (std::size_t i = 0; i < kWheels; ++i) noise_m_[i] = noise_of(*c.travel[i]);
  }

  std::array<Collected, 2> collect() {
    const auto length = std::max<std::size_t>(
        4, static_cast<std::size_t>(std::lround(kPiece_s / recording_.step_s)));
    for (const recording::Stretch& s : recording_.stretches)
      for (std::size_t begin = s.begin; begin + length <= s.end; begin += length)
        add(begin, begin + length);
    return std::move(out_);
  }

 private:
  bool whole(std::size_t begin, std::size_t end) const {
    for (std::size_t k = begin; k < end; ++k) {
      double all = (*c_.ax)[k] + (*c_.ay)[k];
      for (std::size_t i = 0; i < kWheels; ++i) all += (*c_.load[i])[k] + (*c_.travel[i])[k];
      if (!std::isfinite(all) || !((*c_.vx)[k] >= kLeast_mps)) return false;
    }
    return true;
  }

  void add(std::size_t begin, std::size_t end) {
    if (!whole(begin, end)) return;
    const auto piece = [&](Column c) { return piece_of(*c_.time, *c, begin, end); };
    std::array<Piece, kWheels> load, travel;
    for (std::size_t i = 0; i < kWheels; ++i) {
      load[i] = piece(c_.load[i]);
      travel[i] = piece(c_.travel[i]);
      const auto into =
          vehicle::laws::stop_compression(car_.parameters, vehicle::axle_of(i), travel[i].mean);
      if (car_.terms[Term::bump_stop] > 0.0 &&
          (into.bump_m > -kFromStop_m || into.droop_m > -kFromStop_m))
        return;
      if (load[i].mean < 100.0) return;  // in the air
    }
    const double ax = piece(c_.ax).mean, ay = piece(c_.ay).mean, vx = piece(c_.vx).mean;
    const double up = c_.az != nullptr ? piece(c_.az).mean : 0.0;
    const std::size_t middle = (begin + end) / 2;
    const std::size_t block =
        blocks_.of(at(c_.x, middle), at(c_.y, middle), at(c_.time, middle) - c_.time->front());
    for (std::size_t i = 0; i < kWheels; ++i) {
      const std::size_t a = vehicle::axle_of(i), other = i ^ 1u;
      const double side = i % 2 == 0 ? 1.0 : -1.0, rate = travel[i].slope;
      if (travel[i].off > kStraight * noise_m_[i]) continue;  // no one rate: a kerb
      Collected& out = out_[a];
      out.equation.add(
          {travel[i].mean, travel[other].mean, i % 2 == 0 ? 1.0 : 0.0, i % 2 == 0 ? 0.0 : 1.0,
           side * ay, side * ay * load[i].mean / (load[i].mean + load[other].mean),
           std::max(0.0, ax), std::min(0.0, ax),
           std::isfinite(up) && c_.az != nullptr ? up : 1e-3 * vx * vx,
           rate > 0.0 ? stated_n(car_, a, rate) : 0.0, rate > 0.0 ? 0.0 : stated_n(car_, a, rate)},
          load[i].mean - car_.parameters.axle(a, P::front_unsprung_mass_kg) * travel[i].curve);
      out.block.push_back(block);
      out.rate_mps.push_back(rate);
    }
  }

  const vehicle::Car<double>& car_;
  const recording::Recording& recording_;
  const DriveColumns& c_;
  Blocks blocks_{100.0, 10.0};
  std::array<double, kWheels> noise_m_{};
  std::array<Collected, 2> out_;
};

/// Which share of the rates' variance is true, the rest being noise of the travels.
double true_share(const Collected& axle, const DriveColumns& c, std::size_t a, double step_s) {
  const double n = std::max(4.0, std::round(kPiece_s / step_s));
  const double spread = step_s * step_s * n * (n * n - 1.0) / 12.0;
  const double noise = std::hypot(noise_of(*c.travel[2 * a]), noise_of(*c.travel[2 * a + 1]));
  double square = 0.0;
  for (const double rate : axle.rate_mps) square += rate * rate;
  square /= static_cast<double>(axle.rate_mps.size());
  return 1.0 - 0.5 * noise * noise / spread / square;
}

/// `why`: they are not observable, whatever the rows say; empty: the rows are asked.
void find_dampers(const vehicle::Car<double>& car, const Collected& axle, std::size_t a,
                  double share, std::string why, DriveFit& out) {
  const bool by_map = !car.files->damper_n[a].empty();
  const std::string name = recording::kAxleNames[a];
  double spread = 0.0;
  if (why.empty()) {
    spread = base::quantile(axle.rate_mps, 0.95) - base::quantile(axle.rate_mps, 0.05);
    if (share < 0.7)
      why = fmt::format("{:.0f} % of the travels' rates are noise", 100.0 * (1.0 - share));
    else if (spread < 0.02)
      why = fmt::format("travels' rates vary by {:.0f} mm/s, wanted 20", 1e3 * spread);
  }
  ClusteredFit fit;
  if (why.empty()) {
    auto fitted = clustered_fit({axle.equation}, axle.block);
    if (fitted)
      fit = *std::move(fitted);
    else
      why = fitted.refusal().message;
  }
  for (const bool bump : {true, false}) {
    const std::string what = bump ? "bump" : "rebound";
    const double stated = by_map ? 1.0
                                 : car.parameters.axle(a, bump ? P::front_bump_damping_nspm
                                                               : P::front_rebound_damping_nspm);
    Found f = found_of(name + "_" + what + (by_map ? "_damper" : "_damping_nspm"),
                       by_map ? "1" : "N s/m", stated, why);
    if (why.empty()) {
      const std::size_t k = bump ? kBump : kRebound;
      const double value = fit.value[k] / share * stated;
      set_found(f, value, static_cast<double>(fit.blocks) - static_cast<double>(kColumns),
                fit.sd(k) / share * stated, value * std::hypot(kModelShare, 0.3 * (1.0 - share)));
      hide_wide(f, fmt::format("; rates vary by {:.0f} mm/s", 1e3 * spread));
      if (f.unseen.empty() && !(f.value > 0.0))
        out.doubts.push_back(fmt::format(
            "the {} dampers push along with the {} travel: sign of the travels, or clocks of loads "
            "and travels that differ?",
            name, what));
    }
    out.found.push_back(std::move(f));
  }
  if (why.empty())
    out.remarks.push_back(fmt::format(
        "{} dampers: {:.0f} % of the variance of the travels' rates is noise, taken out", name,
        100.0 * (1.0 - share)));
}

}  // namespace

DriveFit fit_dampers(const vehicle::Car<double>& car, const recording::Recording& recording) {
  DriveFit out;
  const DriveColumns c = columns_of(recording.table);
  std::string why = damper_channel_missing(c);
  if (why.empty() && 4.0 * recording.step_s > 1.02 * kPiece_s)
    why = fmt::format("a row every {:.0f} ms, wanted {:.0f} at most", 1e3 * recording.step_s,
                      250.0 * kPiece_s);
  std::array<Collected, 2> axles;
  if (why.empty()) axles = DamperCollector(car, recording, c).collect();
  for (std::size_t a = 0; a < 2; ++a) {
    if (why.empty() && axles[a].block.size() < 100)
      why = fmt::format("{} pieces of {:.2g} s clear of the stops, wanted 100",
                        axles[a].block.size(), kPiece_s);
    const double share = why.empty() ? true_share(axles[a], c, a, recording.step_s) : 0.0;
    find_dampers(car, axles[a], a, share, why, out);
  }
  if (why.empty())
    out.remarks.push_back(fmt::format(
        "dampers have the shape of the vehicle file (its knee and fast share, or its map); of "
        "{:.1f} "
        "Hz and more nothing is seen; {:.0f} % of a rate are counted for what that leaves out",
        0.5 / kPiece_s, 100.0 * kModelShare));
  return out;
}

}  // namespace identify
