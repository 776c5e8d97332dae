// Runs a fuzz target: as the entry of libFuzzer (KERBSTONE_LIBFUZZER), or as a program over the
// files of a corpus, each of them cut short and with bits flipped, and over mutants of them:
//   <reader>_fuzz_replay CORPUS... [--mutants COUNT] [--seed FIRST]
// One run may take 10 s and allocate 64 MB and 512 times the input (yaml-cpp takes 430 bytes for a
// comma).
#include <malloc.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <vector>

#include "fuzz/mutated.h"
#include "fuzz/target.h"

namespace {

std::size_t live_bytes = 0, peak_bytes = 0;

void* counted(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  live_bytes += malloc_usable_size(memory);
  peak_bytes = std::max(peak_bytes, live_bytes);
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return counted(std::malloc(size != 0 ? size : 1)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(step, (size + step - 1) / step * step));
}
void operator delete(void* memory) noexcept {
  if (memory != nullptr) live_bytes -= std::min(live_bytes, malloc_usable_size(memory));
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { operator delete(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  operator delete(memory);
}

// The fuzzer's own allocations pass through nothrow new, which stays as it was.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "alloc_dealloc_mismatch=0"; }

namespace {

void run_limited(std::string_view bytes) {
  const std::size_t before = live_bytes;
  peak_bytes = live_bytes;
  fuzz::run(bytes);
  const std::size_t most = (std::size_t{64} << 20) + 512 * bytes.size();
  if (peak_bytes - before <= most) return;
  std::fprintf(stderr, "%zu bytes of memory for an input of %zu\n", peak_bytes - before,
               bytes.size());
  std::abort();
}

constexpr unsigned kLongest_s = 10;
char current[600];  // what is being run, for the handler

extern "C" void say_where(int signal_number) {
  const char* const what = signal_number == SIGALRM ? "longer than 10 s: " : "ended by a signal: ";
  (void)!::write(STDERR_FILENO, what, std::strlen(what));
  (void)!::write(STDERR_FILENO, current, std::strlen(current));
  (void)!::write(STDERR_FILENO, "\n", 1);
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number == SIGALRM ? SIGKILL : signal_number);
}

void run_named(std::string_view bytes, const std::string& name) {
  std::snprintf(current, sizeof current, "%s", name.c_str());
  ::alarm(kLongest_s);
  run_limited(bytes);
  ::alarm(0);
}

struct Seed {
  std::string name, bytes;
};

std::vector<Seed> seeds_in(const std::vector<std::string>& places) {
  std::vector<std::string> paths;
  for (const std::string& place : places)
    if (std::filesystem::is_directory(place)) {
      for (const auto& entry : std::filesystem::recursive_directory_iterator(place))
        if (entry.is_regular_file()) paths.push_back(entry.path().string());
    } else {
      paths.push_back(place);
    }
  std::sort(paths.begin(), paths.end());
  std::vector<Seed> seeds;
  for (const std::string& path : paths) {
    std::ifstream file(path, std::ios::binary);
    seeds.push_back({path, {std::istreambuf_iterator<char>(file), {}}});
  }
  return seeds;
}

/// Mutant number `i`: of one seed after the other.
std::string mutant(const std::vector<Seed>& seeds, std::size_t i) {
  std::mt19937_64 generator(i);
  return fuzz::mutated(seeds[i % seeds.size()].bytes, generator,
                       i / seeds.size() % 2 == 0 ? 400 : 0);
}

int replay(const std::vector<std::string>& places, std::size_t mutants, std::size_t first,
           bool also_cut) {
  // On a stack of their own: a reader may have used up the other.
  static char stack[1 << 16];
  stack_t own{};
  own.ss_sp = stack, own.ss_size = sizeof stack;
  ::sigaltstack(&own, nullptr);
  for (const int number : {SIGALRM, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    struct sigaction action {};
    action.sa_handler = say_where, action.sa_flags = SA_ONSTACK;
    ::sigaction(number, &action, nullptr);
  }
  const std::vector<Seed> seeds = seeds_in(places);
  if (seeds.empty()) return std::fprintf(stderr, "no files\n"), 1;
  for (const Seed& seed : seeds) {
    run_named(seed.bytes, seed.name);
    for (std::size_t k = 1; k < 64 && also_cut; ++k) {
      const std::size_t at = seed.bytes.size() * k / 64;
      run_named(std::string_view(seed.bytes).substr(0, at),
                seed.name + " cut at " + std::to_string(at));
      std::string flipped = seed.bytes;
      if (at < flipped.size()) flipped[at] = static_cast<char>(flipped[at] ^ (1 << (k % 8)));
      run_named(flipped, seed.name + " bit flipped at " + std::to_string(at));
    }
  }
  double longest_s = 0.0;
  std::size_t longest = first;
  for (std::size_t i = first; i < first + mutants; ++i) {
    const auto start = std::chrono::steady_clock::now();
    run_named(mutant(seeds, i), "mutant --seed " + std::to_string(i) + " --mutants 1");
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (seconds > longest_s) longest_s = seconds, longest = i;
  }
  std::printf("%zu files, %zu mutants; the longest run took %.3f s (mutant %zu)\n", seeds.size(),
              mutants, longest_s, longest);
  return 0;
}

}  // namespace

#ifdef KERBSTONE_LIBFUZZER
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  run_limited({reinterpret_cast<const char*>(data), size});
  return 0;
}

/// KERBSTONE_MUTANTS=COUNT: the mutants of the replay, under the sanitizers, in place of fuzzing.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const char* const count = std::getenv("KERBSTONE_MUTANTS");
  if (count == nullptr) return 0;
  std::exit(replay({*argv + 1, *argv + *argc}, std::strtoul(count, nullptr, 10), 1, false));
}
#else
int main(int argc, char** argv) {
  std::vector<std::string> places;
  std::size_t mutants = 0, first = 1;
  const char* save = nullptr;
  for (int k = 1; k < argc; ++k) {
    const auto number = [&] { return k + 1 < argc ? std::strtoul(argv[++k], nullptr, 10) : 0; };
    if (std::strcmp(argv[k], "--mutants") == 0)
      mutants = number();
    else if (std::strcmp(argv[k], "--seed") == 0)
      first = number();
    else if (std::strcmp(argv[k], "--save") == 0 && k + 1 < argc)  // the first mutant, to a file
      save = argv[++k];
    else
      places.emplace_back(argv[k]);
  }
  if (save != nullptr) {
    std::ofstream(save, std::ios::binary) << mutant(seeds_in(places), first);
    return 0;
  }
  return replay(places, mutants, first, first == 1);
}
#endif
