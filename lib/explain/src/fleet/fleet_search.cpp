#include "fleet_search.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/statistics.h"
#include "fleet_numbers.h"
#include "selection.h"

namespace explain {

using namespace fleet_numbers;

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

FleetSearch::FleetSearch(std::vector<CarSums>& cars, const RoadShape& shape,
                         const std::array<bool, kRoadKinds>& seen, const FleetOptions& options)
    : cars_(cars), shape_(shape), seen_(seen), options_(options) {
  for (const CarSums& car : cars) {
    in_.emplace_back();
    for (std::size_t k = 0; k < car.columns.size(); ++k)
      if (!car.columns[k].candidate)
        in_.back().push_back(k);
      else
        ++tested_;
  }
  std::array<double, kRoadKinds> all{}, forces{};
  for (const CarSums& car : cars)
    for (std::size_t k = 0; k < shape.knots * kRoadKinds; ++k) {
      const auto at = static_cast<Index>(k),
                 own = at + static_cast<Index>(shape.knots * kRoadKinds);
      all[k % kRoadKinds] += car.normal(at, at);
      forces[k % kRoadKinds] += car.normal(own, own);
    }
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    felt_[kind] = all[kind] - forces[kind] > 0.1 * forces[kind];
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    if (seen_[kind]) all_road_[kind] = kRoad[kind].step, sizes_.own[kind] = 0.3 * kRoad[kind].step;
}

double FleetSearch::form(std::size_t kind) const {
  return (felt_[kind] ? kFormFelt : kFormOfForces)[kind];
}

double FleetSearch::least(std::size_t kind) const {
  return felt_[kind] ? kRoad[kind].least : kLeastByForces[kind];
}

Sizes FleetSearch::with_form(Sizes road) const {
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    road[kind] = std::hypot(road[kind], form(kind));
  return road;
}

double FleetSearch::evidence(const Sizes& effective_road, const Sizes& own) const {
  const std::size_t count = std::min(cars_.size(), kCarsForSizes);
  std::vector<CarSays> said(count);
  base::parallel_for(count, 1, options_.threads, [&](std::size_t k, std::size_t) {
    const std::size_t car = k * cars_.size() / count;
    said[k] = says(cars_[car], shape_, own, in_[car]);
  });
  std::vector<const CarSays*> all;
  double out = 0;
  for (const CarSays& s : said) all.push_back(&s), out += s.evidence;
  return out + road_estimate(all, shape_, effective_road).evidence;
}

void FleetSearch::choose_sizes() {
  double most = evidence(with_form(all_road_), sizes_.own);
  // One step at a time from where they are: the evidence has one summit in each.
  for (int sweep = 0; sweep < 3; ++sweep) {
    bool moved = false;
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      if (!seen_[kind]) continue;
      for (Sizes* sizes : {&sizes_.own, &all_road_})
        for (const int way : {-1, 1}) {
          for (;;) {
            const double step = kRoad[kind].step, now = (*sizes)[kind] / step;
            const auto here = std::find_if(std::begin(kSizes), std::end(kSizes),
                                           [&](double s) { return std::abs(s - now) < 0.01 * s; });
            if (here == std::end(kSizes) || (way < 0 && here == std::begin(kSizes)) ||
                (way > 0 && here + 1 == std::end(kSizes)))
              break;
            const double before = (*sizes)[kind];
            (*sizes)[kind] = *(here + way) * step;
            if (const double e = evidence(with_form(all_road_), sizes_.own); e > most + 0.1) {
              most = e, moved = true;
            } else {
              (*sizes)[kind] = before;
              break;
            }
          }
        }
    }
    if (!moved) break;
  }
}

void FleetSearch::say() {
  says_.resize(cars_.size());
  base::parallel_for(cars_.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
    says_[k] = says(cars_[k], shape_, sizes_.own, in_[k]);
  });
}

RoadEstimate FleetSearch::road() const {
  std::vector<const CarSays*> all;
  for (const CarSays& s : says_) all.push_back(&s);
  return road_estimate(all, shape_, with_form(sizes_.road));
}

double FleetSearch::road_evidence(const Sizes& effective) const {
  std::vector<const CarSays*> all;
  for (const CarSays& s : says_) all.push_back(&s);
  return road_estimate(all, shape_, effective).evidence;
}

std::vector<double> FleetSearch::left_out(const Sizes& effective) const {
  const std::size_t groups = std::min(cars_.size(), kGroups);
  const double whole = road_evidence(effective);
  std::vector<double> out(groups);
  base::parallel_for(groups, 1, options_.threads, [&](std::size_t g, std::size_t) {
    std::vector<const CarSays*> others;
    for (std::size_t k = 0; k < cars_.size(); ++k)
      if (k % groups != g) others.push_back(&says_[k]);
    out[g] = 2 * (whole - road_estimate(others, shape_, effective).evidence);
  });
  return out;
}

RoadGain FleetSearch::gain_of(const Sizes& road, std::size_t kind) const {
  const Sizes with = with_form(road);
  Sizes alike = road, without = with;
  alike[kind] = 0.0;
  without[kind] = 0.0;
  std::vector<double> gains = left_out(with);
  const std::vector<double> less = left_out(without);
  RoadGain out;
  double square = 0;
  for (std::size_t k = 0; k < gains.size(); ++k) {
    gains[k] -= less[k];
    out.gain += gains[k];
    out.agreeing += gains[k] > 0 ? 1 : 0;
  }
  const double each = out.gain / static_cast<double>(gains.size());
  for (const double g : gains) square += (g - each) * (g - each);
  out.threshold = std::max(selection::kProfileGain, selection::kProfileSure * std::sqrt(square));
  out.beyond = 2 * (road_evidence(with) - road_evidence(with_form(alike)));
  std::vector<const CarSays*> all;
  for (const CarSays& s : says_) all.push_back(&s);
  const RoadEstimate road_here = road_estimate(all, shape_, with);
  const auto solver = road_here.precision.llt();
  for (std::size_t k = 0; k < shape_.knots; ++k) {
    const auto at = static_cast<Index>(k * kRoadKinds + kind);
    const double variance = solver.solve(VectorXd::Unit(road_here.amounts.size(), at))[at];
    out.largest = std::max(
        out.largest, std::abs(road_here.amounts[at]) / std::hypot(form(kind), std::sqrt(variance)));
  }
  return out;
}

double FleetSearch::best_size(Sizes road, std::size_t kind) const {
  double most = -HUGE_VAL, best = 0;
  for (const double size : kSizes) {
    road[kind] = size * kRoad[kind].step;
    if (const double e = road_evidence(with_form(road)); e > most) most = e, best = road[kind];
  }
  return best;
}

void FleetSearch::choose_road() {
  sizes_.road = {};
  if (cars_.size() < kLeastFleetCars) return;
  for (;;) {
    RoadGain most;
    Sizes next = sizes_.road;
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      if (!seen_[kind] || in_road(kind)) continue;
      Sizes with = sizes_.road;
      with[kind] = best_size(with, kind);
      const RoadGain gain = gain_of(with, kind);
      if (gain.counts() && gain.gain > most.gain) most = gain, next = with;
    }
    if (!most.counts()) break;
    sizes_.road = next;
  }
  // What a later one made needless.
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    if (in_road(kind) && !gain_of(kind).counts()) sizes_.road[kind] = 0.0;
}

std::vector<std::size_t> FleetSearch::rivals_of(std::size_t kind) const {
  const Sizes with = with_form(sizes_.road);
  Sizes without = with;
  without[kind] = 0.0;
  const double nothing = road_evidence(without), gain = 2 * (road_evidence(with) - nothing);
  std::vector<std::size_t> out;
  for (std::size_t other = 0; other < kRoadKinds; ++other) {
    if (!seen_[other] || in_road(other)) continue;
    double best = 0;
    for (const double size : kSizes) {
      Sizes instead = without;
      instead[other] = std::hypot(size * kRoad[other].step, form(other));
      best = std::max(best, 2 * (road_evidence(instead) - nothing));
    }
    if (gain - best < std::max(selection::kLead, selection::kInexact * gain)) out.push_back(other);
  }
  return out;
}

RoadEstimate FleetSearch::road_without(std::size_t car) const {
  std::vector<const CarSays*> others;
  for (std::size_t k = 0; k < cars_.size(); ++k)
    if (k != car) others.push_back(&says_[k]);
  // With one or two cars a road of the size that fits best may be there too.
  return road_estimate(others, shape_,
                       with_form(cars_.size() < kLeastFleetCars ? all_road_ : sizes_.road));
}

CarEstimate FleetSearch::estimate_of(std::size_t car) const {
  return estimate(cars_[car], shape_, sizes_.own, in_[car], road_without(car));
}

CarTests FleetSearch::tests_of(std::size_t car) const {
  std::vector<std::size_t> tested;
  for (std::size_t k = 0; k < cars_[car].columns.size(); ++k)
    if (std::find(in_[car].begin(), in_[car].end(), k) == in_[car].end()) tested.push_back(k);
  return test_columns(cars_[car], shape_, sizes_.own, in_[car], tested, road_without(car));
}

NamedColumn FleetSearch::best_parameter(const std::vector<CarTests>& tests) const {
  struct Saving {
    std::size_t column;
    double saved, threshold;
  };
  NamedColumn best;
  for (std::size_t k = 0; k < cars_.size(); ++k) {
    std::vector<Saving> savings;
    for (const ColumnTest& t : tests[k].refitted) {
      const SummaryColumn& c = cars_[k].columns[t.column];
      // What is held for want of evidence pays for that.
      const double held = c.deviation < 0.4 * c.width ? selection::kHeldGo : 0.0;
      if (c.parameter && let_go(k, t.column) == nullptr)
        savings.push_back({t.column, t.gain - held, selection::kLetGo});
    }
    for (const Saving& s : savings) {
      if (!(s.saved > s.threshold) || !(s.saved > best.gain)) continue;
      best = {k, s.column, s.saved, s.threshold, {}};
      const std::string& own = cars_[k].columns[s.column].id;
      for (const Saving& o : savings)
        if (const std::string& id = cars_[k].columns[o.column].id;
            id != own && s.saved - o.saved < selection::kLead &&
            std::find(best.rivals.begin(), best.rivals.end(), id) == best.rivals.end())
          best.rivals.push_back(id);
    }
  }
  return best;
}

NamedColumn FleetSearch::best_mechanism(const std::vector<CarTests>& tests) const {
  NamedColumn best;
  for (std::size_t k = 0; k < cars_.size(); ++k)
    for (const ColumnTest& t : tests[k].test) {
      const SummaryColumn& c = cars_[k].columns[t.column];
      if (!(t.gain > selection::kNamed) || std::abs(t.amount) < c.least ||
          std::abs(t.amount) > c.most || (c.one_sided && t.amount < 0))
        continue;
      const bool has = std::any_of(named_.begin(), named_.end(), [&](const NamedColumn& n) {
        return n.car == k && cars_[k].columns[n.column].id == c.id;
      });
      if (has) continue;
      // What the stated curves get wrong looks like it in the other cars as well.
      std::vector<double> elsewhere;
      for (std::size_t o = 0; o < cars_.size(); ++o)
        for (const ColumnTest& other : tests[o].test)
          if (o != k && other.gain > 0 && cars_[o].columns[other.column].key == c.key)
            elsewhere.push_back(std::sqrt(other.gain));
      const double spread = elsewhere.size() + 1 >= kLeastFleetCars
                                ? std::max(1.0, 1.4826 * base::median(std::move(elsewhere)))
                                : 1.0;
      const double threshold = selection::kNamed * spread * spread;
      if (t.gain > threshold && t.gain > best.gain) best = {k, t.column, t.gain, threshold, {}};
    }
  return best;
}

std::vector<CarTests> FleetSearch::test_all() const {
  std::vector<CarTests> out(cars_.size());
  base::parallel_for(cars_.size(), 1, options_.threads,
                     [&](std::size_t k, std::size_t) { out[k] = tests_of(k); });
  return out;
}

bool FleetSearch::name_one() {
  const std::vector<CarTests> tests = test_all();
  const NamedColumn parameter = best_parameter(tests), mechanism = best_mechanism(tests);
  if (parameter.gain == 0 && mechanism.gain == 0) return false;
  // Few parameters are far off: a normal prior would share one large error among all that can take
  // a part of it.
  if (parameter.gain >= mechanism.gain) {
    SummaryColumn& c = cars_[parameter.car].columns[parameter.column];
    c.deviation = std::max(c.deviation, selection::kFreed * c.width);
    let_go_.push_back(parameter);
    return true;
  }
  named_.push_back(mechanism);
  in_[mechanism.car].push_back(mechanism.column);
  return true;
}

void FleetSearch::run() {
  const auto progress = [&](double share) {
    if (options_.progress) options_.progress("joint estimate", share);
  };
  const auto most = kMostNamed + 3 * cars_.size();
  for (std::size_t round = 0; round <= most; ++round) {
    progress(static_cast<double>(round) / static_cast<double>(most));
    if (round < 3) choose_sizes();
    say();
    choose_road();
    if (round == most || !name_one()) break;
  }
  say();
  choose_road();
  tests_ = test_all();
}

double FleetSearch::stands_apart(std::size_t car, std::size_t kind) const {
  std::vector<const CarSays*> others;
  for (std::size_t k = 0; k < cars_.size(); ++k)
    if (k != car) others.push_back(&says_[k]);
  Sizes larger = sizes_.own;
  larger[kind] = 3 * std::max(larger[kind], kRoad[kind].least);
  const CarSays apart = says(cars_[car], shape_, larger, in_[car]);
  const auto total = [&](const CarSays& own) {
    std::vector<const CarSays*> all = others;
    all.push_back(&own);
    return own.evidence + road_estimate(all, shape_, with_form(sizes_.road)).evidence;
  };
  return 2 * (total(apart) - total(says_[car]));
}

double FleetSearch::undivided_gain(std::size_t kind) const {
  Sizes road = with_form(all_road_), own = sizes_.own;
  const double with = evidence(road, own);
  road[kind] = own[kind] = 0.0;
  return 2 * (with - evidence(road, own));
}

}  // namespace explain
