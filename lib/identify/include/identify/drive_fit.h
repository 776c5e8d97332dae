// What is found about a car from one drive: numbers with intervals, or why there is none.
#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "vehicle/map.h"

namespace identify {

/// A number that was found, or why it was not.
struct Found {
  std::string name, unit;
  double value = 0.0;
  double sd = 0.0;        ///< of everything that is counted
  double sd_drive = 0.0;  ///< of it what the drive leaves open; the rest is the vehicle file's
  double within = 0.0;    ///< half the 90 % interval
  double stated = 0.0;    ///< the vehicle file's; NaN: it has none
  std::string unseen;     ///< why it is not observable; empty: it is
};

/// A drive as one answer: numbers, what they rest on, and what may be wrong.
struct DriveFit {
  std::vector<Found> found;
  std::vector<std::string> remarks;  ///< what was assumed, what cannot be told apart
  std::vector<std::string> doubts;   ///< why it must not be used
  std::size_t windows = 0, blocks = 0;

  /// Throws std::out_of_range.
  const Found& at(const std::string& name) const {
    for (const Found& f : found)
      if (f.name == name) return f;
    throw std::out_of_range(name);
  }
};

/// One place of a map over two axes.
struct MapPlace {
  double x = 0.0, y = 0.0;
  double value = 0.0, sd = 0.0, within = 0.0;  ///< half the 90 % interval
  double stated = 0.0;                         ///< the vehicle file's
  std::vector<double> seconds;                 ///< near it; of an engine in each gear
  std::string unseen;                          ///< why it is not observable; empty: it is

  bool seen() const { return unseen.empty(); }
};

/// A map of the car that was found at all its places at once.
struct FoundMap {
  std::vector<double> x, y;      ///< axes
  std::vector<MapPlace> places;  ///< by x, then y; empty: none
  DriveFit fit;

  bool any_seen() const { return std::ranges::any_of(places, &MapPlace::seen); }
  /// For a car: places that were not seen as their neighbours and the stated shape say.
  vehicle::Map2 map() const {
    vehicle::Map2 out{x, y, {}};
    for (const MapPlace& place : places) out.z.push_back(place.value);
    return out;
  }
};

/// What fits of parts of a car are told. A mass is found by fit_mass(), which takes no notice of
/// it.
struct WeighedOptions {
  double mass_kg = 0.0;     ///< with fuel; 0: the vehicle file's and fuel_kg
  double mass_sd_kg = 0.0;  ///< of it; with mass_kg 0 that of the vehicle file's prior
  double fuel_kg = 30.0;
  bool body_axes = true;  ///< as the windows'
};

}  // namespace identify
