// A running car behind the standard's functions, which FMI 2.0 and 3.0 share.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fmu/loaded_files.h"
#include "fmu/saved_state.h"
#include "fmu/unit_file.h"
#include "vehicle/step.h"

namespace fmu {

/// One car. Nothing is shared between instances; one instance is used by one thread at a time.
/// Where something cannot be done base::Error (of a road's file crg::Error) says so in one line,
/// and nothing has changed, but for step(): after a failed one only reset() and restore() help.
class Instance {
 public:
  /// Reads unit.txt and the unit's car from the folder. Throws base::Error, also where `token` is
  /// not the unit's.
  Instance(std::string resources, const std::string& token);
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  const std::vector<Variable>& list() const { return list_; }
  /// The variable to which a reference belongs. Throws base::Error for a reference of none.
  const Variable& variable(std::uint32_t reference) const;

  Phase phase() const { return now_.phase; }
  void enter_initialisation(double begin_s);
  void leave_initialisation();
  void terminate();
  void reset();
  /// What is to be said of a run that ends, once for each: where ledges held energy back. Empty:
  /// nothing, or it was said.
  std::string closing_remark();

  /// Outputs are those of the time reached; before the first step those of the begin.
  double number(std::uint32_t reference, Type type);
  const std::string& text(std::uint32_t reference);
  /// Throws base::Error for what is no number, beyond a parameter's bounds, or must not be set now.
  /// An input beyond its bounds is taken at the bound: the remark that comes back says so.
  std::string set_number(std::uint32_t reference, Type type, double value);
  void set_text(std::uint32_t reference, std::string value);

  /// From `time_s`, which must be the time reached, on by `step_s`: in solver steps, or, where it
  /// is no whole number of them, in as few equal ones as are no longer.
  void step(double time_s, double step_s);
  double time_s() const;

  /// How real outputs and rates of states change, at the time reached, where real inputs and states
  /// change along a direction, `seed`, one number for each of `knowns`. Outputs of the last step do
  /// not. Throws base::Error before and after the stepping, and for other variables.
  std::vector<double> derivatives(std::span<const std::uint32_t> unknowns,
                                  std::span<const std::uint32_t> knowns,
                                  std::span<const double> seed);

  SavedState save() const;
  void restore(const SavedState& state);
  const std::string& token() const { return unit_.token; }

 private:
  void start_again();
  void prepare();
  void begin_run();
  void use_files(std::shared_ptr<const LoadedFiles> files);
  void build_car();
  void place_car();
  vehicle::Controls<double> controls() const;
  vehicle::StepOptions solver_steps(double step_s, double& count) const;
  void look_at_opponents(vehicle::Controls<double>& controls) const;
  void show_outputs(const vehicle::Detail<double>& detail,
                    const vehicle::Controls<double>& controls);
  double input(Input which, std::size_t i = 0) const;
  double start(Start which) const;
  void be_current();
  double rate(std::size_t state);
  vehicle::Controls<double> change_of_controls(std::span<const double> along,
                                               const vehicle::Controls<double>& asked);
  void want_settable(const Variable& variable) const;

  std::string resources_;
  std::vector<Variable> list_;
  std::vector<std::size_t> variable_of_;   ///< by value reference
  std::vector<Type> type_of_;              ///< the same
  std::array<std::uint32_t, 9> first_{};   ///< reference of the first value of each source
  std::array<std::uint32_t, 11> input_{};  ///< reference of the first value of each input
  UnitFile unit_;
  SavedState now_;
  std::shared_ptr<const LoadedFiles> files_;
  vehicle::Car<double> car_{};
  vehicle::StepOptions options_;
  std::optional<vehicle::RoadTracker> tracker_;
  std::vector<double> telemetry_;
  std::vector<double> exported_;  ///< starts of all numbers, by value reference
  bool has_closed_ = false;       ///< the closing remark was asked for
  bool changed_ = true;           ///< something was set since the car was made of the parameters
};

}  // namespace fmu
