#include "pad_report.h"

#include <fmt/format.h>

#include <limits>

#include "report/plot_page.h"

namespace crgidentify {

using identify::DriveFit, identify::Found, identify::PadCell, identify::PadMapFit;

std::string pad_table(const PadMapFit& fit) {
  if (fit.cells.empty()) return {};
  std::string out = "friction of the pads (90 % within); empty: not observable\n   bar";
  for (const double kelvin : fit.surface_k)
    out += fmt::format(" {:>15}", fmt::format("{:.0f} K", kelvin));
  for (std::size_t k = 0; k < fit.cells.size(); ++k) {
    const PadCell& cell = fit.cells[k];
    if (k % fit.surface_k.size() == 0) out += fmt::format("\n{:6.1f}", 1e-5 * cell.pressure_pa);
    out += fmt::format(" {:>15}", cell.unseen.empty()
                                      ? fmt::format("{:.3f} ({:.3f})", cell.friction, cell.within)
                                      : std::string());
  }
  return out + "\n";
}

nlohmann::ordered_json pad_json(const PadMapFit& fit) {
  using nlohmann::ordered_json;
  ordered_json out{{"pressure_pa", fit.pressure_pa},
                   {"surface_k", fit.surface_k},
                   {"places", ordered_json::array()},
                   {"remarks", fit.fit.remarks}};
  for (const PadCell& cell : fit.cells) {
    ordered_json one{{"pressure_pa", cell.pressure_pa},
                     {"surface_k", cell.surface_k},
                     {"vehicle_file", cell.stated},
                     {"seconds", cell.seconds}};
    if (cell.unseen.empty()) {
      one["friction"] = cell.friction;
      one["within_90"] = cell.within;
      one["sd"] = cell.sd;
    } else {
      one["not_observable"] = cell.unseen;
    }
    out["places"].push_back(std::move(one));
  }
  return out;
}

std::string pad_map_csv(const PadMapFit& fit) {
  const vehicle::Map2 map = pad_map_of(fit);
  std::string out = "pressure_pa:surface_k";
  for (const double kelvin : map.y) out += fmt::format(",{:.6g}", kelvin);
  for (std::size_t k = 0; k < map.z.size(); ++k)
    out += k % map.y.size() == 0 ? fmt::format("\n{:.6g},{:.6g}", map.x[k / map.y.size()], map.z[k])
                                 : fmt::format(",{:.6g}", map.z[k]);
  return out + "\n";
}

std::string pad_page(const PadMapFit& fit, const DriveFit& brakes, const std::string& title) {
  report::PlotPage page;
  page.title = title;
  for (const std::string& doubt : brakes.doubts)
    page.sentences.push_back("Not to be used: " + doubt + ".");
  for (const std::string& remark : brakes.remarks) page.sentences.push_back(remark + ".");
  for (const Found& f : brakes.found)
    page.facts.push_back({f.name, f.unseen.empty() ? fmt::format("{:.5g} within {:.2g} {}", f.value,
                                                                 f.within, f.unit)
                                                   : "not observable: " + f.unseen});
  const std::size_t n = fit.surface_k.size();
  constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < fit.pressure_pa.size(); ++i) {
    report::PlotLine found{"found", {}, {}}, low{"90 % low", {}, {}}, high{"90 % high", {}, {}},
        stated{"vehicle file", {}, {}};
    for (std::size_t j = 0; j < n; ++j) {
      const PadCell& cell = fit.cells[i * n + j];
      const bool seen = cell.unseen.empty();
      for (auto* line : {&found, &low, &high, &stated}) line->x.push_back(cell.surface_k);
      found.y.push_back(seen ? cell.friction : kEmpty);
      low.y.push_back(seen ? cell.friction - cell.within : kEmpty);
      high.y.push_back(seen ? cell.friction + cell.within : kEmpty);
      stated.y.push_back(cell.stated);
    }
    page.plots.push_back({fmt::format("Friction at {:.0f} bar", 1e-5 * fit.pressure_pa[i]),
                          "disc, K",
                          "friction",
                          {found, low, high, stated}});
  }
  return report::plot_page(page);
}

}  // namespace crgidentify
