// Drives the simulated car; options in, one call, exit code: 0 done, 1 failed, 2 wrong usage.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Kerbstone's simulated car on an OpenCRG road", "crgdrive"};
  app.require_subcommand(1);

  crgdrive::TyreCommand tyre;
  CLI::App* const tyre_app =
      app.add_subcommand("tyre", "Steady-state forces of a .tir file at given points");
  tyre_app->add_option("--tir", tyre.tyre_path, "Tyre property file (Magic Formula 5.2, 6.1, 6.2)")
      ->required();
  tyre_app
      ->add_option("--points", tyre.points_path,
                   "CSV with fz_n,kappa,alpha_rad,gamma_rad,vx_mps[,pressure_pa]")
      ->required();
  tyre_app
      ->add_option("-o,--out", tyre.out_path,
                   "CSV to write: the points and fx_n,fy_n,mz_nm,mx_nm,my_nm")
      ->required();
  tyre_app
      ->add_option("--alpha", tyre.alpha,
                   "tan: tan(alpha) in all formulas (default); angle: alpha in the pure side force")
      ->check(CLI::IsMember({"tan", "angle"}));
  tyre_app->add_flag("--mirrored", tyre.mirrored, "The tyre on the other side of the car");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (tyre_app->parsed()) crgdrive::tyre(tyre);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "crgdrive: %s\n", error.what());
    return 1;
  }
  return 0;
}
