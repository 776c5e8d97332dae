// Explains why recordings and simulation differ; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"

namespace {

void add_threads(CLI::App& app, unsigned& threads) {
  app.add_option("--threads", threads, "0: all; never changes the result")
      ->check(CLI::Range(0, 256));
}

/// Of all commands that compare recordings with a simulation.
void add_inputs(CLI::App& app, crgexplain::RunCommand& inputs) {
  command::add_input(app, "--road", inputs.track_path, "CRG file of the road")->required();
  command::add_input(app, "--grip", inputs.friction_path,
                     "CRG file of the same shape whose heights are grip factors");
  command::add_input(app, "--car", inputs.vehicle_path, "vehicle.yaml of the simulated car")
      ->required();
  command::add_input(
      app, "--mapping", inputs.mapping_path,
      "Which column is which channel (crgexplain map proposes one); without: canonical columns");
  app.add_option(
         "--fuel-kg", inputs.fuel_kg,
         "Fuel at the begin of each log, kg, where none is logged: it burns as vehicle.yaml says")
      ->check(CLI::Range(0.0, explain::kMostFuelKg));
  add_threads(app, inputs.threads);
}

}  // namespace

int main(int argc, char** argv) {
  using command::add_input, command::add_output_file, command::add_output_folder;
  CLI::App app{"Kerbstone's search for why a simulation and a recording differ", "crgexplain"};
  command::Terminal terminal("crgexplain");
  app.require_subcommand(1);
  std::function<int()> run;

  crgexplain::MapCommand map;
  CLI::App* const map_app =
      app.add_subcommand("map", "Proposes a mapping of a log's columns to the canonical channels");
  add_input(*map_app, "log", map.log_path,
            "CSV, MoTeC .ld, Racelogic .vbo, iRacing .ibt, MCAP or rosbag2")
      ->required();
  add_output_file(*map_app, map.out_path, "mapping.yaml to write")->required();
  map_app->add_flag("--list", map.list,
                    "Prints every channel of the log: unit, rate, samples, least and greatest "
                    "value, what it becomes");
  map_app->callback([&] { run = [&] { return crgexplain::map(map, terminal); }; });

  crgexplain::RoadCommand flat;
  CLI::App* const road_app =
      app.add_subcommand("road", "Makes a flat road under the laps of a log, where there is none");
  add_input(*road_app, "log", flat.log_path,
            "Any log with places, or with forward speed and yaw rate")
      ->required();
  add_input(*road_app, "--mapping", flat.mapping_path,
            "Which column is which channel; without: as crgexplain map proposes");
  add_output_file(*road_app, flat.out_path,
                  "CRG file to write; beside it the log with places, where it has none")
      ->required();
  road_app->callback([&] { run = [&] { return crgexplain::flat_road(flat, terminal); }; });

  crgexplain::RunCommand analysis;
  CLI::App* const run_app =
      app.add_subcommand("run", "Locates, names and sizes what the simulation lacks");
  add_inputs(*run_app, analysis);
  add_input(*run_app, "--log", analysis.recording_paths,
            "CSV files with the same columns, one header line each")
      ->required();
  run_app
      ->add_option("--hold-out", analysis.hold_out,
                   "Laps (from 0, over all recordings) used only to judge the result")
      ->delimiter(',')
      ->check(CLI::Range(0, 100000));
  command::hide(run_app->add_option("--nulls", analysis.nulls)
                    ->check(CLI::Range(explain::kLeastNulls, explain::kMostNulls)));
  run_app->add_flag("--skip-simulation", analysis.skip_simulation,
                    "Do not drive the whole simulated car before and after");
  add_output_folder(*run_app, analysis.out_path,
                    "Folder for report.html, findings.json and the corrected inputs")
      ->required();
  run_app->callback([&] { run = [&] { return crgexplain::run(analysis, terminal); }; });

  crgexplain::RunCommand drive;
  CLI::App* const summary_app = app.add_subcommand(
      "summary", "Sums up what a drive says about road, car and sensors, for crgexplain fleet");
  add_inputs(*summary_app, drive);
  add_input(*summary_app, "recording", drive.recording_paths,
            "CSV files of one car and one logger, with the same columns")
      ->required();
  add_output_file(*summary_app, drive.out_path, "Summary to write")->required();
  summary_app->callback([&] { run = [&] { return crgexplain::summary(drive, terminal); }; });

  crgexplain::FleetCommand together;
  CLI::App* const fleet_app = app.add_subcommand(
      "fleet", "Divides what summaries of many drives on one road say between road, cars, sensors");
  add_input(*fleet_app, "summary", together.summary_paths, "Files of crgexplain summary")
      ->required();
  add_threads(*fleet_app, together.threads);
  add_output_folder(*fleet_app, together.out_path, "Folder for report.html and fleet.json")
      ->required();
  fleet_app->callback([&] { run = [&] { return crgexplain::fleet(together, terminal); }; });

  return command::run(app, terminal, argc, argv, [&] { return run(); });
}
