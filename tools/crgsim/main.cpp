// Functional Mock-up Units of anybody, run; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Functional Mock-up Units (FMI 2.0 and 3.0, co-simulation), run", "crgsim"};
  app.require_subcommand(1);
  command::Terminal terminal("crgsim");
  app.option_defaults()->always_capture_default();  // so that --help shows them
  std::function<int()> work;

  crgsim::InfoCommand info;
  CLI::App* const info_app =
      app.add_subcommand("info", "Lists the variables of a unit; runs nothing of it");
  command::add_input(*info_app, "unit", info.unit_path, "The unit, .fmu")->required();
  info_app->footer("Example:\n  crgsim info car.fmu");
  info_app->callback([&] { work = [&] { return crgsim::info(info, terminal); }; });

  crgsim::RunCommand run;
  CLI::App* const run_app = app.add_subcommand(
      "run", "Steps a unit and records its outputs; the unit's code runs in a process of its own");
  command::add_input(*run_app, "unit", run.unit_path, "The unit, .fmu")->required();
  command::add_output_file(*run_app, run.out_path, "CSV to write: time_s and a column per value")
      ->required();
  command::add_input(*run_app, "--inputs", run.inputs_path,
                     "CSV with time_s and columns called like inputs of the unit (name[1] of an "
                     "array); floats run straight between rows, other types are held");
  run_app
      ->add_option("--set", run.starts,
                   "NAME=VALUE: parameters and starts, before the initialisation; values of an "
                   "array with blanks between")
      ->allow_extra_args(false);
  run_app
      ->add_option("--record", run.record,
                   "NAME: a variable to record, of any causality; all outputs when none is named")
      ->allow_extra_args(false);
  const auto add_time = [&](const char* name, double& value, const char* text) {
    run_app->add_option(name, value, text)->default_str("from the unit");
  };
  add_time("--start-s", run.start_s, "Where the time begins");
  add_time("--stop-s", run.stop_s, "Where it ends; 10 s later where the unit does not say");
  add_time("--step-s", run.step_s, "Communication step; 0.001 where the unit does not say");
  run_app->footer(
      "Example:\n  crgsim run car.fmu --inputs controls.csv --set start.speed=20 -o lap.csv");
  run_app->callback([&] { work = [&] { return crgsim::run(run, terminal); }; });

  return command::run(app, terminal, argc, argv, [&] { return work(); });
}
