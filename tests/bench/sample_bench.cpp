// Speed of the sampling stage beside its limit: the same rays as bare 16-wide Embree casts.
//
//   sample_bench [MESH]          default: g-track-1 of torcs-data, else the demo circuit
//
// Both are timed alternately in one run on one thread, so that the ratio holds on a busy machine.
#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <ctime>
#include <cmath>
#include <filesystem>

#include "road/circuit.h"
#include "road/clean.h"
#include "road/read_mesh.h"
#include "road/reference_line.h"
#include "road/sample.h"
#include "road/synth.h"
#include "wide.h"

namespace {

/// Processor time of this thread: what other programs take from it does not count.
double now_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// An Embree scene as the sampler's, without anything of lib/road around it.
struct BareScene {
  explicit BareScene(const road::Mesh& mesh, const Eigen::Vector3d& origin) : device(rtcNewDevice("threads=1")), scene(rtcNewScene(device)) {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices_m.size()));
    for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
      const Eigen::Vector3f local = (vertex + mesh.origin_m - origin).cast<float>();
      v = std::copy(local.data(), local.data() + 3, v);
    }
    auto* i = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles) i = std::copy(triangle.begin(), triangle.end(), i);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~BareScene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  BareScene(const BareScene&) = delete;
  BareScene& operator=(const BareScene&) = delete;
  RTCDevice device;
  RTCScene scene;
};

/// Where 16 rays start; nothing else is kept, so that a packet costs the bare casts little memory to read.
struct Rays16 {
  alignas(64) std::array<float, 16> x_m, y_m, z_top_m;
  alignas(64) std::array<int, 16> active;
};

/// The rays of the grid in the order in which the sampler casts: 16 rows at a time, column by column to the left
/// and to the right. Where a row ends it casts on until the gap is too wide to be a hole, and so do these.
std::vector<Rays16> rays_of(const road::SampledGrid& sampled, const crg::ReferenceLine& line, const Eigen::Vector3d& origin,
                            const road::SampleOptions& options) {
  std::vector<Rays16> packets;
  const crg::Grid& grid = sampled.grid;
  const std::size_t columns = grid.columns(), middle = static_cast<std::size_t>(
      std::lower_bound(grid.v_m.begin(), grid.v_m.end(), -1e-9) - grid.v_m.begin());
  std::array<float, 16> last_z;
  std::array<double, 16> last_v;
  const auto cast = [&](std::size_t first, std::size_t j) {
      Rays16 packet{};
      bool any = false;
      for (std::size_t k = 0; k < 16; ++k) {
        float z = grid.at(first + k, j);
        if (!std::isnan(z)) {
          last_z[k] = z;
          last_v[k] = grid.v_m[j];
        } else if (std::abs(grid.v_m[j] - last_v[k]) < options.max_gap_m + 2.0 * options.v_step_m) {
          z = last_z[k];
        }
        if (std::isnan(z)) continue;
        const crg::Point2 p = crg::node_position(line, first + k, grid.v_m[j]);
        packet.x_m[k] = static_cast<float>(p.x_m - origin.x());
        packet.y_m[k] = static_cast<float>(p.y_m - origin.y());
        packet.z_top_m[k] = static_cast<float>(static_cast<double>(z) - origin.z()) + 2.0f;
        packet.active[k] = -1;
        any = true;
      }
      if (any) packets.push_back(packet);
  };
  for (std::size_t first = 0; first + 16 <= grid.rows(); first += 16) {
    last_z.fill(std::numeric_limits<float>::quiet_NaN());
    last_v.fill(0.0);
    cast(first, middle);
    const auto middle_z = last_z;
    for (std::size_t j = middle + 1; j < columns; ++j) cast(first, j);
    last_z = middle_z;
    last_v.fill(0.0);
    for (std::size_t j = middle; j-- > 0;) cast(first, j);
  }
  return packets;
}

/// Casts them all and reads every height; the constant parts of the rays are written once.
/// Returns how many hit and the sum of their heights.
std::pair<std::size_t, double> cast_bare(RTCScene scene, const std::vector<Rays16>& packets) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit16 ray{};
  std::fill_n(ray.ray.dir_z, 16, -1.0f);
  std::fill_n(ray.ray.mask, 16, 0xffffffffu);
  std::size_t hits = 0;
  double sum = 0.0;
  for (const Rays16& packet : packets) {
    // Stored as widely as Embree loads, or it waits.
    road::wide([&]() __attribute__((always_inline)) {
      for (std::size_t k = 0; k < 16; ++k) ray.ray.org_x[k] = packet.x_m[k];
      for (std::size_t k = 0; k < 16; ++k) ray.ray.org_y[k] = packet.y_m[k];
      for (std::size_t k = 0; k < 16; ++k) ray.ray.org_z[k] = packet.z_top_m[k];
      for (std::size_t k = 0; k < 16; ++k) ray.ray.tfar[k] = 4.0f;
      for (std::size_t k = 0; k < 16; ++k) ray.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    });
    rtcIntersect16(packet.active.data(), scene, &context, &ray);
    float z = 0.0f;
    unsigned met = 0;
    for (std::size_t k = 0; k < 16; ++k) {
      const bool hit = packet.active[k] != 0 && ray.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
      z += hit ? packet.z_top_m[k] - ray.ray.tfar[k] : 0.0f;
      met += hit ? 1 : 0;
    }
    hits += met;
    sum += static_cast<double>(z);
  }
  return {hits, sum};
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
  const auto packets = rays_of(sampled, line, surface.origin_m(), options);
  const BareScene bare(road.mesh, surface.origin_m());
  std::size_t rays = 0;
  for (const auto& packet : packets) rays += static_cast<std::size_t>(std::count(packet.active.begin(), packet.active.end(), -1));

  std::vector<double> sample_s, bare_s;
  std::pair<std::size_t, double> check;
  for (int round = 0; round < 25; ++round) {
    double start = now_s();
    sampled = road::sample_grid(road, surface, line, centreline, options);
    sample_s.push_back(now_s() - start);
    start = now_s();
    check = cast_bare(bare.scene, packets);
    bare_s.push_back(now_s() - start);
  }
  std::vector<double> share;
  for (std::size_t i = 0; i < sample_s.size(); ++i) share.push_back(bare_s[i] / sample_s[i]);
  std::sort(share.begin(), share.end());
  std::sort(sample_s.begin(), sample_s.end());
  std::sort(bare_s.begin(), bare_s.end());
  const double nodes = static_cast<double>(report.nodes), cast = static_cast<double>(rays);
  fmt::print("{} triangles, {:.3g} nodes, {:.3g} rays in {} packets, one thread, best of {}\n", road.mesh.triangles.size(), nodes, cast,
             packets.size(), sample_s.size());
  fmt::print("bare casts hit {} times, mean height {:.3f} m over the local origin\n", check.first, check.second / static_cast<double>(check.first));
  fmt::print("sample_grid       {:6.1f} M nodes/s  {:6.1f} M rays/s\n", nodes / sample_s[0] * 1e-6, cast / sample_s[0] * 1e-6);
  fmt::print("bare Embree casts {:6.1f} M rays/s\n", cast / bare_s[0] * 1e-6);
  fmt::print("share of the limit {:.1f} % (median of the rounds; {:.1f} to {:.1f} %)\n", 100.0 * share[share.size() / 2], 100.0 * share.front(),
             100.0 * share.back());
}
