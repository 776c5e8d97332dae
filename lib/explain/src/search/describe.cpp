// What was found in numbers: amounts with their 90 % intervals, parameters, places.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis.h"
#include "places.h"
#include "road_profiles.h"
#include "selection.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr const char* kVaryAll =
    "vary speed, load and throttle independently: coast down, and hold constant speeds";

MatrixXd covariance_of(const Fitted& f) {
  return f.normal.solve(MatrixXd::Identity(f.x.cols(), f.x.cols()));
}

}  // namespace

MatrixXd Analysis::held_too_near(const Model& m) const {
  VectorXd beyond = VectorXd::Zero(m.fitted.x.cols());
  for (std::size_t k = 0; k < refit_.size(); ++k) {
    const Unknown& u = inventory_.unknowns[refit_[k]];
    const double may = 0.5 * u.width, is = width(k);
    if (u.held > 0 && may > is) beyond[static_cast<Index>(k)] = may * may - is * is;
  }
  return explain::held_too_near(m.fitted, m.precision, beyond);
}

Analysis::Spread Analysis::spread() const {
  Spread out;
  out.model = model();
  const Fitted& m = out.model.fitted;
  out.covariance = covariance_of(m);
  // What is wrong with the curves comes back at the same places every lap: the spread of a
  // parameter is that between stretches of road, where it is larger than that of the noise.
  MatrixXd pull = MatrixXd::Zero(m.x.cols(), stretches());
  for (Index i = 0; i < m.e.size(); ++i)
    pull.col(stretch(rows_.row[static_cast<std::size_t>(i)])) += m.e[i] * m.x.row(i).transpose();
  const MatrixXd influence = m.normal.solve(pull);
  out.by_stretch = influence.rowwise().squaredNorm();
  out.by_held = held_too_near(out.model).diagonal();
  out.careful = careful_model();
  out.careful_covariance = covariance_of(out.careful.fitted);
  out.careful_by_held = held_too_near(out.careful).diagonal();
  return out;
}

double Analysis::Spread::deviation(Index column) const {
  return std::sqrt(std::max({0.0, covariance(column, column), by_stretch[column]}) +
                   by_held[column]);
}

double Analysis::Spread::careful_deviation(Index column) const {
  return std::sqrt(std::max(0.0, careful_covariance(column, column)) + careful_by_held[column]);
}

ParameterValue Analysis::parameter_value(std::size_t place, const Spread& s) const {
  const Unknown& u = inventory_.unknowns[refit_[place]];
  const auto i = static_cast<Index>(place);
  const double value = u.stated + amounts_[i];
  const double half = selection::k90 * std::hypot(s.careful_deviation(i), u.form);
  // The level of what is named was measured by deviations without what held ones may be off by.
  const double judged = std::hypot(std::sqrt(std::max(0.0, s.careful_covariance(i, i))), u.form);
  ParameterValue p{u.id, u.name, u.unit, u.stated, value, value - half, value + half, false, false};
  const bool ran = std::abs(amounts_[i]) > selection::kAtLimit * limit(u);
  p.at_limit = !u.assumed && ran;
  const bool asked_for = std::any_of(freed_.begin(), freed_.end(), [&](const Freed& f) {
    return f.place == place &&
           f.saved + (u.held > 0 ? selection::kHeldGo : 0.0) > selection::kDoubt;
  });
  p.unsure =
      asked_for && std::abs(amounts_[i]) > u.width + selection::kDoubtful / selection::k90 * half;
  p.beyond_prior = !p.at_limit && !u.assumed &&
                   std::abs(amounts_[i]) > std::max(half, u.width + selection::kBeyond * judged);
  return p;
}

void Analysis::free_what_is_beyond() {
  constexpr int kMost = 2;
  for (int round = 0; round < kMost; ++round) {
    const Spread s = spread();
    std::optional<std::size_t> farthest;
    double most = 0.0;
    for (std::size_t k = 0; k < refit_.size(); ++k) {
      const Unknown& u = inventory_.unknowns[refit_[k]];
      const bool free =
          std::any_of(freed_.begin(), freed_.end(), [&](const Freed& f) { return f.place == k; });
      if (u.role != Role::kParameter || u.stays_held || free || undetermined_.contains(k) ||
          !parameter_value(k, s).beyond_prior)
        continue;
      const double far = std::abs(amounts_[static_cast<Index>(k)]) / u.width;
      if (far > most) most = far, farthest = k;
    }
    if (!farthest) return;
    let_go({*farthest, {}, 0.0});
  }
}

Finding Analysis::freed_parameter(std::size_t place, const Freed& freed, const ParameterValue& p,
                                  const Spread& s) const {
  const Unknown& u = inventory_.unknowns[refit_[place]];
  const auto i = static_cast<Index>(place);
  const double half = selection::k90 * std::hypot(s.careful_deviation(i), u.form);
  Finding f = finding_of(refit_[place]);
  f.parameters.push_back({u.name, u.unit, p.value, p.low, p.high});
  f.statistic = amounts_[i] / std::max(1e-300, half / selection::k90);
  f.stability = 1.0;
  for (const std::size_t rival : freed.rivals) {
    const Unknown& other = inventory_.unknowns[refit_[rival]];
    if (other.id != u.id) f.rivals.push_back({other.id, "", kVaryAll, 0.0, false});
  }
  if (freed.instead) {
    const Unknown& other = inventory_.unknowns[*freed.instead];
    f.rivals.push_back({other.id, other.channel, experiment_between(other, u), 0.0, false});
  }
  // Another parameter that does nearly the same: what is left of this column without it.
  for (std::size_t o = 0; o < refit_.size(); ++o) {
    const Unknown& other = inventory_.unknowns[refit_[o]];
    if (o == place || other.role != Role::kParameter) continue;
    const auto j = static_cast<Index>(o);
    const double correlation =
        s.covariance(i, j) / std::sqrt(std::max(1e-300, s.covariance(i, i) * s.covariance(j, j)));
    if (std::abs(correlation) < selection::kRivalParameter) continue;
    f.rivals.push_back(
        {other.id, "", kVaryAll, 0.0, std::abs(correlation) < selection::kSameParameter});
  }
  return f;
}

void Analysis::describe_parameters(Findings& out, const Spread& s) const {
  std::vector<std::pair<std::ptrdiff_t, Finding>> named;
  for (std::size_t k = 0; k < refit_.size(); ++k) {
    const Unknown& u = inventory_.unknowns[refit_[k]];
    if (u.role != Role::kParameter) continue;
    const ParameterValue p = parameter_value(k, s);
    if (std::abs(amounts_[static_cast<Index>(k)]) > selection::kAtLimit * limit(u))
      out.remarks.push_back(fmt::format(
          "{}: the refit runs into its limit at {:.4g} {}; these recordings do not determine it",
          u.name, p.value, u.unit));
    out.parameters.push_back(p);
    const auto let_go =
        std::find_if(freed_.begin(), freed_.end(), [&](const Freed& f) { return f.place == k; });
    if (p.beyond_prior && let_go != freed_.end())
      named.emplace_back(let_go - freed_.begin(), freed_parameter(k, *let_go, p, s));
  }
  // What cost most comes first.
  std::stable_sort(named.begin(), named.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [place, f] : named) out.findings.push_back(std::move(f));
}

void Analysis::describe_amount(Finding& f, const Accepted& a, Index column, const Spread& s) const {
  const Unknown& u = inventory_.unknowns[a.unknown];
  const Fitted& m = s.model.fitted;
  const double careful_deviation = a.by_cost ? s.careful_deviation(column) : 0.0;
  const double half =
      selection::k90 * std::max(careful_deviation, std::hypot(s.deviation(column), 0.25 * u.least));
  const double value = amounts_[column];
  f.parameters.push_back({u.name, u.unit, value, value - half, value + half});
  for (const auto& [name, held] : u.constants) {
    const auto which = static_cast<std::size_t>(*vehicle::find_parameter(name));
    f.parameters.push_back(
        {name, std::string(vehicle::parameter_list()[which].unit), held, held, held});
  }
  if (u.kind != "vehicle") return;
  std::vector<double> u_m, energy;
  for (Index i = 0; i < m.e.size(); ++i) {
    const double part = m.x(i, column) * value;
    u_m.push_back(rows_.row[static_cast<std::size_t>(i)].u_m);
    energy.push_back(part * part);
  }
  f.where = concentrated(u_m, energy, logs_.front().length_m);
}

void Analysis::describe_stretch(Finding& f, const Accepted& a, Index column,
                                const Spread& s) const {
  const Unknown& u = inventory_.unknowns[a.unknown];
  const Place where = f.where.front();
  double mean = 0, count = 0;
  for (std::size_t k = 0; k < a.cells.size(); ++k) {
    const Index j = column + static_cast<Index>(k);
    const double half = selection::k90 * std::sqrt(std::max(0.0, s.covariance(j, j)));
    const double u_m = (a.cells[k] + 0.5) * kCell_m,
                 amount = s.model.fitted.amount[j] +
                          (a.kinematic ? a.amounts[static_cast<Index>(k)] : 0.0);
    f.profile.push_back({u_m, amount, half});
    if (u_m > where.u_begin_m && u_m < where.u_end_m) mean += amount, count += 1;
  }
  const auto inside = [&](std::size_t k) {
    return a.cells[k] * kCell_m >= where.u_begin_m && (a.cells[k] + 1) * kCell_m <= where.u_end_m;
  };
  double sum = 0;
  for (std::size_t k = 0; k < a.cells.size(); ++k)
    for (std::size_t l = 0; l < a.cells.size(); ++l)
      if (inside(k) && inside(l))
        sum += s.covariance(column + static_cast<Index>(k), column + static_cast<Index>(l));
  const double variance = sum / std::max(1.0, count * count);
  const double half = selection::k90 * std::sqrt(std::max(0.0, variance));
  mean /= std::max(1.0, count);
  f.parameters.push_back(
      {u.name + ", mean over the stretch", u.unit, mean, mean - half, mean + half});
}

void Analysis::describe(Findings& out) const {
  const Spread s = spread();
  describe_parameters(out, s);
  // Columns of those that act everywhere, then those of the road.
  Index everywhere = static_cast<Index>(refit_.size()), along = moves_.cols();
  std::size_t at = 0;
  for (const Accepted& a : accepted_) {
    Finding& f = out.findings[at++];
    if (has_one_amount(a)) {
      describe_amount(f, a, everywhere++, s);
      continue;
    }
    const Index size = a.columns.cols();
    if (a.shapes.size() > 0) {
      describe_profile(f, inventory_.unknowns[a.unknown], a,
                       a.amounts + s.careful.fitted.amount.segment(along, size),
                       s.careful_covariance.block(along, along, size, size), logs_.front().length_m,
                       logs_.front().closed);
      tie_with_the_car(f, s.model.fitted, a, along);
    } else {
      describe_stretch(f, a, along, s);
    }
    along += size;
  }
}

}  // namespace explain
