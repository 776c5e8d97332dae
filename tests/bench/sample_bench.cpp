// Speed of the sampling stage beside its limit: the same rays as bare 16-wide Embree casts.
//
//   sample_bench [MESH]          default: g-track-1 of torcs-data, else the demo circuit
//
// Both are timed alternately in one run on one thread, so that the ratio holds on a busy machine.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "road/circuit.h"
#include "road/clean.h"
#include "road/read_mesh.h"
#include "road/reference_line.h"
#include "road/sample.h"
#include "road/synth.h"

namespace {

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Every ray of the grid in the order in which the sampler casts: 16 rows at a time, column by column.
std::vector<road::RayPacket16> packets_of(const road::SampledGrid& sampled, const crg::ReferenceLine& line,
                                          const Eigen::Vector3d& origin) {
  std::vector<road::RayPacket16> packets;
  const crg::Grid& grid = sampled.grid;
  for (std::size_t first = 0; first + 16 <= grid.rows(); first += 16) {
    for (std::size_t j = 0; j < grid.columns(); ++j) {
      road::RayPacket16 packet{};
      bool any = false;
      for (std::size_t k = 0; k < 16; ++k) {
        const float z = grid.at(first + k, j);
        if (std::isnan(z)) continue;
        const crg::Point2 p = crg::node_position(line, first + k, grid.v_m[j]);
        packet.x_m[k] = static_cast<float>(p.x_m - origin.x());
        packet.y_m[k] = static_cast<float>(p.y_m - origin.y());
        packet.z_top_m[k] = static_cast<float>(static_cast<double>(z) - origin.z()) + 2.0f;
        packet.active[k] = -1;
        any = true;
      }
      if (any) packets.push_back(packet);
    }
  }
  return packets;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string torcs = std::string(TORCS_TRACKS) + "/road/g-track-1/g-track-1.acc";
  const bool given = argc > 1;
  const road::Mesh mesh = given || std::filesystem::exists(torcs)
                              ? road::read_mesh(given ? argv[1] : torcs)
                              : road::make_circuit_mesh(road::read_circuit(std::string(KERBSTONE_SOURCE) + "/tracks/kerbstone-ring/circuit.yaml"));
  const road::RoadMesh road = road::clean(mesh);
  const auto centreline = road::trace_centreline(road);
  const auto line = road::fit_reference_line(centreline);
  const road::RaySurface surface(road.mesh);
  road::SampleOptions options;
  options.threads = 1;
  road::SampleReport report;
  auto sampled = road::sample_grid(road, surface, line, centreline, options, &report);
  auto packets = packets_of(sampled, line, surface.origin_m());
  std::size_t rays = 0;
  for (const auto& packet : packets) rays += static_cast<std::size_t>(std::count(packet.active.begin(), packet.active.end(), -1));

  std::vector<double> sample_s, bare_s;
  double check = 0.0;
  for (int round = 0; round < 7; ++round) {
    double start = now_s();
    sampled = road::sample_grid(road, surface, line, centreline, options);
    sample_s.push_back(now_s() - start);
    start = now_s();
    for (auto& packet : packets) {
      surface.cast_down(packet);
      if (packet.active[0] != 0) check += static_cast<double>(packet.z_m[0]);
    }
    bare_s.push_back(now_s() - start);
  }
  std::sort(sample_s.begin(), sample_s.end());
  std::sort(bare_s.begin(), bare_s.end());
  const double nodes = static_cast<double>(report.nodes), cast = static_cast<double>(rays);
  fmt::print("{} triangles, {:.3g} nodes, {:.3g} rays that hit, one thread, best of {} (check {:.0f})\n", road.mesh.triangles.size(), nodes,
             cast, sample_s.size(), check);
  fmt::print("sample_grid       {:6.1f} M nodes/s  {:6.1f} M rays/s\n", nodes / sample_s[0] * 1e-6, cast / sample_s[0] * 1e-6);
  fmt::print("bare Embree casts {:6.1f} M rays/s\n", cast / bare_s[0] * 1e-6);
  fmt::print("share of the limit {:.1f} %\n", 100.0 * bare_s[0] / sample_s[0]);
}
