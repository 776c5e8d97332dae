#include "emitter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "cloud/error.h"
#include "records.h"

namespace cloud {
namespace {

/// A round origin for what lies far from zero.
Eigen::Vector3d near(const Eigen::Vector3d& p) {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (std::abs(p[k]) > 1000.0) origin[k] = 100.0 * std::round(p[k] / 100.0);
  return origin;
}

}  // namespace

void MarkedPoints::add(const MarkedPoints& other) {
  noise += other.noise, withheld += other.withheld, overlap += other.overlap;
  not_last += other.not_last, synthetic += other.synthetic;
}

std::vector<std::string> remarks_of(const MarkedPoints& marked, bool left_out) {
  std::vector<std::string> said;
  std::vector<std::string> out;
  const auto count = [&](std::size_t points, const char* what) {
    if (points > 0) out.push_back(fmt::format("{} {}", points, what));
  };
  count(marked.noise, "marked as noise (class 7 or 18)");
  count(marked.withheld, "as withheld");
  count(marked.overlap, "as overlap of swaths (the flag, or class 12)");
  count(marked.not_last, "that are not the last return of their pulse");
  if (!out.empty())
    said.push_back(fmt::format("of the points {} {}", fmt::join(out, ", "),
                               left_out ? "were left out" : "are not used by map and grid"));
  if (marked.synthetic > 0)
    said.push_back(fmt::format("{} points marked as synthetic {} used", marked.synthetic,
                               left_out ? "were" : "are"));
  if (said.empty()) return {};
  return {fmt::format("{}", fmt::join(said, "; "))};
}

Emitter::Emitter(const std::string& name, const CloudReadOptions& options, CloudReadReport& report,
                 const ChunkSink& sink)
    : name_(name), options_(options), report_(report), sink_(sink) {
  if (options.metres_per_unit) {
    report.metres_per_unit = report.metres_per_height_unit = *options.metres_per_unit;
    report.unit = "as given";
  } else if (!report.unit_from_file && report.metres_per_height_unit != report.metres_per_unit) {
    throw Error(
        name +
        ": its coordinate system names a unit for the heights, and none for the plan; give the one "
        "that both have (--unit; map, grid: --cloud-unit), or write the plan's into the file");
  }
}

void Emitter::operator()(const Raw& raw, double share) {
  hand_out(raw);
  if (options_.progress) options_.progress(share);
}

void Emitter::finish() const {
  if (report_.points > 0) return;
  // Of several files the others may have points that are not.
  if (options_.leave_out_marked && report_.marked.left_out() > 0) return;
  if (report_.not_finite > 0)
    throw Error(fmt::format("{}: none of the {} points has finite coordinates below 1e8 m", name_,
                            report_.not_finite));
  throw Error(name_ + ": no points in this file");
}

/// Degrees lie within a fraction of one, far from zero, with heights that differ by more; no
/// cloud of a road in metres does, and whoever has one says its unit.
void Emitter::look_for_degrees(const Raw& raw) {
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

bool Emitter::left_out_by_marks(const Raw& raw, std::size_t i) {
  const auto value = [&](Role role) {
    const std::vector<double>& values = raw.of[static_cast<std::size_t>(role)];
    return values.empty() ? 0.0 : values[i];
  };
  const double classed = value(Role::classification);
  MarkedPoints& marked = report_.marked;
  std::size_t* counted = nullptr;
  if (classed == 7.0 || classed == 18.0)
    counted = &marked.noise;
  else if (value(Role::withheld) > 0.0)
    counted = &marked.withheld;
  else if (value(Role::overlap) > 0.0 || classed == 12.0)
    counted = &marked.overlap;
  else if (value(Role::return_number) > 0.0 && value(Role::return_number) < value(Role::returns))
    counted = &marked.not_last;
  if (counted != nullptr) {
    ++*counted;
    return options_.leave_out_marked;
  }
  marked.synthetic += value(Role::synthetic) > 0.0 ? 1 : 0;
  return false;
}

void Emitter::hand_out(const Raw& raw) {
  look_for_degrees(raw);
  const double scale = report_.metres_per_unit, height_scale = report_.metres_per_height_unit;
  const std::vector<double>&x = raw.of[0], &y = raw.of[1], &z = raw.of[2];
  Cloud chunk;
  const auto has = [&](Role role) { return !raw.of[static_cast<std::size_t>(role)].empty(); };
  const auto reserve = [&](auto& values, Role role) {
    if (has(role)) values.reserve(raw.size);
  };
  const Role class_role = has(Role::classification) ? Role::classification : Role::label;
  const std::vector<double>& classes = raw.of[static_cast<std::size_t>(class_role)];
  const bool has_marks = has(Role::classification) || has(Role::withheld) || has(Role::synthetic) ||
                         has(Role::overlap) || has(Role::returns);
  chunk.x_m.reserve(raw.size), chunk.y_m.reserve(raw.size), chunk.z_m.reserve(raw.size);
  reserve(chunk.time_s, Role::time), reserve(chunk.intensity, Role::intensity),
      reserve(chunk.classification, class_role), reserve(chunk.sigma_m, Role::sigma);
  for (std::size_t i = 0; i < raw.size; ++i) {
    const Eigen::Vector3d p(x[i] * scale, y[i] * scale, z[i] * height_scale);
    // Nothing on Earth is farther: such numbers are damage and would cost all precision.
    if (!(std::abs(p.x()) < 1e8 && std::abs(p.y()) < 1e8 && std::abs(p.z()) < 1e8)) {
      ++report_.not_finite;
      continue;
    }
    if (has_marks && left_out_by_marks(raw, i)) continue;
    largest_ = largest_.max(Eigen::Array3d(x[i], y[i], z[i]).abs());
    if (!origin_) origin_ = options_.origin_m ? *options_.origin_m : near(p);
    chunk.x_m.push_back(p.x() - origin_->x());
    chunk.y_m.push_back(p.y() - origin_->y());
    chunk.z_m.push_back(p.z() - origin_->z());
    if (!raw.of[3].empty()) chunk.time_s.push_back(raw.of[3][i]);
    if (!raw.of[4].empty()) chunk.intensity.push_back(static_cast<float>(raw.of[4][i]));
    if (!classes.empty())
      chunk.classification.push_back(
          static_cast<std::uint8_t>(classes[i] >= 0.0 ? std::min(classes[i], 255.0) : 0.0));
    if (!raw.of[6].empty())
      chunk.sigma_m.push_back(static_cast<float>(raw.of[6][i] * height_scale));
  }
  if (chunk.size() == 0) return;
  chunk.origin_m = *origin_;
  report_.points += chunk.size();
  sink_(std::move(chunk));
}

}  // namespace cloud
