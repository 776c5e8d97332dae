// Explains why recordings and simulation differ; options in, one call, exit code: 0 done, 1 failed, 2 wrong usage.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <functional>

#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Kerbstone's search for why a simulation and a recording differ", "crgexplain"};
  app.require_subcommand(1);
  std::function<int()> run;

  crgexplain::MapCommand map;
  CLI::App* const map_app = app.add_subcommand("map", "Proposes a mapping of a log's columns to the canonical channels");
  map_app->add_option("log", map.log_path, "CSV with one header line")->required();
  map_app->add_option("-o,--out", map.out_path, "mapping.yaml to write")->required();
  map_app->callback([&] { run = [&] { return crgexplain::map(map); }; });

  crgexplain::RunCommand analysis;
  CLI::App* const run_app = app.add_subcommand("run", "Locates, names and sizes what the simulation lacks");
  run_app->add_option("--track", analysis.track_path, "CRG file of the road")->required();
  run_app->add_option("--vehicle", analysis.vehicle_path, "vehicle.yaml of the simulated car")->required();
  run_app->add_option("--recordings", analysis.recording_paths, "CSV files")->required();
  run_app->add_option("--mapping", analysis.mapping_path, "mapping.yaml; without: canonical columns");
  run_app->add_option("--hold-out", analysis.hold_out, "Laps (from 0, over all recordings) used only to judge the result")->delimiter(',');
  run_app->add_option("--threads", analysis.threads, "0: all; never changes the result")->check(CLI::Range(0, 256));
  run_app->add_option("--nulls", analysis.nulls, "Null replicates that set the thresholds")->check(CLI::Range(100, 100000));
  run_app->add_option("-o,--out", analysis.out_path, "Folder for findings.json and the corrected inputs")->required();
  run_app->callback([&] { run = [&] { return crgexplain::run(analysis); }; });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "crgexplain: %s\n", error.what());
    return 1;
  }
}
