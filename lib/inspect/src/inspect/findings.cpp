#include "inspect/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "defects.h"

namespace road {
namespace {

constexpr const char* kBeyond = "; beyond the edge of the road";

/// The map with the heights between the edges, or with those beyond, alone.
HeightMap part_of(HeightMap map, const RoadEdges& edges, bool between) {
  for (std::size_t i = 0; i < map.rows(); ++i)
    for (std::size_t j = 0; j < map.columns(); ++j)
      if (edges.has(i, map.v_m[j]) != between)
        map.at(i, j) = std::numeric_limits<float>::quiet_NaN();
  return map;
}

/// Bumps and potholes of the road, and of what lies beyond its edges those that would be errors.
std::vector<Finding> bumps_of_both(const HeightMap& map, const HeightMap& road,
                                   const KerbStrips& kerbs, const FindingOptions& options,
                                   const std::vector<Finding>& steps) {
  std::vector<Finding> bumps = find_bumps(road, kerbs, options, steps);
  if (options.edges.empty()) return bumps;
  for (Finding& f : find_bumps(part_of(map, options.edges, false), kerbs, options, steps)) {
    if (f.severity != Severity::error) continue;
    f.severity = Severity::remark;
    f.text += kBeyond;
    bumps.push_back(std::move(f));
  }
  return bumps;
}

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
  const HeightMap road = options.edges.empty() ? map : part_of(map, options.edges, true);
  std::vector<Finding> holes = find_missing(map, road, options, stripes);
  std::vector<Finding> steps = find_tile_steps(road, options);
  std::vector<Finding> seam = find_seam_faults(road, options);
  std::vector<Finding> jumps = steps;
  for (const Finding& f : seam) {
    if (f.unit != "m") continue;
    // The step at the seam stands at both ends of u.
    jumps.push_back(f);
    jumps.push_back(f);
    jumps.back().u_begin_m = jumps.back().u_end_m = map.line.u_begin_m;
  }
  std::vector<Finding> bumps = bumps_of_both(map, road, kerbs, options, jumps);
  for (std::vector<Finding>* some : {&stripes, &holes}) mark_beyond(options.edges, map, *some);
  append(all, find_folds(road), map, options.max_per_kind);
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

void mark_beyond(const RoadEdges& edges, const HeightMap& map, std::vector<Finding>& findings) {
  const auto row = [&](double u_m) {
    return static_cast<std::size_t>(std::clamp((u_m - map.line.u_begin_m) / map.line.u_step_m + 0.5,
                                               0.0, static_cast<double>(map.rows() - 1)));
  };
  for (Finding& f : findings) {
    if (f.severity != Severity::error ||
        !lies_beyond(edges, row(f.u_begin_m), row(f.u_end_m), f.v_begin_m, f.v_end_m))
      continue;
    f.severity = Severity::remark;
    f.text += kBeyond;
  }
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
