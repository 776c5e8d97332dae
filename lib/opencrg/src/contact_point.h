// Contact points: options, and where the last query was found.
#pragma once

#include "border.h"
#include "crg/surface.h"
#include "data_set.h"

namespace opencrg {

struct ContactPoint {
  DataSet* set = nullptr;
  Settings options;
  // What follows from the options and the data set; refresh() brings it up to date.
  const crg::Surface* surface = nullptr;
  Border border;
  ClosedRange closed;
  bool smooth = false, line_curvature = false;
  crg::Cursor cursor;
};

/// The point of an id, or nullptr. Needs no lock.
ContactPoint* find_contact_point(int id) noexcept;

// The rest wants registry_lock().

/// -1 when there are too many.
int create_contact_point(DataSet& set);
bool delete_contact_point(int id);
/// Of a data set, or all where it is nullptr.
void delete_contact_points(const DataSet* set);
void refresh(ContactPoint& point);
void refresh_points_of(const DataSet& set);
/// The next search begins at u.
void search_from(ContactPoint& point, double u_m);

}  // namespace opencrg
