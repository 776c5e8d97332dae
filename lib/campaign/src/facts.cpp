#include "facts.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/one_line.h"

namespace campaign {
namespace {

using nlohmann::json;

enum class Take { number, word, count };  // count: how many a list holds

struct Wanted {
  const char* kind;
  const char* name;
  const char* unit;
  const char* pointer;  // RFC 6901
  Take take = Take::number;
  double factor = 1.0;  // on the page
  const char* shown_unit = nullptr;
};

// In the order of the page's columns.
constexpr Wanted kWanted[] = {
    {"mesh", "length", "m", "/length_m"},
    {"mesh", "triangles", "", "/triangles"},
    {"mesh", "mesh to circuit, 99 %", "m", "/mesh_error/road_p99_m", Take::number, 1e3, "mm"},
    {"road", "length", "m", "/reference_line/length_m"},
    {"road", "width, median", "m", "/centreline/width_median_m"},
    {"road", "smallest radius", "m", "/reference_line/min_radius_m"},
    {"road", "error, 99 %", "m", "/validation/z_error_m/p99", Take::number, 1e3, "mm"},
    {"road", "error, largest", "m", "/validation/z_error_m/max", Take::number, 1e3, "mm"},
    {"road", "points without mesh", "", "/validation/points_without_mesh"},
    {"road", "rough places", "", "/validation/rough_places", Take::count},
    {"road", "holes", "", "/grid/holes"},
    {"road", "folds", "", "/sample/folds", Take::count},
    {"road", "crossings", "", "/sample/crossings", Take::count},
    {"road", "kerbs", "", "/kerb/kerbs", Take::count},
    {"road", "remarks of reading", "", "/read/remarks", Take::count},
    {"road", "remarks of cleaning", "", "/clean/remarks", Take::count},
    {"road", "remarks of sampling", "", "/sample/remarks", Take::count},
    {"scan", "points", "", "/points"},
    {"scan", "on cars", "", "/share_on_cars", Take::number, 100, "%"},
    {"map", "points used", "", "/points/used"},
    {"map", "coverage", "", "/grid/coverage", Take::number, 100, "%"},
    {"map", "holes", "", "/grid/holes"},
    {"map", "rms before", "m", "/registration/rms_before_m", Take::number, 1e3, "mm"},
    {"map", "rms after", "m", "/registration/rms_after_m", Take::number, 1e3, "mm"},
    {"map", "deviation of x", "m", "/registration/typical_stddev/x_m", Take::number, 1e3, "mm"},
    {"map", "deviation of y", "m", "/registration/typical_stddev/y_m", Take::number, 1e3, "mm"},
    {"map", "deviation of z", "m", "/registration/typical_stddev/z_m", Take::number, 1e3, "mm"},
    {"map", "road changed, 99 %", "m", "/grid/changed_p99_m", Take::number, 1e3, "mm"},
    {"map", "remarks", "", "/remarks", Take::count},
    {"lap", "lap", "s", "/lap_s/0"},
    {"lap", "top speed", "m/s", "/top_mps"},
    {"lap", "furthest off the line", "m", "/furthest_off_line_m"},
    {"lap", "steps off the road", "", "/steps_off_road"},
    {"replay", "windows", "", "/windows"},
    {"replay", "along, rms", "m", "/errors/along_m/rmse"},
    {"replay", "lateral, rms", "m", "/errors/lateral_m/rmse"},
    {"replay", "speed, rms", "m/s", "/errors/vx_mps/rmse"},
    {"replay", "yaw rate, rms", "rad/s", "/errors/yaw_rate_radps/rmse"},
    {"replay", "ax, rms", "m/s²", "/errors/ax_mps2/rmse"},
    {"replay", "ay, rms", "m/s²", "/errors/ay_mps2/rmse"},
    {"replay", "along, largest", "m", "/errors/along_m/max"},
    {"replay", "lateral, largest", "m", "/errors/lateral_m/max"},
    {"explain", "verdict", "", "/verdict", Take::word},
    {"explain", "first finding", "", "/findings/0/mechanism", Take::word},
    {"explain", "findings", "", "/findings", Take::count},
    {"explain", "mismatches", "", "/mismatches", Take::count},
    {"explain", "unexplained", "", "/unexplained", Take::count},
    {"explain", "laps", "", "/laps"},
    {"summary", "laps", "", "/laps"},
    {"summary", "measurements without forces", "", "/rows_without_forces"},
    {"summary", "measurements with forces", "", "/rows_with_forces"},
    {"summary", "remarks", "", "/remarks", Take::count},
    {"fleet", "verdict", "", "/verdict", Take::word},
    {"fleet", "first finding", "", "/findings/0/mechanism", Take::word},
    {"fleet", "of", "", "/findings/0/owner", Take::word},
    {"fleet", "findings", "", "/findings", Take::count},
    {"fleet", "not divided", "", "/undivided", Take::count},
    {"fleet", "cars", "", "/cars", Take::count},
    {"fleet", "drives", "", "/drives"},
    {"trials-make", "trials", "", "/trials"},
    {"trials-make", "seal", "", "/seal", Take::word},
    {"trials-run", "recordings", "", "/recordings"},
    {"trials-run", "failed", "", "/failed"},
};

/// At a pointer, without exceptions for what is missing.
const json* at(const json& said, const char* pointer) {
  const json::json_pointer place{std::string(pointer)};
  if (!said.contains(place)) return nullptr;
  return &said.at(place);
}

void add(std::vector<Fact>& facts, const Wanted& wanted, const json& found) {
  Fact fact{.name = wanted.name, .unit = wanted.unit, .text = ""};
  if (wanted.take == Take::word && found.is_string())
    fact.text = base::one_line(found.get<std::string>());
  else if (wanted.take == Take::count && found.is_array())
    fact.value = static_cast<double>(found.size());
  else if (wanted.take == Take::number && found.is_number())
    fact.value = found.get<double>();
  if (std::isfinite(fact.value) || !fact.text.empty()) facts.push_back(std::move(fact));
}

/// blind_trials score: hits and cases of each metric, which have names of their own.
void add_score(std::vector<Fact>& facts, const json& said) {
  const json* const metrics = at(said, "/metrics");
  if (metrics == nullptr || !metrics->is_array()) return;
  for (const json& metric : *metrics) {
    if (!metric.is_object()) continue;
    const json *const name = at(metric, "/metric"), *const hits = at(metric, "/hits"),
                      *const of = at(metric, "/of");
    if (name == nullptr || !name->is_string() || hits == nullptr || !hits->is_number() ||
        of == nullptr || !of->is_number() || of->get<double>() <= 0.0)
      continue;
    const std::string words = base::one_line(name->get<std::string>());
    facts.push_back({words, "", hits->get<double>(), ""});
    facts.push_back({words + ", cases", "", of->get<double>(), ""});
  }
}

}  // namespace

std::vector<Fact> facts_of(const std::string& kind, const json& said) {
  std::vector<Fact> facts;
  for (const Wanted& wanted : kWanted)
    if (kind == wanted.kind)
      if (const json* const found = at(said, wanted.pointer)) add(facts, wanted, *found);
  if (kind == "trials-score") add_score(facts, said);
  return facts;
}

Shown shown(const std::string& kind, const Fact& fact) {
  for (const Wanted& wanted : kWanted)
    if (kind == wanted.kind && fact.name == wanted.name && wanted.shown_unit != nullptr)
      return {wanted.factor, wanted.shown_unit};
  return {1.0, fact.unit};
}

}  // namespace campaign
