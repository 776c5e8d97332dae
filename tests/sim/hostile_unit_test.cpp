// What a stranger's unit can do. SECURITY.md says what these tests hold.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <thread>

#include "base/error.h"
#include "sim/run_unit.h"
#include "some_unit.h"
#include "support/places.h"
#include "support/run_tool.h"

namespace hostile_unit_test {

using sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::AllOf, ::testing::HasSubstr, ::testing::Not;

std::string hostile(const support::TemporaryFolder& folder, const std::string& kind) {
  return write_unit(
      folder, description_2(kind, scalar_2("t", 0, "output") + scalar_2("stopped", 1, "output")), 2,
      {{"resources/given.txt", "x"}}, SIM_HOSTILE_UNIT);
}

sim::UnitRunOptions short_run() {
  sim::UnitRunOptions options;
  options.stop_s = 0.05;
  options.limits.step_s = 0.2;
  options.limits.memory_gb = 0.1;
  return options;
}

struct Told {
  std::string error;
  std::size_t rows = 0;
  double took_s = 0.0;
};

/// Of a run that does not come to its end.
Told told(const std::string& kind, double step_s = 0.2) {
  const support::TemporaryFolder folder;
  sim::UnitRunOptions options = short_run();
  options.limits.step_s = step_s;
  Told out;
  options.keep_row = [&](const auto&, const auto&) { ++out.rows; };
  const std::string unit = hostile(folder, kind);
  const auto begin = std::chrono::steady_clock::now();
  try {
    sim::run_unit(unit, options);
  } catch (const base::Error& error) {
    out.error = error.what();
  }
  out.took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

/// How often the unit was stopped, by the last row.
double stopped(const support::TemporaryFolder& folder, const std::string& kind, sim::UnitRun& run) {
  run = sim::run_unit(hostile(folder, kind), short_run());
  return run.values.back();
}

TEST(HostileUnit, AStepThatDoesNotEndIsEnded) {
  for (const char* const kind : {"loop", "sleep", "stop"}) {
    SCOPED_TRACE(kind);
    const Told it = told(kind);
    EXPECT_THAT(it.error, AllOf(HasSubstr("the unit was ended after 0.01 s: a step took 0."),
                                HasSubstr("at most 0.2 wanted (--unit-step-s)")));
    EXPECT_EQ(it.rows, 2u) << "rows until there are kept";
    EXPECT_LT(it.took_s, 2.2);
  }
}

TEST(HostileUnit, AStartThatDoesNotEndIsEnded) {
  const Told it = told("start loop");
  EXPECT_THAT(it.error,
              AllOf(HasSubstr("the unit was ended before it was initialised: its start took 2."),
                    HasSubstr("at most 2.4 wanted (12 times --unit-step-s)")));
  EXPECT_LT(it.took_s, 4.4);
}

TEST(HostileUnit, WhatTakesMuchMemoryIsEnded) {
  const Told it = told("memory", 20.0);
  EXPECT_THAT(it.error, AllOf(HasSubstr("the unit was ended after 0.01 s: "),
                              HasSubstr(" GB of memory; at most 0.1 wanted (--unit-memory-gb)")));
  EXPECT_LT(it.took_s, 2.0);
}

TEST(HostileUnit, FilesAndThreadsHaveLimits) {
  const Told filled = told("fill", 20.0);
  EXPECT_THAT(filled.error, HasSubstr("GB written to files; at most 0.1 wanted"));
  EXPECT_LT(filled.took_s, 4.0);
  EXPECT_THAT(told("large file").error,
              HasSubstr("a file of 0.1 GB; at most that wanted (--unit-memory-gb)"));
  EXPECT_THAT(told("threads").error, HasSubstr("threads; at most 1000 wanted (--trust"));
}

TEST(HostileUnit, AFloodOfWordsIsEnded) {
  const support::TemporaryFolder folder;
  const support::ToolRun ran = support::run_tool(
      places::crgsim(),
      {"run", hostile(folder, "print"), "--unit-memory-gb", "0.02", "-o", folder.path("out.csv")});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("GB printed; at most 0.001 wanted (a twentieth of"));
  EXPECT_LT(ran.err.size(), 30'000'000u);
}

TEST(HostileUnit, WhatItPrintsDoesNotSteerTheTerminal) {
  const support::TemporaryFolder folder;
  const support::ToolRun ran = support::run_tool(
      places::crgsim(),
      {"run", hostile(folder, "escape"), "--stop-s", "0.05", "-o", folder.path("out.csv")});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr(R"(\x1b]0;title\x07 \xc2\x9b31m red)"));
  EXPECT_THAT(ran.err, Not(HasSubstr("\x1b")));
}

TEST(HostileUnit, ACrashIsOneLine) {
  EXPECT_THAT(told("segfault").error, HasSubstr("the unit crashed after 0.01 s (signal 11: "));
}

TEST(HostileUnit, ItMakesNoProcesses) {
  const support::TemporaryFolder folder;
  sim::UnitRun run;
  EXPECT_EQ(stopped(folder, "fork", run), 1.0);
  EXPECT_EQ(run.refused, "clone");
  EXPECT_THAT(told("bomb").error,
              AllOf(HasSubstr("a step took"),
                    HasSubstr("; its sandbox refused it clone (--trust runs it without)")));
}

TEST(HostileUnit, ItHasNoNetwork) {
  const support::TemporaryFolder folder;
  sim::UnitRun run;
  EXPECT_EQ(stopped(folder, "network", run), 5.0);
  EXPECT_EQ(run.refused, "socket, socketpair");
}

TEST(HostileUnit, ItSignalsNobody) {
  const support::TemporaryFolder folder;
  sim::UnitRun run;
  EXPECT_EQ(stopped(folder, "signals", run), 5.0);
  EXPECT_EQ(run.refused, "kill, prctl, setsid");
}

TEST(HostileUnit, ItSharesNoMemory) {
  const support::TemporaryFolder folder;
  sim::UnitRun run;
  EXPECT_EQ(stopped(folder, "shared", run), 2.0);
}

TEST(HostileUnit, ItWritesInItsOwnFolderAlone) {
  const support::TemporaryFolder folder;
  const std::string kept = folder.file("kept.txt", "as it was");
  sim::UnitRun run;
  EXPECT_EQ(stopped(folder, "outside " + kept, run), 10.0);
  EXPECT_EQ(folder.read("kept.txt"), "as it was");
  for (const char* const made : {".new", ".moved", ".link", ".folder"})
    EXPECT_FALSE(std::filesystem::exists(kept + made)) << made;
  EXPECT_EQ(stopped(folder, "inside", run), 0.0);
}

/// Runs a tool as on a kernel without Landlock. Gives its exit code.
int run_without_landlock(const std::vector<std::string>& words, const std::string& says_into) {
  const pid_t child = ::fork();
  if (child == 0) {
    sock_filter code[] = {{BPF_LD | BPF_W | BPF_ABS, 0, 0, offsetof(seccomp_data, nr)},
                          {BPF_JMP | BPF_JEQ | BPF_K, 0, 1, 444},
                          {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ERRNO | ENOSYS},
                          {BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ALLOW}};
    const sock_fprog filter{std::size(code), code};
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0) ::_exit(99);
    ::dup2(::open(says_into.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    ::execv(arguments[0], arguments.data());
    ::_exit(98);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(HostileUnit, WithoutASandboxNothingOfItRuns) {
  const support::TemporaryFolder folder;
  std::vector<std::string> words{places::crgsim(), "run", hostile(folder, "network"), "--stop-s",
                                 "0.05",           "-o",  folder.path("out.csv")};
  EXPECT_EQ(run_without_landlock(words, folder.path("said")), 1);
  EXPECT_THAT(folder.read("said"),
              AllOf(HasSubstr("the unit's sandbox cannot be made: Landlock: Function not impl"),
                    HasSubstr("--trust runs the unit with all your rights")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("out.csv")));
  words.emplace_back("--trust");
  EXPECT_EQ(run_without_landlock(words, folder.path("said")), 0);
}

TEST(HostileUnit, AServedUnitIsConfinedToo) {
  const support::TemporaryFolder folder;
  const auto served = [&](const std::string& kind) {
    const std::string unit = write_unit(
        folder, description_2(kind, scalar_2("stopped", 1, "output") + scalar_2("in", 2, "input")),
        2, {}, SIM_HOSTILE_UNIT);
    return support::run_tool(
        places::crgsim(),
        {"serve", unit, "--socket", folder.path("s"), "--command", "in", "--measure", "stopped",
         "--stop-s", "0.1", "--unit-step-s", "0.2", "-o", folder.path("out.csv")});
  };
  const support::ToolRun looped = served("loop");
  EXPECT_EQ(looped.code, 1);
  EXPECT_THAT(looped.err, HasSubstr(": a step took 0."));
  EXPECT_FALSE(std::filesystem::exists(folder.path("s")));
  const support::ToolRun network = served("network");
  EXPECT_EQ(network.code, 0) << network.err;
  EXPECT_THAT(network.err, HasSubstr("sandbox refused it socket, socketpair; --trust runs it"));
  EXPECT_THAT(folder.read("out.csv"), HasSubstr("\n0.1,5,"));
}

TEST(HostileUnit, WithTrustItHasNoSandboxAndWhatItDetachedIsKilled) {
  const support::TemporaryFolder folder;
  const auto trusted = [&](const std::string& kind) {
    return support::run_tool(places::crgsim(), {"run", hostile(folder, kind), "--trust", "--stop-s",
                                                "0.05", "-o", folder.path("out.csv")});
  };
  const support::ToolRun network = trusted("network");
  EXPECT_EQ(network.code, 0) << network.err;
  EXPECT_THAT(folder.read("out.csv"), HasSubstr("\n0.05,0.05,0\n"));
  EXPECT_EQ(trusted("detach " + folder.path("detached")).code, 0);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_FALSE(std::filesystem::exists(folder.path("detached")));
}

}  // namespace hostile_unit_test
