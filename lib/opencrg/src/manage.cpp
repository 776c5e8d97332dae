// The calls of the C API that make, change and end data sets and contact points. Nothing may leave
// them but return values: failures become messages.
#include <unistd.h>

#include <atomic>
#include <exception>
#include <string>

#include "contact_point.h"

using opencrg::ContactPoint;
using opencrg::DataSet;

namespace {

std::atomic<bool> quiet_about_missing_files = false;

// Work under the lock; `otherwise` where there is no such object or it fails. Messages go out after
// the lock, since the caller's function may call back.
template <typename Result, typename Work>
Result locked(const char* name, Result otherwise, const Work& work) noexcept {
  std::string why;
  try {
    const std::lock_guard guard(opencrg::registry_lock());
    return work();
  } catch (const std::exception& error) {
    why = error.what();
  }
  crgMsgPrint(dCrgMsgLevelWarn, "%s: %s\n", name, why.c_str());
  return otherwise;
}

template <typename Result, typename Work>
Result with_set(const char* name, int id, Result otherwise, const Work& work) noexcept {
  bool known = true;
  const Result result = locked(name, otherwise, [&] {
    DataSet* set = opencrg::find_data_set(id);
    known = set != nullptr;
    return known ? work(*set) : otherwise;
  });
  if (!known) crgMsgPrint(dCrgMsgLevelWarn, "%s: there is no data set %d\n", name, id);
  return result;
}

template <typename Work>
int with_point(const char* name, int id, const Work& work) noexcept {
  bool known = true;
  const int result = locked(name, 0, [&] {
    ContactPoint* point = opencrg::find_contact_point(id);
    known = point != nullptr;
    return known ? work(*point) : 0;
  });
  if (!known) crgMsgPrint(dCrgMsgLevelWarn, "%s: there is no contact point %d\n", name, id);
  return result;
}

int refused(const char* name, unsigned int id) {
  crgMsgPrint(dCrgMsgLevelWarn,
              "%s: %u is not an option of this kind, or its value is out of range\n", name, id);
  return 0;
}

}  // namespace

int crgLoaderReadFile(const char* filename) {
  if (filename == nullptr) {
    crgMsgPrint(dCrgMsgLevelFatal, "crgLoaderReadFile: no file name\n");
    return 0;
  }
  std::string why;
  try {
    const std::lock_guard guard(opencrg::registry_lock());
    return opencrg::load(filename).id;
  } catch (const std::exception& error) {
    why = error.what();
  }
  if (!quiet_about_missing_files || ::access(filename, F_OK) == 0)
    crgMsgPrint(dCrgMsgLevelFatal, "%s\n", why.c_str());
  return 0;
}

void crgLoaderSuppressFileNotFoundFatalMsg(bool suppress) { quiet_about_missing_files = suppress; }

const char* crgGetReleaseInfo(void) { return "Kerbstone, OpenCRG C-API release 2.0.1"; }

int crgDataSetRelease(int dataSetId) {
  return with_set(__func__, dataSetId, 0, [&](DataSet& set) {
    opencrg::delete_contact_points(&set);
    opencrg::erase_data_set(dataSetId);
    return 1;
  });
}

void crgMemRelease(void) {
  locked(__func__, 0, [] {
    opencrg::delete_contact_points(nullptr);
    for (const int id : opencrg::data_set_ids()) opencrg::erase_data_set(id);
    return 1;
  });
}

int crgDataSetGetURange(int dataSetId, double* uMin, double* uMax) {
  if (uMin == nullptr || uMax == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    const crg::Grid& grid = set.any().grid();
    *uMin = grid.u_begin_m;
    *uMax = grid.u_of(grid.rows() - 1);
    return 1;
  });
}

int crgDataSetGetVRange(int dataSetId, double* vMin, double* vMax) {
  if (vMin == nullptr || vMax == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    *vMin = set.any().grid().v_m.front();
    *vMax = set.any().grid().v_m.back();
    return 1;
  });
}

int crgDataSetGetIncrements(int dataSetId, double* uInc, double* vInc) {
  if (uInc == nullptr || vInc == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    *uInc = set.any().grid().u_step_m;
    *vInc = set.v_step_m;
    return 1;
  });
}

int crgDataSetGetUtilityDataClosedTrack(const int dataSetId, int* uIsClosed, double* uCloseMin,
                                        double* uCloseMax) {
  if (uIsClosed == nullptr || uCloseMin == nullptr || uCloseMax == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    const bool closed = set.range.period_m > 0.0;
    *uIsClosed = closed ? 1 : 0;
    *uCloseMin = closed ? set.range.begin_m : 0.0;
    *uCloseMax = closed ? set.range.begin_m + set.range.period_m : 0.0;
    return 1;
  });
}

int crgDataSetModifierSetInt(int dataSetId, unsigned int optionId, int optionValue) {
  const auto set_it = [&](DataSet& set) {
    return set.modifiers.set_int(optionId, optionValue) ? 1 : -1;
  };
  const int done = with_set(__func__, dataSetId, 0, set_it);
  return done < 0 ? refused(__func__, optionId) : done;
}

int crgDataSetModifierSetDouble(int dataSetId, unsigned int optionId, double optionValue) {
  const auto set_it = [&](DataSet& set) {
    return set.modifiers.set_double(optionId, optionValue) ? 1 : -1;
  };
  const int done = with_set(__func__, dataSetId, 0, set_it);
  return done < 0 ? refused(__func__, optionId) : done;
}

int crgDataSetModifierGetInt(int dataSetId, unsigned int optionId, int* optionValue) {
  if (optionValue == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    return set.modifiers.get_int(optionId, *optionValue) ? 1 : 0;
  });
}

int crgDataSetModifierGetDouble(int dataSetId, unsigned int optionId, double* optionValue) {
  if (optionValue == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    return set.modifiers.get_double(optionId, *optionValue) ? 1 : 0;
  });
}

int crgDataSetModifierRemove(int dataSetId, unsigned int modId) {
  return with_set(__func__, dataSetId, 0,
                  [&](DataSet& set) { return set.modifiers.remove(modId) ? 1 : 0; });
}

int crgDataSetModifierRemoveAll(int dataSetId) {
  return with_set(__func__, dataSetId, 0, [](DataSet& set) {
    set.modifiers.clear();
    return 1;
  });
}

void crgDataSetModifiersApply(int dataSetId) {
  with_set(__func__, dataSetId, 0, [](DataSet& set) {
    opencrg::apply_modifiers(set);
    opencrg::refresh_points_of(set);
    return 1;
  });
}

int crgDataSetGetGlobalOrigin(int dataSetId, double* xoff, double* yoff, double* zoff,
                              double* poff) {
  if (xoff == nullptr || yoff == nullptr || zoff == nullptr || poff == nullptr) return 0;
  return with_set(__func__, dataSetId, 0, [&](const DataSet& set) {
    *xoff = set.origin.x_m, *yoff = set.origin.y_m;
    *zoff = set.origin.z_m, *poff = set.origin.phi_rad;
    return 1;
  });
}

int crgDataSetSetGlobalOrigin(int dataSetId, double xoff, double yoff, double zoff, double poff) {
  return with_set(__func__, dataSetId, 0, [&](DataSet& set) {
    opencrg::set_origin(set, {xoff, yoff, zoff, poff});
    opencrg::refresh_points_of(set);
    return 1;
  });
}

CrgDataStruct* crgDataSetAccess(int dataSetId) {
  return with_set(__func__, dataSetId, static_cast<CrgDataStruct*>(nullptr), [](DataSet& set) {
    if (!set.channels) {
      auto channels = std::make_unique<opencrg::Channels>();
      channels->take(set.any());
      set.channels = std::move(channels);
    }
    return set.channels->seen();
  });
}

void crgDataSetModifierSetDefault(int dataSetId) {
  with_set(__func__, dataSetId, 0, [](DataSet& set) {
    set.modifiers = opencrg::default_modifiers();
    return 1;
  });
}

void crgDataSetOptionSetDefault(int dataSetId) {
  with_set(__func__, dataSetId, 0, [](DataSet& set) {
    set.options = opencrg::default_options();
    return 1;
  });
}

int crgContactPointCreate(int dataSetId) {
  return with_set(__func__, dataSetId, -1, opencrg::create_contact_point);
}

int crgContactPointDelete(int cpId) {
  return locked(__func__, 0, [&] { return opencrg::delete_contact_point(cpId) ? 1 : 0; });
}

void crgContactPointDeleteAll(int dataSetId) {
  locked(__func__, 0, [&] {
    const DataSet* set = opencrg::find_data_set(dataSetId);
    if (set != nullptr || dataSetId == -1) opencrg::delete_contact_points(set);
    return 1;
  });
}

int crgContactPointOptionSetInt(int cpId, unsigned int optionId, int optionValue) {
  const int done = with_point(__func__, cpId, [&](ContactPoint& point) {
    if (!point.options.set_int(optionId, optionValue)) return -1;
    opencrg::refresh(point);
    return 1;
  });
  return done < 0 ? refused(__func__, optionId) : done;
}

int crgContactPointOptionSetDouble(int cpId, unsigned int optionId, double optionValue) {
  const int done = with_point(__func__, cpId, [&](ContactPoint& point) {
    if (!point.options.set_double(optionId, optionValue)) return -1;
    opencrg::refresh(point);
    const crg::Grid& grid = point.surface->grid();
    const double length = grid.u_of(grid.rows() - 1) - grid.u_begin_m;
    if (optionId == dCrgCpOptionRefLineSearchU) opencrg::search_from(point, optionValue);
    if (optionId == dCrgCpOptionRefLineSearchUFrac)
      opencrg::search_from(point, grid.u_begin_m + optionValue * length);
    return 1;
  });
  return done < 0 ? refused(__func__, optionId) : done;
}

int crgContactPointOptionGetInt(int cpId, unsigned int optionId, int* optionValue) {
  if (optionValue == nullptr) return 0;
  return with_point(__func__, cpId, [&](const ContactPoint& point) {
    return point.options.get_int(optionId, *optionValue) ? 1 : 0;
  });
}

int crgContactPointOptionGetDouble(int cpId, unsigned int optionId, double* optionValue) {
  if (optionValue == nullptr) return 0;
  return with_point(__func__, cpId, [&](const ContactPoint& point) {
    return point.options.get_double(optionId, *optionValue) ? 1 : 0;
  });
}

int crgContactPointOptionRemove(int cpId, unsigned int optionId) {
  return with_point(__func__, cpId, [&](ContactPoint& point) {
    if (!point.options.remove(optionId)) return 0;
    opencrg::refresh(point);
    return 1;
  });
}

int crgContactPointOptionRemoveAll(int cpId) {
  return with_point(__func__, cpId, [](ContactPoint& point) {
    point.options.clear();
    opencrg::refresh(point);
    return 1;
  });
}

void crgContactPointSetDefaultOptions(int cpId) {
  with_point(__func__, cpId, [](ContactPoint& point) {
    point.options = opencrg::default_options();
    point.options.set_double(dCrgCpOptionRefLineClose, 0.3);
    point.options.set_double(dCrgCpOptionRefLineFar, 2.2);
    opencrg::refresh(point);
    return 1;
  });
}

int crgContactPointSetHistory(int cpId, int histSize) {
  (void)histSize;
  return with_point(__func__, cpId, [](const ContactPoint&) { return 1; });
}

void crgContactPointSetHistoryForAllPoints(int histSize) { (void)histSize; }

void crgContactPointActivatePerfStat(int cpId) {
  with_point(__func__, cpId, [](const ContactPoint&) { return 1; });
}

void crgContactPointPrintPerfStat(int cpId) {
  if (with_point(__func__, cpId, [](const ContactPoint&) { return 1; }) == 1)
    crgMsgPrint(dCrgMsgLevelNotice, "contact point %d: searches keep no statistics here\n", cpId);
}
