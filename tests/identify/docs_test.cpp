// The example of docs/crgidentify.md runs, and finds what it says.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "recording/table.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "vehicle/magic_formula.h"
#include "vehicle/tyre_file.h"

namespace docs_test {

namespace fs = std::filesystem;

/// The ```sh blocks of a document.
std::string commands_of(const std::string& document) {
  const std::string text = cli::read(fmt::format("{}/docs/{}", places::source(), document));
  std::string script = "set -euo pipefail\n";
  for (std::size_t at = 0; (at = text.find("```sh\n", at)) != std::string::npos;) {
    const std::size_t end = text.find("\n```", at);
    script += text.substr(at + 6, end - at - 5);
    at = end;
  }
  // Two starts in place of eight find the same tyre.
  const std::string of_all = "-o fitted.tir";
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    script.replace(script.find(of_all), of_all.size(), "--starts 2 " + of_all);
  return script;
}

TEST(SlowIdentifyDocs, EveryCommandRuns) {
  const cli::Folder folder;
  for (const char* name : {"tracks", "vehicles"})
    fs::create_symlink(fmt::format("{}/{}", places::source(), name), folder / name);
  cli::write(folder / "all.sh", commands_of("crgidentify.md"));
  const auto folder_of = [](const std::string& program) {
    return fs::path(program).parent_path().string();
  };
  const std::string command =
      fmt::format("cd '{}' && PATH='{}':'{}':'{}':\"$PATH\" bash all.sh > log 2>&1", folder.path(),
                  folder_of(places::crgbuild()), folder_of(places::crgdrive()),
                  folder_of(places::crgidentify()));
  ASSERT_EQ(std::system(command.c_str()), 0) << cli::read(folder / "log");
  const auto fitted = vehicle::read_tyre(folder / "fitted.tir").coefficients;
  const auto truth =
      vehicle::read_tyre(places::source() + "/vehicles/open_wheel/rear.tir").coefficients;
  for (const double tan_alpha : {-0.12, -0.03, 0.07}) {
    const vehicle::TyreInput<double> in{3100.0, 0.0, tan_alpha, 0.02, 30.0, 0.0};
    const double fy_n = vehicle::tyre_forces(truth, in).fy_n;
    EXPECT_NEAR(vehicle::tyre_forces(fitted, in).fy_n, fy_n, 0.002 * std::abs(fy_n));
    const double mz_nm = vehicle::tyre_forces(truth, in).mz_nm;
    EXPECT_NEAR(vehicle::tyre_forces(fitted, in).mz_nm, mz_nm, 0.002 * std::abs(mz_nm));
  }
  EXPECT_THAT(cli::read(folder / "log"), ::testing::HasSubstr("Most useful next: "));
  EXPECT_THAT(cli::read(folder / "fitted.html"), ::testing::HasSubstr("with its 90 % band"));

  // The forces carry the car: what holds it up is its weight and what the air presses it down with.
  const recording::Table forces = recording::read_table(folder / "forces/begin_forces.csv");
  EXPECT_GT(forces.rows(), 300u);
  for (std::size_t k = 0; k < forces.rows(); k += 50) {
    const double load_n = (*forces.find("fz_front_n"))[k] + (*forces.find("fz_rear_n"))[k];
    const double vx_mps = (*forces.find("vx_mps"))[k];
    EXPECT_GT(load_n, 0.8 * 750.0 * 9.81);
    EXPECT_LT(load_n, 1.3 * (750.0 * 9.81 + 0.6 * 2.9 * vx_mps * vx_mps));
    EXPECT_GT((*forces.find("fy_front_sd_n"))[k], 0.0);
  }
  EXPECT_THAT(cli::read(folder / "log"), ::testing::HasSubstr("split by load and reference tyre"));

  // The car whose mass was found first has the forces of the car of the file, though its own file
  // states 4 % more; and the log's own word of the mass leaves less open than the file's prior.
  const recording::Table found =
      recording::read_table(folder / "forces_by_found_mass/begin_forces.csv");
  ASSERT_EQ(found.rows(), forces.rows());
  double sd = 0.0, sd_found = 0.0;
  for (std::size_t k = 0; k < forces.rows(); k += 10) {
    const double as_stated_n = (*forces.find("fz_rear_n"))[k];
    EXPECT_NEAR((*found.find("fz_rear_n"))[k], as_stated_n, 0.01 * as_stated_n);
    sd += (*forces.find("fz_rear_sd_n"))[k];
    sd_found += (*found.find("fz_rear_sd_n"))[k];
  }
  EXPECT_LT(sd_found, 0.7 * sd);

  // The mass is said, and who says the fuel in it: the log before --fuel-kg, else it is assumed.
  const auto mass_with = [&](const std::string& fuel, const std::string& flag) {
    const std::string run = fmt::format(
        "cd '{0}' && awk -F, -v OFS=, '/^#/ {{ next }} /^time_s/ {{ for (i = 1; i <= NF; ++i) if "
        "($i == \"fuel_kg\") c = i }} !/^time_s/ {{ if ($1 > 2) exit; $c = \"{2}\" }} 1' "
        "begin.csv > fuel.csv && '{1}' forces fuel.csv --car vehicles/open_wheel/vehicle.yaml "
        "--road demo/kerbstone-ring_truth.crg --noise-rounds 0 {3} -o fuel > fuel.log 2>&1",
        folder.path(), places::crgidentify(), fuel, flag);
    EXPECT_EQ(WEXITSTATUS(std::system(run.c_str())), 0) << cli::read(folder / "fuel.log");
    EXPECT_THAT(cli::read(folder / "fuel/fuel_forces.csv"), ::testing::HasSubstr("\n# mass "));
    return cli::read(folder / "fuel.log");
  };
  EXPECT_THAT(mass_with("70", "--fuel-kg 5"),
              ::testing::HasSubstr("mass 790.0 kg at the begin: 720.0 by the vehicle file, and "
                                   "70.0 of fuel by the log's fuel_kg"));
  EXPECT_THAT(mass_with("", "--fuel-kg 5"), ::testing::HasSubstr("5.0 of fuel by --fuel-kg"));
  EXPECT_THAT(mass_with("", ""),
              ::testing::HasSubstr("30.0 of fuel by assumption: neither the log nor --fuel-kg"));

  // Loads in kilograms and a speed that is 8 % high: said, and not written.
  const auto not_written = [&](const std::string& part, const std::string& change) {
    const std::string run = fmt::format(
        "cd '{0}' && rm -f wrong.txt && awk -F, -v OFS=, '/^#/ {{ next }} /^time_s/ {{ for (i = 1; "
        "i <= NF; ++i) at[$i] = i }} !/^time_s/ {{ {2} }} 1' lap.csv > wrong.csv && '{1}' {3} "
        "wrong.csv --car vehicles/open_wheel/vehicle.yaml --road demo/kerbstone-ring_truth.crg "
        "-o wrong.txt > wrong.log 2>&1",
        folder.path(), places::crgidentify(), change, part);
    EXPECT_EQ(WEXITSTATUS(std::system(run.c_str())), 3) << part << cli::read(folder / "wrong.log");
    EXPECT_FALSE(fs::exists(folder / "wrong.txt")) << part;
    const std::string said = cli::read(folder / "wrong.log");
    EXPECT_THAT(said, ::testing::HasSubstr("wrong.txt: not written: ")) << part;
    return said;
  };
  for (const char* part : {"mass", "brakes"})
    EXPECT_THAT(not_written(part, "for (c in at) if (c ~ /^fz_/) $at[c] /= 9.80665"),
                ::testing::HasSubstr("the loads weigh"));
  for (const char* part : {"aero", "engine"})
    EXPECT_THAT(not_written(part, "$at[\"vx_mps\"] *= 1.08"),
                ::testing::HasSubstr("a rolling radius +8.0 % off"));

  // Columns in another unit (a ninth of the rows): they fit, and the tyre is another.
  const auto refused = [&](const std::string& change) {
    const std::string mend = fmt::format(
        "cd '{0}' && awk -F, -v OFS=, 'NR > 1 && NR % 9 != 0 {{ next }} NR > 1 {{ {2} }} 1' "
        "bench.csv > off.csv && '{1}' tyre "
        "off.csv --tir vehicles/open_wheel/front.tir --starts 1 -o off.tir > off.log 2>&1",
        folder.path(), places::crgidentify(), change);
    EXPECT_EQ(WEXITSTATUS(std::system(mend.c_str())), 3) << cli::read(folder / "off.log");
    return cli::read(folder / "off.log");
  };
  EXPECT_THAT(refused("$3 *= 7"), ::testing::HasSubstr("slip angles in another unit"));
  const std::string moments = refused("if (NR < 20) $1 = \"\"; $8 *= 10");
  EXPECT_THAT(moments, ::testing::HasSubstr("moments in another unit"));
  EXPECT_THAT(moments, ::testing::HasSubstr("89 rows, 87 looked at, 2 left out"));
}

}  // namespace docs_test
