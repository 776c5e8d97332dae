#include "sim/sights.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_text.h"
#include "put_bytes.h"
#include "sim/message.h"

namespace sim {
namespace {

constexpr std::size_t kJsonPointBytes = 80;  ///< four floats are never longer
constexpr std::size_t kHeadBytes = 1000;

std::uint32_t small(std::size_t number) { return static_cast<std::uint32_t>(number); }

/// In quotes.
std::string word(const std::string& name) {
  using nlohmann::json;
  return base::dump_json(json(name));
}

/// [[1, 2], [3, 4]], numbers that read back as the same bits.
template <class Points, class Numbers>
std::string lists(const Points& points, const Numbers& numbers_of) {
  std::string out = "[";
  for (const auto& point : points)
    fmt::format_to(std::back_inserter(out), "{}[{}]", out.size() > 1 ? "," : "",
                   fmt::join(numbers_of(point), ","));
  return out + "]";
}

std::vector<std::string> write(const Scan& scan, bool as_binary, std::size_t longest) {
  const std::size_t most =
      (longest - kHeadBytes) / (as_binary ? sizeof(ScanPoint) : kJsonPointBytes);
  const std::size_t parts = std::max<std::size_t>(1, (scan.points.size() + most - 1) / most);
  std::vector<std::string> out;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * most, last = std::min(first + most, scan.points.size());
    const std::vector<ScanPoint> points(scan.points.begin() + static_cast<std::ptrdiff_t>(first),
                                        scan.points.begin() + static_cast<std::ptrdiff_t>(last));
    std::string bytes;
    if (as_binary) {
      bytes = "KSS1";
      put(bytes, small(scan.sensor), small(part), small(parts), small(points.size()), scan.time_s);
      bytes.append(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(ScanPoint));
    } else {
      bytes = fmt::format(
          R"({{"scan":{},"time_s":{},"part":{},"parts":{},"at_m":[{}],"turned_rad":[{}],)"
          R"("points":{}}})",
          word(scan.name), scan.time_s, part, parts, fmt::join(scan.at_m, ","),
          fmt::join(scan.turned_rad, ","), lists(points, [](const ScanPoint& p) {
            return std::array{p.x_m, p.y_m, p.z_m, p.intensity};
          }));
    }
    out.push_back(std::move(bytes));
  }
  return out;
}

std::vector<std::string> write(const Edges& edges, bool as_binary, std::size_t) {
  if (!as_binary) {
    const auto numbers = [](const std::array<float, 3>& point) { return point; };
    return {fmt::format(R"({{"edges":{},"time_s":{},"left":{},"right":{}}})", word(edges.name),
                        edges.time_s, lists(edges.left_m, numbers), lists(edges.right_m, numbers))};
  }
  std::string bytes = "KSE1";
  put(bytes, small(edges.sensor), small(edges.left_m.size()), small(edges.right_m.size()),
      edges.time_s);
  for (const auto* const side : {&edges.left_m, &edges.right_m})
    for (const std::array<float, 3>& point : *side) put(bytes, point);
  return {bytes};
}

std::vector<std::string> write(const Plan& plan, bool as_binary, std::size_t) {
  if (!as_binary)
    return {fmt::format(R"({{"plan":{},"sequence":{},"time_s":{}}})",
                        lists(plan.points,
                              [](const PlanPoint& p) {
                                return std::array{p.x_m, p.y_m, p.speed_mps};
                              }),
                        plan.sequence, plan.time_s)};
  std::string bytes = "KSP1";
  put(bytes, plan.sequence, small(plan.points.size()), plan.time_s);
  for (const PlanPoint& point : plan.points) put(bytes, point.x_m, point.y_m, point.speed_mps);
  return {bytes};
}

}  // namespace

std::vector<std::string> write_sight(const Sight& sight, bool as_binary, std::size_t longest) {
  return std::visit([&](const auto& one) { return write(one, as_binary, longest); }, sight);
}

ToldSight tell_sight(Sight sight) {
  constexpr std::size_t kLongestLine = 100'000'000;
  ToldSight out{std::move(sight), {}, {}};
  out.json = write_sight(out.sight, false, kLongestMessage);
  out.line = out.json.size() == 1 ? out.json[0] : write_sight(out.sight, false, kLongestLine)[0];
  return out;
}

}  // namespace sim
