#include "mesh/ray_surface.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <new>

#include "mesh/error.h"

namespace road {

namespace {

constexpr float kMergeHits_m = 1e-3f;  // two hits closer than this are one surface

struct DeviceDeleter {
  void operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
  void operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }
};

}  // namespace

// RayPacket16 begins with Embree's packet.
static_assert(offsetof(RayPacket16, z_top_m) == offsetof(RTCRay16, org_z) &&
              offsetof(RayPacket16, from_m) == offsetof(RTCRay16, tnear) &&
              offsetof(RayPacket16, direction_z) == offsetof(RTCRay16, dir_z) &&
              offsetof(RayPacket16, depth_m) == offsetof(RTCRay16, tfar) &&
              offsetof(RayPacket16, mask) == offsetof(RTCRay16, mask) &&
              offsetof(RayPacket16, triangle) ==
                  offsetof(RTCRayHit16, hit) + offsetof(RTCHit16, primID) &&
              offsetof(RayPacket16, geometry) ==
                  offsetof(RTCRayHit16, hit) + offsetof(RTCHit16, geomID) &&
              offsetof(RayPacket16, active) == sizeof(RTCRayHit16) &&
              alignof(RayPacket16) == alignof(RTCRayHit16));

struct RaySurface::Scene {
  std::unique_ptr<RTCDeviceTy, DeviceDeleter> device;
  std::unique_ptr<RTCSceneTy, SceneDeleter> scene;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  float top_m = 0.0f;  // highest vertex, local

  /// First hit at or below z_top, looking depth down; local coordinates.
  std::optional<SurfaceHit> cast(float x, float y, float z_top, float depth) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    ray.ray.org_x = x;
    ray.ray.org_y = y;
    ray.ray.org_z = z_top;
    ray.ray.dir_z = -1.0f;
    ray.ray.tfar = depth;
    ray.ray.mask = 0xffffffffu;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene.get(), &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const Eigen::Vector3d normal =
        Eigen::Vector3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).cast<double>();
    return SurfaceHit{static_cast<double>(z_top) - static_cast<double>(ray.ray.tfar),
                      ray.hit.primID, std::abs(normal.z()) / normal.norm()};
  }

  /// Hits between z_top and z_top - depth from high to low, z in the map frame.
  std::vector<SurfaceHit> hits(double x_m, double y_m, float z_top, float depth) const {
    std::vector<SurfaceHit> result;
    const auto x = static_cast<float>(x_m - origin_m.x());
    const auto y = static_cast<float>(y_m - origin_m.y());
    const float z_bottom = z_top - depth;
    while (z_top > z_bottom) {
      auto hit = cast(x, y, z_top, z_top - z_bottom);
      if (!hit) break;
      const auto z_local = static_cast<float>(hit->z_m);
      // A step of at least one ulp, or a ray far from the origin would find the same hit for ever.
      z_top = std::min(z_local - kMergeHits_m, std::nextafter(z_local, z_bottom));
      hit->z_m += origin_m.z();
      result.push_back(*hit);
    }
    return result;
  }
};

RaySurface::RaySurface(const Mesh& mesh) : scene_(std::make_unique<Scene>()) {
  // One build thread: the tree, and with it the triangle answered on a shared edge, is then the
  // same on every machine. 30,000 triangles take some 10 ms.
  scene_->device.reset(rtcNewDevice("threads=1"));
  if (!scene_->device) throw Error("Embree: no device could be made (out of memory?)");
  scene_->scene.reset(rtcNewScene(scene_->device.get()));
  rtcSetSceneFlags(scene_->scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_->scene.get(), RTC_BUILD_QUALITY_MEDIUM);

  Eigen::AlignedBox3d box;
  for (const auto& vertex : mesh.vertices_m) box.extend(vertex);
  const Eigen::Vector3d centre =
      box.isEmpty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : box.center();
  scene_->origin_m = mesh.origin_m + centre;

  if (!mesh.triangles.empty()) {
    scene_->top_m = static_cast<float>(box.max().z() - centre.z());
    RTCGeometry geometry = rtcNewGeometry(scene_->device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices_m.size()));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles.size()));
    if (vertices == nullptr || indices == nullptr) throw std::bad_alloc();
    for (const auto& vertex : mesh.vertices_m) {
      for (int axis = 0; axis < 3; ++axis) {
        *vertices++ = static_cast<float>(vertex[axis] - centre[axis]);
      }
    }
    for (const auto& triangle : mesh.triangles) {
      indices = std::copy(triangle.begin(), triangle.end(), indices);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_->scene.get(), geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene_->scene.get());
  if (rtcGetDeviceError(scene_->device.get()) != RTC_ERROR_NONE) {
    throw Error("Embree refused the mesh (out of memory?)");
  }
}

RaySurface::~RaySurface() = default;
RaySurface::RaySurface(RaySurface&&) noexcept = default;
RaySurface& RaySurface::operator=(RaySurface&&) noexcept = default;

const Eigen::Vector3d& RaySurface::origin_m() const noexcept { return scene_->origin_m; }

void RaySurface::cast_prepared(RayPacket16& packet) const noexcept {
  // Where the processor has no packets of 16 (no AVX-512), Embree casts all lanes, active or not,
  // but for rays that end before they begin.
  for (std::size_t i = 0; i < 16; ++i)
    if (packet.active[i] == 0) packet.depth_m[i] = -1.0f;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(packet.active.data(), scene_->scene.get(), &context,
                 reinterpret_cast<RTCRayHit16*>(&packet));
}

void RaySurface::cast_down(RayPacket16& packet) const noexcept {
  packet.depth_m.fill(packet.max_depth_m);
  packet.geometry.fill(RTC_INVALID_GEOMETRY_ID);
  cast_prepared(packet);
  for (std::size_t i = 0; i < 16; ++i) {
    const float z = packet.z_top_m[i] - packet.depth_m[i];
    packet.z_m[i] =
        packet.geometry[i] != RTC_INVALID_GEOMETRY_ID ? z : std::numeric_limits<float>::quiet_NaN();
  }
}

std::optional<RayHit> RaySurface::first_hit(const Ray& ray, double from_m, double reach_m) const {
  const Eigen::Vector3f from = (ray.from_m - scene_->origin_m).cast<float>();
  const Eigen::Vector3f along = ray.direction.cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit cast{};
  cast.ray.org_x = from.x(), cast.ray.org_y = from.y(), cast.ray.org_z = from.z();
  cast.ray.dir_x = along.x(), cast.ray.dir_y = along.y(), cast.ray.dir_z = along.z();
  cast.ray.tnear = static_cast<float>(from_m);
  cast.ray.tfar = static_cast<float>(reach_m);
  cast.ray.mask = 0xffffffffu;
  cast.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_->scene.get(), &context, &cast);
  if (cast.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Eigen::Vector3d normal(cast.hit.Ng_x, cast.hit.Ng_y, cast.hit.Ng_z);
  return RayHit{static_cast<double>(cast.ray.tfar), normal.normalized()};
}

std::optional<SurfaceHit> RaySurface::nearest_hit(double x_m, double y_m, double z_near_m,
                                                  double reach_m) const {
  const double z_local = z_near_m - scene_->origin_m.z();
  std::optional<SurfaceHit> best;
  for (const SurfaceHit& hit : scene_->hits(x_m, y_m, static_cast<float>(z_local + reach_m),
                                            static_cast<float>(2.0 * reach_m))) {
    if (!best || std::abs(hit.z_m - z_near_m) < std::abs(best->z_m - z_near_m)) best = hit;
  }
  return best;
}

std::vector<SurfaceHit> RaySurface::all_hits(double x_m, double y_m) const {
  return scene_->hits(x_m, y_m, scene_->top_m + 1.0f, 2.0f * (scene_->top_m + 1.0f));
}

}  // namespace road
