// A Functional Mock-up Unit of anybody, loaded into this process and stepped (FMI 2.0 and 3.0,
// co-simulation). Whoever loads foreign code trusts it: a crash of it is a crash of the process;
// crgsim loads units in a process of their own.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "sim/unit_description.h"
#include "sim/unpack.h"

namespace sim {

struct Watch;

class Unit {
 public:
  /// Loads the binary of this platform and instantiates it; of a vehicle file, makes its car. `log`
  /// gets the unit's messages, one line each, and whether a run of it ends. Throws Error when there
  /// is no binary for this platform, functions are missing, or the unit refuses; the message ends
  /// with what the unit logged. `watch` learns when the unit is at work.
  Unit(const UnpackedUnit& files, UnitDescription description,
       std::function<void(const std::string&, bool closes)> log = {}, Watch* watch = nullptr);
  Unit(const Unit&) = delete;
  Unit& operator=(const Unit&) = delete;
  ~Unit();  ///< ends and frees the instance

  const UnitDescription& description() const;

  /// All values of a variable that is no text; booleans are 0 and 1. Whole numbers are rounded from
  /// and to doubles: exact up to 2^53. Throw Error where the unit refuses, or the size is another.
  void set(const UnitVariable& variable, std::span<const double> values);
  void get(const UnitVariable& variable, std::span<double> values);
  void set_text(const UnitVariable& variable, const std::string& text);
  std::string get_text(const UnitVariable& variable);

  /// As it was made, then set and initialised by `begin`. Saved states stay. Where that throws it
  /// is as it was before; but a unit of which there may be one at a time is gone (is_there()), and
  /// one with saved states is in the state of the failure where that cannot be helped.
  void begin_anew(const std::function<void()>& begin);
  bool is_there() const;  ///< it can be stepped

  /// Keeps all that changes in it under a name, instead of what was kept there; where the
  /// description says that it keeps states.
  void save(const std::string& name);
  bool has_saved(const std::string& name) const;
  std::size_t saved_states() const;
  /// Back to what was saved under a name.
  void restore(const std::string& name);

  /// From instantiated to ready to be stepped; parameters and starts are set before.
  void initialise(double start_s, std::optional<double> stop_s = {});

  /// One communication step. False when the unit wants the simulation to end there. Throws Error on
  /// any status worse than a warning.
  bool step(double time_s, double step_s);

 private:
  struct Loaded;
  std::unique_ptr<Loaded> loaded_;
};

}  // namespace sim
