// The validation report of the refined road with what the points did to it.
#include "map_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/write_file.h"
#include "cloud/road_frame.h"
#include "inspect/write_report.h"
#include "map_lead.h"
#include "no_value.h"
#include "report/track_report.h"

namespace cloud {
namespace {

std::string millimetres(double metres) { return fmt::format("{:.2f} mm", 1e3 * metres); }

/// A value of the drift of one pass over the report's stations; linear between its own, NaN where
/// the pass did not drive.
std::vector<float> along(const MapReport& facts, int pass, std::size_t entry,
                         const report::TrackReport& page, std::size_t count) {
  std::vector<std::pair<double, double>> at;
  for (const DriftStation& s : facts.drift)
    if (s.pass == pass) at.emplace_back(s.u_m, s.correction[entry]);
  std::sort(at.begin(), at.end());
  std::vector<float> values(count, kNoValue);
  for (std::size_t k = 0; k < count; ++k) {
    const double u = page.u_begin_m + static_cast<double>(k) * page.u_step_m;
    const auto after = std::lower_bound(at.begin(), at.end(), std::pair{u, -1e300});
    if (after == at.begin() || after == at.end()) continue;
    const auto before = after - 1;
    const double gap = after->first - before->first;
    if (gap > 30.0) continue;
    const double share = gap > 0.0 ? (u - before->first) / gap : 0.0;
    values[k] = static_cast<float>((1.0 - share) * before->second + share * after->second);
  }
  return values;
}

report::ExtraSection coverage(const MapReport& facts) {
  const double road = std::max<double>(1.0, static_cast<double>(facts.nodes - facts.nodes_hole));
  const auto share = [&](std::size_t nodes) {
    return fmt::format("{:.2f} % ({} nodes)", 100.0 * static_cast<double>(nodes) / road, nodes);
  };
  report::ExtraSection section;
  section.title = "What the points cover";
  section.sentences = {
      "Nodes far from any point keep the base's height bit by bit. The provenance and "
      "the standard "
      "deviation of every node are in refined.provenance.crg and refined.stddev.crg; the "
      "differences to the base are the comparison \"against\". Grass beside the road is left out: "
      "blades do not show the ground."};
  for (const std::string& remark : facts.remarks) section.sentences.push_back(remark);
  section.facts = {{"points read", fmt::format("{}", facts.points)},
                   {"points used", fmt::format("{}", facts.used)},
                   {"of those looked at, on grass beside the road",
                    fmt::format("{} of {}", facts.on_grass, facts.looked_at)},
                   {"heights from points", share(facts.nodes_lidar)},
                   {"interpolated between such", share(facts.nodes_interpolated)},
                   {"blended between points and base", share(facts.nodes_blended)},
                   {"heights of the base", share(facts.nodes_base)},
                   {"holes of the base", fmt::format("{} nodes", facts.nodes_hole)},
                   {"change of height, median", millimetres(facts.changed_p50_m)},
                   {"change of height, 99 %", millimetres(facts.changed_p99_m)},
                   {"change of height, largest", millimetres(facts.changed_max_m)}};
  return section;
}

report::ExtraSection registration(const MapReport& facts) {
  report::ExtraSection section;
  section.title = "The trajectory's drift";
  section.sentences = {
      "What was added to the poses is among the curves along u, lap by lap. Residuals are robust "
      "deviations of cells of half a metre."};
  section.facts = {{"estimate", fmt::format("{} after {} rounds, {} passes, {} stations",
                                            facts.converged ? "converged" : "NOT converged",
                                            facts.iterations, facts.passes, facts.sections)},
                   {"views against the base, before", millimetres(facts.rms_before_m)},
                   {"views against the base, after", millimetres(facts.rms_after_m)},
                   {"share of the base's cells that is believed",
                    fmt::format("{:.1f} %", 100.0 * facts.inlier_share)},
                   {"deviation of those", millimetres(facts.base_stddev_m)}};
  if (facts.passes > 1) {
    section.facts.push_back(
        {"one pass against another (loop closure), before", millimetres(facts.pass_rms_before_m)});
    section.facts.push_back(
        {"one pass against another (loop closure), after", millimetres(facts.pass_rms_after_m)});
  }
  if (facts.left_out_nodes > 0) {
    section.facts.push_back({"one pass of each stretch left out: 90 % intervals held",
                             fmt::format("{:.1f} % of {} nodes", 100.0 * facts.left_out_within_90,
                                         facts.left_out_nodes)});
    section.facts.push_back({"the points' own deviations were multiplied for that by",
                             fmt::format("{:.2f}", facts.noise_factor)});
  }
  const auto& d = facts.typical_stddev;
  section.facts.push_back(
      {"deviation of the poses that is left: x, y, z",
       fmt::format("{:.1f}, {:.1f}, {:.1f} mm", 1e3 * d[0], 1e3 * d[1], 1e3 * d[2])});
  section.facts.push_back(
      {"the same: roll, pitch, yaw",
       fmt::format("{:.3f}, {:.3f}, {:.3f} mrad", 1e3 * d[3], 1e3 * d[4], 1e3 * d[5])});
  for (const std::string& direction : facts.unfixed)
    section.sentences.push_back("The data hardly fixes " + direction +
                                ": the trajectory was left as it is there.");
  return section;
}

/// Cross sections in the middle of each kerb, before and after.
report::ExtraSection kerbs_before_after(const report::TrackReport& page, const crg::Crg& base,
                                        const crg::Crg& refined, const crg::Grid& source) {
  report::ExtraSection section;
  section.title = "Kerbs before and after";
  const RoadFrame before(base), after(refined);
  for (const report::KerbView& kerb : page.kerbs) {
    if (section.plots.size() == 24) break;
    const double u = 0.5 * (kerb.u_begin_m + kerb.u_end_m);
    const auto row =
        static_cast<std::size_t>(std::clamp(std::round((u - after.u_begin_m()) / after.u_step_m()),
                                            0.0, static_cast<double>(after.rows() - 1)));
    report::CrossPlot plot;
    plot.u_m = u, plot.v_m = 0.5 * (kerb.v_begin_m + kerb.v_end_m);
    std::vector<double> base_z, refined_z;
    bool touched = false;
    for (std::size_t j = 0; j < after.columns(); ++j) {
      const double v = after.v_m()[j];
      if (v < kerb.v_begin_m - 1.0 || v > kerb.v_end_m + 1.0) continue;
      touched |= source.at(row, j) == static_cast<float>(NodeSource::lidar);
      plot.at_v_m.push_back(v);
      base_z.push_back(static_cast<double>(before.node(row, j)) + before.z_origin_m());
      refined_z.push_back(static_cast<double>(after.node(row, j)) + after.z_origin_m());
      const double change = refined_z.back() - base_z.back();
      if (std::abs(change) > std::abs(plot.value_m)) plot.value_m = change;
    }
    if (!touched || plot.at_v_m.size() < 3) continue;
    plot.title = fmt::format("{} kerb, u = {:.0f} to {:.0f} m: changed by {:.1f} mm at most here",
                             kerb.side, kerb.u_begin_m, kerb.u_end_m, 1e3 * plot.value_m);
    plot.lines = {{"before", base_z}, {"after", refined_z}};
    section.plots.push_back(std::move(plot));
  }
  section.sentences = {section.plots.empty()
                           ? "No kerb was found where points lie."
                           : "Cross sections in the middle of each kerb that points cover."};
  return section;
}

/// That the road differs from its base is what the points are for, and no remark.
void forget_the_base(report::TrackReport& page) {
  std::erase_if(page.findings,
                [](const report::ReportFinding& finding) { return finding.kind == "deviation"; });
  if (page.findings.empty() && page.verdict == "usable_with_remarks") page.verdict = "usable";
}

}  // namespace

void write_map_report(const base::OutputSet& outputs, const crg::Crg& base, const crg::Crg& refined,
                      const MapResult& result, const MapReport& facts,
                      const std::vector<road::InputFile>& inputs, unsigned threads) {
  road::ReportRequest request;
  request.crg_path = outputs.staged("refined.crg");
  request.shown_folder = std::filesystem::path(outputs.path("refined.crg")).parent_path().string();
  request.against_path = outputs.staged("base.crg");
  request.title = "refined from LiDAR", request.threads = threads;
  for (const road::InputFile& file : inputs)
    request.sources.push_back({file.role, file.path, file.sha256});
  report::TrackReport page = road::make_report(request);
  forget_the_base(page);
  const std::size_t count = page.curves.empty() ? 0 : page.curves.front().values.size();
  const char* const keys[] = {"x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad"};
  const char* const names[] = {"x", "y", "z", "roll", "pitch", "yaw"};
  // More laps than these would fill the page; summary.json has them all.
  const int passes = std::min(static_cast<int>(facts.passes), 4);
  for (std::size_t entry = 0; entry < 6; ++entry)
    for (int pass = 0; pass < passes; ++pass)
      page.curves.push_back({fmt::format("drift_{}_pass_{}", keys[entry], pass + 1),
                             fmt::format("drift taken out of {}, pass {}", names[entry], pass + 1),
                             entry < 3 ? "mm" : "mrad", along(facts, pass, entry, page, count),
                             1e3});
  if (!facts.faults.empty()) page.verdict = "not_usable";
  std::vector<report::ReportFinding> faults;
  for (const std::string& fault : facts.faults) {
    report::ReportFinding& finding = faults.emplace_back();
    finding.kind = "registration", finding.severity = "error", finding.text = fault;
    finding.u_begin_m = page.u_begin_m;
    finding.u_end_m =
        page.u_begin_m + page.u_step_m * static_cast<double>(std::max<std::size_t>(count, 1) - 1);
  }
  constexpr std::size_t kMostPlaces = 20;  // of changed ground; changes.csv has them all
  for (std::size_t k = 0; k < std::min(facts.changed.size(), kMostPlaces); ++k) {
    const ChangedPlace& place = facts.changed[k];
    faults.push_back(
        {"changed_ground", "remark", place.u_begin_m, place.u_end_m, place.v_begin_m, place.v_end_m,
         place.change_m, "m",
         fmt::format("The ground is {:.1f} mm {} after pass {}, over {:.1f} m2",
                     1e3 * std::abs(place.change_m), place.change_m < 0.0 ? "lower" : "higher",
                     place.pass + 1, place.area_m2)});
  }
  page.findings.insert(page.findings.begin(), faults.begin(), faults.end());
  if (page.verdict == "usable" && !faults.empty()) page.verdict = "usable_with_remarks";
  page.lead = lead_of(result, page.u_begin_m, result.grid.u_step_m);
  page.sheet.fields.insert(page.sheet.fields.begin(),
                           completeness_of(page.sheet, result.source, page.u_begin_m));
  page.extra.push_back(coverage(facts));
  if (facts.sections > 0) page.extra.push_back(registration(facts));
  page.extra.push_back(kerbs_before_after(page, base, refined, result.source));
  base::write_file(outputs.staged("report.json"), report::report_json(page));
  if (report::page_available())
    base::write_file(outputs.staged("report.html"), report::report_page(page));
}

}  // namespace cloud
