// The calls of the C API that a simulator makes in every step.
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
