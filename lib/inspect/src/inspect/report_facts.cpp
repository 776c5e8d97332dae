#include "report_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <utility>
#include <vector>

#include "inspect/compare.h"
#include "inspect/input_file.h"
#include "inspect/sizes.h"

namespace road {
namespace {

const char* format_name(crg::Format format) {
  switch (format) {
    case crg::Format::KRBI:
      return "KRBI (float32, binary)";
    case crg::Format::KDBI:
      return "KDBI (float64, binary)";
    case crg::Format::LRFI:
      return "LRFI (text, 10 characters)";
    case crg::Format::LDFI:
      return "LDFI (text, 20 characters)";
  }
  return "";
}

/// Least and largest of what is not NaN.
std::pair<double, double> extremes(const std::vector<float>& values) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const float value : values) {
    if (std::isnan(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return std::pair<double, double>(low, high);
}

void add_file(const HeightMap& map, const crg::Crg& file, const GridReport& grid,
              const ReportRequest& request, report::TrackReport& report) {
  const auto row = [&](const char* name, std::string value) {
    report.file.push_back({name, std::move(value)});
  };
  std::error_code ignored;
  row("File", shown_path(request.crg_path, request));
  row("Size", fmt::format("{} bytes", std::filesystem::file_size(request.crg_path, ignored)));
  row("Format", format_name(file.format));
  row("Rows x columns", fmt::format("{} x {}", map.rows(), map.columns()));
  row("u", fmt::format("{:.3f} to {:.3f} m, step {:.6f} m", map.line.u_begin_m, map.u_end_m(),
                       map.line.u_step_m));
  row("v", fmt::format("{:.3f} to {:.3f} m", map.v_m.front(), map.v_m.back()));
  row("Nodes with height", fmt::format("{} of {}", grid.nodes_with_z, grid.nodes));
  row("Missing nodes inside the road", fmt::format("{}", grid.holes));
  row("Closed", map.line.closed ? "yes" : "no");
  row("Modifiers",
      file.has_modifier_section
          ? (file.modifiers.empty() ? "none (empty section)" : "those of the file are applied")
          : "none (no section: the reference API would move the road by default)");
  if (!file.included_path.empty()) row("Included file", file.included_path);
}

}  // namespace

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

std::string shown_path(const std::string& path, const ReportRequest& request) {
  const bool moves =
      !request.shown_folder.empty() && std::filesystem::path(path).parent_path() ==
                                           std::filesystem::path(request.crg_path).parent_path();
  return moves ? (std::filesystem::path(request.shown_folder) / file_name(path)).string() : path;
}

void add_header(const crg::Crg& file, report::TrackReport& report) {
  const auto section = [&](const char* name, const std::vector<crg::HeaderEntry>& entries,
                           bool present) {
    if (!present) return;
    if (entries.empty()) report.header.push_back({name, "(empty)"});
    for (const crg::HeaderEntry& entry : entries) {
      if (entry.key == "*") continue;
      report.header.push_back({fmt::format("{} {}", name, entry.key),
                               entry.text.empty() ? fmt::format("{}", entry.value) : entry.text});
    }
  };
  section("ROAD_CRG", file.road, true);
  section("ROAD_CRG_OPTS", file.options, file.has_option_section || !file.options.empty());
  section("ROAD_CRG_MODS", file.modifiers, file.has_modifier_section);
  section("ROAD_CRG_MPRO", file.projection, !file.projection.empty());
  report.comment = file.comment;
}

void add_facts(const HeightMap& map, const AlongU& along, const crg::Crg& file,
               const ReportRequest& request, const KerbStrips& kerbs,
               const std::optional<ValidateReport>& validated, report::TrackReport& report) {
  const auto fact = [&](const char* name, std::string value) {
    report.facts.push_back({name, std::move(value)});
  };
  const GridReport grid = describe(file.grid, map.line);
  fact("Length", fmt::format("{:.1f} m, {}", map.u_end_m() - map.line.u_begin_m,
                             map.line.closed ? "closed" : "open"));
  const auto width = [](double low_m, double median_m, double high_m) {
    return fmt::format("{:.1f} m ({:.1f} to {:.1f} m)", median_m, low_m, high_m);
  };
  if (request.road_width_m)
    fact("Width of the road",
         width((*request.road_width_m)[0], (*request.road_width_m)[1], (*request.road_width_m)[2]));
  if (grid.nodes_with_z > 0) {
    fact("Width of all that has a height",
         width(grid.width_min_m, grid.width_median_m, grid.width_max_m));
    fact("Kerbs", fmt::format("{}{}", kerbs.strips.size(),
                              request.kerbs ? "" : ", by the shape of the road"));
    if (validated)
      fact("Largest error against the mesh",
           fmt::format("{:.2f} mm", 1e3 * validated->z_error_m.max));
    fact("z", fmt::format("{:.3f} to {:.3f} m", grid.z_min_m, grid.z_max_m));
    const auto [z_low, z_high] = extremes(along.elevation_m);
    fact("Elevation of the line", fmt::format("{:.1f} to {:.1f} m", z_low, z_high));
    const auto [s_low, s_high] = extremes(along.slope);
    fact("Slope", fmt::format("{:+.1f} to {:+.1f} %", 100.0 * s_low, 100.0 * s_high));
    const auto [b_low, b_high] = extremes(along.banking);
    fact("Banking", fmt::format("{:+.1f} to {:+.1f} %", 100.0 * b_low, 100.0 * b_high));
  }
  const auto [k_low, k_high] = extremes(along.curvature_1pm);
  const double tightest = std::max(std::abs(k_low), std::abs(k_high));
  fact("Tightest radius", tightest > 1e-6 ? fmt::format("{:.1f} m", 1.0 / tightest) : "straight");
  fact("Grid",
       fmt::format("{} x {} nodes, {:.3g} m x {:.3g} m", map.rows(), map.columns(),
                   map.line.u_step_m,
                   (map.v_m.back() - map.v_m.front()) / static_cast<double>(map.columns() - 1)));
  add_file(map, file, grid, request, report);
}

void add_published(const HeightMap& map, const AlongU& along, const ReportRequest& request,
                   std::vector<Finding>& findings, report::TrackReport& report) {
  const Published& told = request.published;
  const auto add = [&](const char* name, const std::optional<double>& published_m, double here_m,
                       double most_off_m) {
    if (!published_m || !std::isfinite(here_m)) return;
    const double off_m = here_m - *published_m;
    const std::string beside = fmt::format(
        "{:.1f} m, {:.1f} % {} than the {} m of {}", here_m, 100.0 * std::abs(off_m) / *published_m,
        off_m < 0.0 ? "less" : "more", *published_m, told.source.value_or("what is published"));
    report.facts.push_back({fmt::format("{} against the world", name), beside});
    if (std::abs(off_m) > most_off_m)
      findings.push_back({"published", map.line.u_begin_m, map.u_end_m(), map.v_m.front(),
                          map.v_m.back(), off_m, "m", Severity::remark,
                          fmt::format("{}: {}", name, beside)});
  };
  const auto [low_m, high_m] = extremes(along.elevation_m);
  add("Length", told.length_m, map.u_end_m() - map.line.u_begin_m,
      0.01 * told.length_m.value_or(0.0));
  add("Climb", told.climb_m, high_m - low_m, std::max(1.0, 0.05 * told.climb_m.value_or(0.0)));
  std::vector<float> width_m = along.width_m;
  std::erase_if(width_m, [](float width) { return std::isnan(width); });
  std::sort(width_m.begin(), width_m.end());
  const double median_m = width_m.empty() ? NAN : width_m[width_m.size() / 2];
  add("Width", told.width_m, request.road_width_m ? (*request.road_width_m)[1] : median_m,
      0.1 * told.width_m.value_or(0.0));
  if (told.mesh) report.facts.push_back({"Whose mesh", *told.mesh});
}

void add_rules(const FindingOptions& options, const ValidateLimits& limits,
               const std::vector<Finding>& findings, const std::optional<ValidateReport>& validated,
               report::TrackReport& report) {
  // What lies beyond the edges is beyond the limits without being an error.
  const auto add = [&](const char* what, std::initializer_list<const char*> kinds, const char* unit,
                       double limit, double from) {
    report::RuleView rule{what, unit, limit, from, false, {}};
    for (const Finding& f : findings) {
      const double size = std::abs(f.value);
      if (f.unit != unit || (f.severity == Severity::remark && size > limit) ||
          std::find(kinds.begin(), kinds.end(), f.kind) == kinds.end())
        continue;
      if (rule.is_seen && size <= rule.value) continue;
      rule.value = size, rule.is_seen = true, rule.u_m = f.u_begin_m;
    }
    report.rules.push_back(std::move(rule));
  };
  const auto add_value = [&](const char* what, const char* unit, double limit, double value) {
    report.rules.push_back({what, unit, limit, value, true, {}});
  };
  const CompareOptions compared;
  add("hole in the road, longer side", {"hole"}, "m", options.max_hole_m, 0.0);
  add("stripe without road", {"nan_stripe"}, "m", 0.0, 0.0);
  add("bump or pothole", {"bump", "pothole"}, "m", options.max_bump_m, options.min_bump_m);
  add("step across the road", {"tile_step"}, "m", options.max_tile_step_m, options.min_tile_step_m);
  add("bend folded over itself", {"fold"}, "m", 0.0, 0.0);
  if (options.closed) {
    add("step where the road closes", {"wrong_seam"}, "m", options.max_seam_step_m,
        options.min_seam_step_m);
    add("kink where the road closes", {"wrong_seam"}, "rad", options.max_seam_heading_rad,
        options.min_seam_heading_rad);
  }
  if (!validated) return;
  add_value("99 % of the road off the mesh", "m", limits.max_z_error_p99_m,
            validated->road_error_p99_m);
  const double all =
      static_cast<double>(validated->road_points + validated->road_points_without_mesh);
  add_value("road without mesh", "1", limits.max_share_without_mesh,
            all > 0.0 ? static_cast<double>(validated->road_points_without_mesh) / all : 0.0);
  add("place off the mesh", {"deviation"}, "m", compared.max_deviation_m, compared.min_deviation_m);
  add("kerb lower than in the mesh", {"kerb_loss"}, "m", compared.max_deviation_m,
      compared.min_kerb_loss_m);
}

void add_looked_for(const FindingOptions& options, const Comparisons& comparisons,
                    report::TrackReport& report) {
  const auto say = [&](std::string text) { report.looked_for.push_back(std::move(text)); };
  const auto mm = [](double length_m) { return fmt::format("{:.4g} mm", 1000.0 * length_m); };
  say("Holes of one node or more, rows and stripes without road, bends in which the grid folds, "
      "and what 'crgbuild check' finds");
  say(fmt::format("Steps across the road from {} on that at least {:.0f} % of its width make alike",
                  mm(options.min_tile_step_m), 100.0 * options.min_tile_share));
  say(
      fmt::format("Bumps and potholes from {} on over the road 3 to 9 m before and behind, or from "
                  "5.5 times the scatter of the road there; "
                  "lower ones, those longer than about 6 m, and any on kerbs are not looked for",
                  mm(options.min_bump_m)));
  if (options.closed)
    say(fmt::format(
        "Steps from {}, kinks from {:.4g} mrad and gaps from {} on where the road closes",
        mm(options.min_seam_step_m), 1000.0 * options.min_seam_heading_rad,
        mm(options.max_seam_gap_m)));
  const CompareOptions compared;
  bool mesh = false;
  for (const auto& [key, comparison] : comparisons) {
    mesh = mesh || key == "mesh";
    const std::string lost =
        fmt::format("kerbs that are lower from {} on over {:.4g} m", mm(compared.min_kerb_loss_m),
                    compared.min_kerb_loss_length_m);
    if (key == "before")
      say(fmt::format("Against the road before refinement: {}", lost));
    else
      say(fmt::format("Against the {}: places from {} on over {:.4g} m2 or more, {}{}",
                      key == "against" ? "other road" : key, mm(compared.min_deviation_m),
                      compared.min_deviation_area_m2, lost,
                      key == "mesh"
                          ? fmt::format("; smaller places from {} on are listed and are no finding",
                                        mm(report.rough_limit_m))
                          : ""));
  }
  if (!mesh) say("Whether the road is where its mesh is: not looked at, no mesh was given");
}

}  // namespace road
