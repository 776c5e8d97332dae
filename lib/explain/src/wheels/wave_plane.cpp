#include "wave_plane.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <map>

namespace explain {
namespace {

constexpr double kFlank_m = 25.0, kEdge_m = 2.0;

/// Adds one pass of a wheel over a place, without the cubic that its flanks ask for.
void add_pass(const std::vector<const WheelHeight*>& samples, const Place& place,
              const std::vector<bool>& cells, Plane& out) {
  const double middle = 0.5 * (place.u_begin_m + place.u_end_m),
               reach = 0.5 * (place.u_end_m - place.u_begin_m) + kFlank_m;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  std::array<int, 2> flank{};
  const auto powers = [&](double u) {
    const double d = (u - middle) / reach;
    return Eigen::Vector4d(1, d, d * d, d * d * d);
  };
  for (const WheelHeight* l : samples) {
    const auto cell = static_cast<std::size_t>(std::max(0.0, l->u_m) / kWaveCell_m);
    if (l->u_m > place.u_begin_m - kEdge_m && l->u_m < place.u_end_m + kEdge_m) continue;
    if (cell < cells.size() && cells[cell]) continue;
    const Eigen::Vector4d x = powers(l->u_m);
    normal += x * x.transpose();
    right += x * l->raw_m;
    ++flank[l->u_m > middle ? 1 : 0];
  }
  if (flank[0] < 20 || flank[1] < 20) return;
  const Eigen::Vector4d base = normal.ldlt().solve(right);
  for (const WheelHeight* l : samples) {
    if (l->u_m < place.u_begin_m - kEdge_m || l->u_m > place.u_end_m + kEdge_m) continue;
    const std::size_t k = out.bin(l->u_m, l->v_m);
    if (k >= out.rows * out.columns) continue;
    out.sum[static_cast<std::size_t>(l->half)][k] += l->raw_m - base.dot(powers(l->u_m));
    out.count[static_cast<std::size_t>(l->half)][k] += 1;
  }
}

}  // namespace

Plane plane_of(const std::vector<WheelHeight>& heights, double length_m, double right_m,
               double left_m) {
  Plane plane(length_m, right_m, left_m);
  for (const WheelHeight& l : heights) {
    const std::size_t k = plane.bin(l.u_m, l.v_m);
    if (k >= plane.rows * plane.columns) continue;
    plane.sum[static_cast<std::size_t>(l.half)][k] += l.measured_m - l.file_m;
    plane.count[static_cast<std::size_t>(l.half)][k] += 1;
  }
  return plane;
}

std::size_t cell_of(std::size_t row) {
  return static_cast<std::size_t>(static_cast<double>(row) * kBinU_m / kWaveCell_m);
}

Agreement agree(const Plane& plane, std::size_t shift) {
  const auto cells =
      static_cast<std::size_t>(static_cast<double>(plane.rows) * kBinU_m / kWaveCell_m) + 1;
  Agreement out;
  for (auto* v : {&out.product, &out.energy, &out.n}) v->assign(cells, 0.0);
  std::vector<double> aa(cells, 0.0), bb(cells, 0.0);
  for (std::size_t i = 0; i < plane.rows; ++i) {
    const std::size_t other = (i + shift) % plane.rows;
    const std::size_t cell = cell_of(i);
    for (std::size_t j = 0; j < plane.columns; ++j) {
      const double x = plane.mean(0, i * plane.columns + j),
                   y = plane.mean(1, other * plane.columns + j);
      if (!std::isfinite(x) || !std::isfinite(y)) continue;
      out.product[cell] += x * y;
      aa[cell] += x * x;
      bb[cell] += y * y;
      out.n[cell] += 1;
    }
  }
  for (std::size_t k = 0; k < cells; ++k) out.energy[k] = std::sqrt(aa[k] * bb[k]);
  return out;
}

std::vector<Place> joined(const std::vector<bool>& cells) {
  std::vector<Place> out;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (!cells[k]) continue;
    const double begin = static_cast<double>(k) * kWaveCell_m;
    if (!out.empty() && begin - out.back().u_end_m < 1.5 * kWaveCell_m)
      out.back().u_end_m = begin + kWaveCell_m;
    else
      out.push_back({begin, begin + kWaveCell_m, {}});
  }
  return out;
}

Plane anchored(const std::vector<WheelHeight>& heights, const std::vector<Place>& places,
               const std::vector<bool>& cells, const Plane& like) {
  Plane out = like;
  for (auto& s : out.sum) std::fill(s.begin(), s.end(), 0.0);
  for (auto& c : out.count) std::fill(c.begin(), c.end(), 0.0);
  for (const Place& place : places) {
    std::map<std::size_t, std::vector<const WheelHeight*>> passes;
    for (const WheelHeight& l : heights)
      if (l.u_m > place.u_begin_m - kFlank_m && l.u_m < place.u_end_m + kFlank_m)
        passes[l.pass].push_back(&l);
    for (const auto& [pass, samples] : passes) add_pass(samples, place, cells, out);
  }
  return out;
}

}  // namespace explain
