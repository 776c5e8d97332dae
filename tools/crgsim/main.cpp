// Functional Mock-up Units of anybody, run; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"
#include "sim/dds.h"

namespace {

/// What the help and --version say about DDS.
std::string about_dds() {
  if (const std::string version = sim::dds_version(); !version.empty())
    return "with Cyclone DDS " + version;
  return "without Cyclone DDS, for which cyclonedds-dev and cyclonedds-tools must be installed "
         "when it is built: --dds is missing";
}

void add_opponents(CLI::App& app, std::vector<std::string>& opponents) {
  app.add_option(
         "--opponent", opponents,
         "DRIVE.csv[@2s|@30m]: another car on the map, by time_s, x_m, y_m of its drive (so "
         "much further than the run), or so far ahead of the car on its path; up to as "
         "many as the unit takes")
      ->allow_extra_args(false);
}

void add_limits(CLI::App& app, sim::UnitLimits& limits) {
  app.add_option("--unit-step-s", limits.step_s,
                 "So long may a call of the unit take by the clock; its start 12 times that")
      ->check(CLI::Range(0.05, 1e6));
  app.add_option("--unit-memory-gb", limits.memory_gb,
                 "So much memory may the unit take, as much for files, a twentieth for what it "
                 "prints")
      ->check(CLI::Range(0.01, 1e4));
  app.add_flag("--trust", limits.trusted,
               "The unit runs with all your rights, in no sandbox and without limits");
}

/// The command line that is made: its commands, and what the one that was chosen does.
struct CommandLine {
  CLI::App& app;
  command::Terminal& terminal;
  std::function<int()>& run;
};

void add_info(const CommandLine& line, crgsim::InfoCommand& info) {
  CLI::App* const info_app =
      line.app.add_subcommand("info", "Lists the variables of a unit; runs nothing of it");
  command::add_input(*info_app, "unit", info.unit_path,
                     "The unit, .fmu, or the vehicle file of a car, .yaml")
      ->required();
  info_app->footer("Example:\n  crgsim info car.fmu");
  info_app->callback(
      [&, line] { line.run = [&, line] { return crgsim::info(info, line.terminal); }; });
}

void add_run(const CommandLine& line, crgsim::RunCommand& run) {
  CLI::App* const run_app = line.app.add_subcommand(
      "run", "Steps a unit and records its outputs; the unit's code runs in a process of its own");
  command::add_input(*run_app, "unit", run.unit_path,
                     "The unit, .fmu, or the vehicle file of a car, .yaml")
      ->required();
  command::add_output_file(*run_app, run.out_path, "CSV to write: time_s and a column per value")
      ->required();
  command::add_input(*run_app, "--road", run.road_path,
                     "Of a vehicle file: the road that the car drives on, .crg; else the plane");
  command::add_input(
      *run_app, "--inputs", run.inputs_path,
      "CSV with time_s and columns called like inputs of the unit (name[1] of an "
      "array) or its tunable parameters; floats run straight between rows, other types are held");
  run_app
      ->add_option("--set", run.starts,
                   "NAME=VALUE: parameters and starts, before the initialisation; values of an "
                   "array with blanks between")
      ->allow_extra_args(false);
  run_app
      ->add_option("--record", run.record,
                   "NAME: a variable to record, of any causality; all outputs when none is named")
      ->allow_extra_args(false);
  run_app
      ->add_option("--every", run.every,
                   "Steps from one row to the next; the last step has one too")
      ->check(CLI::Range(1, 1000000));
  add_opponents(*run_app, run.opponents);
  const auto add_time = [&](const char* name, double& value, const char* text) {
    return run_app->add_option(name, value, text)->default_str("from the unit");
  };
  command::hide(add_time("--start-s", run.start_s, ""));
  add_time("--stop-s", run.stop_s, "Where it ends; 10 s later where the unit does not say");
  add_time("--step-s", run.step_s, "Communication step; 0.001 where the unit does not say");
  add_limits(*run_app, run.limits);
  run_app->footer(
      "Example:\n  crgsim run car.fmu --inputs controls.csv --set start.speed=20 -o lap.csv");
  run_app->callback(
      [&, line] { line.run = [&, line] { return crgsim::run(run, line.terminal); }; });
}

void add_serve(const CommandLine& line, crgsim::ServeCommand& serve) {
  CLI::App* const serve_app = line.app.add_subcommand(
      "serve", "Steps a unit for a program that drives it: commands in, measurements out");
  command::add_input(*serve_app, "unit", serve.unit_path,
                     "The unit, .fmu, or the vehicle file of a car, .yaml")
      ->required();
  command::add_output_file(*serve_app, serve.out_path,
                           "CSV to write: every measurement, with the commands that acted");
  serve_app->add_option("--socket", serve.socket_path, "Path of a Unix datagram socket to make");
  serve_app->add_option("--udp", serve.udp_port, "UDP port of this machine alone, instead")
      ->check(CLI::Range(1, 65535));
  const auto add_names = [&](const char* name, std::vector<std::string>& names, const char* text) {
    return serve_app->add_option(name, names, text)->allow_extra_args(false);
  };
  serve_app->add_flag("--dds", serve.dds,
                      "Topics of ROS 2 instead, on this machine alone: those of --devices, and "
                      "crgsim/command; " +
                          about_dds());
  serve_app->add_option("--domain", serve.domain, "Of DDS, as ROS_DOMAIN_ID")
      ->check(CLI::Range(0, 232));
  add_names("--command", serve.commands,
            "NAME: an input that commands may set; more than once; with --dds beside those of "
            "crgsim/command");
  add_names("--measure", serve.measurements,
            "NAME: what is measured, of the unit or a sensor (also SENSOR.age_s); more than once; "
            "with --dds into the CSV");
  add_names("--record", serve.recorded,
            "NAME: of the unit, as it is, into the CSV alone: nothing that drives sees it");
  command::add_input(*serve_app, "--devices", serve.devices_path,
                     "Sensors and commands of the unit's numbers (docs/sensors.md): what is told "
                     "of them, when, and "
                     "in which unit");
  add_names("--set", serve.starts, "NAME=VALUE: parameters and starts, before the initialisation");
  add_names("--safe", serve.safe,
            "NAME=NUMBER: what a command becomes when commands stay out; else its start");
  command::add_input(*serve_app, "--road", serve.road_path,
                     "The road of the unit, .crg, on which the car of a vehicle file drives: scans "
                     "and edges of the devices look at it, and "
                     "its header says where their positions lie on the Earth");
  command::add_input(*serve_app, "--inputs", serve.inputs_path,
                     "CSV with time_s and columns called like inputs or tunable parameters: what "
                     "follows the unit's clock and nobody commands, as the weather");
  command::add_output_file(*serve_app, serve.sights_path,
                           "Lines of JSON to write: what scans and edges of the devices saw, and "
                           "what the program that drives planned",
                           "--sights");
  add_opponents(*serve_app, serve.opponents);
  serve_app->add_flag("--lockstep", serve.lockstep,
                      "Every command is followed by --every steps and their measurement; else real "
                      "time");
  const auto above_0 = CLI::PositiveNumber;
  serve_app->add_option("--every", serve.every, "Steps from one measurement to the next")
      ->check(CLI::Range(1, 1000000));
  serve_app->add_option("--speed-up", serve.speed_up, "Of real time")->check(above_0);
  serve_app->add_option("--step-s", serve.step_s, "Communication step")->check(above_0);
  serve_app->add_option("--stop-s", serve.stop_s, "Where the run ends")->check(above_0);
  serve_app
      ->add_option("--safe-after-s", serve.safe_after_s,
                   "So long without a command, and the safe input acts; in real time")
      ->check(above_0);
  serve_app
      ->add_option("--patience-s", serve.patience_s,
                   "So long without a command, and the run ends; in lockstep")
      ->check(above_0);
  add_limits(*serve_app, serve.limits);
  serve_app->footer(
      "Example:\n  crgsim serve car.fmu --socket car.sock --lockstep --command input.throttle "
      "--measure car.vx");
  serve_app->callback(
      [&, line] { line.run = [&, line] { return crgsim::serve(serve, line.terminal); }; });
}

void add_race(const CommandLine& line, crgsim::RaceCommand& race) {
  CLI::App* const race_app = line.app.add_subcommand(
      "race", "Steps several units on one road, each for a program of its own that drives it");
  command::add_input(*race_app, "race", race.race_path,
                     "The cars, .yaml: each has a name and, by their names, options of serve")
      ->required();
  command::add_output_folder(*race_app, race.out_path,
                             "Folder for the record of each car, NAME.csv");
  race_app->add_option("--socket", race.socket_path,
                       "Path of Unix datagram sockets to make: PATH.NAME for each car");
  race_app
      ->add_option("--udp", race.udp_port,
                   "UDP port of this machine alone, instead; the next ones for the next cars")
      ->check(CLI::Range(1, 65535));
  race_app->add_flag("--dds", race.dds,
                     "Topics of ROS 2 instead, below NAME/ for each car; " + about_dds());
  race_app->add_option("--domain", race.domain, "Of DDS, as ROS_DOMAIN_ID")
      ->check(CLI::Range(0, 232));
  race_app->add_flag("--sights", race.sights,
                     "Lines of JSON in the folder, NAME.jsonl: what scans and edges saw and what "
                     "was planned");
  race_app->add_flag("--lockstep", race.lockstep,
                     "A step is taken when all cars have their commands; else real time");
  const auto above_0 = CLI::PositiveNumber;
  race_app->add_option("--speed-up", race.speed_up, "Of real time")->check(above_0);
  race_app->add_option("--step-s", race.step_s, "Communication step")->check(above_0);
  race_app->add_option("--stop-s", race.stop_s, "Where the run ends")->check(above_0);
  add_limits(*race_app, race.limits);
  race_app->footer("Example:\n  crgsim race race.yaml --socket s --lockstep -o race");
  race_app->callback(
      [&, line] { line.run = [&, line] { return crgsim::race(race, line.terminal); }; });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Functional Mock-up Units (FMI 2.0 and 3.0, co-simulation), run", "crgsim"};
  app.footer("Built " + about_dds() + ".");
  app.require_subcommand(1);
  command::Terminal terminal("crgsim");
  app.option_defaults()->always_capture_default();  // so that --help shows them
  std::function<int()> work;
  const CommandLine line{app, terminal, work};

  crgsim::InfoCommand info;
  add_info(line, info);
  crgsim::RunCommand run;
  add_run(line, run);
  crgsim::ServeCommand serve;
  add_serve(line, serve);
  crgsim::RaceCommand race;
  add_race(line, race);

  return command::run(app, terminal, argc, argv, [&] { return work(); }, {"", "", about_dds()});
}
