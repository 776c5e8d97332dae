// Data sets: what a loaded file has become, and the one list of them all.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "border.h"
#include "channels.h"
#include "crg/surface.h"
#include "settings.h"

namespace opencrg {

/// The road's axes in the world: turned about the begin of its line, then moved, m, rad.
struct Origin {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0, phi_rad = 0.0;
};

struct DataSet {
  int id = 0;
  Settings options, modifiers;
  Origin origin;  ///< by the file's header; follows what moves the road, so that the world stays
  /// The road with its line going straight on beyond its ends, and with its ends closed. Either is
  /// made when first wanted.
  std::unique_ptr<const crg::Surface> open, closed;
  ClosedRange range;                   ///< of the closed line; period 0 where the ends do not meet
  bool banking_folds = false;          ///< see height()
  double v_step_m = 0.01;              ///< as the interface answers it
  std::unique_ptr<Channels> channels;  ///< made when first asked for

  const crg::Surface& any() const { return open ? *open : *closed; }
};

/// Guards everything below, and the data sets themselves, but not evaluations.
std::mutex& registry_lock();

/// Reads a file into a new data set. Throws what lib/crg throws.
DataSet& load(const char* path);
DataSet* find_data_set(int id);
std::vector<int> data_set_ids();
void erase_data_set(int id);

/// The surface for queries that close the line or do not; makes it if need be.
const crg::Surface& surface_of(DataSet& set, bool close);

/// Works the modifiers into the data and removes them. Surfaces move: contact points must be told.
/// Throws, with nothing changed, when one is out of its range.
void apply_modifiers(DataSet& set);

/// Moves the road so that its axes lie there and its place in the world stays. As above.
void set_origin(DataSet& set, const Origin& origin);

/// The data as they are now with the options of the set, as a file would hold them.
crg::Crg as_file(const DataSet& set);

}  // namespace opencrg
