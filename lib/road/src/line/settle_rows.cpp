#include "settle_rows.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/statistics.h"

namespace road {
namespace {

constexpr std::size_t kRowsAround = 12;  // rows to both sides that tell what is usual
constexpr std::size_t kFarAround =
    100;                             // and what is usual where a wide place is longer than those
constexpr std::ptrdiff_t kNear = 6;  // rows to both sides: their middles lie on one line,
constexpr double kJump = 0.3;        // of half the width beside it at most
constexpr double kWide = 1.2, kNotWide = 1.1, kFullyWide = 0.9;
constexpr double kQuiet = 0.3;  // of a widening on the side where the road goes on as before

/// Whether a row knows both sides of the road.
bool measured(const GuideRow& row) {
  return row.ends_left && row.ends_right && row.left_m > row.right_m;
}

double half_of(const GuideRow& row) { return 0.5 * (row.left_m - row.right_m); }

/// Half the width in the middle of the rows within `around`; NaN where none knows it.
double usual_half(const GuideRows& all, std::size_t i, std::size_t around) {
  const auto n = static_cast<std::ptrdiff_t>(all.rows.size());
  std::vector<double> near_m;
  for (std::size_t k = 0; k <= 2 * around; ++k) {
    const auto at = static_cast<std::ptrdiff_t>(i + k) - static_cast<std::ptrdiff_t>(around);
    if (!all.closed && (at < 0 || at >= n)) continue;
    const GuideRow& other = all.rows[static_cast<std::size_t>(((at % n) + n) % n)];
    if (measured(other)) near_m.push_back(half_of(other));
  }
  return near_m.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : base::median(std::move(near_m));
}

/// Where the road is wide on one side only (a lay-by, an apron, a pit lane of its own asphalt), it
/// ends there as far from its other side as before and after. Wide places longer than the rows from
/// which it is told what is usual stay as they are.
void narrow_wide_places(GuideRows& all) {
  const std::size_t n = all.rows.size();
  if (n <= 2 * kFarAround) return;
  std::vector<double> usual_m(n);
  for (std::size_t i = 0; i < n; ++i)
    usual_m[i] = std::min(usual_half(all, i, kFarAround), all.usual_half_m);
  const auto wide = [&](std::size_t i) {
    return measured(all.rows[i]) && half_of(all.rows[i]) > kWide * usual_m[i];
  };
  const auto narrow = [&](std::size_t i) {
    return measured(all.rows[i]) && half_of(all.rows[i]) < kNotWide * usual_m[i];
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : n - 1;
    if (!wide(i) || wide(before) || (i == 0 && !all.closed)) continue;
    // From the last row before that is not wide to the first after it.
    std::size_t length = 0, back = 1, on = 0;
    for (std::size_t k = 0; k < 2 * kFarAround && !narrow((i + k) % n); ++k) length = on = k + 1;
    while (back < kFarAround && !narrow((i + n - back) % n)) ++back;
    if (length == 2 * kFarAround || back == kFarAround) continue;
    if (!all.closed && (back > i || i + on >= n)) continue;
    const GuideRow &first = all.rows[(i + n - back) % n], &last = all.rows[(i + on) % n];
    std::vector<double> halves_m;
    for (std::size_t k = 0; k < length; ++k)
      if (measured(all.rows[(i + k) % n])) halves_m.push_back(half_of(all.rows[(i + k) % n]));
    const double full_m = kFullyWide * base::median(halves_m);
    std::size_t begin = 0, end = length - 1;
    while (begin < end && !(half_of(all.rows[(i + begin) % n]) >= full_m)) ++begin;
    while (end > begin && !(half_of(all.rows[(i + end) % n]) >= full_m)) --end;
    const auto out_left = [&](std::size_t k, const GuideRow& from) {
      return all.rows[(i + k) % n].left_m - from.left_m;
    };
    const auto out_right = [&](std::size_t k, const GuideRow& from) {
      return from.right_m - all.rows[(i + k) % n].right_m;
    };
    const auto quiet = [&](const auto& out, const auto& other) {
      return std::abs(out(begin, first)) < kQuiet * other(begin, first) &&
             std::abs(out(end, last)) < kQuiet * other(end, last);
    };
    const bool hold_left = quiet(out_left, out_right), hold_right = quiet(out_right, out_left);
    if (!hold_left && !hold_right) continue;
    const double span = static_cast<double>(on + back);
    const double first_m = half_of(first), last_m = half_of(last);
    for (std::size_t k = 1; k < on + back; ++k) {
      GuideRow& row = all.rows[(i + n - back + k) % n];
      if (!measured(row)) continue;
      const double t = static_cast<double>(k) / span;
      const double width_m =
          std::min(row.left_m - row.right_m, 2.0 * ((1.0 - t) * first_m + t * last_m));
      if (hold_left)
        row.right_m = row.left_m - width_m;
      else
        row.left_m = row.right_m + width_m;
      row.is_narrowed = true;
    }
  }
}

/// Whether a middle jumps from those of its neighbours, or has hardly any: at junctions.
bool is_restless(const std::vector<double>& middle_m, std::size_t i, double half_width_m,
                 bool closed, double scale) {
  const auto n = static_cast<std::ptrdiff_t>(middle_m.size());
  std::vector<double> near_m;
  std::size_t rows = 0;
  for (std::ptrdiff_t k = -kNear; k <= kNear; ++k) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) + k;
    if (!closed && (at < 0 || at >= n)) continue;
    ++rows;
    const double value_m = middle_m[static_cast<std::size_t>(((at % n) + n) % n)];
    if (std::isfinite(value_m)) near_m.push_back(value_m);
  }
  if (3 * near_m.size() < rows) return true;
  return std::abs(middle_m[i] - base::median(std::move(near_m))) >
         kJump * half_width_m + 0.1 * scale;
}

}  // namespace

void fill_between(std::vector<double>& values, bool closed) {
  const std::size_t n = values.size();
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < n; ++i)
    if (std::isfinite(values[i])) known.push_back(i);
  if (known.empty()) return void(std::fill(values.begin(), values.end(), 0.0));
  const std::vector<double> old = values;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isfinite(old[i])) continue;
    const auto after = std::upper_bound(known.begin(), known.end(), i);
    const bool has_after = after != known.end(), has_before = after != known.begin();
    if (!closed && !(has_after && has_before)) {
      values[i] = old[has_after ? *after : known.back()];
      continue;
    }
    const std::size_t b = has_after ? *after : known.front(),
                      a = has_before ? *(after - 1) : known.back();
    const auto forward = static_cast<double>((i + n - a) % n),
               span = static_cast<double>((b + n - a) % n);
    values[i] = span > 0.0 ? old[a] + (old[b] - old[a]) * forward / span : old[a];
  }
}

void settle(GuideRows& all, double scale) {
  const std::size_t n = all.rows.size();
  std::vector<double> halves_m, middle_m(n, std::numeric_limits<double>::quiet_NaN());
  for (const GuideRow& row : all.rows)
    if (measured(row)) halves_m.push_back(half_of(row));
  if (halves_m.empty()) return;
  all.usual_half_m = base::median(halves_m);
  narrow_wide_places(all);
  for (std::size_t i = 0; i < n; ++i) {
    GuideRow& row = all.rows[i];
    const double near_m = usual_half(all, i, kRowsAround);
    row.half_width_m = std::isfinite(near_m) ? near_m : all.usual_half_m;
    row.is_usual = measured(row) && std::abs(half_of(row) - row.half_width_m) <
                                        0.25 * row.half_width_m + 0.1 * scale;
    if (row.is_usual) middle_m[i] = 0.5 * (row.left_m + row.right_m);
  }
  const std::vector<double> first_m = middle_m;
  std::vector<double> half_m(n, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < n; ++i) {
    GuideRow& row = all.rows[i];
    row.is_usual = row.is_usual && !is_restless(first_m, i, row.half_width_m, all.closed, scale);
    if (row.is_usual)
      half_m[i] = row.half_width_m;
    else
      middle_m[i] = std::numeric_limits<double>::quiet_NaN();
  }
  if (std::none_of(all.rows.begin(), all.rows.end(),
                   [](const GuideRow& row) { return row.is_usual; }))
    return;
  fill_between(middle_m, all.closed);
  fill_between(half_m, all.closed);
  for (std::size_t i = 0; i < n; ++i)
    all.rows[i].middle_m = middle_m[i], all.rows[i].half_width_m = half_m[i];
}

}  // namespace road
