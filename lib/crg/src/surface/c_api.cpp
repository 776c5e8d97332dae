#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <string>

#include "crg.h"
#include "crg/surface.h"
#include "locator.h"

// Behind the opaque pointer stands the C++ surface itself.
struct crg_surface {
  crg::Surface surface;
};

namespace {

crg::Cursor from_c(const crg_cursor* cursor) {
  if (cursor == nullptr) return {};
  const double position = static_cast<double>(cursor->segment) + cursor->fraction;
  if (position == 0.0 && cursor->advance == 0.0) return {};
  return crg::cursor_at(position, cursor->advance);
}

void to_c(const crg::Cursor& from, crg_cursor* cursor) {
  if (cursor == nullptr) return;
  const double position = from.last - crg::kCursorBias, advance = from.ahead - from.last;
  // New, or what a caller's damaged cursor became.
  if (!(position >= 0.0 && position < crg::kCursorBias && std::abs(advance) < crg::kCursorBias)) {
    *cursor = {};
    return;
  }
  const auto segment = static_cast<std::size_t>(position);
  *cursor = {segment, position - static_cast<double>(segment), advance};
}

int to_c(const crg::Sample& from, crg_sample* sample) {
  if (sample != nullptr) {
    *sample = {from.valid,    from.inside,   from.u_m,         from.v_m,           from.x_m,
               from.y_m,      from.z_m,      from.dzdx,        from.dzdy,          from.normal_x,
               from.normal_y, from.normal_z, from.heading_rad, from.curvature_1pm, from.friction};
  }
  return from.valid ? 1 : 0;
}

crg::SurfaceOptions from_c(const crg_open_options* given) {
  crg::SurfaceOptions options;
  if (given == nullptr) return options;
  crg_open_options known = {};
  std::memcpy(&known, given, std::min(given->struct_size, sizeof known));
  options.modifiers = known.modifiers == CRG_MODIFIERS_NONE ? crg::ModifierUse::None
                      : known.modifiers == CRG_MODIFIERS_REFERENCE_DEFAULTS
                          ? crg::ModifierUse::ReferenceDefaults
                          : crg::ModifierUse::AsInFile;
  if (known.smooth != 0) options.interpolation = crg::Interpolation::Smooth;
  options.curvature_of_reference_line = known.curvature_of_reference_line != 0;
  if (known.friction != 0.0) options.friction = known.friction;
  if (known.friction_path != nullptr) options.friction_map = crg::read(known.friction_path);
  return options;
}

}  // namespace

extern "C" {

int crg_api_version(void) { return CRG_API_VERSION; }

crg_surface* crg_open(const char* path, const crg_open_options* options, char* message,
                      size_t message_size) {
  std::string reason;
  try {
    return new crg_surface{crg::Surface(crg::read(path), from_c(options))};
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (message != nullptr && message_size > 0) {
    const std::size_t length = std::min(reason.size(), message_size - 1);
    std::memcpy(message, reason.data(), length);
    message[length] = '\0';
  }
  return nullptr;
}

void crg_close(crg_surface* surface) { delete surface; }

void crg_range(const crg_surface* surface, double* u_begin_m, double* u_end_m, double* v_right_m,
               double* v_left_m) {
  const crg::Grid& grid = surface->surface.grid();
  if (u_begin_m != nullptr) *u_begin_m = grid.u_begin_m;
  if (u_end_m != nullptr) *u_end_m = grid.u_of(grid.rows() - 1);
  if (v_right_m != nullptr) *v_right_m = grid.v_m.front();
  if (v_left_m != nullptr) *v_left_m = grid.v_m.back();
}

int crg_is_closed(const crg_surface* surface) { return surface->surface.closed() ? 1 : 0; }

int crg_at_xy(const crg_surface* surface, double x_m, double y_m, crg_cursor* cursor,
              crg_sample* sample) {
  crg::Cursor own = from_c(cursor);
  const crg::Sample answer = surface->surface.at_xy(x_m, y_m, own);
  to_c(own, cursor);
  return to_c(answer, sample);
}

int crg_at_uv(const crg_surface* surface, double u_m, double v_m, crg_sample* sample) {
  return to_c(surface->surface.at_uv(u_m, v_m), sample);
}

double crg_z_at_xy(const crg_surface* surface, double x_m, double y_m, crg_cursor* cursor) {
  crg::Cursor own = from_c(cursor);
  const double z = surface->surface.z_at_xy(x_m, y_m, own);
  to_c(own, cursor);
  return z;
}

double crg_z_at_uv(const crg_surface* surface, double u_m, double v_m) {
  return surface->surface.z_at_uv(u_m, v_m);
}

void crg_xy_of_uv(const crg_surface* surface, double u_m, double v_m, double* x_m, double* y_m) {
  const crg::Point2 point = surface->surface.xy_of_uv(u_m, v_m);
  *x_m = point.x_m;
  *y_m = point.y_m;
}

void crg_uv_of_xy(const crg_surface* surface, double x_m, double y_m, crg_cursor* cursor,
                  double* u_m, double* v_m) {
  crg::Cursor own = from_c(cursor);
  const crg::UV uv = surface->surface.uv_of_xy(x_m, y_m, own);
  to_c(own, cursor);
  *u_m = uv.u_m;
  *v_m = uv.v_m;
}

double crg_strip(const crg_surface* surface, double x_m, double y_m, double heading_rad,
                 size_t along, size_t across, double step_m, float* dz_m, crg_cursor* cursor) {
  crg::Cursor own = from_c(cursor);
  const crg::Strip strip{.x_m = x_m,
                         .y_m = y_m,
                         .ahead = {std::cos(heading_rad), std::sin(heading_rad)},
                         .along = along,
                         .across = across,
                         .step_m = step_m};
  const double base = surface->surface.strip(strip, {dz_m, along * across}, own);
  to_c(own, cursor);
  return base;
}

}  // extern "C"
