// Where the other units of a run are, to one of them. Private to serve_unit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "served_values.h"
#include "together.h"
#include "vehicle/opponent.h"

namespace sim {

class OthersOnRoad {
 public:
  OthersOnRoad(Unit& unit, const std::string& path, Together& together, std::size_t own,
               bool lockstep);

  /// As many as share the road, where the unit has inputs for them.
  static std::size_t inputs_for(const Unit& unit, const Together& together);

  bool tells_its_place() const { return !place_.empty(); }
  /// Puts the others where they are at the begin of this step. One that stands is where it was
  /// before. False when nobody drives any more.
  bool see(std::uint64_t step, bool is_driven, bool stands);
  /// Of the others; nothing where one is not on the road.
  const std::vector<std::optional<vehicle::OpponentPlace>>& places() const { return others_; }

 private:
  Together& together_;
  const std::size_t own_;
  const bool lockstep_;
  Numbers place_;
  std::vector<double> told_;
  std::vector<std::optional<vehicle::OpponentPlace>> others_;
};

}  // namespace sim
