#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>

#include "base/error.h"
#include "base/json_text.h"
#include "base/output_set.h"
#include "base/read_file.h"
#include "base/statistics.h"
#include "base/text_lines.h"
#include "base/write_file.h"
#include "commands.h"
#include "recording/table.h"
#include "tyre_report.h"
#include "vehicle/tyre_file.h"

namespace crgidentify {
namespace {

/// Cornering stiffness over load differs by a factor of 3 from a road tyre to a racing tyre.
constexpr double kOtherUnit = 4.0;
constexpr double kBadly = 0.2;      // of the force's size, noise that is none
constexpr double kManyFar = 0.1;    // share of rows
constexpr double kMaterial = 0.01;  // of the force's size, what is left

/// A tyre that is sane where it was measured and not above gets its last load there: above it the
/// formula stops changing. True when it did.
bool end_at_the_measured(TyreResult& result) {
  auto& tyre = result.fit.tyre;
  const double measured_n = result.conditions.measured.fz_high_n;
  identify::TyreRange above = result.conditions.measured;
  above.fz_low_n = measured_n;
  above.fz_high_n = std::min(tyre.fz_max_n, 2.0 * measured_n);
  if (above.fz_high_n <= measured_n || scan_tyre(tyre, above, result.fit.alpha).empty())
    return false;
  tyre.fz_max_n = measured_n;
  return true;
}

/// At the nominal load, of the upright rolling tyre: dFy/dalpha, dFx/dkappa, dMz/dalpha.
double stiffness_of(const vehicle::TyreCoefficients& tyre, identify::SlipKind kind,
                    vehicle::AlphaConvention alpha) {
  vehicle::TyreInput<double> at{.fz_n = tyre.nominal_load_n, .vx_mps = tyre.nominal_speed_mps};
  const auto rolling = vehicle::tyre_forces(tyre, at, {}, {.alpha = alpha, .moments = false});
  if (kind == identify::SlipKind::kLateral) return std::abs(rolling.cornering_stiffness_npr);
  if (kind == identify::SlipKind::kLongitudinal) return std::abs(rolling.slip_stiffness_n);
  constexpr double kStep = 1e-4;
  at.tan_alpha = kStep;
  const double right_nm = vehicle::tyre_forces(tyre, at, {}, {.alpha = alpha}).mz_nm;
  at.tan_alpha = -kStep;
  const double left_nm = vehicle::tyre_forces(tyre, at, {}, {.alpha = alpha}).mz_nm;
  return std::abs(right_nm - left_nm) / (2.0 * kStep);
}

/// What says that slips or moments are in another unit: a stiffness far from the reference's.
/// Empty: nothing.
std::string another_stiffness(const identify::TyreFit& fit,
                              const vehicle::TyreCoefficients& reference) {
  for (const identify::TyreStage& stage : fit.stages) {
    if (!stage.why_not.empty() || stage.kind == identify::SlipKind::kCombined) continue;
    const double before = stiffness_of(reference, stage.kind, fit.alpha),
                 ratio = stiffness_of(fit.tyre, stage.kind, fit.alpha) / before;
    if (!(before > 0.0) || (ratio < kOtherUnit && ratio > 1.0 / kOtherUnit)) continue;
    const auto [what, column] =
        stage.kind == identify::SlipKind::kLateral
            ? std::pair{"cornering",
                        "slip angles in another unit (alpha_rad is in radians, 0.0175 a degree)"}
        : stage.kind == identify::SlipKind::kLongitudinal
            ? std::pair{"slip", "slip ratios in another unit (kappa is 0.1 for 10 %)"}
            : std::pair{"aligning",
                        "moments in another unit or about another point (mz_nm is in Nm, about the "
                        "contact point)"};
    return fmt::format(
        "the {} stiffness is {:.2g} times the reference's: are {}? If such a tyre it is, give a "
        "reference nearer to it",
        what, ratio, column);
  }
  return {};
}

/// Refuses forces that `crgidentify forces` marked when it wrote them.
void refuse_marked(const std::string& path) {
  constexpr std::string_view kMark = "# not to be used: ";
  const std::string text = base::read_file(path);
  base::Lines lines(text);
  for (std::string_view line; lines.next(line) && line.starts_with('#');)
    if (line.starts_with(kMark))
      throw base::Error(fmt::format(
          "{}:{}: marked as not to be used: {}; mend that and run crgidentify forces again", path,
          lines.number(), line.substr(kMark.size())));
}

/// The tables of forces in a folder, by name.
std::vector<std::string> tables_in(const std::string& folder) {
  std::vector<std::string> out;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().string().ends_with("_forces.csv")) out.push_back(entry.path().string());
  for (const std::string& path : out) {
    base::check_set_is_whole(path);
    refuse_marked(path);
  }
  std::sort(out.begin(), out.end());
  if (out.empty())
    throw base::Error(fmt::format(
        "{}: no table *_forces.csv in it; wanted is a folder that crgidentify forces wrote",
        folder));
  return out;
}

/// Benches and drives; of drives the last quarter of each is kept back.
identify::DriveTyres read_rows(const TyreCommand& command,
                               const vehicle::TyreCoefficients& reference, TyreResult& result,
                               identify::TyreSamples& samples) {
  identify::DriveTyres drives;
  for (const std::string& path : command.bench_paths) {
    if (!std::filesystem::is_directory(path)) {
      if (!command.axle.empty())
        throw command::UsageError(path + ": --axle wants folders that crgidentify forces wrote");
      const recording::Table table = recording::read_table(path);
      result.rows_given += table.rows();
      identify::add_tyre_samples(samples, table, path);
      continue;
    }
    if (command.axle.empty())
      throw command::UsageError(path + ": the forces of a drive want --axle front or rear");
    for (const std::string& one : tables_in(path)) {
      const recording::Table table = recording::read_table(one);
      result.rows_given += 2 * table.rows();
      identify::add_drive_tyres(drives, table, command.axle == "front" ? 0 : 1, reference.left_side,
                                one);
    }
  }
  if (!command.axle.empty()) samples = drives.fit;
  return drives;
}

/// Refuses what misses the measured by a fifth; remarks upon many rows far away.
void judge_what_is_left(const identify::TyreFit& fit, int version, const std::string& path,
                        Terminal& terminal) {
  for (const auto& [name, unit, left] :
       {std::tuple{"fx_n", "N", fit.fx}, {"fy_n", "N", fit.fy}, {"mz_nm", "Nm", fit.mz}}) {
    if (left.rows == 0) continue;
    if (left.noise > kBadly * left.size)
      throw command::NotValid(
          fmt::format("{}: {} is missed by {:.3g} {} where it is {:.3g}: axes or units that are "
                      "not the reference's, or no tyre of this formula",
                      path, name, left.noise, unit, left.size));
    if (left.far > kManyFar && left.rms > kMaterial * left.size)
      terminal.remark(fmt::format(
          "{:.0f} % of {} are further from the fit than four times its noise: wrong "
          "rows, other units, or a tyre that the formula does not describe{}",
          100.0 * left.far, name,
          version == 52 ? "; the reference is Magic Formula 5.2, one of 6.1 describes more" : ""));
  }
}

}  // namespace

int tyre(const TyreCommand& command, Terminal& terminal) {
  if (command.out_path.empty())
    throw command::UsageError("the fitted file is wanted, too: -o NAME.tir");
  terminal.start("reading");
  const std::string text = base::read_file(command.reference_path, vehicle::kLargestTyreBytes);
  const vehicle::TyreFile reference = vehicle::parse_tyre(text, command.reference_path);
  identify::TyreSamples samples;
  TyreResult result;
  const identify::DriveTyres drives = read_rows(command, reference.coefficients, result, samples);
  result.rows_left_out = samples.left_out + drives.held_out.left_out;
  if (samples.rows() == 0)
    throw base::Error(
        fmt::format("{}: none of the {} rows has every condition, a load above zero (fz_n is "
                    "positive) and a force",
                    command.bench_paths.front(), result.rows_given));
  identify::TyreFitOptions options = command.options;
  options.alpha = command.alpha == "angle" ? vehicle::AlphaConvention::kAngle
                                           : vehicle::AlphaConvention::kTangent;
  terminal.start("fitting");
  std::vector<std::string> kept;
  if (command.axle.empty()) {
    result.fit = identify::fit_tyre(samples, reference.coefficients, options);
  } else {
    auto found = identify::fit_drive_tyres(drives, reference.coefficients, options);
    if (!found)
      throw command::NotValid(fmt::format(
          "{}: nothing is written: what was kept back of the drives is described better by the "
          "reference than by any fit to the rest",
          command.reference_path));
    result.fit = std::move(found->fit);
    result.held_fitted = found->fitted;
    result.held_reference = found->reference;
    result.tyre_k = base::median_or(0.0, drives.tyre_k);
    kept = std::move(found->kept);
  }
  terminal.start("judging");
  result.conditions = identify::tyre_conditions(result.fit, samples);
  result.faults = scan_tyre(result.fit.tyre, result.conditions.measured, result.fit.alpha);
  const bool ended = result.faults.empty() && end_at_the_measured(result);

  std::map<std::string, double> values;
  for (const auto& c : result.fit.coefficients) values[c.keyword] = c.value;
  if (result.fit.tyre.fz_max_n != reference.coefficients.fz_max_n)
    values["FZMAX"] = result.fit.tyre.fz_max_n;
  const std::string fitted = vehicle::with_tyre_values(text, values);
  vehicle::parse_tyre(fitted, command.out_path);  // what is written can be read
  base::write_file(command.out_path, fitted);
  if (!command.plots_path.empty())
    base::write_file(command.plots_path,
                     tyre_page(result, samples, drives, reference.coefficients, command.out_path));
  if (terminal.json) {
    auto json = tyre_json(result);
    json["tyre"] = command.out_path;
    json["fz_max_n"] = result.fit.tyre.fz_max_n;
    terminal.print(base::json_text(json));
  } else {
    std::string said = tyre_text(result);
    if (ended)
      said += fmt::format(
          "FZMAX is now {:.0f} N, the greatest load of the data: above it the fitted curves are "
          "none of a tyre\n",
          result.fit.tyre.fz_max_n);
    terminal.print(said + fmt::format("-> {}\n", command.out_path));
  }
  for (const std::string& what : kept) terminal.remark(what);
  judge_what_is_left(result.fit, reference.coefficients.version, command.out_path, terminal);
  if (const std::string off = another_stiffness(result.fit, reference.coefficients); !off.empty())
    throw command::NotValid(fmt::format("{}: {}", command.out_path, off));
  if (!result.faults.empty())
    throw command::NotValid(
        fmt::format("{}: at {:.0f} N {}, within what was measured: look at the rows there, or give "
                    "a reference nearer to this tyre",
                    command.out_path, result.faults.front().fz_n, result.faults.front().what));
  return kOk;
}

}  // namespace crgidentify
