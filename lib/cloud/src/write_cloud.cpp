#include <fmt/format.h>

#include <cstring>

#include "cloud/read_cloud.h"
#include "files/write_file.h"

namespace cloud {
namespace {

template <typename T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace

void write_ply(const Cloud& cloud, const std::string& path) {
  const bool time = !cloud.time_s.empty(), intensity = !cloud.intensity.empty(),
             classes = !cloud.classification.empty();
  files::FileWriter file(path);
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double "
      "y\nproperty double z\n{}{}{}end_header\n",
      cloud.size(), time ? "property double time\n" : "",
      intensity ? "property float intensity\n" : "",
      classes ? "property uchar classification\n" : "");
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put(bytes, cloud.origin_m.x() + cloud.x_m[i]);
    put(bytes, cloud.origin_m.y() + cloud.y_m[i]);
    put(bytes, cloud.origin_m.z() + cloud.z_m[i]);
    if (time) put(bytes, cloud.time_s[i]);
    if (intensity) put(bytes, cloud.intensity[i]);
    if (classes) put(bytes, cloud.classification[i]);
    if (bytes.size() > (1u << 22)) {
      file.append(bytes);
      bytes.clear();
    }
  }
  file.append(bytes);
  file.commit();
}

}  // namespace cloud
