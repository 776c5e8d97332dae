// The numbers of a unit that is served: what is measured and what may be commanded, as sensors and
// the devices' file have them. Private to serve_unit.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/serve_unit.h"
#include "sim/unit.h"
#include "unit_places.h"
#include "vehicle/laws/actuator.h"

namespace sim {

/// Numbers of a unit, read and written one by one; arrays as a whole behind it.
class Numbers {
 public:
  /// Throws Error, with the unit's path, on names that it has no number of.
  Numbers(Unit& unit, const std::string& path, const std::vector<std::string>& names);

  /// Throws Error unless all are inputs, or parameters that may change while the unit runs.
  void want_settable(const std::string& path) const;

  bool empty() const { return places_.empty(); }
  const std::vector<Place>& places() const { return places_; }
  std::vector<double> get();
  void set(const std::vector<double>& values);

 private:
  Unit& unit_;
  std::vector<Place> places_;
  std::vector<double> all_;
};

/// What is measured: numbers of the unit as they are, or as sensors tell them.
class Measurements {
 public:
  Measurements(Unit& unit, const std::string& path, const ServeOptions& options);

  void restart();  ///< as before the first step(), with the same noise
  const vehicle::SignalSensors& sensors() const { return sensors_; }
  void restore(const vehicle::SignalSensors& sensors) { sensors_ = sensors; }
  void step();  ///< after the initialisation and after every step
  std::vector<double> get();

 private:
  enum class Kind { direct, sensor, age, latitude, longitude };

  std::array<double, 2> place_deg(std::size_t position) const;
  static std::optional<std::pair<Kind, std::size_t>> place_of_name(const ServeOptions& options,
                                                                   const std::string& name,
                                                                   const std::string& path);
  /// Fills sources_; gives the names that no sensor has.
  std::vector<std::string> names_of(const ServeOptions& options, const UnitDescription& unit,
                                    const std::string& path);

  const ServeOptions& options_;
  vehicle::SignalSensors sensors_;
  std::vector<std::pair<Kind, std::size_t>> sources_;
  Numbers truth_, direct_;
};

/// What may be commanded: numbers of the unit as they are, or as the devices' file has them.
class Commands {
 public:
  Commands(Unit& unit, const std::string& path, const ServeOptions& options);

  /// Actuators on their way from what is commanded to the unit.
  struct Moving {
    std::vector<vehicle::laws::Actuator<double>> actuators;
    std::int64_t step = 0;
  };

  /// Empty, or why the unit does not take what is said, NaN where nothing is. A real input beyond
  /// its bounds is brought to them; `clipped` tells which.
  std::string bring_within(std::vector<double>& said, std::string& clipped) const;

  /// As whoever commands would have said what the unit has.
  std::vector<double> get();
  /// Before every step. Empty, or what the unit said when it refused a value: then it has again
  /// what it had. Throws Error where it does not take that back.
  std::string act(const std::vector<double>& said);
  void restart();  ///< at rest, at what the unit has
  const Moving& moving() const { return moving_; }
  void restore(const Moving& moving);

 private:
  /// Fills are_; gives the names of the unit.
  std::vector<std::string> signals_of(const ServeOptions& options);

  std::vector<vehicle::SignalCommand> are_;
  Numbers numbers_;
  double step_s_;
  Moving moving_;
  std::vector<vehicle::laws::Response<double>> responses_;
  std::vector<double> held_;  ///< by the unit
  bool is_written_ = false;
};

/// Of the car's pose, where sensors look at the road from it.
std::vector<std::string> pose_names(const ServeOptions& options);

}  // namespace sim
