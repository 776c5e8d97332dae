// Tyres and actuators from measurements, reduced cars from the full one; options in, one call, exit
// code.
#include <functional>
#include <utility>

#include "command/program.h"
#include "commands.h"

namespace {

/// Called with the work of the command that was chosen.
using Work = std::function<int(command::Terminal&)>;
using Chosen = std::function<void(Work)>;

/// A result, and a page about it: NAME.html. `table`, if any: NAME.csv beside both.
CLI::Option* add_output_and_page(CLI::App& app, std::string& out, std::string& page,
                                 const std::string& text, const std::string& about_page,
                                 std::string* table = nullptr) {
  std::vector<command::OutputKind> kinds{{"", &out}, {".html", &page}};
  if (table != nullptr) kinds.push_back({".csv", table, false});
  CLI::Option* const option =
      command::add_output_files(app, kinds, text + "; NAME.html: a page, " + about_page);
  command::hide_old(command::add_output_file(app, page, "", "--plots"), "-o NAME.html");
  return option;
}

/// A command, and what it does when it was chosen.
template <class Command>
CLI::App* add_command(CLI::App& app, const char* name, const std::string& what,
                      const Command& command, int (*work)(const Command&, command::Terminal&),
                      const Chosen& chosen) {
  CLI::App* const out = app.add_subcommand(name, what);
  out->callback(
      [=, &command, &chosen] { chosen([=, &command](auto& t) { return work(command, t); }); });
  return out;
}

template <class Command>
void add_car(CLI::App& app, Command& command, const std::string& about = "vehicle.yaml") {
  command::add_input(app, "--car", command.vehicle_path, about)->required();
  command::add_input(app, "--setup", command.setup_path,
                     "Setup sheet, read after the vehicle's own");
  app.add_option("--set", command.settings,
                 "name=value: a parameter or a term's amplitude; repeatable");
}

void add_mapping(CLI::App& app, std::string& path) {
  command::add_input(app, "--mapping", path,
                     "mapping.yaml: which column is which channel; without: by their names");
}

template <class Number>
void add_number(CLI::App& app, const char* name, Number& number, double low, double high,
                const std::string& text) {
  app.add_option(name, number, text)->check(CLI::Range(low, high));
}

void add_threads(CLI::App& app, unsigned& threads) {
  add_number(app, "--threads", threads, 0, 1024, "0: all cores; the result is the same");
}

/// A number as it was called before.
void add_old_number(CLI::App& app, const char* name, double& number, double low, double high,
                    const std::string& now, double factor = 1.0) {
  command::hide_old(
      app.add_option_function<double>(name, [&number, factor](double x) { number = factor * x; })
          ->check(CLI::Range(low, high)),
      now);
}

void add_tyre(CLI::App& app, crgidentify::TyreCommand& tyre, const Chosen& chosen) {
  CLI::App& tyre_app =
      *add_command(app, "tyre", "Fits the Magic Formula to measured forces and moments of a tyre",
                   tyre, crgidentify::tyre, chosen);
  command::add_input(
      tyre_app, "bench", tyre.bench_paths,
      "CSV with fz_n,kappa,alpha_rad,gamma_rad,vx_mps[,pressure_pa], fx_n and/or fy_n, and mz_nm "
      "if it was measured, in the signs of the reference; several are one measurement. Or folders "
      "that crgidentify forces wrote, with --axle")
      ->required();
  command::add_input(tyre_app, "--tir", tyre.reference_path,
                     "Tyre property file: what is believed where the data say nothing, and all "
                     "that the rows do not tell (other moments, radius, stiffness)")
      ->required();
  add_output_and_page(tyre_app, tyre.out_path, tyre.plots_path,
                      "Tyre property file to write: the reference with fitted values",
                      "fitted curves with their bands, the rows beside them, what is left")
      ->required();
  command::add_choice(tyre_app, "--alpha", tyre.alpha,
                      "tan: tan(alpha) in all formulas; angle: alpha in the pure side force",
                      {"tan", "angle"});
  command::add_choice(tyre_app, "--axle", tyre.axle,
                      "Whose tyres are fitted, from the forces of drives", {"front", "rear"});
  command::hide(tyre_app.add_option("--starts", tyre.options.starts)->check(CLI::Range(1, 1000)));
  tyre_app.add_option("--seed", tyre.options.seed, "Of the starts beside the reference");
  add_threads(tyre_app, tyre.options.threads);
  tyre_app.footer("Example:\n  crgidentify tyre bench.csv --tir old.tir -o new.tir");
}

void add_actuator(CLI::App& app, crgidentify::ActuatorCommand& actuator, const Chosen& chosen) {
  CLI::App& actuator_app = *add_command(
      app, "actuator",
      "Finds an actuator's order and parameters from its recorded command and movement", actuator,
      crgidentify::actuator, chosen);
  command::add_input(actuator_app, "recording", actuator.recording_path, "The log")->required();
  add_mapping(actuator_app, actuator.mapping_path);
  command::add_choice(actuator_app, "--part", actuator.part,
                      "Which one: the channels looked for, and the keys of the setup sheet",
                      {"steering", "throttle", "brake"});
  actuator_app.add_option("--command", actuator.input,
                          "Channel of the command; default steer_command_rad, throttle_command, "
                          "brake_fl_command_pa");
  actuator_app.add_option("--measure", actuator.movement,
                          "Channel of the movement; default steer_rad, throttle, brake_fl_pa");
  command::add_choice(actuator_app, "--order", actuator.order,
                      "Poles, with a zero and play; auto: by cross-validation",
                      {"auto", "0", "1", "2", "3", "1-zero", "2-zero", "3-zero", "0-play", "1-play",
                       "2-play", "3-play", "1-zero-play", "2-zero-play", "3-zero-play"});
  command::hide(
      command::add_choice(actuator_app, "--hold", actuator.hold, "", {"auto", "line", "step"}));
  add_output_and_page(actuator_app, actuator.out_path, actuator.plots_path, "Setup sheet to write",
                      "record and model, step response, amplitude and phase");
  add_threads(actuator_app, actuator.threads);
  actuator_app.footer("Example:\n  crgidentify actuator lap.csv --part brake -o brake.txt");
}

void add_reduce(CLI::App& app, crgidentify::ReduceCommand& reduce, const Chosen& chosen) {
  CLI::App& reduce_app = *add_command(
      app, "reduce", "Makes models for planning and control from the full car, with their errors",
      reduce, crgidentify::reduce, chosen);
  add_car(reduce_app, reduce);
  command::add_input(
      reduce_app, "--road", reduce.track_path,
      "CRG road of the lap that the models are compared on; without: a built-in one");
  command::add_output_file(reduce_app, reduce.out_path,
                           "YAML to write; NAME.h, NAME_axles.csv and NAME_border.csv go beside it")
      ->required();
  add_number(reduce_app, "--fuel-kg", reduce.options.fuel_kg, 0.0, 1000.0, "Fuel on board");
  reduce_app
      .add_option("--speed-mps", reduce.speed_mps, "Lowest and highest speed; 0: the car's own")
      ->expected(2)
      ->check(CLI::Range(0.0, 110.0));
  const char *const speeds = "--speed-mps LOWEST HIGHEST", *const both = "--most-share LAP LIMIT";
  add_old_number(reduce_app, "--least-mps", reduce.speed_mps[0], 5.0, 100.0, speeds);
  add_old_number(reduce_app, "--most-mps", reduce.speed_mps[1], 0.0, 110.0, speeds);
  command::hide(reduce_app.add_option("--speeds", reduce.options.speeds)->check(CLI::Range(2, 20)));
  command::hide(reduce_app.add_option("--slips", reduce.options.slips)->check(CLI::Range(5, 100)));
  reduce_app
      .add_option("--pressing", reduce.options.gravities,
                  "What presses the car on the road, over its gravity: dips and banks above "
                  "1, crests below")
      ->delimiter(',')
      ->check(CLI::Range(0.2, 4.0));
  reduce_app
      .add_option("--most-share", reduce.most_share,
                  "A model is refused whose lateral acceleration on the lap is further off (root "
                  "mean square over the largest), or whose steady-state limit is")
      ->expected(2)
      ->check(CLI::Range(0.0, 1.0));
  add_old_number(reduce_app, "--most-lap-share", reduce.most_share[0], 0.0, 1.0, both);
  add_old_number(reduce_app, "--most-limit-share", reduce.most_share[1], 0.0, 1.0, both);
  add_threads(reduce_app, reduce.options.threads);
  reduce_app.footer(
      "Example:\n  crgidentify reduce --car vehicles/open_wheel/vehicle.yaml -o control.yaml");
  reduce_app.parse_complete_callback([&] {
    if (reduce.speed_mps[0] < 5.0 || reduce.speed_mps[0] > 100.0)
      throw CLI::ValidationError("--speed-mps", "a lowest speed of 5 to 100 wanted");
  });
}

void add_forces(CLI::App& app, crgidentify::ForcesCommand& forces, const Chosen& chosen) {
  CLI::App& forces_app = *add_command(
      app, "forces", "Estimates forces, slips and loads of every wheel of recorded drives", forces,
      crgidentify::forces, chosen);
  command::add_input(forces_app, "recordings", forces.recording_paths, "The logs")->required();
  add_car(forces_app, forces);
  command::add_input(forces_app, "--road", forces.track_path, "CRG road")->required();
  command::add_input(forces_app, "--grip", forces.friction_path,
                     "CRG whose heights are factors on the tyres' grip");
  add_mapping(forces_app, forces.mapping_path);
  command::add_output_folder(forces_app, forces.out_path,
                             "Folder to write LOG_forces.csv of every log to")
      ->required();
  add_number(forces_app, "--fuel-kg", forces.fuel_kg, 0.0, 1000.0,
             "Fuel at the begin, where not recorded; without: 30, and said so");
  add_number(forces_app, "--tyre-k", forces.options.tyre_k, 200.0, 600.0,
             "Tread temperature there");
  add_number(forces_app, "--disc-k", forces.options.disc_k, 200.0, 1500.0,
             "Disc temperature there");
  add_number(forces_app, "--step-s", forces.options.step_s, 1e-4, 4e-3,
             "Of the derivatives, at most");
  add_old_number(forces_app, "--step-ms", forces.options.step_s, 0.1, 4.0, "--step-s, in seconds,",
                 1e-3);
  command::hide(forces_app.add_option("--noise-rounds", forces.options.noise_rounds)
                    ->check(CLI::Range(0, 50)));
  add_threads(forces_app, forces.options.threads);
  forces_app.footer(
      "Example:\n  crgidentify forces lap.csv --car vehicle.yaml --road road.crg -o forces");
}

/// What a command that fits parts of a car writes.
struct DriveOutput {
  const char* text = "Setup sheet to write";
  const char* example = "found.txt";
  const char* about_page = nullptr;  ///< none: it has no page
  std::string* table = nullptr;      ///< none: it has no table
};

/// A command that fits parts of a car to one drive.
CLI::App* add_drive(CLI::App& app, const char* name, const char* what,
                    crgidentify::DriveCommand& drive, const Chosen& chosen,
                    const DriveOutput& output = {}) {
  CLI::App& drive_app = *add_command(app, name, what, drive, crgidentify::drive_part, chosen);
  drive.part = name;
  command::add_input(drive_app, "recording", drive.request.recording_path, "The log")->required();
  add_car(drive_app, drive.request,
          "vehicle.yaml: what the log does not say, and what it is compared with");
  command::add_input(drive_app, "--road", drive.request.road_path,
                     "CRG road: banks, grades, dips and crests; without: az_mps2, else a plane");
  add_mapping(drive_app, drive.request.mapping_path);
  command::add_choice(drive_app, "--frame", drive.accelerations,
                      "Axes of ax_mps2, ay_mps2, az_mps2: of the body, as an accelerometer has "
                      "them, or of the road, as speeds give them",
                      {"body", "road"});
  add_number(drive_app, "--fuel-kg", drive.request.fuel_kg, 0.0, 1000.0,
             "Fuel on board, where not recorded; without: 30, and said so");
  if (output.about_page == nullptr)
    command::add_output_file(drive_app, drive.out_path, output.text);
  else
    add_output_and_page(drive_app, drive.out_path, drive.plots_path, output.text, output.about_page,
                        output.table);
  drive_app.footer(std::string("Example:\n  crgidentify ") + name +
                   " lap.csv --car vehicle.yaml --road road.crg -o " + output.example);
  return &drive_app;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What a car's parts are, from measurements of them", "crgidentify"};
  app.require_subcommand(1);
  command::Terminal terminal("crgidentify");
  app.option_defaults()->always_capture_default();  // so that --help shows them
  Work work;
  const Chosen chosen = [&](Work w) { work = std::move(w); };

  crgidentify::TyreCommand tyre;
  add_tyre(app, tyre, chosen);
  crgidentify::ActuatorCommand actuator;
  add_actuator(app, actuator, chosen);
  crgidentify::ReduceCommand reduce;
  add_reduce(app, reduce, chosen);
  crgidentify::ForcesCommand forces;
  add_forces(app, forces, chosen);
  crgidentify::DriveCommand mass;
  add_drive(app, "mass", "Finds mass, centre of mass and lift areas from wheel loads", mass,
            chosen);
  crgidentify::DriveCommand aero;
  add_drive(app, "aero", "Finds the drag area from coast-downs or open throttle, lift from loads",
            aero, chosen)
      ->add_option("--engine-off", aero.engine_off,
                   "BEGIN,END: from this second of the log to that nothing drives or drags the "
                   "wheels; repeatable");
  crgidentify::DriveCommand suspension;
  add_drive(app, "suspension", "Finds springs and anti-roll bars from wheel loads and travels",
            suspension, chosen);
  crgidentify::DriveCommand brakes;
  CLI::App* const brakes_app = add_drive(
      app, "brakes",
      "Finds the brakes' torques, the pads' friction and the discs' heat from pressures, "
      "temperatures and how the car slows down",
      brakes, chosen,
      {"Setup sheet to write; NAME.csv beside it: the pads' friction as a map for a vehicle file, "
       "where pressures and temperatures show one; the sheet then leaves it out",
       "found.txt", "friction over temperature with its interval", &brakes.pad_map_path});
  command::hide_old(command::add_output_file(*brakes_app, brakes.pad_map_path, "", "--pad-map"),
                    "-o NAME.csv");
  crgidentify::DriveCommand engine;
  add_drive(app, "engine", "Finds the engine's torque map from how the car speeds up", engine,
            chosen,
            {"YAML to write: lines for a vehicle file; NAME_map.csv and NAME_places.csv go beside "
             "it",
             "engine.yaml", "torque over speed with its interval", nullptr});
  return command::run(app, terminal, argc, argv, [&] { return work(terminal); });
}
