// Loading a KRBI file of 18.5 MB (3 km, 0.1 x 0.1 m, 15 m wide) from the page cache: seconds, and
// memory as a share of the payload. kept_ratio: by how much a process that has read another road
// before has more of its own at the end; peak_ratio: had more at once. fresh_ratio: how far the
// memory of a fresh process grows, pages of the program counted, which are the same for any road.
// crg_load_bench COLUMNS makes it as wide as that (151 where none are given). Figures:
// docs/evidence.md.
#include <benchmark/benchmark.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "crg/roads.h"
#include "crg/surface.h"

namespace {

using namespace crg;

std::string road_path, other_path;

void write_road(const std::string& path, std::size_t rows, double radius_m, std::size_t columns) {
  ReferenceLine line = test::circuit(rows, radius_m, 0.12, 5);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double t = 2.0 * M_PI * static_cast<double>(i) / static_cast<double>(line.size() - 1);
    line.z_m.push_back(200.0 + 10.0 * std::sin(2.0 * t));
    line.banking.push_back(0.04 * std::sin(5.0 * t));
  }
  const auto height = [](double u, double v) {
    return 0.01 * std::sin(7.0 * u) + 0.02 * std::cos(0.9 * v);
  };
  const double half_width_m = 0.05 * static_cast<double>(columns - 1);
  write(make_crg(line, test::grid_of(line, -half_width_m, half_width_m, columns, height)), path,
        Format::KRBI);
}

// In bytes, of this process. "VmHWM:": resident at once so far, mapped files included; "RssAnon:":
// resident now, no file's.
double memory(const char* which) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == which && status >> word) return 1024.0 * std::stod(word);
  }
  return NAN;
}

// Runs the work in a child of its own and hands back the number it answers: the memory of one does
// not hide in that of another.
template <typename Work>
double in_child(Work work) {
  int ends[2];
  if (pipe(ends) != 0) return NAN;
  const pid_t child = fork();
  if (child == 0) {
    const double answer = work();
    _exit(::write(ends[1], &answer, sizeof answer) == sizeof answer ? 0 : 1);
  }
  double answer = NAN;
  if (::read(ends[0], &answer, sizeof answer) != sizeof answer) answer = NAN;
  close(ends[0]);
  close(ends[1]);
  int status = 0;
  waitpid(child, &status, 0);
  return answer;
}

// The payload: the grid and the three channels beside it.
double payload_bytes(const Crg& crg) {
  return 4.0 * static_cast<double>(crg.grid.z_m.size() + 3 * crg.grid.rows());
}

struct Growth {
  double fresh = NAN, peak = NAN, kept = NAN;
};

double share_of(const char* which, bool with_surface, bool warm) {
  return in_child([&] {
    if (warm) Surface{read(other_path)};
    const double before = memory(which);
    Crg crg = read(road_path);
    const double payload = payload_bytes(crg);
    if (!with_surface) return (memory(which) - before) / payload;
    const Surface surface(std::move(crg));
    return (memory(which) - before) / payload;
  });
}
Growth growth_of(bool with_surface) {
  return {share_of("VmHWM:", with_surface, false), share_of("VmHWM:", with_surface, true),
          share_of("RssAnon:", with_surface, true)};
}
Growth growth_read, growth_surface;

void count(benchmark::State& state, const Growth& growth) {
  state.counters["kept_ratio"] = growth.kept;
  state.counters["peak_ratio"] = growth.peak;
  state.counters["fresh_ratio"] = growth.fresh;
}
void load(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(read(road_path));
  count(state, growth_read);
}
void load_and_make_surface(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(Surface(read(road_path)));
  count(state, growth_surface);
}
BENCHMARK(load)->Unit(benchmark::kMillisecond);
BENCHMARK(load_and_make_surface)->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  std::string folder = (std::filesystem::temp_directory_path() / "crg_load_XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return 1;
  road_path = folder + "/road.crg";
  const std::size_t columns = argc > 1 && argv[1][0] != '-' ? std::stoul(argv[1]) : 151;
  other_path = folder + "/other.crg";
  in_child([&] {
    write_road(road_path, 30001, 450.0, columns);
    write_road(other_path, 301, 4.5, 151);
    return 0.0;
  });
  growth_read = growth_of(false);
  growth_surface = growth_of(true);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  std::filesystem::remove_all(folder);
}
