#include "explain/write_back.h"

#include <algorithm>
#include <cmath>

#include "crg/edit.h"
#include "crg/surface.h"
#include "mapping_changes.h"
#include "mechanism.h"

namespace explain {
namespace {

/// Its mechanism, if that writes by `how`; else null.
template <class Writer>
const Mechanism* writer_of(const Finding& f, Writer Mechanism::*how) {
  const Mechanism* const m = find_mechanism(f.mechanism);
  return m == nullptr || m->*how == nullptr ? nullptr : m;
}

/// The road with its modifiers worked in, to be written to.
crg::Crg copy_of(const crg::Crg& road) {
  crg::Crg out = crg::crop(road, {});
  out.z_double_m.clear();
  return out;
}

bool is_closed(const crg::Crg& road) { return crg::Surface(road).closed(); }

/// A map of the road's shape: that which was known, 1 elsewhere.
crg::Crg known_factors(const crg::Crg& road, const crg::Crg* known) {
  crg::Crg out = copy_of(road);
  std::fill(out.grid.z_m.begin(), out.grid.z_m.end(), 1.0f);
  if (known != nullptr)
    for (std::size_t i = 0; i < std::min(out.grid.z_m.size(), known->grid.z_m.size()); ++i)
      if (std::isfinite(known->grid.z_m[i])) out.grid.z_m[i] = known->grid.z_m[i];
  out.comment.push_back("factors on the grip, found by crgexplain from recordings");
  return out;
}

}  // namespace

std::optional<crg::Crg> friction_map(const crg::Crg& road, const crg::Crg* known,
                                     const Findings& findings) {
  std::optional<crg::Crg> out;
  for (const Finding& f : findings.findings) {
    const Mechanism* const m = writer_of(f, &Mechanism::write_grip);
    if (m == nullptr || f.profile.size() < 2) continue;
    if (!out) out = known_factors(road, known);
    m->write_grip(*out, is_closed(road), f);
  }
  return out;
}

std::optional<crg::Crg> corrected_road(const crg::Crg& road, const Findings& findings) {
  const auto writes = [](const Finding& f) {
    return writer_of(f, &Mechanism::write_heights) != nullptr;
  };
  if (std::none_of(findings.findings.begin(), findings.findings.end(), writes)) return std::nullopt;
  crg::Crg out = copy_of(road);
  for (const Turn turn : {Turn::kFirst, Turn::kUsual, Turn::kLast})
    for (const Finding& f : findings.findings)
      if (const Mechanism* m = writer_of(f, &Mechanism::write_heights);
          m != nullptr && m->turn == turn)
        m->write_heights(out, is_closed(road), f);
  out.comment.push_back("heights corrected by crgexplain from recordings");
  return out;
}

std::optional<Mapping> corrected_mapping(const Mapping& mapping, const vehicle::Vehicle& car,
                                         const Findings& findings,
                                         const std::vector<Signals>& logs) {
  Mapping out = mapping;
  MappingChanges changes{out, car, logs};
  for (const Finding& f : findings.findings)
    if (const Mechanism* m = writer_of(f, &Mechanism::write_mapping);
        m != nullptr && !f.parameters.empty())
      m->write_mapping(changes, f);
  if (!changes.changed) return std::nullopt;
  return out;
}

CorrectedInputs correct(const StatedInputs& stated, const Findings& findings,
                        const std::vector<Signals>& logs) {
  return {corrected_road(stated.road, findings),
          friction_map(stated.road, stated.friction, findings),
          corrected_vehicle(stated.vehicle_path, stated.car, findings, logs),
          corrected_mapping(stated.mapping, stated.car, findings, logs)};
}

}  // namespace explain
