#include "fleet_search.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/statistics.h"
#include "selection.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Sizes that are tried, in steps of the kind.
constexpr double kSizes[] = {0.03, 0.1, 0.3, 1.0, 3.0, 10.0};
/// Sizes are chosen on so many cars, evenly taken.
constexpr std::size_t kCarsForSizes = 12;
/// Cars are left out one by one, or in so many groups.
constexpr std::size_t kGroups = 40;
/// Findings at most, of all cars.
constexpr int kMostNamed = 12;

}  // namespace

FleetSearch::FleetSearch(const std::vector<CarSums>& cars, const RoadShape& shape,
                         const std::array<bool, kRoadKinds>& seen, const FleetOptions& options)
    : cars_(cars), shape_(shape), seen_(seen), options_(options) {
  for (const CarSums& car : cars) {
    in_.emplace_back();
    for (std::size_t k = 0; k < car.columns.size(); ++k)
      if (!car.columns[k].candidate) in_.back().push_back(k);
      else ++tested_;
  }
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    if (seen_[kind]) all_road_[kind] = kRoad[kind].step, sizes_.own[kind] = 0.3 * kRoad[kind].step;
}

double FleetSearch::evidence(const Sizes& road, const Sizes& own) const {
  const std::size_t count = std::min(cars_.size(), kCarsForSizes);
  std::vector<CarSays> said(count);
  base::parallel_for(count, 1, options_.threads, [&](std::size_t k, std::size_t) {
    const std::size_t car = k * cars_.size() / count;
    said[k] = says(cars_[car], shape_, own, in_[car]);
  });
  std::vector<const CarSays*> all;
  double out = 0;
  for (const CarSays& s : said) all.push_back(&s), out += s.evidence;
  return out + road_estimate(all, shape_, road).evidence;
}

void FleetSearch::choose_sizes() {
  double most = evidence(all_road_, sizes_.own);
  // One step at a time from where they are: the evidence has one summit in each.
  for (int sweep = 0; sweep < 3; ++sweep) {
    bool moved = false;
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      if (!seen_[kind]) continue;
      for (Sizes* sizes : {&sizes_.own, &all_road_})
        for (const int way : {-1, 1}) {
          for (;;) {
            const double step = kRoad[kind].step, now = (*sizes)[kind] / step;
            const auto here = std::find_if(std::begin(kSizes), std::end(kSizes), [&](double s) {
              return std::abs(s - now) < 0.01 * s;
            });
            if ((way < 0 && here == std::begin(kSizes)) || (way > 0 && here + 1 == std::end(kSizes)))
              break;
            const double before = (*sizes)[kind];
            (*sizes)[kind] = *(here + way) * step;
            if (const double e = evidence(all_road_, sizes_.own); e > most + 0.1) {
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
  return road_estimate(all, shape_, sizes_.road);
}

std::vector<double> FleetSearch::left_out(const Sizes& sizes) const {
  const std::size_t groups = std::min(cars_.size(), kGroups);
  std::vector<const CarSays*> all;
  for (const CarSays& s : says_) all.push_back(&s);
  const double whole = road_estimate(all, shape_, sizes).evidence;
  std::vector<double> out(groups);
  base::parallel_for(groups, 1, options_.threads, [&](std::size_t g, std::size_t) {
    std::vector<const CarSays*> others;
    for (std::size_t k = 0; k < cars_.size(); ++k)
      if (k % groups != g) others.push_back(&says_[k]);
    out[g] = 2 * (whole - road_estimate(others, shape_, sizes).evidence);
  });
  return out;
}

std::vector<double> FleetSearch::gains(const Sizes& with, const Sizes& without) const {
  std::vector<double> out = left_out(with);
  const std::vector<double> less = left_out(without);
  for (std::size_t k = 0; k < out.size(); ++k) out[k] -= less[k];
  return out;
}

RoadGain FleetSearch::judged(const std::vector<double>& gains) {
  RoadGain out;
  double square = 0;
  for (const double g : gains) {
    out.gain += g;
    out.agreeing += g > 0 ? 1 : 0;
  }
  const double each = out.gain / static_cast<double>(gains.size());
  for (const double g : gains) square += (g - each) * (g - each);
  out.threshold = std::max(selection::kProfileGain, selection::kProfileSure * std::sqrt(square));
  return out;
}

double FleetSearch::best_size(Sizes sizes, std::size_t kind) const {
  std::vector<const CarSays*> all;
  for (const CarSays& s : says_) all.push_back(&s);
  double most = -HUGE_VAL, best = 0;
  for (const double size : kSizes) {
    sizes[kind] = size * kRoad[kind].step;
    if (const double e = road_estimate(all, shape_, sizes).evidence; e > most)
      most = e, best = sizes[kind];
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
      const RoadGain gain = judged(gains(with, sizes_.road));
      if (gain.counts() && gain.gain > most.gain) most = gain, next = with;
    }
    if (!most.counts()) break;
    sizes_.road = next;
  }
  // What a later one made needless.
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind)
    if (in_road(kind) && !gain_of(kind).counts()) sizes_.road[kind] = 0.0;
}

RoadGain FleetSearch::gain_of(std::size_t kind) const {
  Sizes without = sizes_.road;
  without[kind] = 0.0;
  return judged(gains(sizes_.road, without));
}

std::vector<std::size_t> FleetSearch::rivals_of(std::size_t kind) const {
  Sizes without = sizes_.road;
  without[kind] = 0.0;
  const double gain = judged(gains(sizes_.road, without)).gain;
  std::vector<std::size_t> out;
  for (std::size_t other = 0; other < kRoadKinds; ++other) {
    if (!seen_[other] || in_road(other)) continue;
    Sizes instead = without;
    instead[other] = best_size(instead, other);
    if (gain - judged(gains(instead, without)).gain <
        std::max(selection::kLead, selection::kInexact * gain))
      out.push_back(other);
  }
  return out;
}

CarTests FleetSearch::tests_of(std::size_t car) const {
  std::vector<const CarSays*> others;
  for (std::size_t k = 0; k < cars_.size(); ++k)
    if (k != car) others.push_back(&says_[k]);
  // With one or two cars a road of the size that fits best may be there too.
  const RoadEstimate road = road_estimate(
      others, shape_, cars_.size() < kLeastFleetCars ? all_road_ : sizes_.road);
  std::vector<std::size_t> tested;
  for (std::size_t k = 0; k < cars_[car].columns.size(); ++k)
    if (std::find(in_[car].begin(), in_[car].end(), k) == in_[car].end()) tested.push_back(k);
  return test_columns(cars_[car], shape_, sizes_.own, in_[car], tested, road);
}

bool FleetSearch::name_one() {
  std::vector<CarTests> tests(cars_.size());
  base::parallel_for(cars_.size(), 1, options_.threads,
                     [&](std::size_t k, std::size_t) { tests[k] = tests_of(k); });
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
      const double spread =
          elsewhere.size() >= kLeastFleetCars
              ? std::max(1.0, 1.4826 * base::median(std::move(elsewhere)))
              : 1.0;
      const double threshold = selection::kNamed * spread * spread;
      if (t.gain > threshold && t.gain > best.gain) best = {k, t.column, t.gain, threshold};
    }
  if (best.gain == 0) return false;
  named_.push_back(best);
  in_[best.car].push_back(best.column);
  return true;
}

void FleetSearch::run() {
  const auto progress = [&](double share) {
    if (options_.progress) options_.progress("joint estimate", share);
  };
  for (int round = 0; round <= kMostNamed; ++round) {
    progress(static_cast<double>(round) / kMostNamed);
    if (round < 3) choose_sizes();
    say();
    choose_road();
    if (round == kMostNamed || !name_one()) break;
  }
  say();
  choose_road();
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
    return own.evidence + road_estimate(all, shape_, sizes_.road).evidence;
  };
  return 2 * (total(apart) - total(says_[car]));
}

double FleetSearch::undivided_gain(std::size_t kind) const {
  Sizes road = all_road_, own = sizes_.own;
  const double with = evidence(road, own);
  road[kind] = own[kind] = 0.0;
  return 2 * (with - evidence(road, own));
}

}  // namespace explain
