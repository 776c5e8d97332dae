#include "border.h"

#include <algorithm>
#include <cmath>

namespace opencrg {
namespace {

// A coordinate outside its range: where it comes to lie, and whether that counts as inside.
struct Folded {
  double value_m;
  bool inside;
};

Folded fold(double value_m, double begin_m, double end_m, int mode) {
  const double length = end_m - begin_m, offset = value_m - begin_m;
  if (mode == dCrgBorderModeRepeat) {
    const double rest = std::fmod(offset, length);
    return {begin_m + (rest < 0.0 ? rest + length : rest), true};
  }
  if (mode == dCrgBorderModeReflect) {
    const double rest = std::fmod(std::abs(offset), 2.0 * length);
    return {begin_m + (rest > length ? 2.0 * length - rest : rest), true};
  }
  return {std::clamp(value_m, begin_m, end_m), false};
}

// The reference line's own height and banking at a u on it.
struct OnLine {
  double z_m, banking;
};

OnLine on_line(const crg::ReferenceLine& line, double u_m) {
  const double last = static_cast<double>(line.size() - 2);
  const double rows = (u_m - line.u_begin_m) / line.u_step_m;
  const auto i = static_cast<std::size_t>(std::clamp(rows, 0.0, last));
  const double share = std::clamp(rows - static_cast<double>(i), 0.0, 1.0);
  const auto of = [&](const std::vector<double>& values) {
    return values.empty() ? 0.0 : values[i] + share * (values[i + 1] - values[i]);
  };
  return {of(line.z_m), of(line.banking)};
}

// Heights fade to the line's own at its ends; where both zones reach, the later one counts.
double smoothed(double z_m, const crg::ReferenceLine& line, const Border& border, double begin_m,
                double end_m, double u_m) {
  double share = 1.0, level_m = 0.0;
  const auto level = [&](bool at_end) {
    return line.z_m.empty() ? 0.0 : at_end ? line.z_m.back() : line.z_m.front();
  };
  if (border.smooth_begin_m > 0.0 && u_m - begin_m <= border.smooth_begin_m) {
    share = std::max(0.0, u_m - begin_m) / border.smooth_begin_m;
    level_m = level(false);
  }
  if (border.smooth_end_m > 0.0 && end_m - u_m <= border.smooth_end_m) {
    share = std::max(0.0, end_m - u_m) / border.smooth_end_m;
    level_m = level(true);
  }
  return share == 1.0 ? z_m : level_m + (z_m - level_m) * share;
}

double wrapped(const ClosedRange& closed, double u_m) {
  const double offset = u_m - closed.begin_m;
  if (closed.period_m <= 0.0 || (offset >= 0.0 && offset <= closed.period_m)) return u_m;
  const double rest = std::fmod(offset, closed.period_m);
  return closed.begin_m + (rest > 0.0 ? rest : rest + closed.period_m);
}

}  // namespace

Border border_of(const Settings& settings) {
  const auto whole = [&](unsigned int id, int otherwise) {
    int value = otherwise;
    settings.get_int(id, value);
    return value;
  };
  return {.mode_u = whole(dCrgCpOptionBorderModeU, dCrgBorderModeNone),
          .mode_v = whole(dCrgCpOptionBorderModeV, dCrgBorderModeExKeep),
          .offset_u_m = settings.value_or(dCrgCpOptionBorderOffsetU, 0.0),
          .offset_v_m = settings.value_or(dCrgCpOptionBorderOffsetV, 0.0),
          .smooth_begin_m = settings.value_or(dCrgCpOptionSmoothUBegin, 0.0),
          .smooth_end_m = settings.value_or(dCrgCpOptionSmoothUEnd, 0.0)};
}

std::optional<double> height(const crg::Surface& surface, const Border& border,
                             const ClosedRange& closed, bool banking_folds, double u_m,
                             double v_m) noexcept {
  const crg::Grid& grid = surface.grid();
  const crg::ReferenceLine& line = surface.reference_line();
  const double begin_m = grid.u_begin_m, end_m = grid.u_of(grid.rows() - 1);
  const double right_m = grid.v_m.front(), left_m = grid.v_m.back();
  constexpr double kRounding_m = 1e-8;

  double u = wrapped(closed, u_m), offset_m = 0.0;
  Folded along{u, true}, across{std::clamp(v_m, right_m, left_m), true};
  if (u < begin_m || u > end_m) {
    if (border.mode_u == dCrgBorderModeNone) return std::nullopt;
    along = fold(u, begin_m, end_m, border.mode_u);
    offset_m += border.offset_u_m;
    if (along.inside) u = along.value_m;
  }
  if (v_m < right_m - kRounding_m || v_m > left_m + kRounding_m) {
    if (border.mode_v == dCrgBorderModeNone) return std::nullopt;
    across = fold(v_m, right_m, left_m, border.mode_v);
    offset_m += border.offset_v_m;
  }
  const OnLine on = on_line(line, along.value_m);
  const double banked_v_m = banking_folds ? across.value_m : std::clamp(v_m, right_m, left_m);
  double z = on.z_m + on.banking * banked_v_m;
  if (across.inside || border.mode_v != dCrgBorderModeExZero) {
    z = surface.z_at_uv(along.value_m, across.value_m) + on.banking * (banked_v_m - across.value_m);
  }
  // Offsets count outside; beyond an end its mode decides, also beside the road.
  if (!along.inside || !across.inside) {
    const int mode = along.inside ? border.mode_v : border.mode_u;
    if (mode == dCrgBorderModeExZero) z = offset_m;
    if (mode == dCrgBorderModeExKeep) z += offset_m;
  }
  return border.smooth() ? smoothed(z, line, border, begin_m, end_m, u) : z;
}

}  // namespace opencrg
