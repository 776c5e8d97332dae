// Runs a foreign reader where its crash harms nobody.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>

#include "base/archive.h"
#include "base/descriptor.h"
#include "mesh/error.h"
#include "raw_mesh.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define KERBSTONE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define KERBSTONE_SANITIZED 1
#endif
#endif
#ifndef KERBSTONE_SANITIZED
#define KERBSTONE_SANITIZED 0
#endif

namespace road {
namespace {

// Sanitizers need terabytes of addresses, ten times the time, and their words on stderr.
constexpr bool kSanitized = KERBSTONE_SANITIZED;
// The slowest import that was seen takes 0.2 s and 60 bytes per byte of its file.
constexpr std::size_t kSeconds = kSanitized ? 80 : 8;
constexpr std::size_t kBytesPerSecond = kSanitized ? 50'000 : 500'000;
constexpr std::size_t kMemory = 1'000'000'000;
constexpr std::size_t kMemoryPerByte = 150;
// A process that waits (for a slow disk, for others) is given this much more than one that works.
constexpr std::size_t kWaiting = 10;

constexpr base::ArchiveKind kRawMesh{"kerbstone mesh", 1};

/// Every value of a mesh, for both directions.
template <typename Archive, typename Mesh>
void each(Archive& a, Mesh& mesh) {
  a(mesh.vertices), a(mesh.triangles), a(mesh.object_of_triangle), a(mesh.objects),
      a(mesh.stored_as_float32);
  a(mesh.local_magnitude), a(mesh.metres_per_unit), a(mesh.up), a(mesh.left_handed),
      a(mesh.remarks), a(mesh.files);
}

/// Whether all of it went. Without a refusal the mesh counts.
bool send(int descriptor, const std::string& refusal, const RawMesh& mesh) {
  base::ArchiveWriter writer(kRawMesh);
  writer(refusal);
  each(writer, mesh);
  const std::string bytes = writer.finish();
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::write(descriptor, bytes.data() + at, bytes.size() - at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += static_cast<std::size_t>(count);
  }
  return true;
}

/// What the child may take, growing with the bytes that it has to read.
class Limits {
 public:
  Limits() {
    ::getrlimit(RLIMIT_AS, &memory_);
    ::getrlimit(RLIMIT_CPU, &seconds_);
    std::size_t pages = 0;
    if (!(std::ifstream("/proc/self/statm") >> pages)) pages = 0;
    // Without /proc there is no telling what this process holds already.
    bounds_memory_ = !kSanitized && pages > 0;
    held_ = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  }
  void grow(std::size_t bytes) {
    bytes_ += bytes;
    const std::size_t seconds = kSeconds + bytes_ / kBytesPerSecond;
    set(RLIMIT_CPU, seconds_, seconds);
    ::alarm(static_cast<unsigned>(std::min<std::size_t>(kWaiting * seconds, 1'000'000)));
    if (bounds_memory_) set(RLIMIT_AS, memory_, held_ + kMemory + kMemoryPerByte * bytes_);
  }
  std::size_t seconds() const { return kSeconds + bytes_ / kBytesPerSecond; }

 private:
  static void set(__rlimit_resource resource, rlimit was, rlim_t wanted) {
    was.rlim_cur = std::min<rlim_t>(was.rlim_cur, wanted);
    ::setrlimit(resource, &was);
  }
  rlimit memory_{}, seconds_{};
  bool bounds_memory_ = false;
  std::size_t held_ = 0, bytes_ = 0;
};

/// The system counts memory that two processes share as a file.
bool is_at_file_limit(std::size_t bytes) {
  rlimit most{};
  return ::getrlimit(RLIMIT_FSIZE, &most) == 0 && bytes >= most.rlim_cur;
}

/// What the child does; its exit code.
int run_child(pid_t parent, int result, const std::string& path, std::size_t bytes,
              const std::function<RawMesh(const std::function<void(std::size_t)>&)>& read) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) return 1;
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  sigset_t timers;
  sigemptyset(&timers);
  for (const int signal : {SIGALRM, SIGXCPU}) {
    ::signal(signal, SIG_DFL);
    sigaddset(&timers, signal);
  }
  ::sigprocmask(SIG_UNBLOCK, &timers, nullptr);
  // A crash speaks through this process, and no lock or pipe of it shall stay open through the
  // child.
  if (!kSanitized) {
    const int nowhere = ::open("/dev/null", O_RDWR);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::close_range(STDERR_FILENO + 1, static_cast<unsigned>(result) - 1, 0);
    ::close_range(static_cast<unsigned>(result) + 1, ~0U, 0);
  }
  Limits limits;
  limits.grow(bytes);
  std::string refusal;
  try {
    const RawMesh mesh = read([&](std::size_t more) { limits.grow(more); });
    return send(result, refusal, mesh) ? 0 : 1;
  } catch (const Error& error) {
    refusal = error.what();
  } catch (const std::bad_alloc&) {
    refusal = fmt::format(
        "{}: reading it needs far more memory than a mesh of {} bytes should; the file is "
        "damaged: copy or export it again",
        path, bytes);
  } catch (const std::exception& error) {
    refusal = fmt::format("{}: no mesh can be read from it: {}; copy or export it again", path,
                          error.what());
  }
  return send(result, refusal, {}) ? 0 : 1;
}

}  // namespace

RawMesh read_in_child(
    const std::string& path, std::size_t bytes,
    const std::function<RawMesh(const std::function<void(std::size_t)>& opened)>& read) {
  const base::Descriptor result(::memfd_create("kerbstone-mesh", MFD_CLOEXEC));
  const pid_t parent = ::getpid();
  const pid_t child = result.value < 0 ? -1 : ::fork();
  if (child < 0)
    throw Error(
        fmt::format("{}: cannot start a process to read it in: {}", path, std::strerror(errno)));
  if (child == 0) ::_exit(run_child(parent, result.value, path, bytes, read));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  constexpr const char* kAdvice =
      "the file is damaged, or nested or large beyond reason: export it again, or convert it to "
      ".obj, .ply "
      "or .stl with another program";
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGALRM))
    throw Error(fmt::format("{}: reading it took so long that it was given up; {}", path, kAdvice));
  if (WIFSIGNALED(status))
    throw Error(fmt::format("{}: the reader of such files crashed ({}); {}", path,
                            ::strsignal(WTERMSIG(status)), kAdvice));
  struct stat state {};
  ::fstat(result.value, &state);
  const auto size = static_cast<std::size_t>(state.st_size);
  void* mapped =
      size == 0 ? MAP_FAILED : ::mmap(nullptr, size, PROT_READ, MAP_SHARED, result.value, 0);
  RawMesh mesh;
  std::string refusal;
  bool whole = false;
  if (mapped != MAP_FAILED) {
    base::ArchiveReader reader({static_cast<const char*>(mapped), size}, kRawMesh);
    reader(refusal);
    each(reader, mesh);
    whole = reader.finish();
    ::munmap(mapped, size);
  }
  if (!whole)
    throw Error(is_at_file_limit(size)
                    ? fmt::format("{}: read, it takes more than the {} bytes that 'ulimit -f' "
                                  "allows; raise that limit",
                                  path, size)
                    : fmt::format("{}: the reader of such files broke off; {}", path, kAdvice));
  if (!refusal.empty()) throw Error(refusal);
  return mesh;
}

}  // namespace road
