#include "cloud/read_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "base/ending.h"
#include "base/stand_in.h"
#include "cloud/error.h"
#include "decode.h"
#include "emitter.h"
#include "mapped_file.h"
#include "records.h"
#include "text_records.h"

namespace cloud {
namespace {

using base::ending_of;

/// float32 values, so many a point: x y z intensity and what else there is.
Records float_records(std::string_view bytes, std::size_t values) {
  Records records;
  records.bytes = bytes;
  records.count = bytes.size() / (4 * values);
  for (std::size_t k = 0; k < 4; ++k)
    records.fields.push_back(
        {k < 3 ? static_cast<Role>(k) : Role::intensity, FieldType::f32, 4 * k, 4 * values});
  return records;
}

Records records_of(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  const std::string ending = ending_of(name);
  if (bytes.starts_with("LASF")) return las_records(bytes, name, report);
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r"))
    return ply_records(bytes, name, report);
  if (bytes.starts_with("ASTM-E57") || ending == ".e57")
    throw Error(name +
                ": is an E57 file, which is not read; convert it, as with 'pdal translate in.e57 "
                "out.laz' or CloudCompare");
  if (ending == ".pcd" || bytes.starts_with("# .PCD")) return pcd_records(bytes, name, report);
  if (ending == ".las" || ending == ".laz")
    throw Error(name + ": does not begin with LASF, so it is no LAS file");
  if (ending == ".ply") throw Error(name + ": does not begin with 'ply', so it is no PLY file");
  if (name.size() > 8 && base::ending_of(name.substr(0, name.size() - 4)) == ".pcd" &&
      ending == ".bin") {
    if (bytes.size() % 20 != 0)
      throw Error(fmt::format(
          "{}: {} bytes seen, a multiple of 20 wanted (float32 x y z intensity ring, as nuScenes "
          "writes .pcd.bin); truncated?",
          name, bytes.size()));
    report.format = "nuScenes binary";
    return float_records(bytes, 5);
  }
  if (ending == ".bin") {
    if (bytes.size() % 16 != 0)
      throw Error(fmt::format(
          "{}: {} bytes seen, a multiple of 16 wanted (float32 x y z intensity){}; truncated?",
          name, bytes.size(),
          bytes.size() % 20 == 0 ? ", or of 20 with the ending .pcd.bin (nuScenes)" : ""));
    report.format = "KITTI binary";
    return float_records(bytes, 4);
  }
  if (ending == ".xyz" || ending == ".csv" || ending == ".txt")
    return xyz_records(bytes, name, report);
  throw Error(
      fmt::format("{}: ending '{}' seen; .las, .laz, .ply, .pcd, .bin, .xyz, .csv or .txt wanted",
                  name, ending));
}

/// 1 mm is what a road is to be known to.
void look_at_float32(const Records& records, const Emitter& emit, CloudReadReport& report) {
  for (const Field& field : records.fields) {
    // Relative to an origin float32 is fine enough.
    if (field.role > Role::z || field.type != FieldType::f32 || field.add != 0.0 || records.text)
      continue;
    const auto axis = static_cast<std::size_t>(field.role);
    const auto largest = static_cast<float>(emit.largest(axis));
    const float step = std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest;
    double& step_m = report.float32_step_m[axis];
    step_m = static_cast<double>(step) *
             (axis == 2 ? report.metres_per_height_unit : report.metres_per_unit);
    if (step_m > 0.001)
      report.remarks.push_back(
          fmt::format("{} is quantised to {:g} m (float32 coordinates far from zero); export the "
                      "cloud in double or with a local origin",
                      "xyz"[axis], step_m));
  }
}

CloudReadReport read_all(std::string_view bytes, const std::string& name,
                         const CloudReadOptions& options, const ChunkSink& sink,
                         const std::function<void(std::size_t)>& done) {
  CloudReadReport report;
  if (bytes.empty()) throw Error(name + ": empty file; a point cloud is wanted");
  base::want_no_lfs_pointer(bytes, name);
  base::want_no_web_page(bytes, name);
  Records records = records_of(bytes, name, report);
  if (!records.owned.empty()) records.bytes = records.owned;
  Emitter emit(name, options, report, sink);
  const std::size_t chunk = std::max<std::size_t>(1, options.chunk_points);
  if (records.text) {
    require_xyz(records.columns, name);
    read_text(records, name, chunk, emit);
  } else {
    std::vector<Role> roles;
    for (const Field& field : records.fields) roles.push_back(field.role);
    require_xyz(roles, name);
    read_binary(records, chunk, emit, done);
  }
  emit.finish();
  look_at_float32(records, emit, report);
  if (report.not_finite > 0)
    report.remarks.push_back(
        fmt::format("{} points without finite coordinates were left out", report.not_finite));
  return report;
}

}  // namespace

CloudReadReport read_chunks(const std::string& path, const CloudReadOptions& options,
                            const ChunkSink& sink) {
  const MappedFile file(path);
  return read_all(file.bytes(), path, options, sink,
                  [&](std::size_t offset) { file.forget_before(offset); });
}

CloudReadReport read_chunks_from(std::string_view bytes, const std::string& name,
                                 const CloudReadOptions& options, const ChunkSink& sink) {
  return read_all(bytes, name, options, sink, [](std::size_t) {});
}

Cloud read_cloud(const std::string& path, const CloudReadOptions& options,
                 CloudReadReport* report) {
  Cloud whole;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  const CloudReadReport read = read_chunks(path, options, [&](Cloud&& chunk) {
    if (whole.size() == 0) {
      whole = std::move(chunk);
      return;
    }
    append(whole.x_m, chunk.x_m), append(whole.y_m, chunk.y_m), append(whole.z_m, chunk.z_m);
    append(whole.time_s, chunk.time_s), append(whole.intensity, chunk.intensity),
        append(whole.classification, chunk.classification), append(whole.sigma_m, chunk.sigma_m);
  });
  if (report != nullptr) *report = read;
  return whole;
}

std::vector<std::string> cloud_files(const std::string& path) {
  std::error_code problem;
  if (!std::filesystem::is_directory(path, problem)) return {path};
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(path, problem)) {
    const std::string ending = ending_of(entry.path().string());
    for (const char* known : {".las", ".laz", ".ply", ".pcd", ".bin", ".xyz"})
      if (ending == known) files.push_back(entry.path().string());
  }
  if (problem) throw Error(fmt::format("{}: cannot be listed: {}", path, problem.message()));
  if (files.empty())
    throw Error(path + ": no .las, .laz, .ply, .pcd, .bin or .xyz file in this folder");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace cloud
