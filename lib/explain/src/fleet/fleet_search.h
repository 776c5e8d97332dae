// What counts in the joint estimate, and whose it is.
#pragma once

#include <string>
#include <vector>

#include "explain/fleet.h"
#include "fleet_joint.h"
#include "fleet_numbers.h"
#include "selection.h"

namespace explain {

/// Of one kind along the road: what it saves of the loss on cars left out.
struct RoadGain {
  double gain = 0.0, threshold = 0.0;
  double beyond = 0.0;       ///< what it saves beyond what the simulation gets wrong in all cars
  std::size_t agreeing = 0;  ///< cars (or groups of them) that the others predict better with it
  double largest = 0.0;      ///< of any knot, in deviations of that and of its own
  bool counts() const {
    return gain > threshold && (beyond > selection::kNamed || largest > fleet_numbers::kLargest);
  }
};

/// A mechanism of a car that counts.
struct NamedColumn {
  std::size_t car = 0, column = 0;
  double gain = 0.0, threshold = 0.0;
  std::vector<std::string> rivals;  ///< of a parameter: those that would have saved as much
};

class FleetSearch {
 public:
  /// Widens the priors of parameters that it lets go.
  FleetSearch(std::vector<CarSums>& cars, const RoadShape& shape,
              const std::array<bool, kRoadKinds>& seen, const FleetOptions& options);

  /// Of a kind: whether accelerometers feel it, so that the cars' forces are not needed.
  bool felt(std::size_t kind) const { return felt_[kind]; }
  /// What the simulation gets wrong in all cars alike and would pass for it, one deviation.
  double form(std::size_t kind) const;
  /// Smaller amounts of the road are not worth a finding.
  double least(std::size_t kind) const;

  /// Adds kinds of the road and mechanisms of cars, that which saves most first, until nothing
  /// counts.
  void run();

  const std::vector<NamedColumn>& named() const { return named_; }
  bool in_road(std::size_t kind) const { return sizes_.road[kind] > 0; }
  /// What a kind that is in saves there, and the kinds that would do as well in its place.
  RoadGain gain_of(std::size_t kind) const { return gain_of(sizes_.road, kind); }
  std::vector<std::size_t> rivals_of(std::size_t kind) const;
  const Sizes& own_sizes() const { return sizes_.own; }
  RoadEstimate road() const;  ///< from all cars
  /// Takes a mechanism out again; what cars say and sizes stay.
  void leave_out(const NamedColumn& named) { std::erase(in_[named.car], named.column); }
  /// With the road as the other cars have it.
  CarTests tests_of(std::size_t car) const;
  CarEstimate estimate_of(std::size_t car) const;  ///< the same road
  const std::vector<std::size_t>& in(std::size_t car) const { return in_[car]; }
  /// How a parameter was let go; null: it was not.
  const NamedColumn* let_go(std::size_t car, std::size_t column) const {
    for (const NamedColumn& n : let_go_)
      if (n.car == car && n.column == column) return &n;
    return nullptr;
  }
  /// Of all cars, once the search has run.
  const CarTests& tests(std::size_t car) const { return tests_[car]; }
  std::size_t tested() const { return tested_; }
  /// What a car's own profile of a kind, three times as large as those of the others, would save.
  double stands_apart(std::size_t car, std::size_t kind) const;
  /// Of one or two cars: what a profile of this kind saves, be it the road's or the cars'.
  double undivided_gain(std::size_t kind) const;

 private:
  struct Own {
    Sizes road{}, own{};
  };
  void choose_sizes();
  void say();  ///< what every car says at the sizes
  void choose_road();
  bool name_one();  ///< a mechanism of a car, or lets a parameter go; false: none counts
  double evidence(const Sizes& effective_road, const Sizes& own) const;
  double best_size(Sizes road, std::size_t kind) const;
  Sizes with_form(Sizes road) const;
  double road_evidence(const Sizes& effective) const;  ///< from all cars
  std::vector<double> left_out(const Sizes& effective) const;
  RoadGain gain_of(const Sizes& road, std::size_t kind) const;

  std::vector<CarSums>& cars_;
  const RoadShape& shape_;
  std::array<bool, kRoadKinds> seen_, felt_{};
  const FleetOptions& options_;
  Own sizes_;
  Sizes all_road_{};  ///< with every kind in
  std::vector<std::vector<std::size_t>> in_;
  std::vector<CarSays> says_;
  NamedColumn best_parameter(const std::vector<CarTests>& tests) const;
  NamedColumn best_mechanism(const std::vector<CarTests>& tests) const;
  std::vector<NamedColumn> named_;
  std::vector<NamedColumn> let_go_;
  std::vector<CarTests> tests_;
  std::vector<CarTests> test_all() const;
  RoadEstimate road_without(std::size_t car) const;
  std::size_t tested_ = 0;
};

}  // namespace explain
