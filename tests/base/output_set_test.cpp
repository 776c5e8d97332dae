#include "base/output_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/inotify.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <random>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "support/temporary_folder.h"

namespace output_set_test {

namespace fs = std::filesystem;
using base::OutputSet;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Names = std::set<std::string>;

Names names_in(const std::string& folder) {
  Names names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

/// One run that makes these files, each with its own name and `word` in it.
void run(const std::string& folder, const std::string& name, const std::vector<std::string>& made,
         const std::string& word = "", const std::vector<std::string>& kept = {}) {
  OutputSet set(folder, "tool make");
  for (const std::string& file : made) base::write_file(set.staged(file), file + word);
  set.commit(name, kept, {"timing.json"});
}

/// Runs `body` in a process of its own, which then ends as a killed one does; its exit code.
int killed(const std::function<int()>& body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = -1;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(OutputSet, AppearsWholeAndIsConfirmedUntilAnythingChanges) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("new/out");
  run(out, "a", {"a.crg", "a.stl", "timing.json"});
  EXPECT_EQ(names_in(out), (Names{"a.crg", "a.stl", "timing.json", "manifest.json"}));
  EXPECT_THAT(OutputSet(out, "tool make").confirmed(),
              ElementsAre("a.crg", "a.stl", "timing.json"));
  EXPECT_THAT(OutputSet(out, "tool other").confirmed(), IsEmpty());
  base::write_file(out + "/timing.json", "another time");
  EXPECT_FALSE(OutputSet(out, "tool make").confirmed().empty());
  fs::remove(out + "/timing.json");
  EXPECT_TRUE(OutputSet(out, "tool make").confirmed().empty());
  EXPECT_THAT(OutputSet(out, "tool make").confirmed({"timing.json"}),
              ElementsAre("a.crg", "a.stl"));
  base::write_file(out + "/a.crg", "a.crg by hand");
  EXPECT_THAT(OutputSet(out, "tool make").confirmed({"timing.json"}), IsEmpty());
  run(out, "a", {"a.crg"});
  const std::string manifest = folder.read("new/out/manifest.json");
  std::string other = manifest;
  char& digit = other[other.find("program_sha256") + 20];
  digit = digit == '0' ? '1' : '0';
  folder.file("new/out/manifest.json", other);
  EXPECT_THAT(OutputSet(out, "tool make").confirmed(), IsEmpty()) << "made by another program";
  for (const char* damage : {"", "{}", "{\"files\": 7}", "[1", "null"}) {
    folder.file("new/out/manifest.json", damage);
    EXPECT_THAT(OutputSet(out, "tool make").confirmed(), IsEmpty()) << damage;
  }
  folder.file("new/out/manifest.json", manifest);
  EXPECT_FALSE(OutputSet(out, "tool make").confirmed().empty());
}

TEST(OutputSet, WithoutCommitNothingHasHappened) {
  const support::TemporaryFolder folder;
  {
    const OutputSet set(folder.path("new/deep"), "tool make");
    base::write_file(set.staged("a.crg"), "half a set");
  }
  EXPECT_FALSE(fs::exists(folder.path("new")));
  run(folder.path("out"), "a", {"a.crg"});
  {
    const OutputSet set(folder.path("out"), "tool make");
    base::write_file(set.staged("a.crg"), "other");
  }
  EXPECT_EQ(folder.read("out/a.crg"), "a.crg");
  EXPECT_EQ(names_in(folder.path("out")), (Names{"a.crg", "manifest.json"}));
}

TEST(OutputSet, RemovesWhatTheSameRoadNoLongerHasAndNothingElse) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  run(out, "a", {"a.crg", "a.patch-1.crg", "a.cache", "report.html"});
  folder.file("out/mine.txt", "kept");
  run(out, "a", {"a.crg"}, " again", {"a.cache"});
  EXPECT_EQ(names_in(out), (Names{"a.crg", "a.cache", "mine.txt", "manifest.json"}));
  EXPECT_THAT(OutputSet(out, "tool make").confirmed(), ElementsAre("a.cache", "a.crg"));
  // Another road into the same folder: the first stays, a page about it does not.
  run(out, "a", {"a.crg", "report.html"});
  run(out, "b", {"b.crg"});
  EXPECT_EQ(names_in(out), (Names{"a.crg", "b.crg", "mine.txt", "manifest.json"}));
  // A manifest that names what lies elsewhere is no manifest.
  folder.file("other.txt", "kept");
  std::string manifest = folder.read("out/manifest.json");
  manifest.replace(manifest.find("b.crg"), 5, "../other.txt");
  folder.file("out/manifest.json", manifest);
  run(out, "b", {"b.crg"});
  EXPECT_EQ(folder.read("other.txt"), "kept");
}

TEST(OutputSet, TheNextRunRemovesWhatAKilledOneLeft) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  EXPECT_EQ(killed([&] {
              OutputSet set(out, "tool make");
              base::FileWriter begun(set.staged("a.crg"));
              begun.append("half");
              ::_exit(0);
              return 0;
            }),
            0);
  EXPECT_EQ(names_in(out), (Names{".kerbstone.lock", ".kerbstone.new"}))
      << "the test needs leftovers";
  run(out, "a", {"a.crg"});
  EXPECT_EQ(names_in(out), (Names{"a.crg", "manifest.json"}));
}

TEST(OutputSet, KilledAtAnyMomentTheNextRunLeavesItsOwnFiles) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  std::mt19937 random(1);
  int incomplete = 0;
  run(out, "a", {"a.crg"});  // hashes this program, which the children then need not
  for (int round = 0; round < 60; ++round) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (;;) {
        run(out, "a", {"a.crg", "a.stl", "a.patch-1.crg", "report.html"});
        run(out, "a", {"a.crg", "a.stl", "a.patch-2.crg", "summary.json"}, " again");
      }
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 15'000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    incomplete +=
        fs::exists(out + "/manifest.json") &&
                folder.read("out/manifest.json").find("\"complete\": false") != std::string::npos
            ? 1
            : 0;
    run(out, "a", {"a.crg", "a.stl"}, " last");
    ASSERT_EQ(names_in(out), (Names{"a.crg", "a.stl", "manifest.json"})) << round;
    ASSERT_EQ(folder.read("out/a.crg") + folder.read("out/a.stl"), "a.crg lasta.stl last");
    ASSERT_THAT(OutputSet(out, "tool make").confirmed(), ElementsAre("a.crg", "a.stl"));
  }
  std::printf("%d of 60 were killed while files were moved in\n", incomplete);
}

TEST(OutputSet, AnIncompleteSetIsNotBelievedAndItsFilesAreKnown) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  run(out, "a", {"a.crg", "a.patch-1.crg"});
  std::string manifest = folder.read("out/manifest.json");
  manifest.replace(manifest.find("true"), 4, "false");  // as a kill inside commit() leaves it
  folder.file("out/manifest.json", manifest);
  EXPECT_THAT(OutputSet(out, "tool make").confirmed(), IsEmpty());
  run(out, "a", {"a.crg"});
  EXPECT_EQ(names_in(out), (Names{"a.crg", "manifest.json"}));
}

TEST(OutputSet, OneProcessAtATimeAndTheOtherIsToldWho) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  const OutputSet set(out, "tool make");
  EXPECT_EQ(killed([&] {
              try {
                const OutputSet second(out, "tool other");
              } catch (const base::Error& error) {
                const std::string text = error.what();
                return text.find(out + ": tool make (process " + std::to_string(::getppid()) +
                                 ") is writing into this folder") == 0
                           ? 0
                           : 1;
              }
              return 2;
            }),
            0);
  EXPECT_THROW(OutputSet(out, "tool other"), base::Error);  // nor twice in one
  EXPECT_TRUE(fs::exists(out + "/.kerbstone.lock"));
}

TEST(OutputSet, RefusesAFolderThatIsNone) {
  const support::TemporaryFolder folder;
  folder.file("file", "x");
  EXPECT_THROW(OutputSet(folder.path("file"), "tool make"), base::Error);
  EXPECT_THROW(OutputSet(folder.path("file/below"), "tool make"), base::Error);
  fs::create_directories(folder.path(
      "out/a.crg"));  // a folder where a file is to go: refused before anything is moved
  run(folder.path("out"), "b", {"b.crg"});
  OutputSet set(folder.path("out"), "tool make");
  base::write_file(set.staged("a.crg"), "x");
  EXPECT_THROW(set.commit("a"), base::Error);
  EXPECT_THAT(set.confirmed(), ElementsAre("b.crg"));
}

TEST(OutputSet, GivenUpLeavesTheFolderAsItWas) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  run(out, "a", {"a.crg"});
  EXPECT_EQ(killed([&] {
              OutputSet set(out, "tool make");
              base::FileWriter begun(set.staged("a.crg"));
              begun.append("half");
              base::abandon_writes();
              ::_exit(0);
              return 0;
            }),
            0);
  EXPECT_EQ(names_in(out), (Names{"a.crg", "manifest.json"}));
  EXPECT_EQ(folder.read("out/a.crg"), "a.crg");
}

TEST(OutputSet, GivenUpRemovesTheFoldersThatItMadeUnlessSomethingLiesInThem) {
  const support::TemporaryFolder folder;
  const auto give_up = [&](bool with_a_file) {
    return killed([&] {
      const OutputSet set(folder.path("new/./deep/out/"), "tool make");
      if (with_a_file) folder.file("new/mine.txt", "kept");
      base::abandon_writes();
      ::_exit(0);
      return 0;
    });
  };
  EXPECT_EQ(give_up(false), 0);
  EXPECT_FALSE(fs::exists(folder.path("new")));
  EXPECT_EQ(give_up(true), 0);
  EXPECT_EQ(names_in(folder.path("new")), Names{"mine.txt"});
}

TEST(OutputSet, GivenUpRemovesTheLockAfterAllThatItGuards) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out");
  run(out, "a", {"a.crg"});
  const int watch = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  ASSERT_GE(::inotify_add_watch(watch, out.c_str(), IN_DELETE), 0);
  EXPECT_EQ(killed([&] {
              const OutputSet set(out, "tool make");
              base::abandon_writes();
              ::_exit(0);
              return 0;
            }),
            0);
  alignas(inotify_event) char events[4096];
  const ssize_t count = ::read(watch, events, sizeof events);
  ::close(watch);
  std::vector<std::string> removed;
  for (ssize_t at = 0; at < count;) {
    const auto* event = reinterpret_cast<const inotify_event*>(events + at);
    removed.emplace_back(event->name);
    at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
  }
  EXPECT_THAT(removed, ElementsAre(".kerbstone.new", ".kerbstone.lock"));
}

/// What a killed run leaves is called so by its manifest.
void mark_unfinished(const support::TemporaryFolder& folder, const std::string& manifest) {
  std::string text = folder.read(manifest);
  const std::string whole = "\"complete\": true";
  ASSERT_NE(text.find(whole), std::string::npos);
  folder.file(manifest, text.replace(text.find(whole), whole.size(), "\"complete\": false"));
}

std::string refusal_of(const std::string& path) {
  try {
    base::check_in_set(path);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(OutputSet, WhoeverReadsAFileOfItSeesThatItIsAnother) {
  const support::TemporaryFolder folder;
  const std::string out = folder.path("out"), road = folder.path("out/a.crg");
  EXPECT_EQ(base::files_of_set(out), std::nullopt);
  run(out, "a", {"a.crg", "timing.json"});
  const std::string wanted = base::sha256("a.crg"), seen = base::sha256("b.crg");
  EXPECT_EQ(base::files_of_set(out).value(),
            (std::map<std::string, std::string>{{"a.crg", wanted}, {"timing.json", ""}}));
  EXPECT_EQ(refusal_of(road), "");
  folder.file("out/a.crg", "b.crg");
  EXPECT_THAT(refusal_of(road), ::testing::StartsWith(road + ": SHA-256 " + seen + " seen, " +
                                                      wanted + " wanted; make it again"));
  folder.file("out/timing.json", "other");
  folder.file("out/own.crg", "not of the set");
  EXPECT_EQ(refusal_of(out + "/timing.json"), "");
  EXPECT_EQ(refusal_of(out + "/own.crg"), "");
  folder.file("out/manifest.json", "{\"somebody\": \"else's\"}");
  EXPECT_EQ(refusal_of(road), "");
}

TEST(OutputSet, NothingOfAKilledRunIsRead) {
  const support::TemporaryFolder folder;
  run(folder.path("out"), "a", {"a.crg"});
  mark_unfinished(folder, "out/manifest.json");
  EXPECT_THAT(refusal_of(folder.path("out/a.crg")),
              HasSubstr("manifest.json: 'complete' is false: 'tool make' was killed"));
  // Where the input of the run lies in the folder of its results, the run could never be run again.
  EXPECT_EQ(refusal_of(folder.path("out/own.crg")), "");
  run(folder.path("out"), "a", {"a.crg"});
  EXPECT_EQ(refusal_of(folder.path("out/a.crg")), "");
}

}  // namespace output_set_test
