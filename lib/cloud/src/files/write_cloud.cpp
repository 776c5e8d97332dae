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
  const int size = doubles ? 8 : 4;
  std::string properties, names = "x y z", sizes = fmt::format("{0} {0} {0}", size);
  std::string types = "F F F", counts = "1 1 1";
  const auto add = [&](bool is_there, const char* name, const char* ply_type, int bytes_of_it,
                       char type) {
    if (!is_there) return;
    properties += fmt::format("property {} {}\n", ply_type, name);
    names += fmt::format(" {}", name), sizes += fmt::format(" {}", bytes_of_it);
    types += fmt::format(" {}", type), counts += " 1";
  };
  add(time, "time", "double", 8, 'F');
  add(intensity, "intensity", "float", 4, 'F');
  add(classes, "classification", "uchar", 1, 'U');
  add(sigma, "sigma", "float", 4, 'F');
  std::string bytes;
  if (!pcd) {
    const char* const type = doubles ? "double" : "float";
    bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\n{0}element vertex {1}\nproperty {2} x\n"
        "property {2} y\nproperty {2} z\n{3}end_header\n",
        head, cloud.size(), type, properties);
  } else {
    bytes = fmt::format(
        "# .PCD v0.7 - Point Cloud Data file format\n{0}VERSION 0.7\nFIELDS {1}\nSIZE {2}\n"
        "TYPE {3}\nCOUNT {4}\nWIDTH {5}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {5}\n"
        "DATA binary\n",
        head, names, sizes, types, counts, cloud.size());
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
