#include "crg/patches.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "crg/error.h"
#include "text.h"

namespace crg {
namespace {

// Weight of a patch and its gradient at a place inside its grid.
struct Weight {
  double value = 0.0, dx = 0.0, dy = 0.0;
};

Weight weight_of(const Surface& surface, const Sample& sample, double blend_m) {
  const Grid& grid = surface.grid();
  const double u_end = grid.u_of(grid.rows() - 1);
  // Distance to the nearest border, and the direction in which it grows fastest.
  const double distances[4] = {sample.u_m - grid.u_begin_m, u_end - sample.u_m,
                               sample.v_m - grid.v_m.front(), grid.v_m.back() - sample.v_m};
  const std::size_t nearest =
      static_cast<std::size_t>(std::min_element(distances, distances + 4) - distances);
  const double share = std::clamp(distances[nearest] / blend_m, 0.0, 1.0);
  const double c = std::cos(sample.heading_rad), s = std::sin(sample.heading_rad);
  const double directions[4][2] = {{c, s}, {-c, -s}, {-s, c}, {s, -c}};
  const double slope = 6.0 * share * (1.0 - share) / blend_m;
  return {share * share * (3.0 - 2.0 * share), slope * directions[nearest][0],
          slope * directions[nearest][1]};
}

void set_normal(Sample& sample) {
  const double scale = 1.0 / std::sqrt(1.0 + sample.dzdx * sample.dzdx + sample.dzdy * sample.dzdy);
  sample.normal_x = -sample.dzdx * scale;
  sample.normal_y = -sample.dzdy * scale;
  sample.normal_z = scale;
}

std::vector<PatchedSurface::Patch> read_patches(const PatchIndex& index) {
  std::vector<PatchedSurface::Patch> patches;
  for (const PatchIndex::Entry& entry : index.patches)
    patches.push_back({Surface(read(entry.path)), entry.blend_m});
  return patches;
}

}  // namespace

PatchIndex read_patch_index(const std::string& path) {
  std::error_code none;
  if (const auto type = std::filesystem::status(path, none).type();
      type != std::filesystem::file_type::not_found && type != std::filesystem::file_type::regular)
    throw Error(path + ": not a regular file");
  std::ifstream file(path);
  if (!file) throw Error(path + ": cannot open");
  PatchIndex index;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string kind, name, setting;
    if (!(words >> kind)) continue;
    const std::string place = path + ":" + std::to_string(number) + ": ";
    if ((kind != "base" && kind != "patch") || !(words >> name)) {
      throw Error(place + "\"" + line.substr(0, 60) +
                  "\": want \"base FILE\" or \"patch FILE blend_m=0.1\"");
    }
    PatchIndex::Entry entry{(std::filesystem::path(path).parent_path() / name).string()};
    while (words >> setting) {
      std::string_view rest;
      const std::string_view text = setting;
      const double value =
          text.starts_with("blend_m=") ? parse_number(text.substr(8), &rest).value_or(0.0) : 0.0;
      if (kind == "base" || !rest.empty() || !(value > 0.0)) {
        throw Error(place + "\"" + setting.substr(0, 40) +
                    "\": want blend_m= with a length in metres above 0, behind a patch");
      }
      entry.blend_m = value;
    }
    if (kind == "patch") {
      index.patches.push_back(entry);
    } else if (index.base_path.empty()) {
      index.base_path = entry.path;
    } else {
      throw Error(place + "a second base; want one");
    }
  }
  if (index.base_path.empty()) throw Error(path + ": no line \"base FILE\"");
  return index;
}

PatchedSurface::PatchedSurface(Surface base, std::vector<Patch> patches)
    : base_(std::move(base)), patches_(std::move(patches)) {
  for (const Patch& patch : patches_) {
    if (!(patch.blend_m > 0.0))
      throw Error("patch with a blend of " + shortest(patch.blend_m) + " m: want more than 0");
    const ReferenceLine& line = patch.surface.reference_line();
    const std::vector<double>& v_m = patch.surface.grid().v_m;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Box box{kInfinity, -kInfinity, kInfinity, -kInfinity};
    for (std::size_t i = 0; i < line.size(); ++i) {
      for (const double v : {v_m.front(), v_m.back()}) {
        const Point2 p = node_position(line, i, v);
        box = {std::min(box.x_min_m, p.x_m), std::max(box.x_max_m, p.x_m),
               std::min(box.y_min_m, p.y_m), std::max(box.y_max_m, p.y_m)};
      }
    }
    boxes_.push_back(box);
  }
}

PatchedSurface::PatchedSurface(const PatchIndex& index)
    : PatchedSurface(Surface(read(index.base_path)), read_patches(index)) {}

Sample PatchedSurface::at_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  Sample sample = base_.at_xy(x_m, y_m, cursor);
  for (std::size_t k = 0; k < patches_.size(); ++k) {
    const Box& box = boxes_[k];
    if (!(x_m >= box.x_min_m && x_m <= box.x_max_m && y_m >= box.y_min_m && y_m <= box.y_max_m))
      continue;
    Cursor start;  // patches are short: finding the place anew costs little and leaves no history
    const Sample over = patches_[k].surface.at_xy(x_m, y_m, start);
    if (!over.valid || !over.inside) continue;
    const Weight weight = weight_of(patches_[k].surface, over, patches_[k].blend_m);
    if (sample.valid) {
      const double rise = over.z_m - sample.z_m;
      sample.z_m += weight.value * rise;
      sample.dzdx += weight.value * (over.dzdx - sample.dzdx) + weight.dx * rise;
      sample.dzdy += weight.value * (over.dzdy - sample.dzdy) + weight.dy * rise;
    } else {
      sample.valid = true;
      sample.z_m = over.z_m;
      sample.dzdx = over.dzdx;
      sample.dzdy = over.dzdy;
      sample.friction = over.friction;
    }
    set_normal(sample);
  }
  return sample;
}

double PatchedSurface::z_at_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  return at_xy(x_m, y_m, cursor).z_m;
}

}  // namespace crg
