#include "others_on_road.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "opponent_inputs.h"

namespace sim {
namespace {

/// Of where it is on the map, where others want to know and it can tell.
std::vector<std::string> place_names(const Unit& unit, const Together& together) {
  const std::vector<std::string> names{"car.x", "car.y"};
  const bool tells =
      together.size() > 1 && std::all_of(names.begin(), names.end(), [&](const std::string& name) {
        return unit.description().find(name) != nullptr;
      });
  return tells ? names : std::vector<std::string>{};
}

}  // namespace

OthersOnRoad::OthersOnRoad(Unit& unit, const std::string& path, Together& together, std::size_t own,
                           bool lockstep)
    : together_(together),
      own_(own),
      lockstep_(lockstep),
      place_(unit, path, place_names(unit, together)) {}

std::size_t OthersOnRoad::inputs_for(const Unit& unit, const Together& together) {
  return OpponentInputs::are_of(unit.description()) ? together.size() - 1 : 0;
}

bool OthersOnRoad::see(std::uint64_t step, bool is_driven, bool stands) {
  Standing own;
  own.is_driven = is_driven;
  if (tells_its_place()) {
    if (!stands) told_ = place_.get();
    if (told_.size() == 2)
      own = {std::isfinite(told_[0]) && std::isfinite(told_[1]), told_[0], told_[1], is_driven};
  }
  const std::span<const Standing> all =
      lockstep_ ? together_.meet(own_, step, own) : together_.look(own_, step, own);
  others_.clear();
  bool anybody_drives = false;
  for (std::size_t k = 0; k < all.size(); ++k) {
    anybody_drives = anybody_drives || all[k].is_driven;
    if (k == own_) continue;
    others_.emplace_back();
    if (all[k].is_there) others_.back() = vehicle::OpponentPlace{all[k].x_m, all[k].y_m};
  }
  return anybody_drives;
}

}  // namespace sim
