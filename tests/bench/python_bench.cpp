// The C++ half of python_bench.py: the same road, the same points, the same questions.
// python_bench ROAD.crg POINTS ROUNDS, POINTS being x and y in turn as doubles; prints the best
// rate of heights and of everything in one call, M/s of processor time.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <span>
#include <vector>

#include "crg/options.h"
#include "crg/surface.h"

namespace {

template <class Work>
double best_rate(int rounds, std::size_t count, Work work) {
  double best = 0.0;
  for (int k = 0; k < rounds; ++k) {
    const std::clock_t begin = std::clock();  // other work of the machine does not count
    work();
    const auto took_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    best = std::max(best, 1e-6 * static_cast<double>(count) / took_s);
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "python_bench ROAD.crg POINTS ROUNDS\n");
    return 2;
  }
  const crg::Surface road(crg::read(argv[1]));
  std::ifstream file(argv[2], std::ios::binary | std::ios::ate);
  std::vector<crg::Point2> points(static_cast<std::size_t>(file.tellg()) / sizeof(crg::Point2));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(points.data()),
            static_cast<std::streamsize>(points.size() * sizeof(crg::Point2)));
  const int rounds = std::atoi(argv[3]);
  std::vector<double> z_m(points.size());
  std::vector<crg::Sample> samples(points.size());
  const double heights = best_rate(rounds, points.size(), [&] {
    crg::Cursor cursor;
    road.z_at_xy(points, std::span<double>(z_m), cursor);
  });
  const double everything = best_rate(rounds, points.size(), [&] {
    crg::Cursor cursor;
    road.at_xy(points, std::span<crg::Sample>(samples), cursor);
  });
  std::printf("%.3f %.3f\n", heights, everything);
  return 0;
}
