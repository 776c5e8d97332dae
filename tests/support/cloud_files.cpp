#include "support/cloud_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace support {
namespace {

template <typename T>
void put(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if (big_endian) std::reverse(raw, raw + sizeof value);
  bytes.append(raw, sizeof value);
}

template <typename T>
void set(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace

std::string as_las(const CloudSeed& seed, int minor, int format, bool feet) {
  constexpr std::uint16_t kLength[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  const std::uint16_t header = minor == 4 ? 375 : minor == 3 ? 235 : 227;
  const std::size_t vlr = feet ? 54 + 16 : 0;
  std::string bytes(header + vlr, '\0');
  std::memcpy(bytes.data(), "LASF", 4);
  set<std::uint8_t>(bytes, 24, 1), set<std::uint8_t>(bytes, 25, static_cast<std::uint8_t>(minor));
  set<std::uint16_t>(bytes, 94, header);
  set<std::uint32_t>(bytes, 96, static_cast<std::uint32_t>(bytes.size()));
  set<std::uint32_t>(bytes, 100, feet ? 1 : 0);
  set<std::uint8_t>(bytes, 104, static_cast<std::uint8_t>(format));
  set<std::uint16_t>(bytes, 105, kLength[format]);
  set<std::uint32_t>(bytes, 107, format < 6 ? static_cast<std::uint32_t>(seed.count) : 0);
  if (minor == 4) set<std::uint64_t>(bytes, 247, seed.count);
  for (std::size_t k = 0; k < 3; ++k) set<double>(bytes, 131 + 8 * k, 0.001);
  set<double>(bytes, 155, seed.x0), set<double>(bytes, 163, seed.y0), set<double>(bytes, 171, 0.0);
  if (feet) {
    std::memcpy(bytes.data() + header + 2, "LASF_Projection", 15);
    set<std::uint16_t>(bytes, header + 18u, 34735);
    set<std::uint16_t>(bytes, header + 20u, 16);
    const std::uint16_t keys[] = {1, 1, 0, 1, 3076, 0, 1, 9002};
    std::memcpy(bytes.data() + header + 54, keys, 16);
  }
  for (std::size_t i = 0; i < seed.count; ++i) {
    std::string record(kLength[format], '\0');
    set(record, 0, static_cast<std::int32_t>(std::lround((seed.x(i) - seed.x0) / 0.001)));
    set(record, 4, static_cast<std::int32_t>(std::lround((seed.y(i) - seed.y0) / 0.001)));
    set(record, 8, static_cast<std::int32_t>(std::lround(seed.z(i) / 0.001)));
    set(record, 12, static_cast<std::uint16_t>(i));
    // Formats 0 to 5 keep flags in the upper bits of the class.
    set(record, format < 6 ? 15u : 16u, static_cast<std::uint8_t>(i % 3 + (format < 6 ? 0x40 : 0)));
    if (format == 1 || format == 3 || format == 4 || format == 5) set(record, 20, seed.time(i));
    if (format >= 6) set(record, 22, seed.time(i));
    bytes += record;
  }
  return bytes;
}

std::string with_record(std::string las, std::uint16_t id, const std::string& record) {
  std::uint32_t data = 0, records = 0;
  std::memcpy(&data, las.data() + 96, 4), std::memcpy(&records, las.data() + 100, 4);
  std::string head(54, '\0');
  std::memcpy(head.data() + 2, "LASF_Projection", 15);
  set(head, 18, id), set(head, 20, static_cast<std::uint16_t>(record.size()));
  las.insert(data, head + record);
  set(las, 96, static_cast<std::uint32_t>(data + head.size() + record.size()));
  set(las, 100, records + 1);
  return las;
}

std::string with_extended_record(std::string las, std::uint16_t id, const std::string& record) {
  std::string head(60, '\0');
  std::memcpy(head.data() + 2, "LASF_Projection", 15);
  set(head, 18, id), set(head, 20, static_cast<std::uint64_t>(record.size()));
  set(las, 235, static_cast<std::uint64_t>(las.size())), set(las, 243, std::uint32_t{1});
  return las + head + record;
}

std::string as_cloud_ply(const CloudSeed& seed, const std::string& format, bool doubles) {
  const char* const type = doubles ? "double" : "float";
  std::string bytes = fmt::format(
      "ply\nformat {0} 1.0\nelement vertex {1}\nproperty {2} x\nproperty {2} y\nproperty {2} "
      "z\nproperty double time\nend_header\n",
      format, seed.count, type);
  const bool big = format == "binary_big_endian";
  for (std::size_t i = 0; i < seed.count; ++i) {
    const double p[] = {seed.x(i), seed.y(i), seed.z(i)};
    if (format == "ascii") {
      bytes += fmt::format("{:.6f} {:.6f} {:.6f} {:.6f}\n", p[0], p[1], p[2], seed.time(i));
      continue;
    }
    for (const double v : p) doubles ? put(bytes, v, big) : put(bytes, static_cast<float>(v), big);
    put(bytes, seed.time(i), big);
  }
  return bytes;
}

std::string as_pcd(const CloudSeed& seed, const std::string& data, bool doubles) {
  const int size = doubles ? 8 : 4;
  std::string bytes = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE {0} {0} {0}\nTYPE F F F\nCOUNT 1 1 1\nWIDTH "
      "{1}\nHEIGHT 1\nPOINTS {1}\nDATA {2}\n",
      size, seed.count, data);
  std::string columns[3];
  for (std::size_t i = 0; i < seed.count; ++i) {
    const double p[] = {seed.x(i), seed.y(i), seed.z(i)};
    if (data == "ascii") bytes += fmt::format("{:.6f} {:.6f} {:.6f}\n", p[0], p[1], p[2]);
    for (int k = 0; k < 3; ++k) {
      std::string& out = data == "binary" ? bytes : columns[k];
      if (data != "ascii") doubles ? put(out, p[k]) : put(out, static_cast<float>(p[k]));
    }
  }
  if (data == "binary_compressed") {  // literal runs only: valid LZF
    const std::string plain = columns[0] + columns[1] + columns[2];
    std::string packed;
    for (std::size_t at = 0; at < plain.size(); at += 32) {
      const std::size_t length = std::min<std::size_t>(32, plain.size() - at);
      packed += static_cast<char>(length - 1);
      packed += plain.substr(at, length);
    }
    put(bytes, static_cast<std::uint32_t>(packed.size()));
    put(bytes, static_cast<std::uint32_t>(plain.size()));
    bytes += packed;
  }
  return bytes;
}

std::string as_kitti(const CloudSeed& seed) {
  std::string bytes;
  for (std::size_t i = 0; i < seed.count; ++i)
    for (const double v : {seed.x(i), seed.y(i), seed.z(i), static_cast<double>(i)})
      put(bytes, static_cast<float>(v));
  return bytes;
}

std::string as_xyz(const CloudSeed& seed, bool header) {
  std::string bytes = header ? "time_s,x_m,y_m,z_m\n" : "";
  for (std::size_t i = 0; i < seed.count; ++i)
    bytes += header ? fmt::format("{:.6f},{:.6f},{:.6f},{:.6f}\n", seed.time(i), seed.x(i),
                                  seed.y(i), seed.z(i))
                    : fmt::format("{:.6f} {:.6f} {:.6f}\n", seed.x(i), seed.y(i), seed.z(i));
  return bytes;
}

}  // namespace support
