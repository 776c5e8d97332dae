#include "map_report.h"

#include <fmt/format.h>

#include <limits>

#include "report/plot_page.h"

namespace crgidentify {

using identify::FoundMap, identify::MapPlace;
using nlohmann::ordered_json;

const MapWords kEngineWords{
    "engine_radps",
    "throttle",
    "torque_nm",
    "_nm",
    "gear_s",
    true,
    "torque, N m (90 % within); empty: not observable\n   rad/s   rpm",
    13,
    1,
    [](double radps) { return fmt::format("{:8.1f} {:5.0f}", radps, radps * 9.5492966); },
    [](double open) { return fmt::format("{:.4g}", open); },
    "Torque of the engine over its speed, one drawing for each throttle of the map; drawn where it "
    "is observable, with its 90 % interval, beside the vehicle file's.",
    true,
    [](double open) { return fmt::format("Throttle {:.4g}", open); },
    "engine, rad/s",
    "torque, N m"};
const MapWords kPadWords{"pressure_pa",
                         "surface_k",
                         "friction",
                         "",
                         "seconds",
                         false,
                         "friction of the pads (90 % within); empty: not observable\n   bar",
                         15,
                         3,
                         [](double pa) { return fmt::format("{:6.1f}", 1e-5 * pa); },
                         [](double kelvin) { return fmt::format("{:.0f} K", kelvin); },
                         "",
                         false,
                         [](double pa) { return fmt::format("Friction at {:.0f} bar", 1e-5 * pa); },
                         "disc, K",
                         "friction"};

std::string map_table(const MapWords& words, const FoundMap& map) {
  if (map.places.empty()) return {};
  std::string out = words.table;
  for (const double y : map.y) out += fmt::format(" {:>{}}", words.column(y), words.width);
  for (std::size_t k = 0; k < map.places.size(); ++k) {
    const MapPlace& p = map.places[k];
    if (k % map.y.size() == 0) out += "\n" + words.row(p.x);
    out += fmt::format(
        " {:>{}}",
        p.seen() ? fmt::format("{:.{}f} ({:.{}f})", p.value, words.digits, p.within, words.digits)
                 : "",
        words.width);
  }
  return out + "\n";
}

ordered_json map_json(const MapWords& words, const FoundMap& map) {
  ordered_json out{{words.x, map.x}, {words.y, map.y}, {"places", ordered_json::array()}};
  const std::string unit = words.unit;
  for (const MapPlace& p : map.places) {
    ordered_json one{{words.x, p.x}, {words.y, p.y}, {"vehicle_file" + unit, p.stated}};
    if (words.seconds_apart)
      one[words.seconds] = p.seconds;
    else
      one[words.seconds] = p.seconds.front();
    if (p.seen()) {
      one[words.value] = p.value;
      one["within_90" + unit] = p.within;
      one["sd" + unit] = p.sd;
    } else {
      one["not_observable"] = p.unseen;
    }
    out["places"].push_back(std::move(one));
  }
  return out;
}

std::string map_csv(const MapWords& words, const FoundMap& map) {
  std::string out = fmt::format("{}:{}", words.x, words.y);
  for (const double y : map.y) out += fmt::format(",{:.6g}", y);
  for (std::size_t k = 0; k < map.places.size(); ++k) {
    if (k % map.y.size() == 0) out += fmt::format("\n{:.6g}", map.places[k].x);
    out += fmt::format(",{:.6g}", map.places[k].value);
  }
  return out + "\n";
}

std::string map_page(const MapWords& words, const FoundMap& map, const identify::DriveFit& fit,
                     const std::string& title) {
  constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();
  report::PlotPage page;
  page.title = title;
  for (const std::string& doubt : fit.doubts)
    page.sentences.push_back("Not to be used: " + doubt + ".");
  if (*words.about != '\0') page.sentences.emplace_back(words.about);
  for (const std::string& remark : fit.remarks) page.sentences.push_back(remark + ".");
  for (const identify::Found& f : fit.found)
    page.facts.push_back({f.name, f.unseen.empty()
                                      ? fmt::format("{:.5g} within {:.2g}{}", f.value, f.within,
                                                    f.unit == "1" ? "" : " " + f.unit)
                                      : "not observable: " + f.unseen});
  for (const double at : words.drawn_over_x ? map.y : map.x) {
    report::Plot plot{words.plot(at), words.along, words.up, {}};
    for (const char* name : {"found", "90 % low", "90 % high", "vehicle file"})
      plot.lines.push_back({name, {}, {}});
    for (const MapPlace& p : map.places) {
      if ((words.drawn_over_x ? p.y : p.x) != at) continue;
      const double value = p.seen() ? p.value : kEmpty,
                   y[] = {value, value - p.within, value + p.within, p.stated};
      for (std::size_t k = 0; k < 4; ++k) {
        plot.lines[k].x.push_back(words.drawn_over_x ? p.x : p.y);
        plot.lines[k].y.push_back(y[k]);
      }
    }
    if (!plot.lines[0].x.empty()) page.plots.push_back(std::move(plot));
  }
  return report::plot_page(page);
}

}  // namespace crgidentify
