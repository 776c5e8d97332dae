#include "command/terminal.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "command/signals.h"

namespace terminal_test {

using command::Terminal;

struct Ended {
  int code = -1;
  std::string err;
};

/// What a process of its own says on standard error until it ends.
Ended run(const std::function<void()>& body) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], STDERR_FILENO);
    body();
    ::_exit(0);
  }
  ::close(ends[1]);
  Ended out;
  char bytes[1000];
  for (ssize_t count = 0; (count = ::read(ends[0], bytes, sizeof bytes)) > 0;)
    out.err.append(bytes, static_cast<std::size_t>(count));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  out.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return out;
}

void wait_a_little() { std::this_thread::sleep_for(std::chrono::milliseconds(300)); }

TEST(Terminal, NothingIsSaidAfterTheLastWords) {
  const Ended ended = run([] {
    Terminal terminal("tool");
    terminal.last_words("interrupted");
    std::thread([&] { terminal.error("too late"); }).detach();
    wait_a_little();
    ::_exit(5);
  });
  EXPECT_EQ(ended.code, 5);
  EXPECT_EQ(ended.err, "tool: interrupted\n");
}

TEST(Terminal, ASignalEndsTheProcessBeforeAndAfterItsDestruction) {
  for (const bool destroyed : {false, true}) {
    const Ended ended = run([&] {
      std::optional<Terminal> terminal("tool");
      command::end_on_signals(*terminal);
      if (destroyed) terminal.reset();
      ::kill(::getpid(), SIGTERM);
      wait_a_little();
    });
    EXPECT_EQ(ended.code, 128 + SIGTERM);
    EXPECT_EQ(ended.err, destroyed ? "" : "tool: interrupted; no file is half-written\n");
  }
}

}  // namespace terminal_test
