// Drives the simulated car; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"

namespace {

using command::add_choice, command::add_input, command::add_output_file, command::add_output_files,
    command::add_output_folder;

void add_car_settings(CLI::App& app, crgdrive::CarOptions& car) {
  add_input(app, "--setup", car.setup_path, "Setup sheet, read after the vehicle's own");
  app.add_option("--set", car.settings, "group.key=value or term=amplitude; may be repeated");
  add_choice(app, "--contact", car.contact, "In place of the vehicle's",
             {"single-point", "four-point", "strip"});
  command::hide(add_choice(app, "--integrator", car.integrator, "", {"semi-implicit", "explicit"}));
}

void add_step(CLI::App& app, crgdrive::CarOptions& car) {
  app.add_option("--step-s", car.step_s, "Length of a step, s")->check(CLI::Range(1e-5, 0.01));
}

void add_car_options(CLI::App& app, crgdrive::CarOptions& car) {
  add_input(app, "--car", car.vehicle_path, "vehicle.yaml")->required();
  add_car_settings(app, car);
  app.add_flag("--stop-off-road", car.stop_off_road,
               "A wheel over a hole or beside the road ends the run; without: it goes on over the "
               "nearest valid height");
}

void add_live_options(CLI::App& app, crgdrive::LiveOptions& live) {
  app.add_option("--speed-up", live.speed_up,
                 "Keeps the run to the clock: 1 is real time, 2 twice as fast; without: as fast as "
                 "it goes")
      ->check(CLI::Range(1e-3, 1e6));
  app.add_option("--udp", live.udp, "host:port that gets every row of telemetry as JSON");
}

/// The command line that is made: its commands, and what the one that was chosen does.
struct CommandLine {
  CLI::App& app;
  command::Terminal& terminal;
  std::function<int()>& run;
};

void add_tyre(const CommandLine& line, crgdrive::TyreCommand& tyre) {
  CLI::App* const tyre_app =
      line.app.add_subcommand("tyre", "Steady-state forces of a .tir file at given points");
  add_input(*tyre_app, "--tir", tyre.tyre_path, "Tyre property file (Magic Formula 5.2, 6.1, 6.2)")
      ->required();
  add_input(*tyre_app, "--points", tyre.points_path,
            "CSV with fz_n,kappa,alpha_rad,gamma_rad,vx_mps[,pressure_pa][,turn_1pm]");
  add_output_files(*tyre_app, {{"", &tyre.out_path}, {".html", &tyre.plots_path}},
                   "CSV to write: the points and fx_n,fy_n,mz_nm,mx_nm,my_nm; NAME.html: a page of "
                   "curves at four loads, and combined slip");
  command::hide_old(add_output_file(*tyre_app, tyre.plots_path, "", "--plots"), "-o NAME.html");
  add_choice(*tyre_app, "--alpha", tyre.alpha,
             "tan: tan(alpha) in all formulas; angle: alpha in the pure side force",
             {"tan", "angle"});
  tyre_app->add_flag("--mirror", tyre.mirrored, "The tyre on the other side of the car");
  tyre_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::tyre(tyre, line.terminal); }; });
}

void add_parameters(const CommandLine& line) {
  CLI::App* const parameters_app = line.app.add_subcommand(
      "parameters", "Prints every parameter and term of a car: unit, default, bounds, meaning");
  parameters_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::parameters(line.terminal); }; });
}

/// Other cars, by their logs or driven too.
void add_opponents(CLI::App& app, crgdrive::LapCommand& lap) {
  add_input(app, "--opponent", lap.opponents,
            "LOG[@1s] of a car on the same road, whose wake acts, so far ahead at the start; or "
            "VEHICLE.yaml[@15m], driven in the same run by its own driver, each in the other's "
            "slipstream; may be repeated");
  command::hide_old(app.add_option("--opponent-ahead-s", lap.opponent_ahead_s)
                        ->check(CLI::Range(-3600.0, 3600.0)),
                    "--opponent LOG@1s");
  const char* const now = "--opponent VEHICLE.yaml@15m";
  CLI::Option* const second =
      command::hide_old(add_input(app, "--second", lap.second_path, ""), now);
  command::hide_old(add_output_file(app, lap.second_out_path, "", "--second-output"),
                    "-o FIRST -o SECOND")
      ->needs(second);
  command::hide_old(app.add_option("--second-ahead-m", lap.second_ahead_m), now)
      ->needs(second)
      ->check(CLI::Range(0.0, 1000.0));
  command::hide_old(app.add_option("--second-grip-usage", lap.second_grip_usage),
                    "--grip-usage FIRST SECOND")
      ->needs(second)
      ->check(CLI::Range(0.05, 1.2));
}

void add_lap(const CommandLine& line, crgdrive::LapCommand& lap) {
  CLI::App* const lap_app = line.app.add_subcommand("lap", "Laps of a road by the built-in driver");
  add_car_options(*lap_app, lap.car);
  add_step(*lap_app, lap.car);
  add_live_options(*lap_app, lap.live);
  add_input(*lap_app, "--road", lap.track_path, "CRG file of the road")->required();
  add_input(*lap_app, "--grip", lap.friction_path,
            "CRG file of the same shape whose heights are grip factors");
  lap_app
      ->add_option(
          "-o,--output", lap.out_paths,
          "Telemetry to write, CSV; MCAP where the name ends in .mcap; a second time for a "
          "second car")
      ->allow_extra_args(false)
      ->default_str("")
      ->type_name(command::kFileOrDash);
  add_input(*lap_app, "--devices", lap.devices_path,
            "Device configuration: telemetry as sensors measure it; without: ideal");
  add_opponents(*lap_app, lap);
  lap_app->add_option("--laps", lap.laps, "Laps of a closed road")->check(CLI::Range(1, 1000));
  lap_app->add_flag("--standing", lap.standing, "Start from standstill");
  lap_app
      ->add_option("--speed-mps", lap.begin_mps,
                   "Speed at the begin of an open road, m/s; 0: as fast as the engine holds there")
      ->check(CLI::Range(0.0, 110.0));
  lap_app->add_option("--tyre-k", lap.tyre_k, "Tyre temperature at the start, K (cold: 295)")
      ->check(CLI::Range(200.0, 500.0));
  lap_app->add_option("--disc-k", lap.disc_k, "Brake disc temperature at the start, K")
      ->check(CLI::Range(200.0, 1500.0));
  lap_app->add_option("--fuel-kg", lap.fuel_kg, "Fuel at the start, kg")
      ->check(CLI::Range(0.0, 500.0));
  lap_app
      ->add_option("--grip-usage", lap.grip_usage,
                   "Share of the tyres' grip the driver uses [0.75, and less where the car leaves "
                   "its line]; a second number is the second car's")
      ->expected(1, 2)
      ->check(CLI::Range(0.05, 1.2));
  lap_app
      ->add_option("--margin-m", lap.margin_m,
                   "Car's centre to the edge of the road, m [2, and 4 where it leaves its line]")
      ->check(CLI::Range(0.0, 50.0));
  lap_app->add_option("--rate-hz", lap.rate_hz, "Rows of telemetry per second")
      ->check(CLI::Range(0.1, 100000.0));
  lap_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::lap(lap, line.terminal); }; });
}

void add_replay(const CommandLine& line, crgdrive::ReplayCommand& replay) {
  CLI::App* const replay_app =
      line.app.add_subcommand("replay", "Drives a recording's commands and compares");
  add_car_options(*replay_app, replay.car);
  add_step(*replay_app, replay.car);
  add_input(*replay_app, "--road", replay.track_path, "CRG file of the road")->required();
  add_input(*replay_app, "--log", replay.recording_path, "The log: CSV or of any maker")
      ->required();
  add_input(*replay_app, "--mapping", replay.mapping_path,
            "mapping.yaml: which column is which channel; without: by their names");
  add_input(*replay_app, "--grip", replay.friction_path,
            "CRG file of the same shape whose heights are grip factors");
  add_output_folder(*replay_app, replay.out_path,
                    "Folder for errors.csv and replay.csv; NAME.mcap: the telemetry alone, MCAP");
  replay_app
      ->add_option("--window-s", replay.window_s,
                   "The car is put back on the recording this often; 0: only at its begin")
      ->check(CLI::Range(0.0, 100000.0));
  replay_app->add_flag("--closed-path", replay.closed_path,
                       "The driver steers along the recorded path; without: open loop");
  CLI::Option* const hold_speed = replay_app->add_flag(
      "--hold-speed", replay.hold_speed,
      "A push along the car holds its speed to the recording; what it takes is the result");
  replay_app
      ->add_flag("--driver", replay.driver,
                 "The built-in driver follows the recorded path at the recorded speed")
      ->excludes(hold_speed);
  replay_app->add_option("--tyre-k", replay.tyre_k, "Tyre temperature at the begin, K")
      ->check(CLI::Range(200.0, 500.0));
  replay_app->add_option("--disc-k", replay.disc_k, "Brake disc temperature at the begin, K")
      ->check(CLI::Range(200.0, 1500.0));
  replay_app->add_option("--fuel-kg", replay.fuel_kg, "Fuel at the begin, kg")
      ->check(CLI::Range(0.0, 500.0));
  replay_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::replay(replay, line.terminal); }; });
}

void add_report(const CommandLine& line, crgdrive::ReportCommand& report) {
  CLI::App* const report_app =
      line.app.add_subcommand("report", "Draws one or two drives along the road on a page");
  add_input(*report_app, "telemetry", report.telemetry, "Telemetry or recordings")
      ->required()
      ->expected(1, 2);
  add_input(*report_app, "--road", report.track_path, "CRG file of the road")->required();
  add_input(*report_app, "--mapping", report.mapping_path, "mapping.yaml of the first file");
  add_output_file(*report_app, report.out_path, "The page to write, HTML")->required();
  report_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::report(report, line.terminal); }; });
}

void add_manoeuvre(const CommandLine& line, crgdrive::ManoeuvreCommand& manoeuvre) {
  CLI::App* const manoeuvre_app = line.app.add_subcommand("manoeuvre", "A standard manoeuvre");
  add_choice(*manoeuvre_app, "kind", manoeuvre.kind, "Which one",
             {"step-steer", "sine", "chirp", "ramp", "braking", "coast-down", "kerb", "bump",
              "split-friction", "reverse"})
      ->required();
  add_car_options(*manoeuvre_app, manoeuvre.car);
  add_step(*manoeuvre_app, manoeuvre.car);
  add_live_options(*manoeuvre_app, manoeuvre.live);
  add_output_file(*manoeuvre_app, manoeuvre.out_path,
                  "Telemetry to write, CSV; MCAP where the name ends in .mcap");
  add_input(*manoeuvre_app, "--devices", manoeuvre.devices_path,
            "Device configuration: telemetry as sensors measure it; without: ideal");
  manoeuvre_app->add_option("--speed-mps", manoeuvre.speed_mps, "Speed at the start, m/s")
      ->check(CLI::Range(0.0, 120.0));
  manoeuvre_app->add_option("--stop-s", manoeuvre.duration_s, "Where it ends, s")
      ->check(CLI::Range(1.1, 600.0));
  manoeuvre_app->add_option("--steer-rad", manoeuvre.steer_rad, "Amplitude at the road wheels, rad")
      ->check(CLI::Range(-0.6, 0.6));
  manoeuvre_app->add_option("--frequency-hz", manoeuvre.frequency_hz, "Of the sine, Hz")
      ->check(CLI::Range(0.01, 20.0));
  manoeuvre_app
      ->add_option("--pressure-pa", manoeuvre.pressure_pa, "Front brakes, Pa; rear 0.6 of it")
      ->check(CLI::Range(0.0, 2e7));
  manoeuvre_app->add_option("--height-m", manoeuvre.height_m, "Of kerb or bump, m")
      ->check(CLI::Range(0.0, 0.5));
  manoeuvre_app
      ->add_option("--low-grip", manoeuvre.low_grip, "Grip under the left wheels, split friction")
      ->check(CLI::Range(0.01, 2.0));
  manoeuvre_app->add_option("--fuel-kg", manoeuvre.fuel_kg, "Fuel at the start, kg")
      ->check(CLI::Range(0.0, 500.0));
  manoeuvre_app->add_option("--rate-hz", manoeuvre.rate_hz, "Rows of telemetry per second")
      ->check(CLI::Range(0.1, 100000.0));
  manoeuvre_app->callback([&, line] {
    line.run = [&, line] { return crgdrive::manoeuvre(manoeuvre, line.terminal); };
  });
}

void add_timing(const CommandLine& line, crgdrive::TimingCommand& timing) {
  CLI::App* const timing_app = line.app.add_subcommand("timing", "How long a step takes");
  add_car_options(*timing_app, timing.car);
  add_step(*timing_app, timing.car);
  add_input(*timing_app, "--road", timing.track_path,
            "CRG file to drive on; without: a plane (not for strip contact)");
  timing_app->add_option("--stop-s", timing.seconds, "Where the run ends, s of simulated time")
      ->check(CLI::Range(0.01, 3600.0));
  timing_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::timing(timing, line.terminal); }; });
}

void add_poles(const CommandLine& line, crgdrive::PolesCommand& poles) {
  CLI::App* const poles_app =
      line.app.add_subcommand("poles", "Poles of the car rolling straight, and stable steps");
  add_car_options(*poles_app, poles.car);
  poles_app->add_option("--speed-mps", poles.speeds_mps, "Speeds to linearise at, m/s")
      ->check(CLI::Range(0.0, 150.0));
  poles_app->add_option("--step-s", poles.steps_s, "Steps to judge, s")
      ->check(CLI::Range(1e-5, 0.01));
  poles_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::poles(poles, line.terminal); }; });
}

void add_fmu(const CommandLine& line, crgdrive::FmuCommand& fmu) {
  CLI::App* const fmu_app = line.app.add_subcommand(
      "fmu", "The car and a road as a Functional Mock-up Unit that other simulators drive");
  add_input(*fmu_app, "vehicle", fmu.car.vehicle_path, "vehicle.yaml")->required();
  add_input(*fmu_app, "--road", fmu.track_path, "CRG file of the road; without: a level plane");
  add_input(*fmu_app, "--grip", fmu.friction_path,
            "CRG file of the same shape whose heights are grip factors");
  add_car_settings(*fmu_app, fmu.car);
  add_step(*fmu_app, fmu.car);
  add_choice(*fmu_app, "--fmi", fmu.version, "Version of the standard", {"2", "3"});
  add_output_file(*fmu_app, fmu.out_path, "The unit to write, .fmu")->required();
  fmu_app->callback(
      [&, line] { line.run = [&, line] { return crgdrive::fmu(fmu, line.terminal); }; });
}

void add_new(const CommandLine& line, crgdrive::NewCommand& made) {
  CLI::App* const new_app = line.app.add_subcommand(
      "new",
      "A car from ten numbers of its data sheet; what the sheet lacks is guessed and marked");
  CLI::Option* const sheet =
      add_input(*new_app, "sheet", made.sheet_path, "The data sheet, YAML; see --example");
  CLI::Option* const output =
      add_output_folder(*new_app, made.out_path,
                        "Folder for vehicle.yaml, engine.csv and both tyres")
          ->needs(sheet);
  new_app->add_flag("--example", made.example, "Prints a data sheet to begin with")
      ->excludes(sheet);
  new_app->footer(
      "Examples:\n  crgdrive new --example > my_car.yaml\n  crgdrive new my_car.yaml -o my_car\n"
      "  crgdrive lap --car my_car/vehicle.yaml --road road.crg -o lap.csv");
  new_app->callback([&, line, sheet, output] {
    if (!made.example && (sheet->count() == 0 || output->count() == 0))
      throw CLI::ValidationError(
          "new", "give a data sheet and -o FOLDER, or --example to get a sheet to begin with");
    line.run = [&, line] { return crgdrive::new_car(made, line.terminal); };
  });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Kerbstone's simulated car on an OpenCRG road", "crgdrive"};
  app.require_subcommand(1);
  command::Terminal terminal("crgdrive");
  app.option_defaults()->always_capture_default();  // so that --help shows them
  std::function<int()> run;
  const CommandLine line{app, terminal, run};

  crgdrive::TyreCommand tyre;
  add_tyre(line, tyre);
  add_parameters(line);
  crgdrive::LapCommand lap;
  add_lap(line, lap);
  crgdrive::ReplayCommand replay;
  add_replay(line, replay);
  crgdrive::ReportCommand report;
  add_report(line, report);
  crgdrive::ManoeuvreCommand manoeuvre;
  add_manoeuvre(line, manoeuvre);
  crgdrive::TimingCommand timing;
  add_timing(line, timing);
  crgdrive::PolesCommand poles;
  add_poles(line, poles);
  crgdrive::FmuCommand fmu;
  add_fmu(line, fmu);
  crgdrive::NewCommand made;
  add_new(line, made);

  return command::run(app, terminal, argc, argv, [&] { return run(); });
}
