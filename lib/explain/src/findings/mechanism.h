// A mechanism: one way in which recordings and simulation may differ, and all that crgexplain
// knows of it. A file of src/mechanisms holds one, or one family; list.cpp puts them in their
// order.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "crg/file.h"
#include "explain/findings.h"
#include "recording/recording.h"
#include "vehicle/vehicle_file.h"

namespace explain {

struct Listing;         // listing.h
struct CarChanges;      // car_changes.h
struct MappingChanges;  // mapping_changes.h

/// When a finding is written back. First: what else was found has its place on what it leaves.
/// Last: it needs mass and downforce as all others leave them.
enum class Turn { kFirst, kUsual, kLast };

struct Mechanism {
  const char* id;  ///< "vehicle.turbo_lag"; its kind is what stands before the dot
  /// Adds its unknowns to the inventory: how each enters the relations, its physics, what it needs
  /// of log and car. Or says why these logs cannot speak about it. Null: the one before it in its
  /// family lists it too.
  void (*list)(const Listing&) = nullptr;
  /// Larger amounts are no physics but the sign of something else.
  double most = kUnlimited;
  /// Adds a state of the car that hardly a log has, worked out from what it has: a window of a
  /// replay that begins in the middle of a stop must not begin with the heat of a window ago.
  void (*add_state)(recording::Recording&, const vehicle::Vehicle&) = nullptr;
  /// Its unknowns are components of one thing: found together they are one finding.
  bool by_components = false;
  /// Of what a search of its own finds; of all others every unknown has its own.
  std::string physics{}, equation{};

  // How a finding is written back; null: it changes nothing there.
  void (*write_car)(CarChanges&, const Finding&) = nullptr;
  void (*write_heights)(crg::Crg& road, bool closed, const Finding&) = nullptr;
  void (*write_grip)(crg::Crg& factors, bool closed, const Finding&) = nullptr;
  void (*write_mapping)(MappingChanges&, const Finding&) = nullptr;
  Turn turn = Turn::kUsual;

  static constexpr double kUnlimited = 1e300;
  std::string_view kind() const {
    const std::string_view all(id);
    return all.substr(0, all.find('.'));
  }
};

// What searches of their own find: short_waves.cpp and discs.cpp.
inline constexpr const char* kKerbOrRoughness = "road.kerb_or_roughness";
inline constexpr const char* kMultiPointContact = "vehicle.multi_point_contact";
inline constexpr const char* kBrakeDiscConductance = "vehicle.brake_disc_conductance";

/// Every mechanism there is, in the order in which the inventory lists them.
const std::vector<Mechanism>& mechanisms();

/// Null: none of them.
const Mechanism* find_mechanism(std::string_view id);

/// Makes one finding of components of one thing.
void join_components(Findings& findings);

/// That of the finding's mechanism.
Turn turn_of(const Finding& f);

/// Takes away why it could not be tested, before its own search says so or tests it.
void forget_untestable(Findings& findings, std::string_view id);

/// A finding of a mechanism with a search of its own.
Finding finding_of(const Mechanism& m);

/// All states of the car that hardly a log has; see Mechanism::add_state.
void add_unlogged_states(recording::Recording& recording, const vehicle::Vehicle& car);

}  // namespace explain
