// What crgdrive says to files and words that it cannot use: one sentence, its own exit code.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <regex>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "test_roads.h"

namespace bad_input_test {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::copy(places::source() + "/vehicles/open_wheel", folder / "car");
    good_ = cli::read(folder / "car/vehicle.yaml");
    crg::write(stadium(), folder / "road.crg", crg::Format::KRBI);
  }
  /// Exit code and what was said on standard error.
  std::pair<int, std::string> run(const std::string& arguments) {
    const int status = std::system(
        fmt::format("cd '{}' && '{}' {} > out 2> err", folder.path(), places::crgdrive(), arguments)
            .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, cli::read(folder / "err")};
  }
  void refuses(const std::string& arguments, const std::string& words, int code = 1) {
    const auto [got, said] = run(arguments);
    EXPECT_EQ(got, code) << arguments << ": " << said;
    EXPECT_THAT(said, HasSubstr(words)) << arguments;
  }
  /// With one thing replaced in a file of the car.
  void refuses_car(const std::string& file, const std::string& what, const std::string& by,
                   const std::string& words) {
    const std::string path = folder / ("car/" + file), whole = cli::read(path);
    cli::write(path, std::regex_replace(whole, std::regex(what), by));
    ASSERT_NE(cli::read(path), whole) << what;
    refuses(kManoeuvre, words);
    cli::write(path, whole);
  }
  static constexpr const char* kManoeuvre =
      "manoeuvre coast-down --car car/vehicle.yaml --stop-s 1.2";
  cli::Folder folder;
  std::string good_;
};

TEST_F(BadInput, OfTheCarIsNamedWithFileAndLine) {
  refuses_car("vehicle.yaml", "setup: setup.txt", "setup: &a [x, *a]",
              "more than 64 lists and tables within each other");  // one that holds itself
  refuses_car("vehicle.yaml", "chassis.mass_kg: 720", "chassis.mass_kg: -720",
              "car/vehicle.yaml:23: chassis.mass_kg = -720 kg, wanted 10 to 100000");
  refuses_car("vehicle.yaml", "chassis.mass_kg: 720", "chassis.mass_kg: 720 kg",
              "'720 kg', wanted a finite number");
  refuses_car("vehicle.yaml", "chassis.mass_kg", "chassis.mass",
              "the nearest is 'chassis.mass_kg'");
  refuses_car("vehicle.yaml", "name: open_wheel", "name: x\ncolour: red", "'colour' is not a key");
  refuses_car("vehicle.yaml", "front.tir", "missing.tir", "car/missing.tir does not exist");
  refuses_car("engine.csv", "\n80,", "\n9999,", "must ascend");
  refuses_car("engine.csv", "\n80,", "\nfast,", "column 'engine_radps:throttle' holds 'fast'");
  refuses_car("front.tir", "FNOMIN", "FNOMINE", "FNOMIN is missing");
  refuses_car("front.tir", "'meter'", "'inch'", "UNLOADED_RADIUS is 0.00");
  refuses_car("front.tir", "\nQDZ1[^]*$", "\n",
              "QDZ1 is missing; the file is incomplete or cut off");
  refuses_car("setup.txt", "=", ":", "car/setup.txt:");
}

TEST_F(BadInput, OfTheRoadAndTheCommandIsNamed) {
  refuses("lap --car car/vehicle.yaml --road car/engine.csv", "there is no road in this file");
  const std::string road = cli::read(folder / "road.crg");
  cli::write(folder / "cut.crg", road.substr(0, road.size() / 2));
  refuses("lap --car car/vehicle.yaml --road cut.crg", "cut.crg");
  refuses("lap --car car/vehicle.yaml --road nowhere.crg", "No such file");
  refuses("lap --car car/vehicle.yaml --road road.crg -o nowhere/lap.csv", "nowhere/lap.csv");
  refuses("lap --car car/vehicle.yaml --road road.crg --margin-m 7.5", "wide");
  refuses("fly", "there is no command 'fly'", 2);
  refuses("manoeuvre spin --car car/vehicle.yaml", "spin not in", 2);
  refuses("tyre --tir car/front.tir", "-o NAME.html", 2);
  refuses(std::string(kManoeuvre) + " --set wind=2", "amplitude of wind = 2, wanted 0 to 1");
  refuses(std::string(kManoeuvre) + " --set chassis.mass_kg=nan", "wanted a finite number");
}

TEST_F(BadInput, OfADriveIsNamed) {
  ASSERT_EQ(run("lap --car car/vehicle.yaml --road road.crg -o lap.csv").first, 0);
  crg::Crg other = straight(500.0, 0.5, [](double, double) { return 0.0; });  // past the stadium
  crg::write(other, folder / "other.crg", crg::Format::KRBI);
  refuses("replay --car car/vehicle.yaml --road other.crg --log lap.csv",
          "lie beside the road other.crg");
  refuses("report lap.csv --road other.crg -o page.html", "lie beside the road other.crg");
  refuses("replay --car car/vehicle.yaml --road road.crg --log car/engine.csv",
          "where the names of columns are wanted");
  // An integration that runs away is told as such, never a speed of 1e6 m/s.
  refuses(
      "manoeuvre kerb --car car/vehicle.yaml --contact strip --speed-mps 100 --height-m 0.5 "
      "--set rear.bump_stop_npm2=1e10 --set front.bump_stop_npm2=1e10 --step-s 0.005",
      "ran away beyond 1000");
}

}  // namespace bad_input_test
