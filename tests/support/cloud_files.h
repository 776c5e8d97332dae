// Small clouds as the bytes of every format, written by a hand of their own: not by lib/cloud.
#pragma once

#include <cstdint>
#include <string>

namespace support {

/// `count` points on a slope near (x0, y0): x = x0 + 0.25 i, y = y0 - 0.5 i, z = 100 + 0.01 i, time
/// 10 + 0.001 i, class i % 3, intensity i.
struct CloudSeed {
  std::size_t count = 20;
  double x0 = 500000.0, y0 = 5400000.0;
  double x(std::size_t i) const { return x0 + 0.25 * static_cast<double>(i); }
  double y(std::size_t i) const { return y0 - 0.5 * static_cast<double>(i); }
  double z(std::size_t i) const { return 100.0 + 0.01 * static_cast<double>(i); }
  double time(std::size_t i) const { return 10.0 + 0.001 * static_cast<double>(i); }
};

std::string as_las(const CloudSeed& seed, int minor, int format, bool feet = false);
/// The same LAS 1.4 file with one more record of the user "LASF_Projection", before or behind the
/// points.
std::string with_record(std::string las, std::uint16_t id, const std::string& record);
std::string with_extended_record(std::string las, std::uint16_t id, const std::string& record);
std::string as_cloud_ply(const CloudSeed& seed, const std::string& format, bool doubles);
std::string as_pcd(const CloudSeed& seed, const std::string& data, bool doubles);
std::string as_kitti(const CloudSeed& seed);
std::string as_xyz(const CloudSeed& seed, bool header);

}  // namespace support
