// scripts/campaign from campaign.yaml to the page.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "base/json_text.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace script_test {

namespace fs = std::filesystem;
using support::ToolRun;
using ::testing::HasSubstr;

ToolRun shell(const std::string& command) {
  return support::run_tool("/bin/bash", {"-c", command});
}

/// The folder with the tools of this build, as scripts/campaign takes it.
std::string tools() { return fs::path(places::crgbuild()).parent_path().parent_path().string(); }

ToolRun run_campaign(const std::string& yaml, const std::string& folder, int jobs = 2) {
  return shell(fmt::format("'{}/scripts/campaign' '{}' '{}' --jobs {} --tools '{}' 2>&1",
                           places::source(), yaml, folder, jobs, tools()));
}

/// Two stadiums of which one has no triangle, and laps of a car on both.
void write_campaign(const cli::Folder& folder) {
  fs::create_directories(folder / "meshes");
  cli::write(folder / "meshes/good.obj", cli::Stadium{}.obj());
  cli::write(folder / "meshes/broken.obj", "v 1 2 3\n");
  cli::write(folder / "campaign.yaml",
             "name: small\n"
             "tracks:\n"
             "  good: {mesh: meshes/good.obj, options: {--u-step-m: 0.25, --v-step-m: 0.25}}\n"
             "  broken: {mesh: meshes/broken.obj}\n"
             "cars:\n"
             "  av21: " +
                 places::source() +
                 "/vehicles/av21/vehicle.yaml\n"
                 "analyses:\n"
                 "  laps: {options: {--rate-hz: 20}}\n");
}

class Script : public ::testing::Test {
 protected:
  void SetUp() override {
    if (shell("command -v snakemake").code != 0)
      GTEST_SKIP() << "snakemake is not installed (scripts/setup campaign)";
  }
};

std::string state_of(const std::string& page, const std::string& job) {
  const std::string csv = cli::read(fs::path(page).replace_filename("campaign.csv"));
  const std::size_t row = csv.find("\n" + job + ",");
  if (row == std::string::npos) return "";
  const std::string line = csv.substr(row + 1, csv.find('\n', row + 1) - row - 1);
  std::size_t begin = 0;
  for (int comma = 0; comma < 3; ++comma) begin = line.find(',', begin) + 1;
  return line.substr(begin, line.find(',', begin) - begin);
}

TEST_F(Script, GoesOnAfterAFailureAndGivesTheBytesOfTheCommands) {
  const cli::Folder folder;
  write_campaign(folder);
  const std::string out = folder / "out", page = out + "/index.html";
  const ToolRun first = run_campaign(folder / "campaign.yaml", out);
  EXPECT_EQ(first.code, 3) << first.out;
  EXPECT_EQ(state_of(page, "road/good"), "done");
  EXPECT_EQ(state_of(page, "lap-page/good+av21"), "done");
  EXPECT_EQ(state_of(page, "road/broken"), "failed");
  EXPECT_EQ(state_of(page, "lap/broken+av21"), "blocked");
  EXPECT_THAT(cli::read(page), HasSubstr("broken.obj: "));

  // By hand, in a folder of its own.
  const std::string hand = folder / "hand", car = places::source() + "/vehicles/av21/vehicle.yaml";
  fs::create_directories(hand + "/lap/good+av21");
  const ToolRun by_hand = shell(fmt::format(
      "cd '{0}' && '{1}' build '{2}' -o road/good --name good --u-step-m 0.25 --v-step-m 0.25 "
      "--threads 1 && '{3}' lap --car '{4}' --road road/good/good.crg -o "
      "lap/good+av21/lap.csv --rate-hz 20",
      hand, places::crgbuild(), folder / "meshes/good.obj", places::crgdrive(), car));
  ASSERT_EQ(by_hand.code, 0) << by_hand.err;
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(hand)) {
    const fs::path name = entry.path().lexically_relative(hand);
    if (!entry.is_regular_file() || name.filename() == "timing.json") continue;
    ++files;
    EXPECT_TRUE(cli::read(entry.path()) == cli::read(out / name)) << name;
  }
  EXPECT_GE(files, 8);

  // What is done is not done again; what failed is, and what waited for it.
  const auto built = fs::last_write_time(out + "/road/good/good.crg");
  cli::write(folder / "meshes/broken.obj", cli::Stadium{}.obj());
  const ToolRun second = run_campaign(folder / "campaign.yaml", out);
  EXPECT_EQ(second.code, 0) << second.out;
  EXPECT_EQ(fs::last_write_time(out + "/road/good/good.crg"), built);
  EXPECT_EQ(state_of(page, "lap/broken+av21"), "done");
}

// One summary of each recording, one job that divides what all of a track say.
TEST_F(Script, AFleetIsSummedUpRecordingByRecording) {
  const cli::Folder folder;
  const ToolRun ran = shell(fmt::format(
      "KERBSTONE_TOOLS='{0}' python3 '{1}/campaigns/plan.py' '{1}/campaigns/fleet.yaml' '{2}' 2>&1",
      tools(), places::source(), folder / "out"));
  ASSERT_EQ(ran.code, 0) << ran.out;
  const nlohmann::json plan = base::parse_json<nlohmann::json>(cli::read(folder / "out/plan.json"));
  std::vector<std::string> summaries;
  const nlohmann::json* fleet = nullptr;
  for (const nlohmann::json& job : plan.at("jobs")) {
    if (job.at("kind") == "summary") summaries.push_back(job.at("id"));
    if (job.at("kind") == "fleet") fleet = &job;
  }
  EXPECT_EQ(summaries,
            (std::vector<std::string>{"summary/heavy", "summary/slippery", "summary/blunt"}));
  ASSERT_NE(fleet, nullptr);
  EXPECT_EQ(fleet->at("after").get<std::vector<std::string>>(), summaries);
  EXPECT_EQ(fleet->at("page"), "fleet/kerbstone-ring/report.html");
  EXPECT_EQ(fleet->at("command").at(2), "summary/heavy/drive.summary");
}

// The template as it is: three cars, of which each is driven by one that is not as stated.
TEST_F(Script, TheTemplateFleetRunsToItsEnd) {
  if (std::getenv("KERBSTONE_HEAVY") == nullptr) GTEST_SKIP() << "minutes: KERBSTONE_HEAVY=1";
  const cli::Folder folder;
  const std::string out = folder / "out";
  const ToolRun ran = run_campaign(places::source() + "/campaigns/fleet.yaml", out);
  ASSERT_EQ(ran.code, 0) << ran.out;
  for (const char* recording : {"heavy", "slippery", "blunt"}) {
    EXPECT_EQ(state_of(out + "/index.html", std::string("summary/") + recording), "done");
    for (const char* window : {"0.6s", "2s", "8s"})
      EXPECT_EQ(state_of(out + "/index.html", fmt::format("replay/{}+{}", recording, window)),
                "done");
  }
  EXPECT_TRUE(fs::exists(out + "/fleet/kerbstone-ring/report.html"));
  // What campaigns/fleet.yaml sets against what the cars' files say. Seen: 0.68 and 1.10.
  const std::map<std::string, double> drag_area_m2{{"open_wheel", 0.7}, {"club_racer", 1.1}};
  const nlohmann::json fleet =
      base::parse_json<nlohmann::json>(cli::read(out + "/fleet/kerbstone-ring/fleet.json"));
  std::set<std::string> with_drag, with_mass;
  for (const nlohmann::json& f : fleet.at("findings")) {
    const std::string mechanism = f.at("mechanism"), owner = f.at("owner");
    EXPECT_NE(f.at("belongs_to"), "road") << base::dump_json(f, 1);
    if (mechanism == "parameter.mass") with_mass.insert(owner);
    if (mechanism != "parameter.drag") continue;
    with_drag.insert(owner);
    ASSERT_TRUE(drag_area_m2.contains(owner)) << base::dump_json(f, 1);
    EXPECT_NEAR(f.at("stated").get<double>() + f.at("amount").get<double>(), drag_area_m2.at(owner),
                0.04);
  }
  EXPECT_EQ(with_drag, (std::set<std::string>{"club_racer", "open_wheel"}));
  EXPECT_EQ(with_mass, (std::set<std::string>{"av21"}));
}

// The same scans as one job and in tiles.
TEST_F(Script, TilesMakeTheRoadOfOneJob) {
  const cli::Folder folder;
  const std::string track = "{scans: {circuit: " + places::source() +
                            "/tracks/kerbstone-ring/circuit.yaml, options: {--u-begin-m: 380, "
                            "--u-end-m: 440, --azimuths: 128, "
                            "--beams: 32}}, options: {--no-report: true, --gate-m: 0.4}";
  cli::write(folder / "campaign.yaml",
             "name: tiles\ntracks:\n  whole: " + track + "}\n  cut: " + track + ", tiles: 3}\n");
  const std::string out = folder / "out", page = out + "/index.html";
  const ToolRun ran = run_campaign(folder / "campaign.yaml", out);
  ASSERT_EQ(ran.code, 0) << ran.out;
  for (const char* job : {"split/cut", "tile/cut+1+1", "tile/cut+4+3", "merge/cut+3", "map/cut"})
    EXPECT_EQ(state_of(page, job), "done") << job;
  const auto said = [&](const std::string& name) {
    return base::parse_json<nlohmann::json>(cli::read(out + "/map/" + name + "/summary.json"));
  };
  EXPECT_EQ(said("cut")["drift"], said("whole")["drift"]);
  EXPECT_EQ(said("cut")["points"], said("whole")["points"]);
  EXPECT_GT(said("cut")["points"]["used"], 100000);
  EXPECT_EQ(cli::read(out + "/map/cut/trajectory.csv"),
            cli::read(out + "/map/whole/trajectory.csv"));

  // A tile that is lost is made again.
  fs::remove(out + "/split/cut/step-2.tile-2");
  const std::string road = cli::read(out + "/map/cut/refined.crg");
  EXPECT_EQ(run_campaign(folder / "campaign.yaml", out).code, 0);
  EXPECT_TRUE(fs::exists(out + "/split/cut/step-2.tile-2"));
  EXPECT_TRUE(cli::read(out + "/map/cut/refined.crg") == road);
}

// ssh is played by a script: one host that cannot be reached, one that is this machine.
TEST_F(Script, AHostThatCannotBeReachedCostsNoJob) {
  const cli::Folder folder;
  write_campaign(folder);
  cli::write(folder / "ssh", "#!/bin/sh\n[ \"$1\" = near ] || exit 255\nexec sh -c \"$2\"\n");
  fs::permissions(folder / "ssh", fs::perms::owner_all);
  cli::write(folder / "hosts", "far 2  # is down\nnear 2\n");
  const std::string out = folder / "out";
  const ToolRun ran =
      shell(fmt::format("CI=true KERBSTONE_SSH='{0}/ssh' KERBSTONE_HOSTS='{0}/hosts' "
                        "'{1}/scripts/campaign' '{0}/campaign.yaml' '{2}' --tools '{3}' "
                        "--profile ssh 2>&1",
                        folder.path(), places::source(), out, tools()));
  EXPECT_EQ(ran.code, 3) << ran.out;
  EXPECT_THAT(ran.out, HasSubstr("far cannot be reached"));
  EXPECT_EQ(state_of(out + "/index.html", "lap-page/good+av21"), "done");
  EXPECT_EQ(state_of(out + "/index.html", "road/broken"), "failed");
}

// What a controller that died may do: begin a submission twice, and not know that it has ended.
TEST_F(Script, ASubmissionThatHasEndedIsNotRunAgain) {
  const cli::Folder folder;
  write_campaign(folder);
  const std::string out = folder / "out", campaigns = places::source() + "/campaigns";
  const auto call = [&](const std::string& words) {
    return shell(fmt::format("cd '{}' && KERBSTONE_TOOLS='{}' python3 '{}'/{} 2>&1", out, tools(),
                             campaigns, words));
  };
  fs::create_directories(out);
  ASSERT_EQ(call(fmt::format("plan.py '{}' .", folder / "campaign.yaml")).code, 0);
  const auto runs = [&] {
    const std::string lines = cli::read(out + "/.locks/road/good");
    return std::count(lines.begin(), lines.end(), '\n');
  };
  EXPECT_EQ(call("job.py . road/good first").code, 0);
  const auto built = fs::last_write_time(out + "/road/good/good.crg");
  EXPECT_EQ(call("job.py . road/good first").code, 0);
  EXPECT_EQ(runs(), 1);
  EXPECT_EQ(fs::last_write_time(out + "/road/good/good.crg"), built);
  EXPECT_EQ(call("profiles/slurm/status.py first").out, "success\n");
  // Another submission of the same job is another run, and so is one that Slurm knows nothing of.
  EXPECT_EQ(call("job.py . road/good second").code, 0);
  EXPECT_EQ(call("job.py . road/good").code, 0);
  EXPECT_EQ(runs(), 3);
}

// A Slurm of its own on this machine, jobs and two daemons killed: 20 jobs of which 3; with
// KERBSTONE_HEAVY=1 200 of which 20, ten minutes.
TEST_F(Script, SlurmGivesTheSameBytesWhateverIsKilled) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  if (shell("PATH=$PATH:/usr/sbin; command -v slurmctld slurmd munged sbatch").code != 0)
    GTEST_SKIP() << "Slurm is not installed (scripts/setup cluster)";
  const cli::Folder folder;
  const ToolRun ran =
      shell(fmt::format("python3 '{0}/tests/campaign/slurm_trial.py' '{0}' '{1}' '{2}' {3} 2>&1",
                        places::source(), tools(), folder / "work", heavy ? "200 20" : "20 3"));
  EXPECT_EQ(ran.code, 0) << ran.out;
  std::printf("%s", ran.out.c_str());
}

TEST_F(Script, RefusesInOneLine) {
  const cli::Folder folder;
  write_campaign(folder);
  const auto refusal = [&](const std::string& yaml) {
    cli::write(folder / "bad.yaml", yaml);
    const ToolRun ran = run_campaign(folder / "bad.yaml", folder / "out");
    EXPECT_EQ(ran.code, 1) << ran.out;
    EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 1) << ran.out;
    return ran.out;
  };
  EXPECT_THAT(refusal("tracks: ["), HasSubstr("bad.yaml"));
  EXPECT_THAT(refusal("a: &a [1]\nname: *a\n"), HasSubstr("bad.yaml:1: anchors"));
  EXPECT_THAT(refusal("name: x\n"), HasSubstr("nothing to do"));
  EXPECT_THAT(refusal("name: x\ntrakcs: {}\n"), HasSubstr("no key 'trakcs' is known"));
  EXPECT_THAT(refusal("name: x\ntracks: {../up: {mesh: meshes/good.obj}}\n"),
              HasSubstr("name '../up' seen"));
  EXPECT_THAT(refusal("name: x\ntracks: {a: {mesh: meshes/none.obj}}\n"),
              HasSubstr("no such file"));
  EXPECT_THAT(refusal("name: x\ntracks: {a: {mesh: meshes/good.obj, options: {--output: /x}}}\n"),
              HasSubstr("'--output' seen"));
  EXPECT_THAT(refusal("name: x\ntracks: {a: {mesh: meshes/good.obj, tiles: 4}}\n"),
              HasSubstr("tiles: they are of scans, not of a mesh"));
}

}  // namespace script_test
