// Damaged files of every kind, each read by the real program with the memory of a small machine:
// it ends in time with a code that is documented, says in one line what is wrong, and where it
// succeeds it writes numbers. 3 files of each kind, and in the slow suite 300, 1,000 with
// KERBSTONE_HEAVY=1, any number with KERBSTONE_MUTANTS (docs/dev/fuzzing.md).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "fuzz/mutated.h"
#include "support/gltf_parts.h"
#include "support/mesh_files.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace mutants_test {

namespace fs = std::filesystem;
using cli::Folder;
using support::run_tool, support::ToolRun;
using Words = std::vector<std::string>;

constexpr std::size_t kMostAddresses = std::size_t{3} << 30;
constexpr std::size_t kMostResident = std::size_t{1} << 30;
constexpr double kMostProcessor_s = 10.0;
constexpr unsigned kMostClock_s = 60;  // other programs run beside it

struct Seed {
  std::string ending, bytes;
};
using Seeds = std::vector<Seed>;

std::string corpus(const std::string& folder) {
  return places::source() + "/tests/corpus/" + folder;
}

/// All files of these folders of the corpus, those of one ending where one is given.
Seeds from_corpus(const std::vector<std::string>& folders, const std::string& ending = "") {
  Seeds out;
  std::vector<fs::path> paths;
  for (const std::string& folder : folders)
    for (const auto& entry : fs::directory_iterator(corpus(folder)))
      if (ending.empty() || entry.path().extension() == ending) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  for (const fs::path& path : paths) out.push_back({path.extension(), cli::read(path)});
  return out;
}

void put_mesh(const Folder& folder) {
  cli::write(folder / "track.obj", support::as_obj(support::small_road()));
  cli::write(folder / "track.ply", support::as_ply(support::small_road(), "ascii", "float"));
  cli::write(folder / "a mesh.glb", support::as_glb(support::small_road()));
  cli::write(folder / "points.csv", "u_m,v_m\n1,0\n500,90\n");
  cli::write(folder / "zones.csv", "u_begin_m,u_end_m,v_begin_m,v_end_m,friction\n0,9,-2,2,0.5\n");
}

/// A road, a log that begins on it, and which column of it is which channel.
void put_log(const Folder& folder) {
  put_mesh(folder);
  ASSERT_EQ(cli::crgbuild({"build", folder / "track.obj", "-o", folder / "built", "--name", "road",
                           "--up", "z", "--unit", "m", "--u-step-m", "0.5", "--v-step-m", "0.5",
                           "--no-report"})
                .code,
            0);
  std::string log = "time_s,x_m,y_m,yaw_rad,vx_mps,yaw_rate_radps,ax_mps2,ay_mps2,steer_rad\n";
  for (int i = 0; i < 80; ++i)
    log += fmt::format("{:.2f},{:.2f},0.1,0.01,10,{:.3f},0.1,{:.3f},0.02\n", 0.05 * i, 5 + 0.5 * i,
                       0.01 * (i % 7), 0.1 * (i % 7));
  cli::write(folder / "log.csv", log);
  ASSERT_EQ(run_tool(places::crgexplain(),
                     {"map", folder / "log.csv", "-q", "-o", folder / "mapping.yaml"})
                .code,
            0);
}

void put_car(const Folder& folder) {
  fs::copy(places::source() + "/vehicles/open_wheel", folder / "car", fs::copy_options::recursive);
  cli::write(folder / "fz.csv",
             "fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n3000,0.05,0.02,0,30\n0,-1,1.5,0,0\n");
}

/// The engine's map by its name, whatever its kind.
void put_car_of_a_map(const Folder& folder) {
  put_car(folder);
  for (const char* ending : {".csv", ".mat"}) {
    std::string car = cli::read(folder / "car/vehicle.yaml");
    const std::string name = "engine.csv";
    car.replace(car.find(name), name.size(), std::string("../mutant") + ending);
    cli::write(folder / ("car/of" + std::string(ending) + ".yaml"), car);
  }
}

void put_edges(const Folder& folder) {
  put_mesh(folder);
  std::string right = "lat_deg,lon_deg,h_m\n";
  for (int i = 0; i <= 20; ++i) right += fmt::format("{:.6f},9.250150,100\n", 45.5 + 5e-5 * i);
  cli::write(folder / "right.csv", right);
}

void put_scans(const Folder& folder) {
  const std::string ring = places::source() + "/tracks/kerbstone-ring/circuit.yaml";
  ASSERT_EQ(run_tool(places::lidar2mesh(),
                     {"synth", ring, "-o", folder / "scans", "--u-begin-m", "380", "--u-end-m",
                      "381", "--laps", "1", "--azimuths", "64", "--beams", "8", "--cars", "0"})
                .code,
            0);
  ASSERT_EQ(cli::crgbuild({"crop", folder / "scans/truth.crg", "-o", folder / "base.crg",
                           "--u-begin-m", "370", "--u-end-m", "390"})
                .code,
            0);
}

void put_unit(const Folder& folder) {
  ASSERT_EQ(
      run_tool(places::crgdrive(), {"fmu", places::source() + "/vehicles/open_wheel/vehicle.yaml",
                                    "-o", folder / "unit.fmu"})
          .code,
      0);
}

void put_campaign(const Folder& folder) {
  fs::create_directories(folder / "campaign/state/road");
  cli::write(folder / "campaign/plan.json",
             R"({"name": "one", "jobs": [{"kind": "road", "subject": "mutant"}]})");
}

Seeds meshes() {
  const road::Mesh mesh = support::small_road();
  Seeds out{{".obj", support::as_obj(mesh)},      {".stl", support::as_stl(mesh)},
            {".stl", support::as_text_stl(mesh)}, {".acc", support::as_acc(mesh)},
            {".glb", support::as_glb(mesh)},      {".glb", support::busy_gltf().glb()}};
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    out.push_back({".ply", support::as_ply(mesh, format, "float")});
  return out;
}

/// A left edge for that of put_edges() on the right, in each of the formats.
Seeds edges() {
  std::string csv = "lat_deg,lon_deg,h_m\n", line, gpx, json;
  for (int i = 0; i <= 20; ++i) {
    const double lat = 45.5 + 5e-5 * i;
    csv += fmt::format("{:.6f},9.25,100\n", lat);
    line += fmt::format("9.25,{:.6f},100 ", lat);
    gpx += fmt::format("<trkpt lat=\"{:.6f}\" lon=\"9.25\"><ele>100</ele></trkpt>", lat);
    json += fmt::format("{}[9.25,{:.6f},100]", i == 0 ? "" : ",", lat);
  }
  return {{".csv", csv},
          {".kml",
           "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Placemark><LineString>"
           "<coordinates>" +
               line + "</coordinates></LineString></Placemark></Document></kml>"},
          {".gpx", "<gpx version=\"1.1\"><trk><trkseg>" + gpx + "</trkseg></trk></gpx>"},
          {".geojson", R"({"type":"LineString","coordinates":[)" + json + "]}"}};
}

/// How one kind of file is read. In the commands @ is the folder of the test, @mutant the damaged
/// file and @out what is written.
struct Kind {
  const char* name;
  void (*prepare)(const Folder& folder);
  std::function<Seeds(const Folder& folder)> seeds;
  std::size_t head;
  std::vector<Words> commands;
  const char* mutant = "";  ///< its name; else "mutant" and the ending of the seed
};

const std::vector<Kind> kKinds{
    {"crg",
     put_mesh,
     [](const Folder&) {
       return from_corpus({"crg", "reference"}, ".crg");
     },
     1000,
     {{"crgbuild", "info", "@mutant", "--json"},
      {"crgbuild", "check", "@mutant", "--json"},
      {"crgbuild", "query", "@mutant", "--points", "@/points.csv", "-o", "@out.csv"},
      {"crgbuild", "report", "@mutant", "-o", "@out", "--json"},
      {"crgbuild", "convert", "@mutant", "--format", "LDFI", "-o", "@out.crg"},
      {"crgbuild", "export", "@mutant", "-o", "@out.csv"}}},
    {"mesh",
     put_mesh,
     [](const Folder&) { return meshes(); },
     0,
     {{"crgbuild", "build", "@mutant", "-o", "@out", "--u-step-m", "0.5", "--v-step-m", "0.5",
       "--json"},
      {"crgbuild", "build", "@mutant", "-o", "@out", "--u-step-m", "0.5", "--v-step-m", "0.5",
       "--up", "z", "--unit", "m", "--no-report"},
      {"crgbuild", "objects", "@mutant", "--json"},
      {"crgbuild", "clean", "@mutant", "-o", "@out.obj"}}},
    {"cloud",
     put_mesh,
     [](const Folder&) {
       Seeds all = from_corpus({"las", "laz", "ply", "pcd", "xyz"});
       all.push_back({".csv", "x_m,y_m,z_m\n0,0,0\n1,0,0.1\n0,1,0.2\n1,1,0\n"});
       return all;
     },
     400,
     {{"lidar2mesh", "info", "@mutant", "--json"},
      {"lidar2mesh", "ground", "@mutant", "-o", "@out.ply", "--json"},
      {"lidar2mesh", "tiles", "@mutant", "-o", "@out", "--json"}}},
    {"log",
     put_log,
     [](const Folder& folder) {
       Seeds all = from_corpus({"logs", "recording"});
       all.insert(all.begin(), {".csv", cli::read(folder / "log.csv")});
       return all;
     },
     0,
     {{"crgexplain", "map", "@mutant", "-o", "@out.yaml", "--json"},
      {"crgexplain", "map", "@mutant", "-o", "@out.yaml", "--list", "--json"},
      {"crgdrive", "report", "@mutant", "--road", "@/built/road.crg", "-o", "@out.html",
       "--json"}}},
    {"mapping",
     put_log,
     [](const Folder& folder) {
       Seeds all = from_corpus({"mapping"}, ".yaml");
       for (int i = 0; i < 3; ++i)
         all.insert(all.begin(), {".yaml", cli::read(folder / "mapping.yaml")});
       return all;
     },
     0,
     {{"crgdrive", "report", "@/log.csv", "--road", "@/built/road.crg", "--mapping", "@mutant",
       "-o", "@out.html", "--json"}}},
    {"recipe",
     put_mesh,
     [](const Folder&) {
       Seeds all = from_corpus({"recipe"});
       all.insert(all.begin(), {".yaml",
                                "mesh: track.obj\nup: z\nunit: m\nu_step_m: 0.5\nv_step_m: 0.5\n"
                                "friction: true\nnear_m: [10, 0]\nyaw_deg: 3\n"});
       return all;
     },
     0,
     {{"crgbuild", "build", "@mutant", "-o", "@out", "--no-report", "--json"}}},
    {"circuit",
     put_mesh,
     [](const Folder&) { return from_corpus({"circuit"}); },
     0,
     {{"crgbuild", "synth", "@mutant", "-o", "@out", "--step-m", "10", "--json"}}},
    {"vehicle",
     put_car,
     [](const Folder& folder) {
       return Seeds{{".yaml", cli::read(folder / "car/vehicle.yaml")}};
     },
     0,
     {{"crgdrive", "poles", "--speed-mps", "20", "--car", "@mutant", "--json"},
      {"crgdrive", "manoeuvre", "bump", "--car", "@mutant", "--stop-s", "1.2", "-o", "@out.csv",
       "--json"}},
     "car/mutant.yaml"},
    {"setup",
     put_car,
     [](const Folder& folder) {
       return Seeds{{".txt", cli::read(folder / "car/setup.txt")}};
     },
     0,
     {{"crgdrive", "poles", "--speed-mps", "20", "--car", "@/car/vehicle.yaml", "--setup",
       "@mutant", "--json"}}},
    {"tir",
     put_car,
     [](const Folder&) { return from_corpus({"tir"}); },
     0,
     {{"crgdrive", "tyre", "--tir", "@mutant", "-o", "@out.html", "--json"},
      {"crgdrive", "tyre", "--tir", "@mutant", "--points", "@/fz.csv", "-o", "@out.csv"}}},
    {"map",
     put_car_of_a_map,
     [](const Folder& folder) {
       Seeds all = from_corpus({"map"});
       for (int i = 0; i < 3; ++i)
         all.insert(all.begin(), {".csv", cli::read(folder / "car/engine.csv")});
       return all;
     },
     0,
     {{"crgdrive", "poles", "--speed-mps", "20", "--car", "@/car/of@ending.yaml", "--json"}}},
    {"trajectory",
     put_scans,
     [](const Folder& folder) {
       Seeds all = from_corpus({"trajectory"});
       all.insert(all.begin(), {".csv", cli::read(folder / "scans/truth_trajectory.csv")});
       return all;
     },
     0,
     {{"lidar2mesh", "split", "@/scans", "--trajectory", "@mutant", "--road", "@/base.crg",
       "--tiles", "1", "-o", "@out", "--json"}}},
    {"summary",
     put_mesh,
     [](const Folder&) { return from_corpus({"summary"}); },
     0,
     {{"crgexplain", "fleet", "@mutant", "-o", "@out", "--json"}}},
    {"unit",
     put_unit,
     [](const Folder& folder) {
       // The list of a zip stands at its end, the text of the unit before the long program.
       return Seeds{{".fmu", cli::read(folder / "unit.fmu")}};
     },
     4000,
     {{"crgsim", "info", "@mutant", "--json"}}},
    {"edge",
     put_edges,
     [](const Folder&) { return edges(); },
     0,
     {{"crgbuild", "from-edges", "@mutant", "@/right.csv", "-o", "@out", "--json"}}},
    {"guide",
     put_edges,
     [](const Folder&) {
       Seeds all = from_corpus({"guide"});
       all.insert(all.begin(), {".csv", "x_m,y_m\n0,0\n50,0.5\n100,0\n150,-0.5\n200,0\n"});
       return all;
     },
     0,
     {{"crgbuild", "build", "@/track.obj", "--guide", "@mutant", "--no-report", "-o", "@out",
       "--u-step-m", "0.5", "--v-step-m", "0.5", "--json"}}},
    {"campaign",
     put_campaign,
     [](const Folder&) { return from_corpus({"campaign"}); },
     0,
     {{"kerbstone", "collect", "@/campaign", "--json"}},
     "campaign/state/road/mutant.json"},
};

bool is_no_number(std::string cell) {
  std::transform(cell.begin(), cell.end(), cell.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (cell.starts_with("-")) cell.erase(0, 1);
  return cell == "nan" || cell == "inf" || cell == "infinity";
}

/// "nan" and "inf" are no JSON; as text neither is a number.
void expect_numbers_in_json(const std::string& text, const std::string& what) {
  EXPECT_TRUE(nlohmann::json::accept(text)) << what << ": " << text.substr(0, 300);
}

void expect_numbers_in_csv(const std::string& text, const std::string& what) {
  std::istringstream lines(text);
  std::string line, cell;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream cells(line);
    while (std::getline(cells, cell, ','))
      EXPECT_FALSE(is_no_number(cell)) << what << ":" << number << ": " << line;
  }
}

void expect_numbers(const fs::path& path) {
  if (fs::is_directory(path))
    for (const auto& entry : fs::recursive_directory_iterator(path)) {
      if (!entry.is_directory()) expect_numbers(entry.path());
    }
  else if (path.extension() == ".json")
    expect_numbers_in_json(cli::read(path), path);
  else if (path.extension() == ".csv")
    expect_numbers_in_csv(cli::read(path), path);
}

class Mutants : public ::testing::TestWithParam<Kind> {
 protected:
  void run(std::size_t count) {
    const Kind& kind = GetParam();
    kind.prepare(folder_);
    if (HasFatalFailure()) return;
    const Seeds seeds = kind.seeds(folder_);
    for (const Words& command : kind.commands)
      EXPECT_TRUE(kind.name == std::string("summary") ||  // one wrong byte and its check refuses it
                  std::any_of(seeds.begin(), seeds.end(),
                              [&](const Seed& seed) {
                                const int code = read_file(seed.ending, seed.bytes, command);
                                return code == 0 || code == 3;
                              }))
          << command[1] << " reads no undamaged file";
    std::size_t read = 0;
    for (std::size_t k = 0; k < count; ++k) {
      std::mt19937_64 generator(k + 1);
      const Seed& seed = seeds[k % seeds.size()];
      const std::string bytes = fuzz::mutated(seed.bytes, generator, kind.head);
      const int code =
          read_file(seed.ending, bytes, kind.commands[generator() % kind.commands.size()]);
      read += code == 0 || code == 3 ? 1 : 0;
      if (!HasFailure()) continue;
      const std::string kept = fmt::format("{}/mutant_{}_{}{}", fs::temp_directory_path().string(),
                                           kind.name, k, seed.ending);
      cli::write(kept, bytes);
      ADD_FAILURE() << "the file is " << kept;
      break;
    }
    std::printf("%zu files, of which %zu were read; at most %.1f s of a processor, %zu MB\n", count,
                read, most_s_, most_resident_ >> 20);
  }

 private:
  std::string placed(const std::string& word, const std::string& mutant,
                     const std::string& ending) const {
    if (word == "@mutant") return mutant;
    if (word.starts_with("@out")) return folder_ / word.substr(1);
    if (!word.starts_with("@/")) return word;
    std::string out = folder_ / word.substr(2);
    if (const std::size_t at = out.find("@ending"); at != std::string::npos)
      out.replace(at, 7, ending);
    return out;
  }
  void clear_outputs() const {
    for (const char* name :
         {"out", "out.csv", "out.crg", "out.obj", "out.ply", "out.yaml", "out.html"})
      fs::remove_all(folder_ / name);
  }
  int read_file(const std::string& ending, const std::string& bytes, const Words& command) {
    const Kind& kind = GetParam();
    const std::string mutant = folder_ / (*kind.mutant != '\0' ? kind.mutant : "mutant" + ending);
    cli::write(mutant, bytes);
    clear_outputs();
    Words words;
    std::string program, said;
    for (const support::Tool& tool : support::all_tools())
      if (tool.name == command.front()) program = tool.path;
    for (std::size_t i = 1; i < command.size(); ++i)
      words.push_back(placed(command[i], mutant, ending));
    for (const std::string& word : command) said += word + " ";
    SCOPED_TRACE(said);
    const ToolRun ran = run_tool(
        program, words, {.most_address_bytes = kMostAddresses, .most_clock_s = kMostClock_s});
    expect_well_ended(ran);
    if (ran.code != 0) return ran.code;
    if (std::find(words.begin(), words.end(), "--json") != words.end())
      expect_numbers_in_json(ran.out, "standard output");
    for (const char* name : {"out", "out.csv"})
      if (fs::exists(folder_ / name)) expect_numbers(folder_ / name);
    return 0;
  }
  void expect_well_ended(const ToolRun& ran) {
    EXPECT_TRUE(ran.code >= 0 && ran.code <= 3) << "exit code " << ran.code << ": " << ran.err;
    EXPECT_LE(ran.processor_s, kMostProcessor_s);
    EXPECT_LE(ran.most_resident_bytes, kMostResident);
    if (ran.code == 1 || ran.code == 2) {
      EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    }
    most_s_ = std::max(most_s_, ran.processor_s);
    most_resident_ = std::max(most_resident_, ran.most_resident_bytes);
  }

  Folder folder_;
  std::size_t most_resident_ = 0;
  double most_s_ = 0.0;
};

using SlowMutants = Mutants;

TEST_P(Mutants, OfAKindAreReadOrRefusedInALine) { run(3); }

TEST_P(SlowMutants, OfAKindAreReadOrRefusedInALine) {
  const char* const asked = std::getenv("KERBSTONE_MUTANTS");
  run(asked != nullptr ? std::stoi(asked) : std::getenv("KERBSTONE_HEAVY") != nullptr ? 1000 : 300);
}

void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

std::string name_of(const ::testing::TestParamInfo<Kind>& kind) { return kind.param.name; }
INSTANTIATE_TEST_SUITE_P(Of, Mutants, ::testing::ValuesIn(kKinds), name_of);
INSTANTIATE_TEST_SUITE_P(Slow, SlowMutants, ::testing::ValuesIn(kKinds), name_of);

}  // namespace mutants_test
