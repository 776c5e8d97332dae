// Writes seeds of the fuzz targets: roads that together use every section, format, channel and
// option; meshes; point clouds of every format. Usage: make_corpus tests/corpus
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "crg/file.h"
#include "crg/roads.h"
#include "report/picture.h"
#include "support/cloud_files.h"
#include "support/coloured_ring.h"
#include "support/laz_file.h"
#include "support/mesh_files.h"

using namespace crg;

namespace {

std::string folder;

void save(const std::string& name, const std::string& bytes) {
  std::ofstream(folder + "/crg/" + name + ".crg", std::ios::binary) << bytes;
}

void save_as(const std::string& reader, const std::string& name, const std::string& bytes) {
  std::filesystem::create_directories(folder + "/" + reader);
  std::ofstream(folder + "/" + reader + "/" + name, std::ios::binary) << bytes;
}

void save_clouds() {
  support::CloudSeed seed;
  seed.count = 12;
  for (const int format : {0, 1, 3, 6, 10})
    save_as("las", fmt::format("format_{}.las", format),
            support::as_las(seed, format < 6 ? format % 4 : 4, format, format % 2 == 0));
  for (const int format : {0, 1, 2, 3, 6, 7, 8})
    for (const int version : {0, 1}) {
      support::LazOptions options;
      if (version == 1) options.version = format < 6 ? 1 : 4, options.chunks = {5, 1, 9};
      options.chunked = format != 2;
      save_as("laz", fmt::format("format_{}_{}.laz", format, version),
              support::as_laz(support::busy_las(format, format % 3, 25, 1), options));
    }
  for (const bool doubles : {false, true}) {
    const char* const of = doubles ? "double" : "float";
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
      save_as("ply", fmt::format("{}_{}.ply", format, of),
              support::as_cloud_ply(seed, format, doubles));
    for (const char* data : {"ascii", "binary", "binary_compressed"})
      save_as("pcd", fmt::format("{}_{}.pcd", data, of), support::as_pcd(seed, data, doubles));
  }
  save_as("xyz", "header.csv", support::as_xyz(seed, true));
  save_as("xyz", "bare.xyz", support::as_xyz(seed, false));
}

void save_meshes() {
  const road::Mesh mesh = support::small_road();
  save_as("mesh_text", "binary.stl", support::as_stl(mesh).substr(0, 84 + 50 * 8));
  save_as("mesh_text", "text.stl", support::as_text_stl(mesh));
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
    save_as("mesh_text", fmt::format("{}.ply", format), support::as_ply(mesh, format, "float"));
  save_as("mesh_text", "road.obj", support::as_obj(mesh));
  save_as("mesh_text", "road.acc", support::as_acc(mesh));
}

Crg small(bool closed) {
  ReferenceLine line =
      closed ? test::circuit(21, 12.0, 0.1, 2)
             : test::line_along(
                   9, 1.0, [](double u) { return 0.05 * std::sin(u); }, 5.0, -3.0, 0.4);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line.z_m.push_back(10.0 + 0.1 * std::sin(0.6 * static_cast<double>(i)));
    line.banking.push_back(0.02 * std::cos(0.3 * static_cast<double>(i)));
  }
  Crg crg = make_crg(line,
                     test::grid_of(line, -1.0, 1.5, 5,
                                   [](double u, double v) { return 0.01 * std::sin(3.0 * u + v); }),
                     {"seed"});
  crg.grid.at(2, 0) = std::numeric_limits<float>::quiet_NaN();
  return crg;
}

void save_pictures() {
  save_as("picture", "grass.png", support::png_of(support::kGrass, 12, 9));
  save_as("picture", "asphalt.jpg", support::jpeg_of(support::kAsphalt, 12, 19));
  std::vector<std::uint8_t> rgba;
  for (int k = 0; k < 4 * 5 * 3; ++k) rgba.push_back(static_cast<std::uint8_t>(17 * k));
  save_as("picture", "leaf.png", report::encode_png(5, 3, rgba));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: make_corpus DIRECTORY\n"), 2;
  folder = argv[1];
  std::filesystem::create_directories(folder + "/crg");
  save_clouds();
  save_meshes();
  save_pictures();
  const char* names[] = {"krbi", "kdbi", "lrfi", "ldfi"};
  for (int format = 0; format < 4; ++format) {
    save(std::string("open_") + names[format], to_bytes(small(false), static_cast<Format>(format)));
    save(std::string("closed_") + names[format],
         to_bytes(small(true), static_cast<Format>(format)));
  }
  Crg options = small(false);
  int mode = 0;
  for (const char* key : {"BORDER_MODE_U", "BORDER_MODE_V", "BORDER_OFFSET_U", "BORDER_OFFSET_V",
                          "BORDER_SMOOTH_UBEG", "BORDER_SMOOTH_UEND", "REFLINE_SEARCH_FAR",
                          "WARN_CURV_LOCAL", "CHECK_EPS"}) {
    set_value(options.options, key, key == std::string("CHECK_EPS") ? 1e-5 : mode++ % 5);
  }
  save("options", to_bytes(options, Format::LRFI));
  set_value(options.options, "BORDER_MODE_U", 4.0);
  set_value(options.options, "BORDER_MODE_V", 3.0);
  save("reflect", to_bytes(options, Format::LRFI));
  Crg modifiers = small(false);
  for (const char* key : {"SCALE_Z_GRID", "SCALE_SLOPE", "SCALE_BANKING", "SCALE_LENGTH",
                          "SCALE_WIDTH", "SCALE_CURVATURE", "GRID_NAN_MODE", "GRID_NAN_OFFSET",
                          "REFPOINT_U_FRACTION", "REFPOINT_V", "REFPOINT_X", "REFPOINT_PHI"}) {
    set_value(modifiers.modifiers, key, 1.0);
  }
  save("modifiers_refpoint", to_bytes(modifiers, Format::LRFI));
  modifiers.modifiers = {{.key = "REFLINE_ROTCENTER_X", .value = 3.0},
                         {.key = "REFLINE_OFFSET_PHI", .value = 1.0},
                         {.key = "REFLINE_OFFSET_Z", .value = -2.0},
                         {.key = "GRID_NAN_MODE", .value = 2.0}};
  save("modifiers_offset", to_bytes(modifiers, Format::KRBI));
  Crg everything = small(false);
  everything.projection = {{.key = "GELL_NM", .text = "WGS84"},
                           {.key = "GELL_A", .value = 6378137.0},
                           {.key = "PROJ_NM", .text = "UTM_32N"},
                           {.key = "PROJ_F0", .value = 0.9996}};
  for (const char* key :
       {"REFERENCE_LINE_START_LON", "REFERENCE_LINE_START_LAT", "REFERENCE_LINE_END_LON",
        "REFERENCE_LINE_END_LAT", "REFERENCE_LINE_OFFSET_X"})
    set_value(everything.road, key, 9.0);
  everything.u_m.assign(9, 1.0);
  everything.other_channels = {
      {.definition = "reference line wetness,mm", .values = std::vector<double>(9, 0.5)}};
  everything.other_sections = {{.name = "$VENDOR", .lines = {"a = b"}}};
  everything.virtual_channels = {"reference line u,m,0,1"};
  everything.grid.v_m = {-1.0, -0.9, 0.1, 0.2, 1.5};
  save("everything", to_bytes(everything, Format::KDBI));
  Crg nodes = small(false);
  const ReferenceLine line = integrate_reference_line(nodes);
  nodes.x_m = line.x_m;
  nodes.y_m = line.y_m;
  save("xy_channels", to_bytes(nodes, Format::LDFI));
  save("minimal",
       "$ROAD_CRG\r\nREFERENCE_LINE_INCREMENT = 1.0\r\nLONG_SECTION_V_INCREMENT = "
       "+.5D0\r\n$\r\n$KD_Definition\r\n#:LRFI ! text\r\n"
       "D:long section 2,m\r\nD:long section 1,m\r\n$\r\n$$$$\r\n 0.0000000 *missing*\r\n 1.0      "
       " -0.5E-1\r\n");
  save("include", "$ROAD_CRG_FILE\n  ../crg-txt/\n  other.crg\n$\n$ROAD_CRG_MODS\n$\n");
  save("spiral", [] {
    const ReferenceLine tight = test::line_along(30, 0.5, [](double u) { return 0.2 + 0.2 * u; });
    return to_bytes(
        make_crg(tight, test::grid_of(tight, -3.0, 3.0, 3, [](double, double) { return 1.0; })),
        Format::KRBI);
  }());
}
