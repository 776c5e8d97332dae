// Tyres and actuators from measurements; options in, one call, exit code.
#include <functional>

#include "command/program.h"
#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"What a car's parts are, from measurements of them", "crgidentify"};
  app.require_subcommand(1);
  command::Terminal terminal("crgidentify");
  app.option_defaults()->always_capture_default();  // so that --help shows them
  std::function<int()> run;

  crgidentify::TyreCommand tyre;
  CLI::App* const tyre_app =
      app.add_subcommand("tyre", "Fits the Magic Formula to measured forces of a tyre");
  command::add_input(*tyre_app, "bench", tyre.bench_paths,
                     "CSV with fz_n,kappa,alpha_rad,gamma_rad,vx_mps[,pressure_pa], fx_n and/or "
                     "fy_n, in the signs of the reference; several are one measurement")
      ->required();
  command::add_input(*tyre_app, "--reference", tyre.reference_path,
                     "Tyre property file: what is believed where the data say nothing, and all "
                     "that forces do not tell (moments, radius, stiffness)")
      ->required();
  command::add_output_file(*tyre_app, tyre.out_path,
                           "Tyre property file to write: the reference with fitted values")
      ->required();
  command::add_output_file(
      *tyre_app, tyre.plots_path,
      "Page to write, HTML: fitted curves with their bands, and the reference's", "--plots");
  command::add_choice(*tyre_app, "--alpha", tyre.alpha,
                      "tan: tan(alpha) in all formulas; angle: alpha in the pure side force",
                      {"tan", "angle"});
  tyre_app->add_option("--starts", tyre.starts, "Starts of every stage")
      ->check(CLI::Range(1, 1000));
  tyre_app->add_option("--seed", tyre.seed, "Of the starts beside the reference");
  tyre_app->add_option("--threads", tyre.threads, "0: all cores; the result is the same")
      ->check(CLI::Range(0, 1024));
  tyre_app->footer("Example:\n  crgidentify tyre bench.csv --reference old.tir -o new.tir");
  tyre_app->callback([&] { run = [&] { return crgidentify::tyre(tyre, terminal); }; });

  return command::run(app, terminal, argc, argv, [&] { return run(); });
}
