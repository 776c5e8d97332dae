#include "sandbox.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "base/descriptor.h"
#include "base/error.h"

namespace sim {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw base::Error(fmt::format(
      "the unit's sandbox cannot be made: {}: {}; Linux 5.13 with Landlock and seccomp wanted; "
      "--trust runs the unit with all your rights",
      what, std::strerror(errno)));
}

// Landlock, by the kernel's numbers: headers of many machines are older than their kernel.
constexpr long kCreateRuleset = 444, kAddRule = 445, kRestrictSelf = 446;
constexpr std::uint64_t kWriteFile = 1u << 1, kRemoves = 3u << 4, kMakeDirectory = 1u << 7,
                        kMakeFile = 1u << 8, kMakeLink = 1u << 12, kAllMakes = 0x7fu << 6,
                        kRefer = 1u << 13, kTruncate = 1u << 14, kControlDevices = 1u << 15,
                        kSignals = 1u << 1;

struct Ruleset {
  std::uint64_t files, network, scopes;
};
struct __attribute__((packed)) Beneath {
  std::uint64_t allowed;
  std::int32_t parent;
};

void allow(int ruleset, const char* path, std::uint64_t what) {
  const base::Descriptor at(::open(path, O_PATH | O_CLOEXEC));
  const Beneath rule{what, at.value};
  if (at.value < 0 || ::syscall(kAddRule, ruleset, 1, &rule, 0) != 0) refuse(path);
}

void write_in_folder_alone(const std::string& folder) {
  const long version = ::syscall(kCreateRuleset, nullptr, 0, 1);
  if (version < 1) refuse("Landlock");
  const std::uint64_t since_2 = version >= 2 ? kRefer : 0, since_3 = version >= 3 ? kTruncate : 0;
  const Ruleset rules{
      kWriteFile | kRemoves | kAllMakes | since_2 | since_3 | (version >= 5 ? kControlDevices : 0),
      0, version >= 6 ? kSignals : 0};
  const std::size_t size = version >= 6   ? sizeof rules
                           : version >= 4 ? 2 * sizeof rules.files
                                          : sizeof rules.files;
  const base::Descriptor ruleset(static_cast<int>(::syscall(kCreateRuleset, &rules, size, 0)));
  if (ruleset.value < 0) refuse("Landlock");
  allow(ruleset.value, folder.c_str(),
        kWriteFile | kRemoves | kMakeDirectory | kMakeFile | kMakeLink | since_2 | since_3);
  allow(ruleset.value, "/dev/null", kWriteFile);
  if (::syscall(kRestrictSelf, ruleset.value, 0) != 0) refuse("Landlock");
}

void close_all_but(const std::vector<int>& keep) {
  std::vector<int> opened;
  DIR* const folder = ::opendir("/proc/self/fd");
  if (folder == nullptr) refuse("/proc/self/fd");
  while (const dirent* const entry = ::readdir(folder)) opened.push_back(std::atoi(entry->d_name));
  ::closedir(folder);
  for (const int one : opened)
    if (one > STDERR_FILENO && std::find(keep.begin(), keep.end(), one) == keep.end()) ::close(one);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing < 0) refuse("/dev/null");
  ::dup2(nothing, STDIN_FILENO);
  if (nothing != STDIN_FILENO) ::close(nothing);
}

/// Real time is scheduled, and its memory held, when the unit is there already.
void drop_rights(bool real_time) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> rights{};
  if (::syscall(SYS_capget, &header, rights.data()) != 0) refuse("capabilities");
  const std::uint32_t kept =
      real_time ? (1u << CAP_SYS_NICE | 1u << CAP_IPC_LOCK) & rights[0].permitted : 0;
  rights = {};
  rights[0].effective = rights[0].permitted = kept;
  if (::syscall(SYS_capset, &header, rights.data()) != 0) refuse("capabilities");
}

struct Call {
  const char* name;
  unsigned number;
};

/// A system call that is refused by the low half of an argument.
struct Rule {
  Call call;
  int argument;
  std::uint32_t mask, value;
  bool when_equal = true;
};

#define CALL(NAME) \
  Call { #NAME, SYS_##NAME }

/// Refused always; by number where the headers of Debian 12 do not have it.
constexpr Call kRefused[] = {
    // Processes, and what would outlive this one.
    CALL(fork),
    CALL(vfork),
    CALL(execve),
    CALL(execveat),
    CALL(setsid),
    CALL(setpgid),
    CALL(unshare),
    CALL(setns),
    // Others' processes.
    CALL(tkill),
    Call{"pidfd_send_signal", 424},
    Call{"pidfd_getfd", 438},
    Call{"process_madvise", 440},
    CALL(ptrace),
    CALL(process_vm_readv),
    CALL(process_vm_writev),
    CALL(setpriority),
    CALL(ioprio_set),
    CALL(move_pages),
    CALL(migrate_pages),
    // The network, and sockets of this machine.
    CALL(socket),
    CALL(socketpair),
    CALL(connect),
    CALL(bind),
    CALL(listen),
    CALL(accept),
    CALL(accept4),
    // What Landlock leaves free.
    CALL(truncate),
    CALL(chmod),
    CALL(fchmod),
    CALL(fchmodat),
    Call{"fchmodat2", 452},
    CALL(chown),
    CALL(fchown),
    CALL(lchown),
    CALL(fchownat),
    CALL(utime),
    CALL(utimes),
    CALL(futimesat),
    CALL(utimensat),
    CALL(setxattr),
    CALL(lsetxattr),
    CALL(fsetxattr),
    CALL(removexattr),
    CALL(lremovexattr),
    CALL(fremovexattr),
    Call{"setxattrat", 463},
    Call{"removexattrat", 466},
    Call{"file_setattr", 469},
    // Memory that is no process's own, and ways around this list.
    CALL(memfd_create),
    Call{"memfd_secret", 447},
    CALL(shmget),
    CALL(shmat),
    CALL(shmctl),
    CALL(semget),
    CALL(semop),
    CALL(semtimedop),
    CALL(semctl),
    CALL(msgget),
    CALL(msgsnd),
    CALL(msgrcv),
    CALL(msgctl),
    CALL(mq_open),
    CALL(mq_unlink),
    Call{"io_uring_setup", 425},
    Call{"io_uring_enter", 426},
    Call{"io_uring_register", 427},
    CALL(userfaultfd),
    CALL(perf_event_open),
    CALL(bpf),
    CALL(add_key),
    CALL(request_key),
    CALL(keyctl),
};

std::vector<Rule> rules() {
  const auto self = static_cast<std::uint32_t>(::getpid());
  constexpr std::uint32_t kThread = 0x10000, kOpens = O_TRUNC | O_ACCMODE, kNoAccess = O_ACCMODE;
  return {
      // Processes, and what would outlive this one.
      {CALL(clone), 0, kThread, 0},
      {CALL(prctl), 0, ~0u, PR_SET_PDEATHSIG},

      // Others' processes.
      {CALL(kill), 0, ~0u, self, false},
      {CALL(tgkill), 0, ~0u, self, false},
      {CALL(rt_sigqueueinfo), 0, ~0u, self, false},
      {CALL(rt_tgsigqueueinfo), 0, ~0u, self, false},
      {CALL(prlimit64), 0, ~0u, 0, false},
      {CALL(fcntl), 1, ~0u, F_SETOWN},
      {CALL(fcntl), 1, ~0u, 15 /* F_SETOWN_EX */},
      {CALL(fcntl), 1, ~0u, 10 /* F_SETSIG */},
      {CALL(ioctl), 1, ~0u, 0x8901 /* FIOSETOWN */},
      {CALL(ioctl), 1, ~0u, 0x8902 /* SIOCSPGRP */},
      {CALL(ioctl), 1, ~0u, TCSETS},
      {CALL(ioctl), 1, ~0u, TCSETSW},
      {CALL(ioctl), 1, ~0u, TCSETSF},
      {CALL(ioctl), 1, ~0u, TIOCSTI},
      {CALL(ioctl), 1, ~0u, TIOCLINUX},

      // What Landlock leaves free.
      {CALL(open), 1, kOpens, O_TRUNC},
      {CALL(openat), 2, kOpens, O_TRUNC},
      {CALL(open), 1, kNoAccess, kNoAccess},
      {CALL(openat), 2, kNoAccess, kNoAccess},
  };
}

#undef CALL

std::vector<sock_filter> program(std::uint32_t refused) {
  const auto load = [](std::size_t at) {
    return sock_filter{BPF_LD | BPF_W | BPF_ABS, 0, 0, static_cast<std::uint32_t>(at)};
  };
  const auto give = [](std::uint32_t what) { return sock_filter{BPF_RET | BPF_K, 0, 0, what}; };
  const auto equal = [](std::uint32_t value, std::uint8_t yes, std::uint8_t no) {
    return sock_filter{BPF_JMP | BPF_JEQ | BPF_K, yes, no, value};
  };
  const sock_filter load_call = load(offsetof(seccomp_data, nr));
  std::vector<sock_filter> out{load(offsetof(seccomp_data, arch)),
                               equal(AUDIT_ARCH_X86_64, 1, 0),
                               give(SECCOMP_RET_KILL_PROCESS),
                               load_call,
                               {BPF_JMP | BPF_JGE | BPF_K, 0, 1, 0x40000000},  // of x32
                               give(SECCOMP_RET_KILL_PROCESS)};
  for (const Call& call : kRefused)
    out.insert(out.end(), {equal(call.number, 0, 1), give(refused)});
  for (const Rule& rule : rules()) {
    const std::size_t at =
        offsetof(seccomp_data, args) + 8 * static_cast<std::size_t>(rule.argument);
    out.insert(out.end(), {equal(rule.call.number, 0, 4),
                           load(at),
                           {BPF_ALU | BPF_AND | BPF_K, 0, 0, rule.mask},
                           rule.when_equal ? equal(rule.value, 0, 1) : equal(rule.value, 1, 0),
                           give(refused),
                           load_call});
  }
  // Their arguments lie in memory; libraries know the older calls for them.
  for (const std::uint32_t unseen : {435u /* clone3 */, 437u /* openat2 */})
    out.insert(out.end(), {equal(unseen, 0, 1), give(SECCOMP_RET_ERRNO | ENOSYS)});
  out.push_back(give(SECCOMP_RET_ALLOW));
  return out;
}

long filter(std::uint32_t refused, unsigned long flags) {
  std::vector<sock_filter> code = program(refused);
  const sock_fprog all{static_cast<unsigned short>(code.size()), code.data()};
  return ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, flags, &all);
}

}  // namespace

void confine_files(const std::string& folder, double largest_file_bytes,
                   const std::vector<int>& keep, bool real_time) {
  close_all_but(keep);
  const auto most = static_cast<rlim_t>(largest_file_bytes);
  const rlimit file{most, most}, no_core{0, 0};
  if (::setrlimit(RLIMIT_FSIZE, &file) != 0 || ::setrlimit(RLIMIT_CORE, &no_core) != 0)
    refuse("limits");
  ::setenv("TMPDIR", folder.c_str(), 1);
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) refuse("no_new_privs");
  drop_rights(real_time);
  write_in_folder_alone(folder);
}

int confine_calls() {
  constexpr unsigned long kThreads = SECCOMP_FILTER_FLAG_TSYNC | SECCOMP_FILTER_FLAG_TSYNC_ESRCH;
  const long listener = filter(SECCOMP_RET_USER_NOTIF, kThreads | SECCOMP_FILTER_FLAG_NEW_LISTENER);
  if (listener >= 0) return static_cast<int>(listener);
  // Older kernels, and where a container listens already.
  if (filter(SECCOMP_RET_ERRNO | EPERM, SECCOMP_FILTER_FLAG_TSYNC) != 0) refuse("seccomp");
  return -1;
}

std::string refuse_call(int listener) {
  seccomp_notif asked{};
  if (::ioctl(listener, SECCOMP_IOCTL_NOTIF_RECV, &asked) != 0) return {};
  seccomp_notif_resp answer{};
  answer.id = asked.id;
  answer.error = -EPERM;
  ::ioctl(listener, SECCOMP_IOCTL_NOTIF_SEND, &answer);
  const auto number = static_cast<unsigned>(asked.data.nr);
  for (const Call& call : kRefused)
    if (call.number == number) return call.name;
  for (const Rule& rule : rules())
    if (rule.call.number == number) return rule.call.name;
  return {};
}

}  // namespace sim
