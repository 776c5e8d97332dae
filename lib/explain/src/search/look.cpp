// How the rows come about: how long the steps are, where a car is driven, what a stopped run has
// kept of it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "analysis.h"
#include "base/parallel.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Mean square of the difference over that which is let pass: what a good logger's mean over 0.3 s
/// just tells (0.03 m/s2, rad/s2, N per kg), or 3 % of the quantity itself. Infinite where the
/// coarse drive is lost.
double apart(const std::vector<double>& coarse, const std::vector<double>& fine, double unit) {
  double sum = 0, square = 0, count = 0;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    if (!std::isfinite(fine[i])) continue;
    if (!std::isfinite(coarse[i])) return HUGE_VAL;  // lost
    sum += (coarse[i] - fine[i]) * (coarse[i] - fine[i]);
    square += fine[i] * fine[i];
    count += 1;
  }
  return count > 0 ? sum / std::max(0.03 * 0.03 * count * unit * unit, 0.03 * 0.03 * square) : 0.0;
}

double apart(const Led& coarse, const Led& fine, double mass_kg) {
  return std::max({apart(coarse.force_x_mps2, fine.force_x_mps2, 1.0),
                   apart(coarse.force_y_mps2, fine.force_y_mps2, 1.0),
                   apart(coarse.yaw_radps2, fine.yaw_radps2, 1.0),
                   apart(coarse.load_front_n, fine.load_front_n, mass_kg),
                   apart(coarse.load_rear_n, fine.load_rear_n, mass_kg)});
}

/// The largest apart() of all recordings.
double most_apart(const std::vector<KnownDrive>& coarse, const std::vector<KnownDrive>& fine,
                  double mass_kg) {
  double most = 0.0;
  for (std::size_t k = 0; k < coarse.size(); ++k)
    most = std::max(most, apart(coarse[k].led, fine[k].led, mass_kg));
  return most;
}

double seconds(const std::vector<double>& x) {
  return Signals::kStep_s * static_cast<double>(std::count_if(
                                x.begin(), x.end(), [](double v) { return std::isfinite(v); }));
}

}  // namespace

std::vector<KnownDrive> Analysis::choose_substeps() {
  const double mass = car_.parameters[vehicle::Parameter::chassis_mass_kg];
  std::vector<std::vector<KnownDrive>> driven;  // each in steps half as long as the one before
  bool enough = false;
  for (const int substeps : {10, 20, 40, 80}) {
    stated_.substeps = substeps;
    std::vector<KnownDrive>& now = driven.emplace_back(logs_.size());
    base::parallel_for(logs_.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
      residuals(logs_[k], car_, stated_,
                {.keep = &now[k], .tick = [&] { progress("length of the steps", 0.0); }});
    });
    const std::size_t last = driven.size() - 1;
    enough = last > 0 && most_apart(driven[last - 1], now, mass) < 1.0;
    if (enough) break;
  }
  if (enough) driven.pop_back();
  for (std::size_t k = 0; k < logs_.size() && !enough; ++k) {
    const KnownDrive& drive = driven.back()[k];
    const double led = seconds(drive.led.force_x_mps2), wanted = seconds(drive.by.vx_mps);
    if (led < 0.9 * wanted)
      remarks_.push_back(fmt::format(
          "the car of the vehicle file cannot follow this recording: in {:.0f} of {:.0f} s its "
          "equations of motion are lost even in steps of {:.2g} ms; forces are compared where they "
          "hold; crgdrive replay shows where",
          wanted - led, wanted, 1e3 * Signals::kStep_s / stated_.substeps));
  }
  fine_substeps_ = driven.back().front().setting.substeps;
  // Differences between two drives need less: three times as much is let pass. With five times as
  // much the search went another way on a real oval.
  constexpr double kRoughly = 3.0 * 3.0;
  std::size_t rough = 0;
  while (rough + 1 < driven.size() && !(most_apart(driven[rough], driven.back(), mass) < kRoughly))
    ++rough;
  stated_.substeps = driven[rough].front().setting.substeps;
  drives_ = driven[rough];
  return std::move(driven.back());
}

void Analysis::find_what_fine_steps_add() {
  Setting setting = setting_with(amounts_);
  if (!options_.forces || setting.substeps == fine_substeps_) return;
  const auto driven = [&] {
    return std::move(
        explain::rows_at(logs_, car_, {setting}, drives_, rows_, options_.threads).front());
  };
  const VectorXd rough = driven();
  setting.substeps = fine_substeps_;
  const VectorXd added = driven() - rough;
  fine_adds_ = added.array().isFinite().select(added, 0.0);
}

VectorXd Analysis::rows_at(const Setting& setting) const {
  return std::move(rows_at(std::vector<Setting>{setting}).front());
}

std::vector<VectorXd> Analysis::rows_at(const std::vector<Setting>& settings,
                                        const std::function<void(double)>& progress) const {
  if (!options_.forces) {
    std::vector<VectorXd> out(settings.size());
    base::parallel_for(settings.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
      out[k] = rows_without_drive(settings[k]);
    });
    return out;
  }
  const MatrixXd driven = kept([&] {
    const std::vector<VectorXd> rows =
        explain::rows_at(logs_, car_, settings, drives_, rows_, options_.threads, progress);
    MatrixXd together(static_cast<Index>(rows_.row.size()), static_cast<Index>(rows.size()));
    for (std::size_t k = 0; k < rows.size(); ++k) together.col(static_cast<Index>(k)) = rows[k];
    return together;
  });
  std::vector<VectorXd> out;
  for (Index k = 0; k < driven.cols(); ++k) {
    VectorXd& rows = out.emplace_back(driven.col(k));
    if (fine_adds_.size() > 0) rows += fine_adds_;
    for (Index i = 0; i < rows.size(); ++i)
      if (!std::isfinite(rows[i])) rows[i] = stated_rows_[i];
    take_stretches(rows);
  }
  return out;
}

void Analysis::take_stretches(VectorXd& rows) const {
  for (const Accepted& a : accepted_)
    if (is_kinematic_stretch(a)) rows -= a.columns * a.amounts;
}

MatrixXd Analysis::kept(const std::function<MatrixXd()>& make) const {
  // The n-th of a run is the n-th of every run over the same inputs.
  const std::string name = fmt::format("drives {}", ++asked_);
  const auto rows = static_cast<Index>(rows_.row.size());
  std::string bytes;
  if (options_.kept.load && options_.kept.load(name, bytes) && rows > 0 &&
      bytes.size() % (static_cast<std::size_t>(rows) * sizeof(double)) == 0) {
    MatrixXd out(rows, static_cast<Index>(bytes.size() / sizeof(double)) / rows);
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
  }
  const auto begin = std::chrono::steady_clock::now();
  MatrixXd out = make();
  constexpr std::chrono::milliseconds kWorthIt{250};
  if (options_.kept.keep && std::chrono::steady_clock::now() - begin > kWorthIt)
    options_.kept.keep(name, std::string(reinterpret_cast<const char*>(out.data()),
                                         static_cast<std::size_t>(out.size()) * sizeof(double)));
  return out;
}

MatrixXd Analysis::columns_of(const std::vector<const Unknown*>& unknowns,
                              const char* stage) const {
  if (!options_.forces) {
    std::vector<Setting> moved(unknowns.size() + 1, setting_with(amounts_));
    for (std::size_t k = 0; k < unknowns.size(); ++k) unknowns[k]->set(moved[k], unknowns[k]->step);
    const std::vector<VectorXd> there = rows_at(moved);
    MatrixXd out(there.back().size(), static_cast<Index>(unknowns.size()));
    for (std::size_t k = 0; k < unknowns.size(); ++k)
      out.col(static_cast<Index>(k)) = (there.back() - there[k]) / unknowns[k]->step;
    return out;
  }
  return kept([&] {
    return derivatives(logs_, car_, setting_with(amounts_), unknowns, drives_, rows_,
                       options_.threads, [&](double share) { progress(stage, share); });
  });
}

VectorXd Analysis::rows_without_drive(const Setting& setting) const {
  std::vector<Residuals> out;
  for (std::size_t k = 0; k < logs_.size(); ++k)
    out.push_back(residuals(logs_[k], car_, setting, {.known = &drives_[k], .none = true}));
  VectorXd rows = gather(rows_, out);
  if (fine_adds_.size() > 0) rows += fine_adds_;
  take_stretches(rows);
  return rows.array().isFinite().select(rows, r_);
}

void Analysis::look() {
  const Setting setting = setting_with(amounts_);
  if (!options_.forces) {
    r_ = rows_without_drive(setting);
    return;
  }
  base::parallel_for(logs_.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
    residuals(logs_[k], car_, setting, {.known = &drives_[k], .keep = &drives_[k], .tick = [&] {
                                          progress("refit of the parameters", 0.0);
                                        }});
  });
  r_ = rows_at(setting);
}

}  // namespace explain
