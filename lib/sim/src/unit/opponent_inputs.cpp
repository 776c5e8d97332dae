#include "opponent_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace sim {
namespace {

constexpr double kSame_m = 1e-3, kLapGap_m = 30.0, kLost_m = 50.0;

/// Where an opponent is by time; nothing before its first and after its last row.
std::optional<vehicle::OpponentPlace> place_at(const vehicle::Opponent& drive, double time_s) {
  const std::vector<double>& t = drive.time_s;
  if (time_s < t.front() || time_s > t.back()) return std::nullopt;
  const auto upper = std::upper_bound(t.begin() + 1, t.end() - 1, time_s);
  const auto i = static_cast<std::size_t>(upper - t.begin());
  const double share = (time_s - t[i - 1]) / (t[i] - t[i - 1]);
  return vehicle::OpponentPlace{drive.x_m[i - 1] + share * (drive.x_m[i] - drive.x_m[i - 1]),
                                drive.y_m[i - 1] + share * (drive.y_m[i] - drive.y_m[i - 1])};
}

}  // namespace

PathAhead::PathAhead(const vehicle::Opponent& drive) {
  for (std::size_t i = 0; i < drive.x_m.size(); ++i) {
    const double step_m =
        x_m_.empty() ? 0.0 : std::hypot(drive.x_m[i] - x_m_.back(), drive.y_m[i] - y_m_.back());
    if (!x_m_.empty() && step_m < kSame_m) continue;  // it stood
    s_m_.push_back(x_m_.empty() ? 0.0 : s_m_.back() + step_m);
    x_m_.push_back(drive.x_m[i]);
    y_m_.push_back(drive.y_m[i]);
  }
  const double gap_m = std::hypot(x_m_.back() - x_m_.front(), y_m_.back() - y_m_.front());
  is_lap_ = gap_m < kLapGap_m && s_m_.back() > 10.0 * kLapGap_m;
  length_m_ = s_m_.back() + gap_m;
}

std::size_t PathAhead::next(std::size_t i, int step) const {
  const std::size_t n = x_m_.size();
  if (step > 0) return i + 1 < n ? i + 1 : is_lap_ ? 0 : i;
  return i > 0 ? i - 1 : is_lap_ ? n - 1 : i;
}

double PathAhead::distance_m(std::size_t i, double x_m, double y_m) const {
  return std::hypot(x_m_[i] - x_m, y_m_[i] - y_m);
}

std::optional<vehicle::OpponentPlace> PathAhead::place(double x_m, double y_m, double ahead_m) {
  if (x_m_.size() < 2) return std::nullopt;
  for (const int step : {1, -1})
    while (distance_m(next(at_, step), x_m, y_m) < distance_m(at_, x_m, y_m)) at_ = next(at_, step);
  if (!is_found_ || distance_m(at_, x_m, y_m) > kLost_m) {
    for (std::size_t i = 0; i < x_m_.size(); ++i)
      if (distance_m(i, x_m, y_m) < distance_m(at_, x_m, y_m)) at_ = i;
    is_found_ = true;
  }
  // Between the points before and behind: the foot on the path's direction there.
  const std::size_t before = next(at_, -1), behind = next(at_, 1);
  const double dx = x_m_[behind] - x_m_[before], dy = y_m_[behind] - y_m_[before];
  const double along_m = ((x_m - x_m_[at_]) * dx + (y_m - y_m_[at_]) * dy) / std::hypot(dx, dy);
  double s_m = s_m_[at_] + (std::isfinite(along_m) ? along_m : 0.0) + ahead_m;
  if (is_lap_) s_m -= length_m_ * std::floor(s_m / length_m_);
  if (!(s_m >= 0.0) || s_m > (is_lap_ ? length_m_ : s_m_.back())) return std::nullopt;
  const auto upper = std::upper_bound(s_m_.begin() + 1, s_m_.end(), s_m);
  const auto i = static_cast<std::size_t>(upper - s_m_.begin());
  const std::size_t to = i < x_m_.size() ? i : is_lap_ ? 0 : i - 1;
  const double span_m = (i < x_m_.size() ? s_m_[i] : length_m_) - s_m_[i - 1];
  const double share = span_m > 0.0 ? (s_m - s_m_[i - 1]) / span_m : 0.0;
  return vehicle::OpponentPlace{x_m_[i - 1] + share * (x_m_[to] - x_m_[i - 1]),
                                y_m_[i - 1] + share * (y_m_[to] - y_m_[i - 1])};
}

bool OpponentInputs::are_of(const UnitDescription& unit) {
  return unit.find("input.opponent[1].active") != nullptr ||
         unit.find("input.opponent.active") != nullptr;
}

OpponentInputs::OpponentInputs(std::span<const OpponentDrive> opponents, std::size_t others,
                               const UnitDescription& unit, const std::string& path)
    : opponents_(opponents), others_(others) {
  for (std::size_t k = 0; k < others + opponents.size(); ++k) {
    auto& places = places_.emplace_back();
    for (std::size_t i = 0; i < kInputs.size(); ++i) {
      const std::string element = fmt::format("input.opponent[{}].{}", k + 1, kInputs[i]),
                        whole = fmt::format("input.opponent.{}", kInputs[i]);
      const UnitVariable* const one = unit.find(element);
      const UnitVariable* const all = unit.find(whole);
      if (one == nullptr && (all == nullptr || all->size <= k))
        throw base::Error(
            fmt::format("{}: no input {}, which an opponent needs ({}); {}", path, element,
                        k < others ? "another car of the run" : opponents[k - others].name,
                        k == 0 ? "the units of crgdrive fmu have it" : "name fewer opponents"));
      places[i] = one != nullptr ? Place{one, 0} : Place{all, k};
    }
  }
  for (const OpponentDrive& opponent : opponents) {
    paths_.emplace_back(opponent.drive);
    if (opponent.ahead_m && car_.empty())
      car_ = {&known(unit, path, "car.x"), &known(unit, path, "car.y")};
  }
}

void OpponentInputs::set(Unit& unit, std::size_t k,
                         const std::optional<vehicle::OpponentPlace>& at) {
  const std::array values{at ? 1.0 : 0.0, at ? at->x_m : 0.0, at ? at->y_m : 0.0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const UnitVariable& variable = *places_[k][i].variable;
    std::vector<double> all(variable.size, 0.0);
    if (variable.size > 1) unit.get(variable, all);
    all[places_[k][i].index] = values[i];
    unit.set(variable, all);
  }
}

void OpponentInputs::write(Unit& unit, double time_s,
                           std::span<const std::optional<vehicle::OpponentPlace>> others) {
  for (std::size_t k = 0; k < others_; ++k) set(unit, k, others[k]);
  std::array<double, 2> car{};
  for (std::size_t i = 0; i < car_.size(); ++i) unit.get(*car_[i], std::span(car).subspan(i, 1));
  for (std::size_t k = 0; k < opponents_.size(); ++k)
    set(unit, others_ + k,
        opponents_[k].ahead_m ? paths_[k].place(car[0], car[1], *opponents_[k].ahead_m)
                              : place_at(opponents_[k].drive, time_s));
}

}  // namespace sim
