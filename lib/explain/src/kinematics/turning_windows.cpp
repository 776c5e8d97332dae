#include "turning_windows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace explain {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Steps of Signals::kStep_s: a window every second, which begins and ends within half a second. A
/// road leans over in two: longer ones take the nose's pitching for a lean.
constexpr std::size_t kWindow = 20, kRamp = 10, kAll = kWindow + kRamp;
constexpr double kSlowest_mps = 6.0;

double at_time(const std::vector<double>& x, double step) {
  if (!(step >= 0) || step + 1 >= static_cast<double>(x.size()))
    return std::numeric_limits<double>::quiet_NaN();
  const auto i = static_cast<std::size_t>(step);
  const double f = step - static_cast<double>(i);
  return (1 - f) * x[i] + f * x[i + 1];
}

/// One recording being cut into windows.
struct Cutting {
  const Turning& log;
  const OffTheLine& off;
  double length_m = 0.0;
  bool closed = false;
  Index places = 0;
  double delay_steps = 0.0, filter_s = 0.0;
};

/// A window from step `first` on: what the gyro has more, the errors, how far was turned where.
struct Window {
  double more_rad = 0.0;
  std::array<double, kErrors> error{};
  VectorXd turned_rad, went_m, beside_m2, slope_m, bend;
};

bool is_known(const Cutting& c, std::size_t first) {
  for (std::size_t i = first; i <= first + kAll; ++i) {
    const double step = static_cast<double>(i) + c.delay_steps;
    if (!(c.log.speed_mps[i] > kSlowest_mps) ||
        !std::isfinite(c.log.u_m[i] + c.log.turned_rad[i] + c.log.cosine[i] + c.off.bend_1pm[i] +
                       at_time(c.log.gyro_radps, step) + at_time(c.log.dgyro_radps2, step)))
      return false;
  }
  return true;
}

Window window_at(const Cutting& c, std::size_t first) {
  Window w;
  w.turned_rad = w.went_m = w.beside_m2 = w.slope_m = w.bend = VectorXd::Zero(c.places);
  double stated_rad = 0.0, gyro_rad = 0.0;
  for (std::size_t k = 0; k < kAll; ++k) {
    const std::size_t i = first + k;
    const double share =
        std::min({1.0, (static_cast<double>(k) + 0.5) / static_cast<double>(kRamp),
                  (static_cast<double>(kAll - k) - 0.5) / static_cast<double>(kRamp)});
    const double turned = share * (c.log.turned_rad[i + 1] - c.log.turned_rad[i]);
    stated_rad += 0.5 * (c.log.cosine[i] + c.log.cosine[i + 1]) * turned;
    const Beside b = beside(c.log.u_m[i], c.length_m, c.closed, c.places);
    const double way_m = share * went(c.log, i, c.length_m, c.closed);
    for (const auto& [place, part] :
         {std::pair{b.first, (1 - b.share) * way_m}, {b.second, b.share * way_m}}) {
      w.went_m[place] += part;
      w.beside_m2[place] += part * c.off.beside_m[i];
      w.slope_m[place] += part * c.off.slope[i];
      w.bend[place] += part * c.off.bend_1pm[i];
    }
    const double begin = static_cast<double>(i) + c.delay_steps;
    const auto mean = [&](const std::vector<double>& x) {
      return 0.5 * (at_time(x, begin) + at_time(x, begin + 1));
    };
    const double of = share * Signals::kStep_s, change = mean(c.log.dgyro_radps2),
                 bends = share * (at_time(c.log.dgyro_radps2, begin + 1) -
                                  at_time(c.log.dgyro_radps2, begin));
    const double felt = of * (mean(c.log.gyro_radps) + c.filter_s * change);
    gyro_rad += felt;
    w.turned_rad[b.first] += (1 - b.share) * felt;
    w.turned_rad[b.second] += b.share * felt;
    w.error[kBias] += of;
    w.error[kDelay] -= of * change + c.filter_s * bends;
    w.error[kFilter] += bends;
    w.error[kSlip] += share * (c.log.speed_mps[i + 1] * at_time(c.log.gyro_radps, begin + 1) -
                               c.log.speed_mps[i] * at_time(c.log.gyro_radps, begin));
  }
  w.more_rad = gyro_rad - stated_rad;
  w.error[kGain] = gyro_rad;
  return w;
}

/// Half laps that hold next to nothing join the one before.
void number_folds(TurningWindows& w) {
  std::map<int, std::size_t> size;
  for (const int f : w.fold) ++size[f];
  std::map<int, int> number;
  int next = -1;
  for (const auto& [fold, count] : size) {
    if (next < 0 || count * 5 > w.fold.size() / size.size()) ++next;
    number[fold] = next;
  }
  for (int& f : w.fold) f = number[f];
  w.folds = next + 1;
}

}  // namespace

Beside beside(double u_m, double length_m, bool closed, Index places) {
  const Index spaces = closed ? places : places - 1;
  const double at = (u_m > 0 ? std::min(u_m / length_m, 1.0) : 0.0) * static_cast<double>(spaces);
  const Index k = std::min(static_cast<Index>(at), spaces - 1);
  return {k, (k + 1) % places, at - static_cast<double>(k)};
}

double went(const Turning& log, std::size_t i, double length_m, bool closed) {
  const double way = log.u_m[i + 1] - log.u_m[i];
  return closed && way < -0.5 * length_m ? way + length_m : way;
}

TurningWindows turning_windows(const std::vector<Turning>& logs, const std::vector<OffTheLine>& off,
                               double length_m, bool closed, Index places, double delay_s,
                               double filter_s) {
  std::vector<Window> windows;
  TurningWindows out;
  int laps = 0;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const Turning& log = logs[k];
    const Cutting c{
        log, off[k], length_m, closed, places, (delay_s - filter_s) / Signals::kStep_s, filter_s};
    if (log.by == TurningBy::kNone) continue;
    for (std::size_t first = 0; first + kAll < log.u_m.size();) {
      if (!is_known(c, first)) {
        ++first;
        continue;
      }
      Window w = window_at(c, first);
      const std::size_t middle = first + kAll / 2;
      out.fold.push_back(2 * (laps + log.lap[middle]) + (log.u_m[middle] > 0.5 * length_m ? 1 : 0));
      windows.push_back(std::move(w));
      first += kWindow;
    }
    laps += log.lap.empty() ? 1 : log.lap.back() + 1;
  }
  const auto rows = static_cast<Index>(windows.size());
  out.more_rad = VectorXd(rows);
  out.turned_rad = out.went_m = out.beside_m2 = out.slope_m = out.bend = MatrixXd(rows, places);
  out.errors = MatrixXd(rows, Index{kErrors});
  for (Index i = 0; i < rows; ++i) {
    const Window& w = windows[static_cast<std::size_t>(i)];
    out.more_rad[i] = w.more_rad;
    out.turned_rad.row(i) = w.turned_rad.transpose();
    out.went_m.row(i) = w.went_m.transpose();
    out.beside_m2.row(i) = w.beside_m2.transpose();
    out.slope_m.row(i) = w.slope_m.transpose();
    out.bend.row(i) = w.bend.transpose();
    for (Index k = 0; k < kErrors; ++k) out.errors(i, k) = w.error[static_cast<std::size_t>(k)];
  }
  number_folds(out);
  return out;
}

TurnedPlaces turned_places(const std::vector<Turning>& logs, double length_m, bool closed,
                           Index places) {
  TurnedPlaces out;
  for (VectorXd* v : {&out.turned_rad, &out.went_m, &out.bank, &out.grade, &out.v_m})
    *v = VectorXd::Zero(places);
  VectorXd count = VectorXd::Zero(places);
  for (const Turning& log : logs) {
    for (std::size_t i = 0; i + 1 < log.u_m.size() && log.by != TurningBy::kNone; ++i) {
      const double turned = log.turned_rad[i + 1] - log.turned_rad[i];
      if (!std::isfinite(log.u_m[i] + turned + log.cosine[i]) || !(log.speed_mps[i] > kSlowest_mps))
        continue;
      const Beside b = beside(log.u_m[i], length_m, closed, places);
      for (const auto& [k, share] : {std::pair{b.first, 1 - b.share}, {b.second, b.share}}) {
        count[k] += share;
        out.turned_rad[k] += share * turned;
        out.went_m[k] += share * went(log, i, length_m, closed);
        out.bank[k] += share * log.bank[i];
        out.grade[k] += share * log.grade[i];
        out.v_m[k] += share * log.v_m[i];
      }
    }
  }
  Index last = 0;
  while (last < places && !(count[last] > 0)) ++last;
  if (last == places) return out;
  for (Index k = last, n = 0; n < places; k = (k + 1) % places, ++n) {
    if (count[k] > 0) {
      for (VectorXd* v : {&out.bank, &out.grade, &out.v_m}) (*v)[k] /= count[k];
      last = k;
    } else {
      for (VectorXd* v : {&out.bank, &out.grade, &out.v_m}) (*v)[k] = (*v)[last];
    }
  }
  return out;
}

}  // namespace explain
