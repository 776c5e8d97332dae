// A unit of FMI 2.0 that misbehaves in the way that its guid names, in its second step; those
// called "start ..." while they are initialised. Value 0 is its time, value 1 how often it was
// stopped from doing what it wanted.
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

namespace {

struct Instance {
  std::string kind, folder;
  double time_s = 0.0, stopped = 0.0;
};
Instance& of(void* instance) { return *static_cast<Instance*>(instance); }

/// Longer than any limit of the tests.
void loop() {
  for (int k = 0; k < 300; ++k)
    for (const auto begin = std::chrono::steady_clock::now();
         std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(100);) {
    }
}

/// At most 50 processes, which end.
void bomb() {
  for (int made = 0; made < 50;) {
    const pid_t child = ::fork();
    if (child == 0) ::usleep(200'000), ::_exit(0);
    if (child > 0) ++made;
  }
}

void take_memory(std::size_t bytes) {
  for (std::size_t taken = 0; taken < bytes; taken += 1 << 20)
    (void)::mmap(nullptr, 1 << 20, PROT_READ | PROT_WRITE,
                 MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
}

/// How many of these things of the machine outside it may do.
int stopped_outside(const std::string& path) {
  int stopped = 0;
  const auto want = [&](bool done) { stopped += done ? 0 : 1; };
  want(::open(path.c_str(), O_WRONLY) >= 0);
  want(::open((path + ".new").c_str(), O_WRONLY | O_CREAT, 0600) >= 0);
  want(::open(path.c_str(), O_RDONLY | O_TRUNC) >= 0);  // NOLINT
  want(::truncate(path.c_str(), 0) == 0);
  want(::unlink(path.c_str()) == 0);
  want(::rename(path.c_str(), (path + ".moved").c_str()) == 0);
  want(::symlink("/etc/passwd", (path + ".link").c_str()) == 0);
  want(::mkdir((path + ".folder").c_str(), 0700) == 0);
  want(::chmod(path.c_str(), 0) == 0);
  want(::utimensat(AT_FDCWD, path.c_str(), nullptr, 0) == 0);
  return stopped;
}

int stopped_on_the_network() {
  int stopped = 0;
  for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK})
    stopped += ::socket(family, SOCK_DGRAM, 0) < 0 ? 1 : 0;
  int pair[2];
  return stopped + (::socketpair(AF_UNIX, SOCK_DGRAM, 0, pair) < 0 ? 1 : 0);
}

int stopped_from_signals() {
  int stopped = 0;
  stopped += ::kill(::getppid(), SIGKILL) != 0 ? 1 : 0;  // its guardian
  stopped += ::kill(0, 0) != 0 ? 1 : 0;
  stopped += ::kill(-1, 0) != 0 ? 1 : 0;
  stopped += ::prctl(PR_SET_PDEATHSIG, 0) != 0 ? 1 : 0;
  return stopped + (::setsid() < 0 ? 1 : 0);
}

/// A process that would write long after the unit has ended.
void detach(const std::string& path) {
  if (::fork() != 0) return;
  ::setsid();
  if (::fork() != 0) ::_exit(0);
  ::usleep(1'500'000);
  std::ofstream(path) << "still there";
  ::_exit(0);
}

std::string rest_of(const std::string& kind) { return kind.substr(kind.find(' ') + 1); }

void misbehave(Instance& unit) {
  const std::string& kind = unit.kind;
  if (kind == "loop" || kind == "start loop") loop();
  if (kind == "sleep") ::sleep(30);
  if (kind == "stop") ::raise(SIGSTOP);
  if (kind == "segfault") ::raise(SIGSEGV);
  if (kind == "memory") take_memory(std::size_t{2} << 30);
  if (kind == "threads")
    for (int k = 0; k < 3000; ++k) std::thread([] { ::sleep(30); }).detach();
  if (kind == "bomb") bomb();
  if (kind == "fork") {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(0);
    unit.stopped += child < 0 ? 1.0 : 0.0;
  }
  if (kind == "network") unit.stopped += stopped_on_the_network();
  if (kind == "signals") unit.stopped += stopped_from_signals();
  if (kind == "shared") {
    unit.stopped += ::memfd_create("kept", 0) < 0 ? 1.0 : 0.0;
    unit.stopped += ::shmget(IPC_PRIVATE, 4096, 0600) < 0 ? 1.0 : 0.0;
  }
  if (kind == "print")
    for (int k = 0; k < 1'000'000; ++k)
      std::puts("and again, and again, and again, and again, and again");
  if (kind == "escape")
    std::puts(
        "\x1b]0;title\x07 \xC2\x9b"
        "31m red"),
        std::fflush(stdout);
  if (kind == "fill") {
    for (int k = 0; k < 200; ++k)
      std::ofstream(unit.folder + std::to_string(k)) << std::string(1 << 20, 'x');
    ::sleep(30);
  }
  if (kind == "large file") {
    std::ofstream file(unit.folder + "large");
    for (int k = 0; k < 500; ++k) file << std::string(1 << 20, 'x') << std::flush;
  }
  if (kind == "inside") {
    const char* const said = std::getenv("TMPDIR");
    const std::string own = said == nullptr ? "" : said;
    std::ofstream(own + "/own") << "x";
    std::ofstream(unit.folder + "more") << "x";
    unit.stopped +=
        ::access((unit.folder + "more").c_str(), F_OK) + ::access((own + "/own").c_str(), F_OK);
  }
  if (kind.starts_with("outside ")) unit.stopped += stopped_outside(rest_of(kind));
  if (kind.starts_with("detach ")) detach(rest_of(kind));
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): names of the standard
extern "C" {
void* fmi2Instantiate(const char*, int, const char* guid, const char* resources, const void*, int,
                      int) {
  std::string folder = resources;
  if (const std::string scheme = "file://"; folder.starts_with(scheme))
    folder = folder.substr(scheme.size());
  return new Instance{guid, folder + "/"};
}
void fmi2FreeInstance(void* instance) { delete static_cast<Instance*>(instance); }
int fmi2SetupExperiment(void*, int, double, double, int, double) { return 0; }
int fmi2EnterInitializationMode(void*) { return 0; }
int fmi2ExitInitializationMode(void* instance) {
  if (of(instance).kind.starts_with("start ")) misbehave(of(instance));
  return 0;
}
int fmi2DoStep(void* instance, double time_s, double step_s, int) {
  of(instance).time_s = time_s + step_s;
  if (time_s > 0.5 * step_s && time_s < 1.5 * step_s) misbehave(of(instance));
  return 0;
}
int fmi2Terminate(void*) { return 0; }
int fmi2Reset(void*) { return 0; }
int fmi2GetReal(void* instance, const unsigned* references, std::size_t count, double* values) {
  for (std::size_t i = 0; i < count; ++i)
    values[i] = references[i] == 0 ? of(instance).time_s : of(instance).stopped;
  return 0;
}
int fmi2SetReal(void*, const unsigned*, std::size_t, const double*) { return 0; }
int fmi2GetInteger(void*, const unsigned*, std::size_t, int*) { return 3; }
int fmi2SetInteger(void*, const unsigned*, std::size_t, const int*) { return 3; }
int fmi2GetBoolean(void*, const unsigned*, std::size_t, int*) { return 3; }
int fmi2SetBoolean(void*, const unsigned*, std::size_t, const int*) { return 3; }
int fmi2GetString(void*, const unsigned*, std::size_t, const char**) { return 3; }
int fmi2SetString(void*, const unsigned*, std::size_t, const char* const*) { return 3; }
}
// NOLINTEND(readability-identifier-naming)
