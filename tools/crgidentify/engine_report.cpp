#include "engine_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/one_line.h"
#include "recording/table.h"
#include "report/plot_page.h"

namespace crgidentify {

using identify::EngineCell, identify::EngineFit;

std::string engine_table(const EngineFit& fit) {
  std::string out = "torque, N m (90 % within); empty: not observable\n   rad/s   rpm";
  for (const double open : fit.throttle) out += fmt::format(" {:>13}", fmt::format("{:.4g}", open));
  for (std::size_t k = 0; k < fit.cells.size(); ++k) {
    const EngineCell& cell = fit.cells[k];
    if (k % fit.throttle.size() == 0)
      out += fmt::format("\n{:8.1f} {:5.0f}", cell.engine_radps, cell.engine_radps * 9.5492966);
    out += fmt::format(" {:>13}", cell.unseen.empty() ? fmt::format("{:.1f} ({:.1f})",
                                                                    cell.torque_nm, cell.within_nm)
                                                      : std::string());
  }
  return out + "\n";
}

nlohmann::ordered_json engine_json(const EngineFit& fit) {
  using nlohmann::ordered_json;
  ordered_json out{{"engine_radps", fit.engine_radps},
                   {"throttle", fit.throttle},
                   {"places", ordered_json::array()}};
  for (const EngineCell& cell : fit.cells) {
    ordered_json one{{"engine_radps", cell.engine_radps},
                     {"throttle", cell.throttle},
                     {"vehicle_file_nm", cell.stated_nm},
                     {"gear_s", cell.gear_s}};
    if (cell.unseen.empty()) {
      one["torque_nm"] = cell.torque_nm;
      one["within_90_nm"] = cell.within_nm;
      one["sd_nm"] = cell.sd_nm;
    } else {
      one["not_observable"] = cell.unseen;
    }
    out["places"].push_back(std::move(one));
  }
  return out;
}

std::string engine_map_csv(const EngineFit& fit) {
  const vehicle::Map2 map = engine_map_of(fit);
  std::string out = "engine_radps:throttle";
  for (const double open : map.y) out += fmt::format(",{:.6g}", open);
  for (std::size_t k = 0; k < map.z.size(); ++k)
    out += k % map.y.size() == 0 ? fmt::format("\n{:.6g},{:.6g}", map.x[k / map.y.size()], map.z[k])
                                 : fmt::format(",{:.6g}", map.z[k]);
  return out + "\n";
}

std::string engine_cells_csv(const EngineFit& fit) {
  constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();
  recording::Table out;
  const auto add = [&](std::string name, auto value) {
    std::vector<double> column;
    for (const EngineCell& cell : fit.cells) column.push_back(value(cell));
    out.add(std::move(name), std::move(column));
  };
  add("engine_radps", [](const EngineCell& c) { return c.engine_radps; });
  add("throttle", [](const EngineCell& c) { return c.throttle; });
  add("torque_nm", [](const EngineCell& c) { return c.unseen.empty() ? c.torque_nm : kEmpty; });
  add("within_90_nm", [](const EngineCell& c) { return c.unseen.empty() ? c.within_nm : kEmpty; });
  add("vehicle_file_nm", [](const EngineCell& c) { return c.stated_nm; });
  for (std::size_t g = 0; !fit.cells.empty() && g < fit.cells.front().gear_s.size(); ++g)
    add(fmt::format("gear_{}_s", g + 1), [g](const EngineCell& c) { return c.gear_s[g]; });
  return recording::format_table(out, 6);
}

bool is_any_seen(const EngineFit& fit) {
  return std::any_of(fit.cells.begin(), fit.cells.end(),
                     [](const EngineCell& cell) { return cell.unseen.empty(); });
}

std::string engine_yaml(const EngineFit& fit, const std::string& map_name) {
  const auto unseen = std::count_if(fit.cells.begin(), fit.cells.end(),
                                    [](const EngineCell& c) { return !c.unseen.empty(); });
  const bool is_map = is_any_seen(fit);
  std::string out =
      is_map ? fmt::format(
                   "# Lines for a vehicle file. {} of {} places of the map were not seen: "
                   "they follow their\n# neighbours and the stated map's shape.\n",
                   unseen, fit.cells.size())
             : "# No lines for a vehicle file: no place of the map was seen.\n";
  for (const std::string& doubt : fit.fit.doubts)
    out += fmt::format("# not to be used: {}\n", base::one_line(doubt));
  for (const identify::Found& f : fit.fit.found)
    out += f.unseen.empty()
               ? fmt::format("# {}: {:.4f}, 90 % within {:.4f}\n", f.name, f.value, f.within)
               : fmt::format("# {} not observable: {}\n", f.name, base::one_line(f.unseen));
  if (!is_map) return out;
  return out +
         fmt::format("maps:\n  engine_torque_nm: {}\nparameters:\n  engine.torque: 1\n", map_name);
}

std::string engine_page(const EngineFit& fit, const std::string& title) {
  report::PlotPage page;
  page.title = title;
  for (const std::string& doubt : fit.fit.doubts)
    page.sentences.push_back("Not to be used: " + doubt + ".");
  page.sentences.push_back(
      "Torque of the engine over its speed, one drawing for each throttle of the map; drawn where "
      "it is observable, with its 90 % interval, beside the vehicle file's.");
  for (const std::string& remark : fit.fit.remarks) page.sentences.push_back(remark + ".");
  for (const identify::Found& f : fit.fit.found)
    page.facts.push_back({f.name, f.unseen.empty()
                                      ? fmt::format("{:.4f} within {:.4f}", f.value, f.within)
                                      : "not observable: " + f.unseen});
  const std::size_t n = fit.throttle.size();
  constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t j = 0; j < n; ++j) {
    report::PlotLine found{"found", {}, {}}, low{"90 % low", {}, {}}, high{"90 % high", {}, {}},
        stated{"vehicle file", {}, {}};
    for (std::size_t i = 0; i < fit.engine_radps.size(); ++i) {
      const EngineCell& cell = fit.cells[i * n + j];
      const bool seen = cell.unseen.empty();
      for (auto* line : {&found, &low, &high, &stated}) line->x.push_back(cell.engine_radps);
      found.y.push_back(seen ? cell.torque_nm : kEmpty);
      low.y.push_back(seen ? cell.torque_nm - cell.within_nm : kEmpty);
      high.y.push_back(seen ? cell.torque_nm + cell.within_nm : kEmpty);
      stated.y.push_back(cell.stated_nm);
    }
    page.plots.push_back({fmt::format("Throttle {:.4g}", fit.throttle[j]),
                          "engine, rad/s",
                          "torque, N m",
                          {found, low, high, stated}});
  }
  return report::plot_page(page);
}

}  // namespace crgidentify
