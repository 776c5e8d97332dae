// Reads point clouds: .las 1.0-1.4 (formats 0-10), .laz (formats 0-3 and 6-8, COPC), .ply, .pcd,
// KITTI .bin, .xyz/.csv/.txt.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/cloud.h"

namespace cloud {

struct CloudReadOptions {
  /// Metres per unit of the file; automatic: from the LAS coordinate system, else 1.
  std::optional<double> metres_per_unit = {};
  /// Subtracted in double; automatic: the first finite point of the file, rounded to 100 m where it
  /// lies farther than 1000 m from zero, else 0.
  std::optional<Eigen::Vector3d> origin_m = {};
  std::size_t chunk_points = 1'000'000;             ///< handed out at once; bounds the memory
  bool leave_out_marked = false;                    ///< those of MarkedPoints::left_out()
  std::function<void(double share)> progress = {};  ///< of the file, after each chunk
};

/// Points by what the file says of them, each once: class 7 or 18 (low and high noise, as ASPRS
/// numbers the field "classification"), withheld, overlap (of swaths that show the same ground, the
/// flag or class 12), not the last return of their pulse, synthetic (made otherwise than by a
/// scanner).
struct MarkedPoints {
  std::size_t noise = 0, withheld = 0, overlap = 0, not_last = 0, synthetic = 0;
  std::size_t left_out() const { return noise + withheld + overlap + not_last; }
  void add(const MarkedPoints& other);
};
/// Where there are any, one sentence.
std::vector<std::string> remarks_of(const MarkedPoints& marked, bool left_out);

/// What the file says and what was seen while reading it.
struct CloudReadReport {
  std::string
      format;  ///< "LAS 1.2, point format 3", "LAZ 1.4, ...", "PLY binary_little_endian", ...
  std::string unit = "m";  ///< "m", "ft", "US survey ft", or as the file names another
  double metres_per_unit = 1.0;
  double metres_per_height_unit = 1.0;  ///< some coordinate systems give heights in another unit
  bool unit_from_file = false;
  std::string coordinate_system;  ///< as far as the file names one, e.g. "EPSG:2994"
  std::size_t points = 0;         ///< handed out
  std::size_t not_finite = 0;     ///< left out
  MarkedPoints marked;
  /// From one float32 to the next at the largest coordinate per axis; 0: not stored as float32, or
  /// relative to an origin.
  std::array<double, 3> float32_step_m = {0.0, 0.0, 0.0};
  std::vector<std::string> remarks;
};

/// Hands out the cloud piece by piece, all pieces with the same origin, in the order of the file.
using ChunkSink = std::function<void(Cloud&& chunk)>;

/// Hands out the scans, always the same chunks in the same order; it is called two to four times,
/// with more than one thread from another one than the caller's, which waits for it.
using CloudSource = std::function<void(const ChunkSink&)>;

/// A remark says where float32 holds coordinates to no better than 1 mm.
/// Throws Error: no such file, truncated (says how many points fit), corrupt header, unknown
/// format, no points, or no finite point among them; nothing is handed out, without an error, where
/// leave_out_marked leaves out all. Sizes are checked against the file before anything is
/// allocated. Memory: one chunk; .pcd with compressed data the whole of it.
CloudReadReport read_chunks(const std::string& path, const CloudReadOptions& options,
                            const ChunkSink& sink);

/// The same for bytes in memory; the ending of `name` tells the format where the bytes do not.
CloudReadReport read_chunks_from(std::string_view bytes, const std::string& name,
                                 const CloudReadOptions& options, const ChunkSink& sink);

/// The whole file at once.
Cloud read_cloud(const std::string& path, const CloudReadOptions& options = {},
                 CloudReadReport* report = nullptr);

/// The clouds of a folder (sorted by name) or the path itself. Throws Error where there is
/// none.
std::vector<std::string> cloud_files(const std::string& path);

/// Binary .ply or .pcd, as the path ends, with time (double), intensity, classification where there
/// are any; whole or not at all. Coordinates are float32 relative to the cloud's origin, which
/// stands in the header as "comment origin_m X Y Z" or "# origin_m X Y Z" where it is not 0;
/// readers here add it. `doubles`: in the map frame, exact; PCL 1.13 loads such a .ply as 0 0 0.
/// `comments` follow there, a line each. Throws Error (another ending, disk).
void write_cloud(const Cloud& cloud, const std::string& path, bool doubles = false,
                 const std::vector<std::string>& comments = {});

/// For a look before the work: throws Error where write_cloud() would not know the format.
/// Standard output, "-", is .ply.
void require_cloud_ending(const std::string& path);

/// Facts about a cloud.
struct CloudFacts {
  CloudReadReport read;
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();  ///< map frame
  bool has_time = false, has_intensity = false;
  double time_begin_s = 0.0, time_end_s = 0.0;
  std::map<int, std::size_t> points_of_class;  ///< empty where the file has no classes
  /// Smallest spacing of coordinates per axis: that of float32, or of LAS' scale; found coarser
  /// where the values repeat on a coarser grid.
  std::array<double, 3> resolution_m = {0.0, 0.0, 0.0};
};

/// Reads the file once, piece by piece. Adds a remark to read.remarks for an axis quantised to more
/// than 15 mm. Throws as read_chunks.
CloudFacts describe(const std::string& path, const CloudReadOptions& options = {});

}  // namespace cloud
