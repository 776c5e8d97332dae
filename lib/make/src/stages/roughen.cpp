// Roughness that a mesh of large facets has not: waves with the spectrum of a class of ISO 8608.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "circuit/iso8608.h"
#include "grid_stage.h"
#include "key_kinds.h"
#include "mesh/error.h"

namespace road {
namespace stage_roughen {
namespace {

constexpr char kNone = '-';
constexpr double kRowsPerWave = 4.0;  // with fewer, straight lines between nodes take height away

struct Roughen {
  char iso_class = kNone;
  std::uint64_t seed = 1;
  double longest_wave_m = 5.0, shortest_wave_m = 0.5;
};

struct Roughened {
  double rms_m = 0.0, largest_m = 0.0;
};

void add_keys(std::vector<RecipeKey>& keys) {
  std::vector<std::pair<std::string, char>> classes{{"none", kNone}};
  for (char one = 'A'; one <= 'H'; ++one) classes.emplace_back(std::string(1, one), one);
  keys.push_back(choice<char>(
      "roughen", "roughness_class", std::move(classes),
      "roughness of this class of ISO 8608 is added to the heights, for meshes without any",
      [](Recipe& r) -> char& { return r.more.of<Roughen>().iso_class; }));
  keys.push_back(whole_number<std::uint64_t>(
      "roughen", "roughness_seed", 0, 1'000'000'000, "of this roughness: the same, the same waves",
      [](Recipe& r) { return std::vector<std::uint64_t*>{&r.more.of<Roughen>().seed}; }));
  keys.push_back(number("roughen", "roughness_longest_wave_m", 0.1, 100.0,
                        "longer waves are left to the mesh",
                        [](Recipe& r) -> double& { return r.more.of<Roughen>().longest_wave_m; }));
  keys.push_back(number("roughen", "roughness_shortest_wave_m", 0.01, 100.0,
                        "shorter waves are left out; four steps of the grid or more",
                        [](Recipe& r) -> double& { return r.more.of<Roughen>().shortest_wave_m; }));
}

bool wanted(const Recipe& recipe) { return recipe.more.of<Roughen>().iso_class != kNone; }

/// Throws where grid or road are too coarse or too short for the waves.
void check(const Roughen& options, const crg::Grid& grid, const crg::ReferenceLine& line,
           double whole_length_m) {
  double step_m = line.u_step_m;
  for (std::size_t j = 1; j < grid.v_m.size(); ++j)
    step_m = std::max(step_m, grid.v_m[j] - grid.v_m[j - 1]);
  if (!(options.longest_wave_m > options.shortest_wave_m))
    throw Error(
        fmt::format("roughness_longest_wave_m is {:g} and roughness_shortest_wave_m {:g}: the "
                    "longest must be longer",
                    options.longest_wave_m, options.shortest_wave_m));
  // Steps are stretched a little so that a closed road closes.
  if (options.shortest_wave_m < 0.99 * kRowsPerWave * step_m)
    throw Error(
        fmt::format("roughness_shortest_wave_m is {:g}, but a grid with steps of {:.4g} m holds "
                    "waves of {:.4g} m and longer; raise it, or give smaller --u-step-m and "
                    "--v-step-m",
                    options.shortest_wave_m, step_m, kRowsPerWave * step_m));
  if (!(options.longest_wave_m < whole_length_m))
    throw Error(fmt::format("roughness_longest_wave_m is {:g}, the road {:.4g} m long; lower it",
                            options.longest_wave_m, whole_length_m));
}

/// Adds to every node with a height, and gives what it added: 0 where there is none. The n-th row
/// lies at u_begin_m + n u_step_m of the whole road.
std::vector<float> add(const Roughness& roughness, double u_begin_m, double u_step_m,
                       unsigned threads, crg::Grid& grid) {
  const std::size_t columns = grid.v_m.size(), rows = grid.z_m.size() / columns;
  std::vector<float> added_m(grid.z_m.size(), 0.0F);
  base::parallel_for(rows, 64, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> u_m, height_m((end - begin) * columns, 0.0);
    for (std::size_t i = begin; i < end; ++i)
      u_m.push_back(u_begin_m + static_cast<double>(i) * u_step_m);
    roughness.add_grid(u_m, grid.v_m, height_m);
    for (std::size_t k = 0; k < height_m.size(); ++k) {
      float& z_m = grid.z_m[begin * columns + k];
      if (std::isnan(z_m)) continue;
      added_m[begin * columns + k] = static_cast<float>(height_m[k]);
      z_m += added_m[begin * columns + k];
    }
  });
  return added_m;
}

void run(const GridWork& work) {
  const Roughen& options = work.recipe.more.of<Roughen>();
  MadeRoad& built = work.built;
  // The last row of a closed road is its first; a stretch has the steps of the whole.
  const double step_m = built.line.u_step_m,
               whole_length_m = std::round(built.summary.reference_line.length_m / step_m) * step_m;
  check(options, built.sampled.grid, built.line, whole_length_m);
  const Roughness roughness({.iso_class = options.iso_class,
                             .seed = options.seed,
                             .n_min_cpm = 1.0 / options.longest_wave_m,
                             .n_max_cpm = 1.0 / options.shortest_wave_m},
                            whole_length_m);
  const unsigned threads = work.recipe.sample.threads;
  built.added_m =
      add(roughness, built.line.u_begin_m, built.line.u_step_m, threads, built.sampled.grid);
  for (KerbPatch& patch : built.patches)
    add(roughness, patch.u_begin_m, patch.line.u_step_m, threads, patch.grid);
  Roughened& done = built.summary.more.of<Roughened>();
  double sum2 = 0.0, nodes = 0.0;
  for (std::size_t k = 0; k < built.added_m.size(); ++k) {
    if (std::isnan(built.sampled.grid.z_m[k])) continue;
    const auto one = static_cast<double>(built.added_m[k]);
    sum2 += one * one;
    nodes += 1.0;
    done.largest_m = std::max(done.largest_m, std::abs(one));
  }
  if (nodes > 0.0) done.rms_m = std::sqrt(sum2 / nodes);
}

void report(const BuildSummary& summary, Json& out) {
  if (!wanted(summary.recipe)) return void(out["roughen"] = nullptr);
  const Roughened& done = summary.more.of<Roughened>();
  out["roughen"] = {{"rms_m", done.rms_m}, {"largest_m", done.largest_m}};
}

}  // namespace
}  // namespace stage_roughen

GridStage roughen() {
  using namespace stage_roughen;
  return {.name = "roughen", .add_keys = add_keys, .wanted = wanted, .run = run, .report = report};
}

}  // namespace road
