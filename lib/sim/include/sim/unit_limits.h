// What a unit of somebody else may use up before its process is ended.
#pragma once

namespace sim {

struct UnitLimits {
  /// By the clock, for one call of the unit; its start (load, instantiate, initialise) may take
  /// kStartSteps times as long. While the machine or the run is stopped no time passes.
  double step_s = 5.0;
  /// Above what it begins with; as much for the files that it writes, kPrintedShare for what it
  /// prints.
  double memory_gb = 2.0;
  bool trusted = false;  ///< neither limits nor a sandbox

  static constexpr double kStartSteps = 12.0, kPrintedShare = 0.05;
};

}  // namespace sim
