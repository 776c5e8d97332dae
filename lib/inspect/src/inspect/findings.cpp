#include "inspect/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "defects.h"

namespace road {
namespace {

/// Keeps the largest ones when there are too many, and says so.
void append(std::vector<Finding>& all, std::vector<Finding> some, const HeightMap& map,
            std::size_t limit) {
  if (some.size() > limit) {
    const std::size_t left_out = some.size() - limit;
    std::stable_sort(some.begin(), some.end(), [](const Finding& a, const Finding& b) {
      return std::abs(a.value) > std::abs(b.value);
    });
    const Finding next = some[limit];
    some.resize(limit);
    some.push_back(finding(
        map, next.kind.c_str(), map.line.u_begin_m, map.u_end_m(), next.value, next.unit.c_str(),
        next.severity,
        fmt::format(
            "{} more places of the kind {} are not listed; the largest of them has {:.3g} {}",
            left_out, next.kind, next.value, next.unit)));
  }
  std::stable_sort(some.begin(), some.end(),
                   [](const Finding& a, const Finding& b) { return a.u_begin_m < b.u_begin_m; });
  for (Finding& f : some) all.push_back(std::move(f));
}

}  // namespace

Finding finding(const HeightMap& map, const char* kind, double u_begin_m, double u_end_m,
                double value, const char* unit, Severity severity, std::string text) {
  Finding f;
  f.kind = kind;
  f.u_begin_m = u_begin_m;
  f.u_end_m = u_end_m;
  f.v_begin_m = map.v_m.front();
  f.v_end_m = map.v_m.back();
  f.value = value;
  f.unit = unit;
  f.severity = severity;
  f.text = std::move(text);
  return f;
}

std::vector<Finding> find_defects(const HeightMap& map, const KerbStrips& kerbs,
                                  const FindingOptions& options) {
  std::vector<Finding> all;
  std::vector<Finding> stripes;
  std::vector<Finding> holes = find_missing(map, options, stripes);
  std::vector<Finding> steps = find_tile_steps(map, options);
  std::vector<Finding> seam = find_seam_faults(map, options);
  std::vector<Finding> jumps = steps;
  for (const Finding& f : seam) {
    if (f.unit != "m") continue;
    // The step at the seam stands at both ends of u.
    jumps.push_back(f);
    jumps.push_back(f);
    jumps.back().u_begin_m = jumps.back().u_end_m = map.line.u_begin_m;
  }
  std::vector<Finding> bumps = find_bumps(map, kerbs, options, jumps);
  append(all, find_folds(map), map, options.max_per_kind);
  append(all, std::move(stripes), map, options.max_per_kind);
  append(all, std::move(seam), map, options.max_per_kind);
  append(all, std::move(holes), map, options.max_per_kind);
  // The flanks of a short bump step too; a step proper leaves no bump above itself.
  std::erase_if(steps, [&](const Finding& step) {
    return std::any_of(bumps.begin(), bumps.end(), [&](const Finding& bump) {
      return std::abs(step.value) < bump.value && step.u_begin_m > bump.u_begin_m - 1.0 &&
             step.u_end_m < bump.u_end_m + 1.0;
    });
  });
  append(all, std::move(steps), map, options.max_per_kind);
  append(all, std::move(bumps), map, options.max_per_kind);
  return all;
}

Verdict verdict_of(const std::vector<Finding>& findings) {
  Verdict verdict = Verdict::usable;
  for (const Finding& f : findings) {
    if (f.severity == Severity::error) return Verdict::not_usable;
    verdict = Verdict::usable_with_remarks;
  }
  return verdict;
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::usable:
      return "usable";
    case Verdict::usable_with_remarks:
      return "usable_with_remarks";
    case Verdict::not_usable:
      return "not_usable";
  }
  return "";
}

const char* to_string(Severity severity) {
  return severity == Severity::error ? "error" : "remark";
}

}  // namespace road
