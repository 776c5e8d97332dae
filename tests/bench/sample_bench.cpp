// Speed of the sampling stage beside its limit: the same rays as bare 16-wide Embree casts.
//
//   sample_bench [MESH]          default: g-track-1 of torcs-data, else the demo circuit
//
// Both are timed alternately in one run on one thread, so that the ratio holds on a busy machine.
// The rays are those that the sampler has Embree cast, written down in a run before: the same
// packets in the same order.
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include "circuit/circuit.h"
#include "circuit/synth.h"
#include "mesh/read_mesh.h"
#include "road/clean.h"
#include "road/reference_line.h"
#include "road/sample.h"
#include "support/places.h"
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
  explicit BareScene(const road::Mesh& mesh, const Eigen::Vector3d& origin)
      : device(rtcNewDevice("threads=1")), scene(rtcNewScene(device)) {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices_m.size()));
    for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
      const Eigen::Vector3f local = (vertex + mesh.origin_m - origin).cast<float>();
      v = std::copy(local.data(), local.data() + 3, v);
    }
    auto* i = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
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

/// Where 16 rays start; nothing else is kept, so that a packet costs the bare casts little memory
/// to read.
struct Rays16 {
  alignas(64) std::array<float, 16> x_m, y_m, z_top_m;
  alignas(64) std::array<int, 16> active;
};

std::vector<Rays16>* written_down = nullptr;  // where casts are written down; null: nowhere

/// What the bare casts found, so that none of it can be left out.
struct Found {
  std::size_t hits = 0;
  double sum_z_m = 0.0;
};

/// Casts them all and reads every height and triangle; the constant parts of the rays are written
/// once.
Found cast_bare(RTCScene scene, const std::vector<Rays16>& packets) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit16 ray{};
  std::fill_n(ray.ray.dir_z, 16, -1.0f);
  std::fill_n(ray.ray.mask, 16, 0xffffffffu);
  Found found;
  road::wide([&]() __attribute__((always_inline)) {
    using road::lanes, road::Floats16, road::Ints16;
    Floats16 sum_z_m{};
    Ints16 hits{};
    std::size_t casts = 0;
    for (const Rays16& packet : packets) {
      // Stored as widely as Embree loads, or it waits.
      lanes<Floats16>(ray.ray.org_x) = lanes<const Floats16>(packet.x_m.data());
      lanes<Floats16>(ray.ray.org_y) = lanes<const Floats16>(packet.y_m.data());
      lanes<Floats16>(ray.ray.org_z) = lanes<const Floats16>(packet.z_top_m.data());
      lanes<Floats16>(ray.ray.tfar) = Floats16{} + 4.0f;
      lanes<Ints16>(ray.hit.geomID) = Ints16{} - 1;
      rtcIntersect16(packet.active.data(), scene, &context, &ray);
      // There is one geometry: 0 where its triangles were hit, else -1.
      const Ints16 hit = ~lanes<Ints16>(ray.hit.geomID);
      const Floats16 z_m =
          lanes<const Floats16>(packet.z_top_m.data()) - lanes<Floats16>(ray.ray.tfar);
      hits -= hit;
      sum_z_m += reinterpret_cast<Floats16>(reinterpret_cast<Ints16>(z_m) & hit);
      if (++casts % 256 != 0 && casts != packets.size()) continue;
      for (std::size_t k = 0; k < 16; ++k) found.sum_z_m += static_cast<double>(sum_z_m[k]);
      sum_z_m = Floats16{};
    }
    for (std::size_t k = 0; k < 16; ++k) found.hits += static_cast<std::size_t>(hits[k]);
  });
  return found;
}

}  // namespace

const auto embree = reinterpret_cast<decltype(&rtcIntersect16)>(dlsym(RTLD_NEXT, "rtcIntersect16"));

/// Stands before Embree's: the sampler and the bare casts both come by here.
void rtcIntersect16(const int* valid, RTCScene scene, RTCIntersectContext* context,
                    RTCRayHit16* packet) {
  if (written_down != nullptr) [[unlikely]] {
    Rays16& rays = written_down->emplace_back();
    std::copy_n(packet->ray.org_x, 16, rays.x_m.data());
    std::copy_n(packet->ray.org_y, 16, rays.y_m.data());
    std::copy_n(packet->ray.org_z, 16, rays.z_top_m.data());
    std::copy_n(valid, 16, rays.active.data());
  }
  embree(valid, scene, context, packet);
}

int main(int argc, char** argv) {
  const std::string torcs = places::torcs_tracks() + "/road/g-track-1/g-track-1.acc";
  const bool given = argc > 1;
  const road::Mesh mesh = given || std::filesystem::exists(torcs)
                              ? road::read_mesh(given ? argv[1] : torcs)
                              : road::make_circuit_mesh(road::read_circuit(
                                    places::source() + "/tracks/kerbstone-ring/circuit.yaml"));
  const road::RoadMesh road = road::clean(mesh);
  const auto centreline = road::trace_centreline(road);
  const auto line = road::fit_reference_line(centreline);
  const road::RaySurface surface(road.mesh);
  road::SampleOptions options;
  options.threads = 1;
  road::SampleReport report;
  std::vector<Rays16> packets;
  written_down = &packets;
  auto sampled = road::sample_grid(road, surface, line, centreline, options, &report);
  written_down = nullptr;
  const BareScene bare(road.mesh, surface.origin_m());
  std::size_t rays = 0;
  for (const auto& packet : packets)
    rays += static_cast<std::size_t>(std::count(packet.active.begin(), packet.active.end(), -1));

  std::vector<double> sample_s, bare_s;
  Found check;
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
  fmt::print("{} triangles, {:.3g} nodes, {:.3g} rays in {} packets, one thread, best of {}\n",
             road.mesh.triangles.size(), nodes, cast, packets.size(), sample_s.size());
  fmt::print("bare casts hit {} times, mean height {:.3f} m over the local origin\n", check.hits,
             check.sum_z_m / static_cast<double>(check.hits));
  fmt::print("sample_grid       {:6.1f} M nodes/s  {:6.1f} M rays/s\n", nodes / sample_s[0] * 1e-6,
             cast / sample_s[0] * 1e-6);
  fmt::print("bare Embree casts {:6.1f} M rays/s\n", cast / bare_s[0] * 1e-6);
  fmt::print("share of the limit {:.1f} % (median of the rounds; {:.1f} to {:.1f} %)\n",
             100.0 * share[share.size() / 2], 100.0 * share.front(), 100.0 * share.back());
}
