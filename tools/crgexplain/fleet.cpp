#include "explain/fleet.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/read_file.h"
#include "base/write_file.h"
#include "commands.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

using Json = nlohmann::ordered_json;

/// The largest that a summary within its bounds can be.
constexpr std::size_t kLargestSummary = 16u << 20;

Json places(const std::vector<explain::Place>& where) {
  Json out = Json::array();
  for (const explain::Place& w : where)
    out.push_back({{"u_begin_m", w.u_begin_m}, {"u_end_m", w.u_end_m}});
  return out;
}

Json json_of(const explain::FleetFinding& f) {
  Json out{{"mechanism", f.mechanism},
           {"belongs_to", f.belongs_to},
           {"owner", f.owner},
           {"channel", f.channel},
           {"name", f.name},
           {"unit", f.unit},
           {"stated", f.stated},
           {"amount", f.amount},
           {"ci90", {f.low, f.high}},
           {"gain", f.gain},
           {"threshold", f.threshold},
           {"agreeing", f.agreeing},
           {"cannot_be_told_from", f.rivals},
           {"where", places(f.where)},
           {"profile", Json::array()}};
  for (const explain::ProfilePoint& p : f.profile)
    out["profile"].push_back({{"u_m", p.u_m}, {"value", p.value}, {"ci90", p.ci90}});
  return out;
}

Json json_of(const explain::FleetCar& car) {
  Json out{{"name", car.name}, {"sha256", car.sha256},     {"drives", car.drives},
           {"laps", car.laps}, {"driven_s", car.driven_s}, {"parameters", Json::array()}};
  for (const explain::ParameterValue& p : car.parameters)
    out["parameters"].push_back({{"id", p.id},
                                 {"name", p.name},
                                 {"unit", p.unit},
                                 {"stated", p.stated},
                                 {"value", p.value},
                                 {"ci90", {p.low, p.high}},
                                 {"beyond_prior", p.beyond_prior}});
  return out;
}

std::string json_text(const explain::FleetFindings& all) {
  Json out{{"verdict", explain::name_of(all.verdict)},
           {"drives", all.drives},
           {"mechanisms_tested", all.tested},
           {"road_sha256", all.road_sha256},
           {"program", all.program},
           {"findings", Json::array()},
           {"undivided", Json::array()},
           {"own_size", Json::object()},
           {"cars", Json::array()},
           {"remarks", all.remarks}};
  for (const explain::FleetFinding& f : all.findings) out["findings"].push_back(json_of(f));
  for (const explain::Undivided& u : all.undivided)
    out["undivided"].push_back({{"what", u.what},
                                {"between", u.between},
                                {"owner", u.owner},
                                {"gain", u.gain},
                                {"separating_experiment", u.separating}});
  for (std::size_t k = 0; k < explain::kRoadKinds; ++k)
    if (all.seen[k]) out["own_size"][explain::kRoad[k].id] = all.own_size[k];
  for (const explain::FleetCar& car : all.cars) out["cars"].push_back(json_of(car));
  return base::json_text(out);
}

void print(const explain::FleetFindings& all, const std::string& folder, Terminal& terminal) {
  terminal.print(fmt::format("verdict: {}\n", explain::name_of(all.verdict)));
  for (const explain::FleetFinding& f : all.findings) {
    terminal.print(fmt::format("  {}, {}: {}{}: {} = {:.4g} {} [{:.4g}, {:.4g}]\n", f.belongs_to,
                               one_line(f.owner), f.mechanism,
                               f.channel.empty() ? "" : " (" + one_line(f.channel) + ")",
                               one_line(f.name), f.amount, f.unit, f.low, f.high));
    for (const explain::Place& w : f.where)
      terminal.print(fmt::format("    u {:.0f} to {:.0f} m\n", w.u_begin_m, w.u_end_m));
    for (const std::string& rival : f.rivals)
      terminal.print(fmt::format("    cannot be told from {}\n", one_line(rival)));
  }
  for (const explain::Undivided& u : all.undivided)
    terminal.print(fmt::format("  cannot tell, {}: {}: {}; what would: {}\n", one_line(u.owner),
                               one_line(u.what), one_line(u.between), one_line(u.separating)));
  for (const std::string& remark : all.remarks)
    terminal.print(fmt::format("  {}\n", one_line(remark)));
  terminal.print(fmt::format("{0}/report.html, {0}/fleet.json\n", folder));
}

}  // namespace

int fleet(const FleetCommand& command, Terminal& terminal) {
  explain::FleetOptions options;
  options.threads = command.threads;
  options.progress = terminal.progress();
  for (const std::string& path : command.summary_paths)
    for (const char* name : {"fleet.json", "report.html"}) {
      std::error_code none;
      if (std::filesystem::equivalent(path, command.out_path + "/" + name, none))
        throw vehicle::Error(
            fmt::format("{}: is read, and -o {} would overwrite it; choose another folder", path,
                        command.out_path));
    }
  const base::FolderLock lock(command.out_path, "crgexplain fleet");
  const explain::FleetFindings found = explain::explain_fleet(
      command.summary_paths.size(),
      [&](std::size_t k) {
        const std::string& path = command.summary_paths[k];
        return explain::summary_from_bytes(base::read_file(path, kLargestSummary), path);
      },
      options);
  const std::string json = json_text(found);
  base::write_file(command.out_path + "/fleet.json", json);
  base::write_file(command.out_path + "/report.html",
                   explain::fleet_page(found, "Drives of several cars on one road"));
  if (terminal.json)
    terminal.print(json);
  else
    print(found, command.out_path, terminal);
  return kOk;
}

}  // namespace crgexplain
