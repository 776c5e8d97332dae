#include "analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <tuple>

#include "base/parallel.h"
#include "road_profiles.h"
#include "vehicle/error.h"

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

Analysis::Analysis(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                   const ExplainOptions& options)
    : logs_(logs), car_(car), options_(options) {
  if (logs.empty()) throw vehicle::Error("no recordings");
  inventory_ = inventory(logs, car);
  for (std::size_t k = 0; k < inventory_.unknowns.size(); ++k)
    (inventory_.unknowns[k].role == Role::kCandidate ? candidate_ : refit_).push_back(k);
  cells_ = static_cast<int>(logs.front().length_m / kCell_m) + 1;
  stated_.p = car.parameters;
  const std::vector<KnownDrive> fine = choose_substeps();
  std::vector<Residuals> base;
  for (std::size_t k = 0; k < logs.size(); ++k)
    base.push_back(residuals(logs[k], car, fine[k].setting, {.known = &fine[k]}));
  rows_ = make_rows(logs, base);
  if (rows_.row.size() < selection::kLeastRows)
    throw vehicle::Error(
        fmt::format("{}: {:.0f} s of usable driving on this road; at least 30 s are wanted",
                    logs.front().name, 0.3 * static_cast<double>(rows_.row.size()) / 4));
  // Laps held out take no part in any choice: their weight is zero.
  for (const Row& row : rows_.row) training_.push_back(options.hold_out.count(row.lap) == 0);
  if (std::count(training_.begin(), training_.end(), true) <
      static_cast<std::ptrdiff_t>(selection::kLeastRows))
    throw vehicle::Error("the held-out laps leave less than 30 s for the analysis");
  amounts_ = VectorXd::Zero(static_cast<Index>(refit_.size()));
  stated_rows_ = gather(rows_, base);
  find_what_fine_steps_add();
}

Findings Analysis::begin() const {
  Findings out;
  out.laps = static_cast<std::size_t>(rows_.laps);
  for (const Signals& s : logs_) {
    out.remarks.insert(out.remarks.end(), s.remarks.begin(), s.remarks.end());
    out.rounds += s.closed ? s.rounds : 0.0;
    out.broken_columns = out.broken_columns || s.broken;
  }
  out.remarks.insert(out.remarks.end(), remarks_.begin(), remarks_.end());
  return out;
}

Setting Analysis::setting_with(const VectorXd& amounts) const {
  Setting s = stated_;
  s.along = turning_road_;
  for (std::size_t k = 0; k < refit_.size(); ++k)
    inventory_.unknowns[refit_[k]].set(s, amounts[static_cast<Index>(k)]);
  auto at = static_cast<Index>(refit_.size());
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) inventory_.unknowns[a.unknown].set(s, amounts[at++]);
    if (a.shapes.size() > 0) s.along.*inventory_.unknowns[a.unknown].profile = values_along(a);
  }
  return s;
}

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
  if (setting.substeps == fine_substeps_) return;
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
  }
  return out;
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
  return rows.array().isFinite().select(rows, r_);
}

void Analysis::look() {
  const Setting setting = setting_with(amounts_);
  base::parallel_for(logs_.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
    residuals(logs_[k], car_, setting,
              {.known = &drives_[k], .keep = &drives_[k], .tick = [&] {
                 progress("refit of the parameters", 0.0);
               }});
  });
  r_ = rows_at(setting);
}

void Analysis::weigh() {
  const VectorXd e =
      weight_.size() == 0 ? r_ : VectorXd(model().fitted.e.cwiseQuotient(weight_.cwiseMax(1e-12)));
  Noise noise = noise_of(rows_, e, training_);
  weight_ = std::move(noise.weight);
  sigma_ = noise.sigma;
  spread_ = noise.spread;
}

Analysis::Model Analysis::model(const VectorXd& w) const {
  Model m;
  Index columns = moves_.cols();
  for (const Accepted& a : accepted_) columns += a.columns.cols();
  MatrixXd x(r_.size(), columns);
  m.precision = VectorXd::Zero(columns);
  VectorXd before = VectorXd::Zero(columns);
  x.leftCols(moves_.cols()) = moves_;
  for (Index k = 0; k < moves_.cols(); ++k)
    if (k < static_cast<Index>(refit_.size())) {
      m.precision[k] =
          1.0 / (width(static_cast<std::size_t>(k)) * width(static_cast<std::size_t>(k)));
      before[k] = amounts_[k];
    }
  auto everywhere = static_cast<Index>(refit_.size());
  for (const Accepted& a : accepted_) {
    if (!has_one_amount(a)) continue;
    for (Index i = 0; i < x.rows() && a.kinematic && everywhere < moves_.cols(); ++i)
      if (!relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only)
        x(i, everywhere) = 0.0;
    ++everywhere;
  }
  Index at = moves_.cols();
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) continue;
    x.middleCols(at, a.columns.cols()) = a.columns;
    m.precision.segment(at, a.columns.cols()) = a.precision;
    if (a.shapes.size() > 0) before.segment(at, a.columns.cols()) = a.amounts;
    at += a.columns.cols();
  }
  m.fitted = fit(w.asDiagonal() * x, w.cwiseProduct(r_), m.precision, before);
  return m;
}

VectorXd Analysis::careful_weights(Stage stage) const {
  // Errors of the stated curves come back in every state and every lap: more rows do not make them
  // smaller, so that a relation with forces counts as no more than this many independent ones.
  std::array<double, kRelationCount> rows{};
  for (const Row& row : rows_.row) rows[row.relation] += 1;
  VectorXd w = weights(stage);
  for (Index i = 0; i < w.size(); ++i) {
    const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
    if (!relations()[k].sensors_only)
      w[i] *= std::sqrt(std::min(1.0, selection::kIndependentRows * spread_[k] / rows[k]));
  }
  return w;
}

VectorXd Analysis::weights(Stage stage) const {
  if (stage == Stage::kForces) return weight_;
  VectorXd w = weight_;
  for (Index i = 0; i < w.size(); ++i)
    if (!relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only) w[i] = 0.0;
  return w;
}

std::vector<const Unknown*> Analysis::free_unknowns() const {
  std::vector<const Unknown*> free;
  for (const std::size_t k : refit_) free.push_back(&inventory_.unknowns[k]);
  for (const Accepted& a : accepted_)
    if (has_one_amount(a)) free.push_back(&inventory_.unknowns[a.unknown]);
  return free;
}

void Analysis::update_moves(std::size_t from) {
  const std::vector<const Unknown*> free = free_unknowns();
  const std::vector<const Unknown*> wanted(free.begin() + static_cast<std::ptrdiff_t>(from),
                                           free.end());
  const MatrixXd columns = columns_of(wanted, "refit of the parameters");
  moves_.conservativeResize(columns.rows(), static_cast<Index>(free.size()));
  moves_.rightCols(columns.cols()) = columns;
}

void Analysis::move_amounts() {
  const std::vector<const Unknown*> free = free_unknowns();
  const Model m = careful_model();
  const VectorXd move = m.fitted.amount.head(moves_.cols());
  // No further than 1.5 prior widths at once: the relations are not linear in everything.
  for (Index k = 0; k < static_cast<Index>(refit_.size()); ++k) {
    const Unknown& u = *free[static_cast<std::size_t>(k)];
    const double most = 1.5 * std::min(width(static_cast<std::size_t>(k)), 2 * u.width);
    const double far = limit(u);
    amounts_[k] = std::clamp(amounts_[k] + std::clamp(move[k], -most, most), -far, far);
  }
  for (Index k = static_cast<Index>(refit_.size()); k < moves_.cols(); ++k) amounts_[k] += move[k];
  Index place = moves_.cols();
  for (Accepted& a : accepted_) {
    if (a.shapes.size() > 0) a.amounts += m.fitted.amount.segment(place, a.columns.cols());
    place += a.columns.cols();
  }
}

void Analysis::refit(int rounds) {
  // One Jacobian serves all rounds (chord method); only columns that are new are computed again.
  const bool fresh = moves_.size() == 0;
  const auto known = static_cast<std::size_t>(moves_.cols());
  look();
  if (fresh)
    update_moves(0);
  else if (known < free_unknowns().size())
    update_moves(known);
  for (int round = 0; round < rounds; ++round) {
    if (weight_.size() == 0) weigh();
    move_amounts();
    look();
    weigh();
  }
  if (fresh) {
    find_what_fine_steps_add();
    look();
    update_moves(0);
  }
  // The amounts of accepted unknowns are where they are wanted.
  auto at = static_cast<Index>(refit_.size());
  for (Accepted& a : accepted_)
    if (has_one_amount(a)) a.amount = amounts_[at++];
}

void Analysis::move_columns() {
  if (freed_.empty() && accepted_.empty()) return;
  find_what_fine_steps_add();
  update_moves(0);
  refit(2);
}

void Analysis::differentiate_candidates() {
  std::vector<const Unknown*> wanted;
  for (const std::size_t k : candidate_) wanted.push_back(&inventory_.unknowns[k]);
  candidate_moves_ = columns_of(wanted, "one derivative per mechanism");
  careful_ = careful_weights();
}

bool Analysis::used(const Unknown& u) const {
  return settled(u) || std::any_of(accepted_.begin(), accepted_.end(), [&](const Accepted& a) {
           const Unknown& other = inventory_.unknowns[a.unknown];
           return std::tie(other.id, other.channel, other.name) ==
                  std::tie(u.id, u.channel, u.name);
         });
}

Finding Analysis::finding_of(std::size_t unknown) const {
  const Unknown& u = inventory_.unknowns[unknown];
  Finding f;
  f.unknown = unknown;
  f.mechanism = u.id;
  f.kind = u.kind;
  f.channel = u.channel;
  f.physics = u.physics;
  f.equation = u.equation;
  return f;
}

void Analysis::accept(Findings& out, Finding found, Accepted a) {
  out.findings.push_back(std::move(found));
  if (has_one_amount(a)) {
    // amounts_ lists those that act everywhere in the order of accepted_.
    amounts_.conservativeResize(amounts_.size() + 1);
    amounts_[amounts_.size() - 1] = a.amount;
  }
  accepted_.push_back(std::move(a));
  refit(2);
}

}  // namespace explain
