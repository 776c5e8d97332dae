// Opponents, written into the inputs of a unit. Private to serve_unit and run_unit.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/opponents.h"
#include "sim/unit.h"
#include "unit_places.h"

namespace sim {

/// Where on a driven path somebody is, and what lies ahead of there.
class PathAhead {
 public:
  explicit PathAhead(const vehicle::Opponent& drive);

  /// The place on the path `ahead_m` further than the one nearest to x, y; nothing beyond its ends,
  /// unless these are next to each other: then the path is a lap, and begins again. Of places that
  /// are alike (a path that crosses itself) the one that goes on from the call before.
  std::optional<vehicle::OpponentPlace> place(double x_m, double y_m, double ahead_m);

 private:
  std::size_t next(std::size_t i, int step) const;
  double distance_m(std::size_t i, double x_m, double y_m) const;

  std::vector<double> x_m_, y_m_, s_m_;  ///< points that differ; s along the path
  double length_m_ = 0.0;                ///< of a lap with the way from its end to its begin
  bool is_lap_ = false, is_found_ = false;
  std::size_t at_ = 0;
};

class OpponentInputs {
 public:
  /// Whether a unit has inputs for opponents.
  static bool are_of(const UnitDescription& unit);

  /// `others` share the road and come before the opponents that were recorded. Throws Error where
  /// the unit has no input.opponent[k].active, .x, .y for each of them, and for opponents by place
  /// where it has no car.x and car.y.
  OpponentInputs(std::span<const OpponentDrive> opponents, std::size_t others,
                 const UnitDescription& unit, const std::string& path);

  std::size_t others() const { return others_; }
  /// Before each step. Who is not on the road is not active.
  void write(Unit& unit, double time_s,
             std::span<const std::optional<vehicle::OpponentPlace>> others = {});

 private:
  static constexpr std::array kInputs{"active", "x", "y"};

  void set(Unit& unit, std::size_t k, const std::optional<vehicle::OpponentPlace>& at);

  std::span<const OpponentDrive> opponents_;
  std::size_t others_;
  std::vector<PathAhead> paths_;                           ///< of each opponent
  std::vector<std::array<Place, kInputs.size()>> places_;  ///< of each other, then of each opponent
  std::vector<const UnitVariable*> car_;                   ///< x, y; none where nobody asks
};

}  // namespace sim
