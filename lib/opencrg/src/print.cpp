// The calls of the C API that tell what there is, as messages of level notice, and the check.
#include <algorithm>
#include <exception>
#include <optional>

#include "contact_point.h"
#include "crg/check.h"

using opencrg::DataSet;

namespace {

// Copies under the lock and prints after it: the caller's message function may call back.
template <typename Copy>
auto copied(int dataSetId, const Copy& copy)
    -> std::optional<decltype(copy(std::declval<const DataSet&>()))> {
  const std::lock_guard guard(opencrg::registry_lock());
  const DataSet* set = opencrg::find_data_set(dataSetId);
  if (set == nullptr) return std::nullopt;
  return copy(*set);
}

void say(const char* what, double value) {
  crgMsgPrint(dCrgMsgLevelNotice, "%-36s %.10g\n", what, value);
}

// What the messages need of a road, without its heights.
struct Facts {
  crg::ReferenceLine line;
  std::vector<double> v_m;
  double v_step_m;
  std::size_t rows;
  bool heading, slope, banking, x, y;
};

std::optional<Facts> facts_of(int dataSetId) noexcept try {
  return copied(dataSetId, [](const DataSet& set) {
    const crg::Crg& crg = set.any().file();
    return Facts{set.any().reference_line(),
                 crg.grid.v_m,
                 set.v_step_m,
                 crg.grid.rows(),
                 !crg.heading_rad.empty(),
                 !crg.slope.empty(),
                 !crg.banking.empty(),
                 !crg.x_m.empty(),
                 !crg.y_m.empty()};
  });
} catch (const std::exception&) {
  return std::nullopt;
}

}  // namespace

void crgDataPrintHeader(int dataSetId) {
  const auto facts = facts_of(dataSetId);
  if (!facts) return;
  const crg::ReferenceLine& line = facts->line;
  say("u, begin [m]", line.u_begin_m);
  say("u, end [m]", line.u_begin_m + static_cast<double>(facts->rows - 1) * line.u_step_m);
  say("u, step [m]", line.u_step_m);
  say("x, begin [m]", line.x_m.front());
  say("x, end [m]", line.x_m.back());
  say("y, begin [m]", line.y_m.front());
  say("y, end [m]", line.y_m.back());
  say("heading, begin [rad]", line.heading_rad.front());
  say("heading, end [rad]", line.heading_rad.back());
  say("v, right [m]", facts->v_m.front());
  say("v, left [m]", facts->v_m.back());
  say("v, step [m]", facts->v_step_m);
}

void crgDataPrintChannelInfo(int dataSetId) {
  const auto facts = facts_of(dataSetId);
  if (!facts) return;
  say("rows", static_cast<double>(facts->rows));
  say("long sections", static_cast<double>(facts->v_m.size()));
  for (const double v : facts->v_m) say("long section at v [m]", v);
  say("channel of heading", facts->heading ? 1.0 : 0.0);
  say("channel of slope", facts->slope ? 1.0 : 0.0);
  say("channel of banking", facts->banking ? 1.0 : 0.0);
  say("channel of x", facts->x ? 1.0 : 0.0);
  say("channel of y", facts->y ? 1.0 : 0.0);
}

void crgDataPrintRoadInfo(int dataSetId) {
  const auto facts = facts_of(dataSetId);
  if (!facts) return;
  say("length of the road [m]", static_cast<double>(facts->rows - 1) * facts->line.u_step_m);
  say("width of the road [m]", facts->v_m.back() - facts->v_m.front());
  say("right of the reference line [m]", std::min(0.0, facts->v_m.front()));
  say("left of the reference line [m]", std::max(0.0, facts->v_m.back()));
  say("cross sections", static_cast<double>(facts->rows));
  say("long sections", static_cast<double>(facts->v_m.size()));
}

void crgDataSetModifiersPrint(int dataSetId) {
  const auto modifiers = copied(dataSetId, [](const DataSet& set) { return set.modifiers; });
  if (modifiers) modifiers->print("modifier");
}

void crgContactPointOptionsPrint(int cpId) {
  opencrg::Settings options;
  {
    const std::lock_guard guard(opencrg::registry_lock());
    const opencrg::ContactPoint* point = opencrg::find_contact_point(cpId);
    if (point == nullptr) return;
    options = point->options;
  }
  options.print("option");
}

int crgCheck(int dataSetId) {
  crg::CheckReport report;
  try {
    const auto crg = copied(dataSetId, opencrg::as_file);
    if (!crg) {
      crgMsgPrint(dCrgMsgLevelWarn, "%s: there is no data set %d\n", __func__, dataSetId);
      return 0;
    }
    report = crg::check(*crg);
  } catch (const std::exception& error) {
    crgMsgPrint(dCrgMsgLevelWarn, "%s: %s\n", __func__, error.what());
    return 0;
  }
  for (const crg::Finding& finding : report.findings) {
    crgMsgPrint(finding.severity == crg::Severity::Note ? dCrgMsgLevelNotice : dCrgMsgLevelWarn,
                "%s: %s\n", finding.rule.c_str(), finding.message.c_str());
  }
  return report.passed() ? 1 : 0;
}
