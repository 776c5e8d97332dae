// Programs that run for hours hold no more at their end than near their begin. With
// KERBSTONE_HEAVY=1 ten hours of a car and 50,000 requests (docs/evidence.md).
#include <fcntl.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sim/unit_driver.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace flat_test {

namespace fs = std::filesystem;

bool heavy() { return std::getenv("KERBSTONE_HEAVY") != nullptr; }

struct Held {
  long resident_kb = 0, descriptors = 0;
};

std::vector<pid_t> children_of(pid_t process) {
  std::vector<pid_t> out;
  for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::ifstream children(task.path() / "children");
    for (pid_t child = 0; children >> child;) out.push_back(child);
  }
  return out;
}

Held held_alone(pid_t process) {
  const std::string proc = "/proc/" + std::to_string(process);
  Held out;
  std::ifstream status(proc + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) out.resident_kb = std::stol(line.substr(6));
  for (const auto& entry : fs::directory_iterator(proc + "/fd")) {
    (void)entry;
    ++out.descriptors;
  }
  return out;
}

/// What a process and its children hold.
Held held_by(pid_t process) {
  Held out = held_alone(process);
  for (const pid_t child : children_of(process)) {
    const Held more = held_by(child);
    out.resident_kb += more.resident_kb, out.descriptors += more.descriptors;
  }
  return out;
}

/// A program that runs until this object ends.
class Running {
 public:
  Running(const std::string& program, const std::vector<std::string>& words,
          const std::string& printed)
      : process_(::fork()) {
    if (process_ != 0) return;
    ::dup2(::open(printed.c_str(), O_WRONLY | O_CREAT, 0600), 1);
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() {
    ::kill(process_, SIGTERM);
    ::waitpid(process_, nullptr, 0);
  }
  Held held() const { return held_by(process_); }
  pid_t process() const { return process_; }

 private:
  pid_t process_;
};

void expect_same(const Held& early, const Held& late) {
  support::figure("early_mb", early.resident_kb / 1024.0);
  support::figure("late_mb", late.resident_kb / 1024.0);
  support::figure("descriptors", static_cast<double>(late.descriptors));
  EXPECT_GT(early.resident_kb, 1000);
  EXPECT_LE(std::abs(late.resident_kb - early.resident_kb), 5000);
  EXPECT_EQ(late.descriptors, early.descriptors);
}

/// Does one thing `count` times; what is held after a tenth of them and at the end is the same.
template <class Step>
void expect_flat(const Running& program, int count, const Step& step) {
  Held early;
  for (int k = 0; k < count && !::testing::Test::HasFailure(); ++k) {
    step(k);
    if (k == count / 10) early = program.held();
  }
  expect_same(early, program.held());
}

TEST(SlowFlat, ACarServedInLockstep) {
  const cli::Folder folder;
  const int seconds = heavy() ? 36000 : 600;
  ASSERT_EQ(support::run_tool(places::crgdrive(),
                              {"fmu", places::source() + "/vehicles/open_wheel/vehicle.yaml", "-o",
                               folder / "car.fmu"})
                .code,
            0);
  const Running serve(places::crgsim(),
                      {"serve", folder / "car.fmu", "--socket", folder / "s", "--lockstep",
                       "--every", "1000", "--command", "input.throttle", "--measure", "car.vx",
                       "--stop-s", std::to_string(seconds + 10), "-o", folder / "drive.csv"},
                      folder / "printed");
  const sim_tests::Driver driver(folder / "s");
  expect_flat(serve, seconds, [&](int k) {
    driver.say(
        nlohmann::json{{"sequence", k + 1}, {"set", {{"input.throttle", 0.05 + 0.05 * (k % 3)}}}}
            .dump());
    EXPECT_EQ(driver.hear().value("time_s", 0.0), k + 1.0);
  });
}

TEST(SlowFlat, APageAskedAgainAndAgain) {
  const cli::Folder folder;
  fs::create_directory(folder / "shown");
  fs::copy(places::source() + "/tests/corpus/reference/bends.crg", folder / "shown");
  cli::write(folder / "shown/track.yaml", "mesh: a.obj\n");
  cli::write(folder / "shown/log.csv", "time_s,x_m,y_m,speed\n0,0,0,1\n1,1,0,2\n2,2,0,3\n");
  const Running view(places::kerbstone(), {"view", folder / "shown", "--no-open"},
                     folder / "printed");
  std::string said;
  for (int tries = 0; tries < 1000 && said.find("\n") == std::string::npos; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    said = cli::exists(folder / "printed") ? cli::read(folder / "printed") : "";
  }
  const std::size_t port = said.find("127.0.0.1:"), token = said.find('#');
  ASSERT_TRUE(port != std::string::npos && token != std::string::npos) << said;
  httplib::Client client("127.0.0.1", std::stoi(said.substr(port + 10)));
  client.set_keep_alive(true);
  client.set_default_headers({{"X-Kerbstone-Token", said.substr(token + 1, 32)}});
  const std::vector<std::pair<std::string, int>> asked{
      {"/", 200},
      {"/api/list", 200},
      {"/api/text?id=0/track.yaml", 200},
      {"/api/file?id=0/log.csv", 200},
      {"/api/channels?id=0/log.csv&name=speed", 200},
      {"/api/road?id=0/bends.crg", 200},
      {"/none", 404}};
  expect_flat(view, heavy() ? 50000 : 5000, [&](int k) {
    const auto& [path, code] = asked[static_cast<std::size_t>(k) % asked.size()];
    const auto answer = client.Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->status, code) << path;
  });
}

// What Snakemake holds from a tenth of the laps on.
TEST(SlowFlat, ACampaignOfManyJobs) {
  if (support::run_tool("/bin/sh", {"-c", "command -v snakemake"}).code != 0)
    GTEST_SKIP() << "snakemake is not installed (scripts/setup campaign)";
  const cli::Folder folder;
  const std::size_t laps = heavy() ? 1000 : 40;
  nlohmann::json masses_kg, drags_m2;
  for (std::size_t k = 0; k < laps / 10; ++k) masses_kg.push_back(700 + k);
  for (int k = 0; k < 10; ++k) drags_m2.push_back(0.7 + 0.01 * k);
  cli::write(
      folder / "many.yaml",
      nlohmann::json{
          {"name", "many"},
          {"tracks",
           {{"ring", {{"circuit", places::source() + "/tracks/kerbstone-ring/circuit.yaml"}}}}},
          {"cars", {{"av21", places::source() + "/vehicles/av21/vehicle.yaml"}}},
          {"analyses",
           {{"sweeps",
             {{"parameters", {{"chassis.mass_kg", masses_kg}, {"aero.drag_area_m2", drags_m2}}}}}}}}
          .dump());
  const Running campaign(places::source() + "/scripts/campaign",
                         {folder / "many.yaml", folder / "out", "--tools",
                          fs::path(places::kerbstone()).parent_path().parent_path().string()},
                         folder / "printed");
  const auto done = [&] {
    std::size_t count = 0;
    if (cli::exists(folder / "out/state/lap"))
      for (const auto& entry : fs::directory_iterator(folder / "out/state/lap"))
        count += entry.path().string().ends_with(".cost.json") ? 1 : 0;
    return count;
  };
  const auto wait_for = [&](std::size_t count) {
    while (done() < count && ::waitpid(campaign.process(), nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
  };
  const auto held_by_snakemake = [&] {
    Held out;
    for (const pid_t child : children_of(campaign.process())) out = held_alone(child);
    return out;
  };
  wait_for(laps / 10);
  const Held early = held_by_snakemake();
  wait_for(laps - laps / 10);
  expect_same(early, held_by_snakemake());
  wait_for(laps + 1);  // all of it, before its folder is gone
}

}  // namespace flat_test
