#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "recording/table.h"
#include "report/plot_page.h"
#include "vehicle/tyre_points.h"

namespace crgdrive {
namespace {

/// What turning about the vertical alone does, at each load.
report::Plot turning(const char* title, const char* y_name, const vehicle::TyreCoefficients& tyre,
                     const vehicle::TyreOptions& options, const std::array<double, 4>& loads_n,
                     double vehicle::TyreForces<double>::*member) {
  constexpr int kPoints = 200;
  constexpr double kMostTurn_1pm = 2.0;
  report::Plot plot{title, "turning over speed, 1/m", y_name, {}};
  for (const double fz_n : loads_n) {
    report::PlotLine line{fmt::format("{:.0f} N", fz_n), {}, {}};
    for (int i = -kPoints; i <= kPoints; ++i) {
      vehicle::TyreInput<double> in;
      in.fz_n = fz_n;
      in.vx_mps = tyre.nominal_speed_mps;
      in.turn_1pm = kMostTurn_1pm * i / kPoints;
      line.x.push_back(in.turn_1pm);
      line.y.push_back(vehicle::tyre_forces(tyre, in, {}, options).*member);
    }
    plot.lines.push_back(std::move(line));
  }
  return plot;
}

/// Curves of pure slip at four loads, and what slip in the other direction leaves of them.
std::string curves(const TyreCommand& command, const vehicle::TyreFile& file,
                   const vehicle::TyreOptions& options) {
  const vehicle::TyreCoefficients& tyre = file.coefficients;
  const double nominal_n = tyre.lfzo * tyre.nominal_load_n;
  // Within the file's range; a file without one reaches 1.6 times its nominal load.
  const double most_n = std::clamp(tyre.fz_max_n, nominal_n, 1.6 * nominal_n);
  const auto forces = [&](double fz_n, double kappa, double alpha_rad) {
    vehicle::TyreInput<double> in;
    in.fz_n = fz_n;
    in.kappa = kappa;
    in.tan_alpha = std::tan(alpha_rad);
    in.vx_mps = tyre.nominal_speed_mps;
    return vehicle::tyre_forces(tyre, in, {}, options);
  };
  using Forces = vehicle::TyreForces<double>;
  constexpr int kPoints = 200;
  constexpr double kMostKappa = 0.25, kMostAlpha_rad = 0.25, kDegree = std::numbers::pi / 180.0;
  const auto line = [&](std::string name, double most, const auto& x_of, const auto& y_of) {
    report::PlotLine out{std::move(name), {}, {}};
    for (int i = -kPoints; i <= kPoints; ++i) {
      const double slip = most * i / kPoints;
      out.x.push_back(x_of(slip));
      out.y.push_back(y_of(slip));
    }
    return out;
  };
  const std::array<double, 4> loads_n{0.25 * most_n, 0.5 * most_n, 0.75 * most_n, most_n};
  const auto at_loads = [&](const char* title, const char* x_name, const char* y_name, bool side,
                            double Forces::*member) {
    report::Plot plot{title, x_name, y_name, {}};
    for (const double fz_n : loads_n)
      plot.lines.push_back(line(
          fmt::format("{:.0f} N", fz_n), side ? kMostAlpha_rad : kMostKappa,
          [&](double slip) { return side ? slip / kDegree : slip; },
          [&](double slip) {
            return side ? forces(fz_n, 0.0, slip).*member : forces(fz_n, slip, 0.0).*member;
          }));
    return plot;
  };
  report::PlotPage page;
  page.title = "Tyre " + command.tyre_path;
  page.facts = {
      {"file", command.tyre_path + "  " + base::sha256_of_file(command.tyre_path).substr(0, 16)},
      {"formula", fmt::format("Magic Formula {:.1f}", tyre.version / 10.0)},
      {"nominal load", fmt::format("{:.0f} N", nominal_n)},
      {"conditions",
       fmt::format("inclination 0, {:.1f} m/s, nominal pressure, {}{}", tyre.nominal_speed_mps,
                   command.alpha, command.mirrored ? ", mirrored" : "")}};
  page.plots.push_back(at_loads("Longitudinal force", "kappa", "N", false, &Forces::fx_n));
  page.plots.push_back(at_loads("Side force", "alpha, degrees", "N", true, &Forces::fy_n));
  page.plots.push_back(at_loads("Aligning moment", "alpha, degrees", "N m", true, &Forces::mz_nm));
  const auto combined = [&](const char* title, const char* x_name, const char* y_name,
                            const auto& y_of) {
    report::Plot plot{title, x_name, y_name, {}};
    for (const double degrees : {0.0, 2.0, 4.0, 8.0})
      plot.lines.push_back(line(
          degrees == 0.0 ? "no side slip" : fmt::format("alpha -{:.0f} degrees", degrees),
          kMostKappa, [](double kappa) { return kappa; },
          [&](double kappa) { return y_of(forces(nominal_n, kappa, -degrees * kDegree)); }));
    return plot;
  };
  page.plots.push_back(combined("Longitudinal force with side slip, nominal load", "kappa", "N",
                                [](const Forces& f) { return f.fx_n; }));
  page.plots.push_back(combined("Side force with longitudinal slip, nominal load", "kappa", "N",
                                [](const Forces& f) { return f.fy_n; }));
  if (vehicle::has_turn_slip(tyre)) {
    page.plots.push_back(
        turning("Side force by turn slip alone", "N", tyre, options, loads_n, &Forces::fy_n));
    page.plots.push_back(turning("Aligning moment by turn slip alone", "N m", tyre, options,
                                 loads_n, &Forces::mz_nm));
  }
  return report::plot_page(page);
}

}  // namespace

int tyre(const TyreCommand& command, Terminal& terminal) {
  if (command.points_path.empty() != command.out_path.empty())
    throw UsageError("--points and -o NAME.csv go together");
  if (command.points_path.empty() && command.plots_path.empty())
    throw UsageError("give --points with -o NAME.csv, or -o NAME.html for a page");
  const vehicle::TyreFile file = vehicle::read_tyre(command.tyre_path);
  vehicle::TyreOptions options;
  options.alpha = command.alpha == "angle" ? vehicle::AlphaConvention::kAngle
                                           : vehicle::AlphaConvention::kTangent;
  options.mirrored = command.mirrored;
  const double version = file.coefficients.version / 10.0;
  std::string text = fmt::format("{}: Magic Formula {:.1f}, {} coefficients at their default\n",
                                 command.tyre_path, version, file.defaulted.size());
  if (!file.unused.empty()) text += fmt::format("not used: {}\n", fmt::join(file.unused, ", "));
  for (const std::string& remark : file.remarks) text += remark + '\n';
  nlohmann::ordered_json numbers = {{"tyre", command.tyre_path},
                                    {"magic_formula", version},
                                    {"defaulted", file.defaulted.size()},
                                    {"unused", file.unused},
                                    {"remarks", file.remarks}};
  if (!command.points_path.empty()) {
    const recording::Table points = recording::read_table(command.points_path);
    const recording::Table forces =
        vehicle::evaluate_tyre(file.coefficients, points, command.points_path, options);
    base::write_file(command.out_path, recording::format_table(forces, 10));
    text += fmt::format("{} points -> {}\n", forces.rows(), command.out_path);
    numbers["points"] = forces.rows();
    numbers["forces"] = command.out_path;
  }
  if (!command.plots_path.empty()) {
    base::write_file(command.plots_path, curves(command, file, options));
    text += fmt::format("curves -> {}\n", command.plots_path);
    numbers["plots"] = command.plots_path;
  }
  terminal.print(terminal.json ? base::json_text(numbers) : text);
  return kOk;
}

}  // namespace crgdrive
