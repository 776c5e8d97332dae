#include "vehicle/vehicle_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "base/write_file.h"
#include "map_file.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "tyre_files.h"
#include "vehicle/error.h"

namespace vehicle_file_test {

namespace fs = std::filesystem;
using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;
using ::testing::AllOf;
using ::testing::HasSubstr;

class VehicleFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("kerbstone_vehicle_file_" + std::to_string(::getpid()) + "_" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
    base::write_file(path("t.tir"), test_tyre_text());
    base::write_file(path("engine.csv"),
                     "engine_radps:throttle,0,1\n0,0,100\n500,-30,300\n900,-50,200\n");
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string text() {
    return "name: small\n"
           "tyres: {front: t.tir, rear: t.tir}\n"
           "maps:\n"
           "  engine_torque_nm: engine.csv\n";
  }
  /// What read_vehicle says about this vehicle.yaml, or "".
  std::string refusal(const std::string& yaml) const {
    base::write_file(path("vehicle.yaml"), yaml);
    try {
      read_vehicle(path("vehicle.yaml"));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

TEST_F(VehicleFile, ReadsAMapOfGripOverTemperature) {
  base::write_file(path("grip.csv"), "tread_k,factor\n300,0.8\n350,1\n");
  EXPECT_EQ(refusal(text() + "  tyre_grip: grip.csv\n"), "");
  const Vehicle v = read_vehicle(path("vehicle.yaml"));
  EXPECT_NEAR(evaluate(v.files.tyre_grip, 325.0), 0.9, 1e-12);
  base::write_file(path("grip.csv"), "tread_k,factor\n300,80\n350,100\n");
  EXPECT_THAT(refusal(text() + "  tyre_grip: grip.csv\n"),
              HasSubstr("tyre grip map: 80, wanted 0 to 2"));
}

TEST_F(VehicleFile, ReadsATurbochargerAndItsMaps) {
  base::write_file(path("flow.csv"),
                   "shaft_radps:pressure_ratio,1,2\n10000,0.2,0.1\n16000,0.3,0.2\n");
  base::write_file(path("efficiency.csv"),
                   "shaft_radps:pressure_ratio,1,2\n10000,0.6,0.7\n16000,0.65,0.75\n");
  const std::string maps = "  compressor_kgps: flow.csv\n  compressor_efficiency: efficiency.csv\n";
  EXPECT_EQ(refusal(text() + maps + "turbo: full\n"), "");
  const Vehicle v = read_vehicle(path("vehicle.yaml"));
  EXPECT_EQ(v.files.turbo, Turbo::kFull);
  EXPECT_EQ(v.files.compressor_kgps.z[3], 0.2);
  EXPECT_EQ(v.files.compressor_efficiency.z[1], 0.7);
  EXPECT_THAT(refusal(text() + "turbo: twin\n"),
              HasSubstr("turbo = 'twin', wanted first_order or full"));
  base::write_file(path("efficiency.csv"), "shaft_radps:pressure_ratio,1,2\n1,0.6,0\n2,0.6,0.7\n");
  EXPECT_THAT(refusal(text() + maps + "turbo: full\n"), HasSubstr("compressor efficiency map"));
  EXPECT_EQ(refusal(text()), "");
  EXPECT_EQ(read_vehicle(path("vehicle.yaml")).files.turbo, Turbo::kFirstOrder);
}

TEST_F(VehicleFile, ReadsTurbineSurgeAndSteeringMaps) {
  base::write_file(path("flow.csv"),
                   "speed_radps_per_root_k:expansion_ratio,1,2\n100,2,9\n600,1,8\n");
  base::write_file(path("efficiency.csv"),
                   "speed_radps_per_root_k:expansion_ratio,1,2\n100,0.5,0.6\n600,0.6,0.7\n");
  base::write_file(path("surge.csv"), "pressure_ratio,flow_kgps\n1,0.01\n3,0.06\n");
  base::write_file(path("rack.csv"), "steer_command_rad,steer_rad\n-5,-0.4\n0,0\n5,0.45\n");
  const std::string maps =
      "  turbine_flow: flow.csv\n  turbine_efficiency: efficiency.csv\n"
      "  compressor_surge_kgps: surge.csv\n  steering: rack.csv\n";
  EXPECT_EQ(refusal(text() + maps + "turbo: full\n"), "");
  const Vehicle v = read_vehicle(path("vehicle.yaml"));
  EXPECT_EQ(v.files.turbine_flow.z[1], 9.0);
  EXPECT_EQ(v.files.turbine_efficiency.z[3], 0.7);
  EXPECT_EQ(v.files.compressor_surge_kgps.y[1], 0.06);
  EXPECT_EQ(v.files.steering.y[2], 0.45);
  EXPECT_THAT(refusal(text() + maps + "parameters: {steering.ratio: 14}\n"),
              HasSubstr("steering.ratio = 14 beside a steering map"));
  base::write_file(path("flow.csv"),
                   "speed_radps_per_root_k:expansion_ratio,1,2\n100,2e-3,9e-3\n600,0,8e-3\n");
  EXPECT_THAT(refusal(text() + maps), HasSubstr("kg sqrt(K)/(s MPa)"));
}

TEST_F(VehicleFile, ReadsACarWithParametersTermsAndSetup) {
  base::write_file(path("setup.txt"),
                   "# camber\nfront.camber_rad = -0.03 # more\n\nrear.toe_rad=+0.001\n"
                   "front.spring_npm = 150000 prior 0.015  # as found\n");
  base::write_file(
      path("vehicle.yaml"),
      text() +
          "contact: four_point\nsetup: setup.txt\n"
          "parameters:\n  chassis.mass_kg: 650\n"
          "  chassis.yaw_inertia_kgm2: {value: 900, prior: 0.2, assumed: true, source: a guess}\n"
          "terms: {wind: 0, tyre_thermal: 0.5}\n");
  const Vehicle v = read_vehicle(path("vehicle.yaml"));
  EXPECT_EQ(v.name, "small");
  EXPECT_EQ(v.contact, Contact::kFourPoint);
  EXPECT_EQ(v.parameters[P::chassis_mass_kg], 650);
  EXPECT_EQ(v.parameters[P::front_camber_rad], -0.03);
  EXPECT_EQ(v.parameters[P::rear_toe_rad], 0.001);
  EXPECT_EQ(v.parameters[P::front_spring_npm], 150000.0);
  EXPECT_EQ(v.prior[static_cast<std::size_t>(P::front_spring_npm)], 0.015);
  EXPECT_EQ(v.parameters[P::rear_spring_npm], default_parameters()[P::rear_spring_npm]);
  const auto yaw = static_cast<std::size_t>(P::chassis_yaw_inertia_kgm2);
  EXPECT_EQ(v.prior[yaw], 0.2);
  EXPECT_TRUE(v.assumed[yaw]);
  EXPECT_TRUE(v.stated[yaw]);
  EXPECT_FALSE(v.stated[static_cast<std::size_t>(P::rear_spring_npm)]);
  EXPECT_EQ(v.terms[Term::wind], 0.0);
  EXPECT_EQ(v.terms[Term::tyre_thermal], 0.5);
  EXPECT_EQ(evaluate(v.files.engine_torque_nm, 250.0, 1.0), 200.0);
  EXPECT_EQ(v.read_files.size(), 5u);
}

TEST_F(VehicleFile, RefusesWithPlaceAndReason) {
  EXPECT_THAT(refusal("name: x\n"), HasSubstr("lacks 'tyres'"));
  EXPECT_THAT(refusal(text() + "colour: red\n"),
              AllOf(HasSubstr("vehicle.yaml:5"), HasSubstr("'colour'")));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.mass: 700}\n"),
              AllOf(HasSubstr("vehicle.yaml:5"), HasSubstr("no parameter 'chassis.mass'"),
                    HasSubstr("chassis.mass_kg")));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.mass_kg: -700}\n"),
              HasSubstr("chassis.mass_kg = -700 kg, wanted 10 to"));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.mass_kg: 700 kg}\n"),
              HasSubstr("finite number"));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.mass_kg: .nan}\n"),
              HasSubstr("finite number"));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.mass_kg: 700, chassis.mass_kg: 600}\n"),
              HasSubstr("twice"));
  EXPECT_THAT(refusal(text() + "parameters: [1, 2]\n"), HasSubstr("not a list of keys"));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.mass_kg: {value: 1, unit: t}}\n"),
              HasSubstr("'unit'"));
  EXPECT_THAT(refusal(text() + "terms: {wind: 2}\n"), HasSubstr("0 to 1"));
  EXPECT_THAT(refusal(text() + "terms: {storm: 1}\n"), HasSubstr("no term 'storm'"));
  EXPECT_THAT(refusal(text() + "contact: two\n"), HasSubstr("single_point"));
  EXPECT_THAT(refusal("name: [\n"), HasSubstr("vehicle.yaml:"));
  EXPECT_THAT(refusal("name: \"a\\\rb\"\n"),
              testing::Not(HasSubstr("\r")));  // an escape that is none
  EXPECT_THAT(refusal("just words\n"), HasSubstr("not a list"));
  EXPECT_THAT(refusal("name: x\ntyres: {front: t.tir, rear: none.tir}\nmaps: {}\n"),
              HasSubstr("none.tir"));
  EXPECT_THAT(
      refusal("name: x\ntyres: {front: " + std::string(5000, 't') + ", rear: t.tir}\nmaps: {}\n"),
      HasSubstr("does not exist"));
  EXPECT_THAT(refusal("name: x\ntyres: {front: t.tir, rear: t.tir}\nmaps: {}\n"),
              HasSubstr("engine_torque_nm"));
  EXPECT_THAT(refusal(text() + "  drag_factor: engine.csv\n"),
              HasSubstr("wanted 'ride_front_m:ride_rear_m'"));
  EXPECT_THAT(refusal(text() + "parameters: {chassis.cog_behind_front_m: 9}\n"),
              HasSubstr("behind the rear axle"));
}

TEST_F(VehicleFile, RefusesBadMapsAndSetups) {
  const auto with_engine = [&](const std::string& csv) {
    base::write_file(path("engine.csv"), csv);
    return refusal(text());
  };
  EXPECT_THAT(with_engine("engine_rpm:throttle,0,1\n0,0,1\n"), HasSubstr("engine_radps:throttle"));
  EXPECT_THAT(with_engine("engine_radps:throttle,0,1\n500,0,1\n100,0,1\n"),
              HasSubstr("must ascend"));
  EXPECT_THAT(with_engine("engine_radps:throttle,1,0\n0,0,1\n100,0,1\n"), HasSubstr("must ascend"));
  EXPECT_THAT(with_engine("engine_radps:throttle,0,x\n0,0,1\n"), HasSubstr("'x'"));
  EXPECT_THAT(with_engine("engine_radps:throttle,0,1\n0,,1\n"), HasSubstr("empty"));
  EXPECT_THAT(with_engine("engine_radps:throttle,0,1\n"), HasSubstr("no values"));
  EXPECT_THAT(with_engine(""), HasSubstr("header"));
  SetUp();
  base::write_file(path("s.txt"), "front.camber_rad = -0.03\nfront.camber_rad = -0.02\n");
  EXPECT_THAT(refusal(text() + "setup: s.txt\n"), AllOf(HasSubstr("s.txt:2"), HasSubstr("twice")));
  base::write_file(path("s.txt"), "front.spring_npm = 150000 prior 0\n");
  EXPECT_THAT(refusal(text() + "setup: s.txt\n"),
              AllOf(HasSubstr("s.txt:1"), HasSubstr("wanted above 0")));
  base::write_file(path("s.txt"), "wind = 1 prior 0.1\n");
  EXPECT_THAT(refusal(text() + "setup: s.txt\n"), HasSubstr("which has no prior"));
  base::write_file(path("s.txt"), "front.spring_npm = 150000 about 0.1\n");
  EXPECT_THAT(refusal(text() + "setup: s.txt\n"), HasSubstr("150000 about 0.1"));
  base::write_file(path("s.txt"), "front.camber_rad -0.03\n");
  EXPECT_THAT(refusal(text() + "setup: s.txt\n"), HasSubstr("name=value"));
}

/// The bytes of a MATLAB 4 file: per variable five little-endian integers, the name, the values by
/// column.
void append_mat4(std::string& bytes, const std::string& name, std::int32_t rows,
                 std::int32_t columns, const std::vector<double>& by_column) {
  const std::int32_t header[5] = {0, rows, columns, 0, static_cast<std::int32_t>(name.size() + 1)};
  bytes.append(reinterpret_cast<const char*>(header), sizeof header);
  bytes.append(name.c_str(), name.size() + 1);
  bytes.append(reinterpret_cast<const char*>(by_column.data()), by_column.size() * sizeof(double));
}

TEST_F(VehicleFile, ReadsMapsFromMatlabFiles) {
  std::string bytes;
  append_mat4(bytes, "engine_radps", 3, 1, {0, 500, 900});
  append_mat4(bytes, "throttle", 1, 2, {0, 1});
  append_mat4(bytes, "torque_nm", 3, 2, {0, -30, -50, 100, 300, 200});
  base::write_file(path("engine.mat"), bytes);
  const std::string yaml =
      "name: m\ntyres: {front: t.tir, rear: t.tir}\nmaps: {engine_torque_nm: engine.mat}\n";
  base::write_file(path("vehicle.yaml"), yaml);
  const Vehicle v = read_vehicle(path("vehicle.yaml"));
  EXPECT_EQ(evaluate(v.files.engine_torque_nm, 250.0, 1.0), 200.0);
  EXPECT_EQ(evaluate(v.files.engine_torque_nm, 900.0, 0.0), -50.0);

  for (const auto& [thousands, machine] : {std::pair{2, "VAX"}, {3, "VAX"}, {4, "Cray"}}) {
    const std::int32_t type = 1000 * thousands;
    base::write_file(
        path("engine.mat"),
        std::string(reinterpret_cast<const char*>(&type), sizeof type) + bytes.substr(4));
    EXPECT_THAT(refusal(yaml), HasSubstr(std::string("engine.mat: numbers of a ") + machine +
                                         ", wanted those of IEEE"));
  }

  base::write_file(path("engine.mat"), "not a MATLAB file");
  EXPECT_THAT(refusal(yaml), HasSubstr("engine.mat"));
  for (std::size_t length = 0; length < bytes.size(); length += 5) {
    base::write_file(path("engine.mat"), bytes.substr(0, length));
    EXPECT_THAT(refusal(yaml), HasSubstr("engine.mat")) << length;
  }
  std::mt19937 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    std::string mutated = bytes;
    for (unsigned i = 1 + random() % 3; i > 0; --i)
      mutated[random() % mutated.size()] = static_cast<char>(random());
    std::ofstream(path("engine.mat"), std::ios::binary) << mutated;
    (void)refusal(yaml);
  }
}

TEST_F(VehicleFile, ReadsMatlabFilesOfLevel5) {
  const std::string corpus = places::source() + "/tests/corpus/map/";
  for (const char* name : {"one.mat", "packed.mat"}) {
    const Map1 map = read_map1(corpus + name, "x", "value");
    EXPECT_EQ(map.x, (std::vector<double>{0.0, 0.5, 1.0})) << name;
    EXPECT_EQ(map.y, (std::vector<double>{1.0, 2.0, 3.0})) << name;
  }
  const Map2 map = read_map2(corpus + "two.mat", "x", "y", "value");
  EXPECT_EQ(map.z, (std::vector<double>{1.0, 4.0, 2.0, 5.0, 3.0, 6.0}));  // by column in the file
  // A name of 2.5 GB, which libmatio reserved and cleared.
  std::string bytes = cli::read(corpus + "one.mat");
  const std::size_t name = bytes.find(std::string("\1\0\0\0\1\0\0\0x", 9));
  ASSERT_NE(name, std::string::npos);
  bytes[name + 7] = '\x97';
  base::write_file(path("large.mat"), bytes);
  EXPECT_THAT([&] { read_map1(path("large.mat"), "x", "value"); },
              testing::ThrowsMessage<Error>(HasSubstr("no variable 'x', or the file is damaged")));
}

TEST_F(VehicleFile, EndsInAnErrorOrACarWhateverTheBytes) {
  const std::string yaml =
      text() + "parameters: {chassis.mass_kg: {value: 700, prior: 0.1}}\nterms: {wind: 1}\n";
  for (std::size_t length = 0; length < yaml.size(); length += 3)
    (void)refusal(yaml.substr(0, length));
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    std::string mutated = yaml;
    for (int i = 0; i < 3; ++i) mutated[random() % mutated.size()] = static_cast<char>(random());
    (void)refusal(mutated);
  }
}

TEST_F(VehicleFile, ReadsTheCarsOfThisProject) {
  for (const char* name : {"open_wheel", "av21"}) {
    const Vehicle v = read_vehicle(places::source() + "/vehicles/" + name + "/vehicle.yaml");
    EXPECT_EQ(v.name, name);
    EXPECT_NO_THROW(make_car(v.files, v.parameters, v.terms, v.contact));
  }
  const Vehicle av21 = read_vehicle(places::source() + "/vehicles/av21/vehicle.yaml");
  EXPECT_EQ(av21.parameters[P::chassis_wheelbase_m], 2.971);
  EXPECT_FALSE(av21.assumed[static_cast<std::size_t>(P::aero_drag_area_m2)]);
  EXPECT_TRUE(av21.assumed[static_cast<std::size_t>(P::chassis_yaw_inertia_kgm2)]);
}

}  // namespace vehicle_file_test
