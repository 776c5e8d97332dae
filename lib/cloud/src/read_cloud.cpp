#include "cloud/read_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/ending.h"
#include "cloud/error.h"
#include "mapped_file.h"
#include "records.h"

namespace cloud {
namespace {

using base::ending_of;

template <typename T>
double value_of(const char* from, bool swap) {
  T value;
  std::memcpy(&value, from, sizeof value);
  if (swap) {
    char bytes[sizeof value];
    std::memcpy(bytes, from, sizeof value);
    std::reverse(bytes, bytes + sizeof value);
    std::memcpy(&value, bytes, sizeof value);
  }
  return static_cast<double>(value);
}

template <typename T>
void decode(const char* from, const Field& field, std::size_t count, bool swap, double* out) {
  for (std::size_t i = 0; i < count; ++i, from += field.stride)
    *out++ = value_of<T>(from, swap) * field.scale + field.add;
}

/// `from`: the field of the first of `count` points.
void decode(const char* from, const Field& field, std::size_t count, bool swap, double* out) {
  switch (field.type) {
    case FieldType::i8:
      return decode<std::int8_t>(from, field, count, swap, out);
    case FieldType::u8:
      return decode<std::uint8_t>(from, field, count, swap, out);
    case FieldType::i16:
      return decode<std::int16_t>(from, field, count, swap, out);
    case FieldType::u16:
      return decode<std::uint16_t>(from, field, count, swap, out);
    case FieldType::i32:
      return decode<std::int32_t>(from, field, count, swap, out);
    case FieldType::u32:
      return decode<std::uint32_t>(from, field, count, swap, out);
    case FieldType::i64:
      return decode<std::int64_t>(from, field, count, swap, out);
    case FieldType::u64:
      return decode<std::uint64_t>(from, field, count, swap, out);
    case FieldType::f32:
      return decode<float>(from, field, count, swap, out);
    case FieldType::f64:
      return decode<double>(from, field, count, swap, out);
  }
}

constexpr std::size_t kRoles = 6;

/// Raw values of a chunk, one array per role; empty where the file has no such field.
struct Raw {
  std::vector<double> of[kRoles];
  std::size_t size = 0;
};

/// Units, origin, points that are not numbers; then the sink.
class Emitter {
 public:
  Emitter(const std::string& name, const CloudReadOptions& options, CloudReadReport& report,
          const ChunkSink& sink)
      : name_(name), options_(options), report_(report), sink_(sink) {
    if (options.metres_per_unit) {
      report.metres_per_unit = report.metres_per_height_unit = *options.metres_per_unit;
      report.unit = "as given";
    }
  }

  /// `share`: how much of the file these and those before are.
  void operator()(const Raw& raw, double share) {
    hand_out(raw);
    if (options_.progress) options_.progress(share);
  }

  void finish() const {
    if (report_.points > 0) return;
    if (report_.not_finite > 0)
      throw Error(fmt::format("{}: none of the {} points has finite coordinates below 1e8 m", name_,
                              report_.not_finite));
    throw Error(name_ + ": no points in this file");
  }

 private:
  /// Degrees lie within a fraction of one, far from zero, with heights that differ by more; no
  /// cloud of a road in metres does, and whoever has one says its unit.
  void look_for_degrees(const Raw& raw) {
    if (looked_ || raw.size < 50 || options_.metres_per_unit || report_.unit_from_file) return;
    looked_ = true;
    double low[3], high[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [least, most] = std::minmax_element(raw.of[k].begin(), raw.of[k].end());
      low[k] = *least, high[k] = *most;
      if (!std::isfinite(low[k]) || !std::isfinite(high[k])) return;
    }
    const double wide = std::max(high[0] - low[0], high[1] - low[1]);
    const auto far = [&](int k) { return std::min(std::abs(low[k]), std::abs(high[k])); };
    const auto most = [&](int k) { return std::max(std::abs(low[k]), std::abs(high[k])); };
    const double less = std::min(most(0), most(1)), more = std::max(most(0), most(1));
    if (wide > 0.0 && wide < 1.0 && less < 90.0 && more < 180.0 && far(0) > 2.0 * wide &&
        far(1) > 2.0 * wide && high[2] - low[2] > 10.0 * wide)
      try {
        refuse_degrees(fmt::format(
            "look like degrees of longitude and latitude (x {:.5f} to {:.5f}, y {:.5f} to {:.5f}, "
            "heights over {:.1f})",
            low[0], high[0], low[1], high[1], high[2] - low[2]));
      } catch (const Error& error) {
        throw Error(name_ + ": " + error.what() +
                    "; if they are metres, say so with --unit m (map, grid: --cloud-unit m)");
      }
  }

  void hand_out(const Raw& raw) {
    look_for_degrees(raw);
    const double scale = report_.metres_per_unit, height_scale = report_.metres_per_height_unit;
    const std::vector<double>&x = raw.of[0], &y = raw.of[1], &z = raw.of[2];
    Cloud chunk;
    const auto reserve = [&](auto& values, Role role) {
      if (!raw.of[static_cast<std::size_t>(role)].empty()) values.reserve(raw.size);
    };
    chunk.x_m.reserve(raw.size), chunk.y_m.reserve(raw.size), chunk.z_m.reserve(raw.size);
    reserve(chunk.time_s, Role::time), reserve(chunk.intensity, Role::intensity),
        reserve(chunk.classification, Role::classification);
    for (std::size_t i = 0; i < raw.size; ++i) {
      const Eigen::Vector3d p(x[i] * scale, y[i] * scale, z[i] * height_scale);
      // Nothing on Earth is farther: such numbers are damage and would cost all precision.
      if (!(std::abs(p.x()) < 1e8 && std::abs(p.y()) < 1e8 && std::abs(p.z()) < 1e8)) {
        ++report_.not_finite;
        continue;
      }
      if (!origin_) origin_ = options_.origin_m ? *options_.origin_m : near(p);
      chunk.x_m.push_back(p.x() - origin_->x());
      chunk.y_m.push_back(p.y() - origin_->y());
      chunk.z_m.push_back(p.z() - origin_->z());
      if (!raw.of[3].empty()) chunk.time_s.push_back(raw.of[3][i]);
      if (!raw.of[4].empty()) chunk.intensity.push_back(static_cast<float>(raw.of[4][i]));
      if (!raw.of[5].empty())
        chunk.classification.push_back(
            static_cast<std::uint8_t>(raw.of[5][i] >= 0.0 ? std::min(raw.of[5][i], 255.0) : 0.0));
    }
    if (chunk.size() == 0) return;
    chunk.origin_m = *origin_;
    report_.points += chunk.size();
    sink_(std::move(chunk));
  }

  static Eigen::Vector3d near(const Eigen::Vector3d& p) {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      if (std::abs(p[k]) > 1000.0) origin[k] = 100.0 * std::round(p[k] / 100.0);
    return origin;
  }
  const std::string& name_;
  const CloudReadOptions& options_;
  CloudReadReport& report_;
  const ChunkSink& sink_;
  std::optional<Eigen::Vector3d> origin_;
  bool looked_ = false;
};

void require_xyz(const std::vector<Role>& roles, const std::string& name) {
  for (const Role role : {Role::x, Role::y, Role::z})
    if (std::count(roles.begin(), roles.end(), role) != 1)
      throw Error(fmt::format("{}: {} fields {} seen, one wanted", name,
                              std::count(roles.begin(), roles.end(), role),
                              "xyz"[static_cast<int>(role)]));
}

/// First field of each role that matters.
std::vector<Field> wanted_fields(const Records& records) {
  std::vector<Field> wanted;
  bool seen[kRoles] = {};
  for (const Field& field : records.fields) {
    if (field.role == Role::none || seen[static_cast<std::size_t>(field.role)]) continue;
    seen[static_cast<std::size_t>(field.role)] = true;
    wanted.push_back(field);
  }
  return wanted;
}

void read_binary(const Records& records, std::size_t chunk_points, Emitter& emit,
                 const std::function<void(std::size_t)>& done) {
  const std::vector<Field> fields = wanted_fields(records);
  Raw raw;
  std::string unpacked;
  for (std::size_t begin = 0; begin < records.count; begin += chunk_points) {
    const std::size_t end = std::min(records.count, begin + chunk_points);
    raw.size = end - begin;
    if (records.laz) records.laz->read(raw.size, unpacked);
    for (const Field& field : fields) {
      std::vector<double>& out = raw.of[static_cast<std::size_t>(field.role)];
      out.resize(raw.size);
      const char* const from =
          records.laz ? unpacked.data() : records.bytes.data() + begin * field.stride;
      decode(from + field.offset, field, raw.size, records.big_endian, out.data());
      if (field.mask != 0xff)
        for (double& v : out) v = static_cast<double>(static_cast<std::uint8_t>(v) & field.mask);
    }
    emit(raw, static_cast<double>(end) / static_cast<double>(records.count));
    if (records.laz)
      done(records.laz->chunk_begin());
    else if (records.owned.empty())
      done(fields.front().offset + end * fields.front().stride);
  }
}

bool is_gap(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\r'; }

/// The number at `here`, moved behind it; NaN for "nan"; false where there is none.
bool number_at(const char*& here, const char* end, double& value) {
  while (here < end && is_gap(*here)) ++here;
  if (here < end && *here == '+') ++here;
  const auto [behind, problem] = std::from_chars(here, end, value);
  if (problem == std::errc::result_out_of_range) {
    value = std::numeric_limits<double>::quiet_NaN();
  } else if (problem != std::errc()) {
    return false;
  }
  here = behind;
  return here == end || is_gap(*here);
}

void read_text(const Records& records, const std::string& name, std::size_t chunk_points,
               Emitter& emit) {
  const char* here = records.bytes.data() + records.text_begin;
  const char* const end = records.bytes.data() + records.bytes.size();
  Raw raw;
  std::size_t line_number = records.first_line - 1, read = 0;
  while (here < end && !(records.counted && read == records.count)) {
    const char* line_end =
        static_cast<const char*>(std::memchr(here, '\n', static_cast<std::size_t>(end - here)));
    if (line_end == nullptr) line_end = end;
    ++line_number;
    const char* at = here;
    while (at < line_end && is_gap(*at)) ++at;
    here = line_end + (line_end < end ? 1 : 0);
    if (at == line_end || *at == '#') continue;
    double values[kRoles] = {};
    for (std::size_t k = 0; k < records.columns.size(); ++k) {
      double value = 0.0;
      if (!number_at(at, line_end, value))
        throw Error(fmt::format("{}:{}: {} numbers wanted, number {} is '{}'", name, line_number,
                                records.columns.size(), k + 1,
                                std::string(at, std::min(line_end, at + 20))));
      if (records.columns[k] != Role::none)
        values[static_cast<std::size_t>(records.columns[k])] = value;
    }
    for (const Role role : records.columns)
      if (role != Role::none)
        raw.of[static_cast<std::size_t>(role)].push_back(values[static_cast<std::size_t>(role)]);
    ++raw.size, ++read;
    if (raw.size == chunk_points) {
      emit(raw, static_cast<double>(here - records.bytes.data()) /
                    static_cast<double>(records.bytes.size()));
      raw = {};
    }
  }
  if (raw.size > 0) emit(raw, 1.0);
  if (records.counted && read < records.count)
    throw Error(fmt::format("{}: truncated: {} points promised, {} seen; copy the file again", name,
                            records.count, read));
}

constexpr const char* kProject =
    "project the points first, as with 'pdal translate in.las out.las reprojection "
    "--filters.reprojection.out_srs=EPSG:32632' (the UTM zone of the place)";

bool is_angle(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name.starts_with("longitude") || name.starts_with("latitude") || name == "lon" ||
         name == "lat" || name == "lng" || name == "lon_deg" || name == "lat_deg";
}

/// Columns by a header line of names, or x y z [intensity] without one.
Records xyz_records(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  Records records;
  records.bytes = bytes;
  records.text = true;
  std::size_t here = 0, line_number = 0;
  while (here < bytes.size()) {
    const std::size_t end = std::min(bytes.find('\n', here), bytes.size());
    const std::string_view line = bytes.substr(here, std::min<std::size_t>(end - here, 4096));
    ++line_number;
    std::size_t first = 0;
    while (first < line.size() && (is_gap(line[first]) || line[first] == '\xEF' ||
                                   line[first] == '\xBB' || line[first] == '\xBF'))
      ++first;
    if (first == line.size() ||
        (line[first] == '#' && line.find_first_of(",x", first) == std::string_view::npos)) {
      here = std::min(end + 1, bytes.size());
      continue;
    }
    std::vector<std::string> words(1);
    for (const char c : line.substr(line[first] == '#' ? first + 1 : first)) {
      if (!is_gap(c))
        words.back() += c;
      else if (!words.back().empty())
        words.emplace_back();
    }
    if (words.back().empty()) words.pop_back();
    double ignored = 0.0;
    const char* at = words.empty() ? nullptr : words[0].data();
    if (!words.empty() && number_at(at, at + words[0].size(), ignored)) {
      if (words.size() < 3)
        throw Error(
            fmt::format("{}:{}: {} columns seen, x y z wanted", name, line_number, words.size()));
      records.columns.assign(std::min<std::size_t>(words.size(), 4), Role::intensity);
      records.columns[0] = Role::x, records.columns[1] = Role::y, records.columns[2] = Role::z;
    } else {
      bool seen[kRoles + 1] = {};
      for (const std::string& word : words) {
        if (is_angle(word))
          throw Error(fmt::format("{}: column {} seen, x, y and z in metres wanted; {}", name, word,
                                  kProject));
        Role role = role_of(word);
        if (seen[static_cast<std::size_t>(role)] && role > Role::z) role = Role::none;
        seen[static_cast<std::size_t>(role)] = true;
        records.columns.push_back(role);
      }
      here = std::min(end + 1, bytes.size());
      ++line_number;
    }
    break;
  }
  records.text_begin = here;
  records.first_line = line_number;
  report.format = "text";
  require_xyz(records.columns,
              name + (records.columns.empty() ? "" : ": column names of the first line"));
  return records;
}

}  // namespace

void add_origin(const std::vector<std::string>& words, Records& records) {
  for (std::size_t k = 0; k + 3 < words.size(); ++k) {
    if (words[k] != "origin_m") continue;
    double origin[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string& word = words[k + 1 + axis];
      const char* at = word.data();
      if (!number_at(at, word.data() + word.size(), origin[axis]) ||
          !(std::abs(origin[axis]) < 1e8))
        return;
    }
    for (Field& field : records.fields)
      if (field.role <= Role::z) field.add = origin[static_cast<std::size_t>(field.role)];
    return;
  }
}

namespace {

Records records_of(std::string_view bytes, const std::string& name, CloudReadReport& report) {
  const std::string ending = ending_of(name);
  if (bytes.starts_with("LASF")) return las_records(bytes, name, report);
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r"))
    return ply_records(bytes, name, report);
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
    Records records;
    records.bytes = bytes;
    records.count = bytes.size() / 20;
    for (std::size_t k = 0; k < 4; ++k)
      records.fields.push_back(
          {k < 3 ? static_cast<Role>(k) : Role::intensity, FieldType::f32, 4 * k, 20});
    report.format = "nuScenes binary";
    return records;
  }
  if (ending == ".bin") {
    if (bytes.size() % 16 != 0)
      throw Error(fmt::format(
          "{}: {} bytes seen, a multiple of 16 wanted (float32 x y z intensity){}; truncated?",
          name, bytes.size(),
          bytes.size() % 20 == 0 ? ", or of 20 with the ending .pcd.bin (nuScenes)" : ""));
    Records records;
    records.bytes = bytes;
    records.count = bytes.size() / 16;
    for (std::size_t k = 0; k < 4; ++k)
      records.fields.push_back(
          {k < 3 ? static_cast<Role>(k) : Role::intensity, FieldType::f32, 4 * k, 16});
    report.format = "KITTI binary";
    return records;
  }
  if (ending == ".xyz" || ending == ".csv" || ending == ".txt")
    return xyz_records(bytes, name, report);
  throw Error(
      fmt::format("{}: ending '{}' seen; .las, .laz, .ply, .pcd, .bin, .xyz, .csv or .txt wanted",
                  name, ending));
}

CloudReadReport read_all(std::string_view bytes, const std::string& name,
                         const CloudReadOptions& options, const ChunkSink& sink,
                         const std::function<void(std::size_t)>& done) {
  CloudReadReport report;
  if (bytes.empty()) throw Error(name + ": empty file; a point cloud is wanted");
  Records records = records_of(bytes, name, report);
  if (!records.owned.empty()) records.bytes = records.owned;
  Emitter emit(name, options, report, sink);
  const std::size_t chunk = std::max<std::size_t>(1, options.chunk_points);
  if (records.text) {
    require_xyz(records.columns, name);
    read_text(records, name, chunk, emit);
  } else {
    std::vector<Role> roles;
    for (const Field& field : records.fields) {
      roles.push_back(field.role);
      // Relative to an origin float32 is fine enough.
      if (field.role <= Role::z) report.float32 |= field.type == FieldType::f32 && field.add == 0.0;
    }
    require_xyz(roles, name);
    read_binary(records, chunk, emit, done);
  }
  emit.finish();
  if (report.not_finite > 0)
    report.remarks.push_back(
        fmt::format("{} points without finite coordinates were left out", report.not_finite));
  return report;
}

}  // namespace

void refuse_degrees(const std::string& seen) {
  throw Error(fmt::format("the coordinates {}, metres or feet wanted; {}", seen, kProject));
}

std::size_t size_of(FieldType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

Role role_of(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name == "x" || name == "x_m") return Role::x;
  if (name == "y" || name == "y_m") return Role::y;
  if (name == "z" || name == "z_m") return Role::z;
  if (name == "time" || name == "time_s" || name == "t" || name == "gps_time" ||
      name == "gpstime" || name == "timestamp")
    return Role::time;
  if (name == "intensity" || name == "scalar_intensity" || name == "i" || name == "reflectance")
    return Role::intensity;
  if (name == "classification" || name == "class" || name == "label" ||
      name == "scalar_classification")
    return Role::classification;
  return Role::none;
}

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
        append(whole.classification, chunk.classification);
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
