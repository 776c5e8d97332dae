#include <fmt/format.h>

#include <cstring>

#include "base/ending.h"
#include "base/one_line.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "cloud/read_cloud.h"

namespace cloud {
namespace {

template <typename T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace

void require_cloud_ending(const std::string& path) {
  const std::string ending = base::ending_of(path);
  if (path == "-" || ending == ".ply" || ending == ".pcd") return;
  throw Error(fmt::format("{}: ending '{}' seen; .ply or .pcd wanted", path, ending));
}

void write_cloud(const Cloud& cloud, const std::string& path, bool doubles,
                 const std::vector<std::string>& comments) {
  require_cloud_ending(path);
  const std::string ending = base::ending_of(path);
  const bool time = !cloud.time_s.empty(), intensity = !cloud.intensity.empty(),
             classes = !cloud.classification.empty(), sigma = !cloud.sigma_m.empty();
  // float32 keeps 0.06 mm up to 1 km: coordinates stay relative to the origin.
  const Eigen::Vector3d shown = doubles ? cloud.origin_m : Eigen::Vector3d::Zero();
  const std::string origin =
      doubles || cloud.origin_m.isZero()
          ? ""
          : fmt::format("{} {} {}", cloud.origin_m.x(), cloud.origin_m.y(), cloud.origin_m.z());
  const bool pcd = ending == ".pcd";
  std::string head;
  if (!origin.empty()) head = (pcd ? "# origin_m " : "comment origin_m ") + origin + "\n";
  for (const std::string& comment : comments)
    head += (pcd ? "# " : "comment ") + base::one_line(comment) + "\n";
  std::string bytes;
  if (!pcd) {
    const char* const type = doubles ? "double" : "float";
    bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\n{}element vertex {}\nproperty {} x\nproperty {} "
        "y\nproperty {} z\n{}{}{}{}end_header\n",
        head, cloud.size(), type, type, type, time ? "property double time\n" : "",
        intensity ? "property float intensity\n" : "",
        classes ? "property uchar classification\n" : "", sigma ? "property float sigma\n" : "");
  } else {
    const int size = doubles ? 8 : 4;
    bytes = fmt::format(
        "# .PCD v0.7 - Point Cloud Data file format\n{}VERSION 0.7\nFIELDS x y z{}{}{}{}\nSIZE {} "
        "{} "
        "{}{}{}{}{}\nTYPE F F F{}{}{}{}\nCOUNT 1 1 1{}{}{}{}\nWIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 "
        "1 0 0 "
        "0\nPOINTS {}\nDATA binary\n",
        head, time ? " time" : "", intensity ? " intensity" : "", classes ? " classification" : "",
        sigma ? " sigma" : "", size, size, size, time ? " 8" : "", intensity ? " 4" : "",
        classes ? " 1" : "", sigma ? " 4" : "", time ? " F" : "", intensity ? " F" : "",
        classes ? " U" : "", sigma ? " F" : "", time ? " 1" : "", intensity ? " 1" : "",
        classes ? " 1" : "", sigma ? " 1" : "", cloud.size(), cloud.size());
  }
  base::FileWriter file(path);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double value = cloud.point(i)[k] + shown[k];
      if (doubles)
        put(bytes, value);
      else
        put(bytes, static_cast<float>(value));
    }
    if (time) put(bytes, cloud.time_s[i]);
    if (intensity) put(bytes, cloud.intensity[i]);
    if (classes) put(bytes, cloud.classification[i]);
    if (sigma) put(bytes, cloud.sigma_m[i]);
    if (bytes.size() > (1u << 22)) {
      file.append(bytes);
      bytes.clear();
    }
  }
  file.append(bytes);
  file.commit();
}

}  // namespace cloud
