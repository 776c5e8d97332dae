// The calls of the C API that a simulator makes in every step.
#include <array>
#include <cmath>

#include "contact_point.h"

using opencrg::ContactPoint;

namespace {

ContactPoint* asked(int id, const double* a, const double* b) noexcept {
  return a == nullptr || b == nullptr ? nullptr : opencrg::find_contact_point(id);
}

bool finite(double a, double b) noexcept { return std::isfinite(a) && std::isfinite(b); }

[[gnu::noinline]] int by_rules(const ContactPoint& point, double u, double v, double* z) noexcept {
  *z = 0.0;
  if (!finite(u, v)) return 0;
  const auto found =
      opencrg::height(*point.surface, point.border, point.closed, point.set->banking_folds, u, v);
  if (found) *z = *found;
  return found ? 1 : 0;
}

int heading(const ContactPoint& point, double u, double v, double* phi, double* curv) noexcept {
  const crg::Heading sample = point.surface->heading_at_uv(u, point.line_curvature ? 0.0 : v);
  *phi = sample.heading_rad;
  *curv = sample.curvature_1pm;
  return 1;
}

/// To the world where `way` is 1, from it where it is -1.
int placed(const ContactPoint* point, double way, std::array<double, 3> from, double* x, double* y,
           double* z) noexcept {
  if (point == nullptr || z == nullptr || !finite(from[0], from[1])) return 0;
  const opencrg::Origin& o = point->set->origin;
  const crg::ReferenceLine& line = point->surface->reference_line();
  const double begin_x = line.x_m.front() + (way < 0.0 ? o.x_m : 0.0),
               begin_y = line.y_m.front() + (way < 0.0 ? o.y_m : 0.0);
  const double dx = from[0] - begin_x, dy = from[1] - begin_y;
  const double cos = std::cos(o.phi_rad), sin = way * std::sin(o.phi_rad);
  *x = begin_x + way * o.x_m + cos * dx - sin * dy;
  *y = begin_y + way * o.y_m + sin * dx + cos * dy;
  *z = from[2] + way * o.z_m;
  return 1;
}

}  // namespace

int crgEvalxy2uv(int cpId, double x, double y, double* u, double* v) {
  ContactPoint* point = asked(cpId, u, v);
  if (point == nullptr || !finite(x, y)) return 0;
  const crg::UV uv = point->surface->uv_of_xy(x, y, point->cursor);
  *u = uv.u_m;
  *v = uv.v_m;
  return 1;
}

int crgEvaluv2xy(int cpId, double u, double v, double* x, double* y) {
  const ContactPoint* point = asked(cpId, x, y);
  if (point == nullptr || !finite(u, v)) return 0;
  const crg::Point2 place = point->surface->xy_of_uv(u, v);
  *x = place.x_m;
  *y = place.y_m;
  return 1;
}

int crgEvaluv2z(int cpId, double u, double v, double* z) {
  const ContactPoint* point = asked(cpId, z, z);
  if (point == nullptr) return 0;
  if (!point->smooth) [[likely]] {
    *z = point->surface->z_at_uv(u, v);
    if (!std::isnan(*z)) [[likely]]
      return 1;
  }
  return by_rules(*point, u, v, z);
}

int crgEvalxy2z(int cpId, double x, double y, double* z) {
  ContactPoint* point = asked(cpId, z, z);
  if (point == nullptr) return 0;
  if (!point->smooth) [[likely]] {
    *z = point->surface->z_at_xy(x, y, point->cursor);
    if (!std::isnan(*z)) [[likely]]
      return 1;
  }
  *z = 0.0;
  if (!finite(x, y)) return 0;
  const crg::UV uv = point->surface->uv_of_xy(x, y, point->cursor);
  return by_rules(*point, uv.u_m, uv.v_m, z);
}

int crgEvaluv2pk(int cpId, double u, double v, double* phi, double* curv) {
  const ContactPoint* point = asked(cpId, phi, curv);
  return point == nullptr || !finite(u, v) ? 0 : heading(*point, u, v, phi, curv);
}

int crgEvalxy2pk(int cpId, double x, double y, double* phi, double* curv) {
  ContactPoint* point = asked(cpId, phi, curv);
  if (point == nullptr || !finite(x, y)) return 0;
  if (point->line_curvature) {
    const crg::UV uv = point->surface->uv_of_xy(x, y, point->cursor);
    return heading(*point, uv.u_m, uv.v_m, phi, curv);
  }
  const crg::Sample sample = point->surface->at_xy(x, y, point->cursor);
  *phi = sample.heading_rad;
  *curv = sample.curvature_1pm;
  return 1;
}

int crgEvalxyz2enh(int cpId, double x, double y, double z, double* e, double* n, double* h) {
  return placed(asked(cpId, e, n), 1.0, {x, y, z}, e, n, h);
}

int crgEvalenh2xyz(int cpId, double e, double n, double h, double* x, double* y, double* z) {
  return placed(asked(cpId, x, y), -1.0, {e, n, h}, x, y, z);
}
