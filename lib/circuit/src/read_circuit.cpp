// circuit.yaml -> CircuitDesign. The only file of the synthetic circuit that knows yaml-cpp.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/read_file.h"
#include "circuit/circuit.h"
#include "mesh/error.h"
#include "plan_view.h"

namespace road {
namespace {

[[noreturn]] void fail(const std::string& file, const YAML::Mark& mark, const std::string& words) {
  throw Error(fmt::format("{}:{}: {}", file, mark.is_null() ? 1 : mark.line + 1, words));
}

/// One mapping: values are asked for by key, finish() refuses the keys nobody asked for.
class Map {
 public:
  Map(const std::string& file, std::string what, const YAML::Node& node)
      : file_(file), what_(std::move(what)), node_(node) {
    if (!node_.IsMap()) fail(file_, node_.Mark(), what_ + " must be a mapping of keys to values");
  }

  bool has(const char* key) const { return static_cast<bool>(node_[key]); }

  YAML::Node child(const char* key) {
    known_.emplace_back(key);
    return node_[key];
  }

  double number(const char* key, double low, double high) {
    const YAML::Node node = child(key);
    if (!node)
      fail(file_, node_.Mark(), fmt::format("{} has no {}; give {} to {}", what_, key, low, high));
    return checked(key, node, low, high);
  }
  double number(const char* key, double low, double high, double otherwise) {
    const YAML::Node node = child(key);
    return node ? checked(key, node, low, high) : otherwise;
  }

  std::string word(const char* key, const std::vector<std::string>& allowed,
                   const char* otherwise) {
    const YAML::Node node = child(key);
    if (!node) return otherwise;
    std::string seen = node.IsScalar() ? node.Scalar() : "(not a word)";
    if (std::find(allowed.begin(), allowed.end(), seen) == allowed.end()) {
      fail(file_, node.Mark(),
           fmt::format("{} is '{}'; give one of: {}", key, seen, fmt::join(allowed, ", ")));
    }
    return seen;
  }

  bool flag(const char* key, bool otherwise) {
    return word(key, {"true", "false"}, otherwise ? "true" : "false") == "true";
  }

  Side side() {
    if (!has("side")) fail(file_, node_.Mark(), what_ + " has no side; give left or right");
    return word("side", {"left", "right"}, "left") == "left" ? Side::left : Side::right;
  }

  /// u_begin_m and u_end_m.
  std::pair<double, double> range() {
    const double begin = number("u_begin_m", 0.0, 1e6);
    const double end = number("u_end_m", 0.0, 1e6);
    if (!(end > begin)) {
      fail(file_, node_.Mark(),
           fmt::format("{} runs from u = {} m to {} m; end must lie after begin", what_, begin,
                       end));
    }
    return {begin, end};
  }

  /// A scalar, or a list of [u_m, value].
  Knots knots(const char* key, double low, double high, double otherwise) {
    const YAML::Node node = child(key);
    if (!node) return {{0.0}, {otherwise}};
    if (node.IsScalar()) return {{0.0}, {checked(key, node, low, high)}};
    Knots knots;
    for (const YAML::Node& pair : list(key, node)) {
      if (!pair.IsSequence() || pair.size() != 2) {
        fail(file_, pair.Mark(), fmt::format("{} needs pairs [u_m, value]", key));
      }
      knots.u_m.push_back(checked("u_m", pair[0], 0.0, 1e6));
      knots.value.push_back(checked(key, pair[1], low, high));
    }
    if (knots.u_m.empty())
      fail(file_, node.Mark(), fmt::format("{} is empty; give [u_m, value]", key));
    return knots;
  }

  /// The maps of a list; none when the key is absent.
  std::vector<Map> maps(const char* key) {
    std::vector<Map> result;
    const YAML::Node node = child(key);
    if (!node) return result;
    for (const YAML::Node& item : list(key, node)) {
      result.emplace_back(file_, fmt::format("{}[{}]", key, result.size()), item);
    }
    return result;
  }

  YAML::Node list(const char* key, const YAML::Node& node) const {
    if (!node.IsSequence()) fail(file_, node.Mark(), fmt::format("{} must be a list", key));
    return node;
  }

  double checked(const char* key, const YAML::Node& node, double low, double high) const {
    double value = std::numeric_limits<double>::quiet_NaN();
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !(value >= low) ||
        !(value <= high)) {
      fail(file_, node.Mark(),
           fmt::format("{} is '{}'; give a number from {} to {}", key,
                       node.IsScalar() ? node.Scalar() : "(not a number)", low, high));
    }
    return value;
  }

  void finish() const {
    for (const auto& entry : node_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a word)";
      if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
        fail(file_, entry.first.Mark(),
             fmt::format("{} has an unknown key '{}'; known: {}", what_, key,
                         fmt::join(known_, ", ")));
      }
    }
  }

  const std::string& file() const { return file_; }
  YAML::Mark mark() const { return node_.Mark(); }

 private:
  std::string file_;
  std::string what_;
  YAML::Node node_;
  std::vector<std::string> known_;
};

/// A turn by `angle` with curvature 0 at both ends: clothoid, arc, clothoid.
void add_corner(Map& map, std::vector<PlanSegment>& plan) {
  const double radius = map.number("radius_m", 1.0, 1e6);
  const double angle_deg = map.number("angle_deg", -720.0, 720.0);
  const double in = map.number("clothoid_in_m", 0.1, 1e5, map.number("clothoid_m", 0.1, 1e5, 30.0));
  const double out =
      map.number("clothoid_out_m", 0.1, 1e5, map.number("clothoid_m", 0.1, 1e5, 30.0));
  const double arc = radius * std::abs(angle_deg) * kDegree - 0.5 * (in + out);
  if (!(arc > 0.0)) {
    fail(map.file(), map.mark(),
         fmt::format(
             "a corner of {} deg with radius {} m is {:.2f} m of arc, the clothoids take {:.2f} m "
             "of it; shorten them",
             angle_deg, radius, radius * std::abs(angle_deg) * kDegree, 0.5 * (in + out)));
  }
  const double curvature = std::copysign(1.0 / radius, angle_deg);
  plan.push_back({in, 0.0, curvature, false});
  plan.push_back({arc, curvature, curvature, false});
  plan.push_back({out, curvature, 0.0, false});
}

std::vector<PlanSegment> read_plan(Map& top) {
  std::vector<PlanSegment> plan;
  const YAML::Node list = top.child("plan");
  if (!list)
    fail(top.file(), top.mark(),
         "there is no plan; give a list of straight, corner, arc, clothoid");
  for (const YAML::Node& item : top.list("plan", list)) {
    if (!item.IsMap() || item.size() != 1) {
      fail(top.file(), item.Mark(), "a plan entry is one of: straight, corner, arc, clothoid");
    }
    const std::string kind = item.begin()->first.Scalar();
    Map map(top.file(), kind, item.begin()->second);
    if (kind == "straight") {
      const YAML::Node length = map.child("length_m");
      const bool solve = length && length.IsScalar() && length.Scalar() == "solve";
      plan.push_back({solve ? 0.0 : map.number("length_m", 0.01, 1e6), 0.0, 0.0, solve});
    } else if (kind == "corner") {
      add_corner(map, plan);
    } else if (kind == "arc") {
      const double radius = map.number("radius_m", 1.0, 1e6);
      const double angle = map.number("angle_deg", -720.0, 720.0) * kDegree;
      const double curvature = std::copysign(1.0 / radius, angle);
      plan.push_back({std::abs(angle) * radius, curvature, curvature, false});
    } else if (kind == "clothoid") {
      const double length = map.number("length_m", 0.1, 1e5);
      const double begin = map.number("curvature_begin_1pm", -1.0, 1.0);
      plan.push_back({length, begin, map.number("curvature_end_1pm", -1.0, 1.0), false});
    } else {
      fail(
          top.file(), item.Mark(),
          fmt::format("'{}' is no plan entry; give one of: straight, corner, arc, clothoid", kind));
    }
    map.finish();
  }
  return plan;
}

/// Shapes by name. Heights are shares of the kerb's height; every corner is a vertex of the mesh.
KerbProfile read_profile(Map& map) {
  const YAML::Node node = map.child("profile");
  if (node && node.IsSequence()) {
    KerbProfile profile{"points", {}, {}};
    for (const YAML::Node& pair : node) {
      if (!pair.IsSequence() || pair.size() != 2) {
        fail(map.file(), pair.Mark(), "profile needs pairs [share of width, share of height]");
      }
      profile.t.push_back(map.checked("share of width", pair[0], 0.0, 1.0));
      profile.height.push_back(map.checked("share of height", pair[1], -1.0, 1.0));
    }
    return profile;
  }
  const std::string name = map.word("profile", {"ramp", "flat", "sausage"}, "ramp");
  if (name == "ramp") return {name, {0.0, 0.9, 1.0}, {0.0, 1.0, 0.0}};
  if (name == "flat") return {name, {0.0, 0.12, 0.88, 1.0}, {0.0, 1.0, 1.0, 0.0}};
  KerbProfile profile{name, {}, {}};
  constexpr int kPieces = 10;  // sin^2 as a polyline, the way such kerbs are modelled
  for (int i = 0; i <= kPieces; ++i) {
    const double t = static_cast<double>(i) / kPieces;
    const double s = std::sin(std::numbers::pi * t);
    profile.t.push_back(t);
    profile.height.push_back(i == 0 || i == kPieces ? 0.0 : s * s);
  }
  return profile;
}

void read_features(Map& top, CircuitDesign& design) {
  for (Map& map : top.maps("kerbs")) {
    KerbDesign kerb;
    std::tie(kerb.u_begin_m, kerb.u_end_m) = map.range();
    kerb.side = map.side();
    kerb.width_m = map.number("width_m", 0.1, 10.0);
    kerb.height_m = map.number("height_m", -1.0, 1.0);
    kerb.taper_m = map.number("taper_m", 0.0, 100.0, kerb.taper_m);
    kerb.profile = read_profile(map);
    map.finish();
    design.kerbs.push_back(std::move(kerb));
  }
  for (Map& map : top.maps("bumps")) {
    BumpDesign bump;
    bump.shape = map.word("shape", {"cosine", "plateau"}, "cosine") == "cosine"
                     ? BumpDesign::Shape::cosine
                     : BumpDesign::Shape::plateau;
    bump.u_m = map.number("u_m", 0.0, 1e6);
    bump.v_m = map.number("v_m", -100.0, 100.0, 0.0);
    bump.length_m = map.number("length_m", 0.1, 1000.0);
    bump.width_m = map.number("width_m", 0.0, 100.0, 0.0);
    bump.height_m = map.number("height_m", -1.0, 1.0);
    map.finish();
    design.bumps.push_back(bump);
  }
  for (Map& map : top.maps("barriers")) {
    BarrierDesign barrier;
    std::tie(barrier.u_begin_m, barrier.u_end_m) = map.range();
    barrier.side = map.side();
    barrier.height_m = map.number("height_m", 0.1, 10.0, barrier.height_m);
    map.finish();
    design.barriers.push_back(barrier);
  }
  for (Map& map : top.maps("trees")) {
    TreeRow trees;
    std::tie(trees.u_begin_m, trees.u_end_m) = map.range();
    trees.side = map.side();
    trees.spacing_m = map.number("spacing_m", 1.0, 1e4, trees.spacing_m);
    trees.from_road_edge_m = map.number("from_road_edge_m", 0.5, 200.0, trees.from_road_edge_m);
    trees.height_m = map.number("height_m", 1.0, 60.0, trees.height_m);
    trees.crown_width_m = map.number("crown_width_m", 0.5, 60.0, trees.crown_width_m);
    map.finish();
    design.trees.push_back(trees);
  }
  for (Map& map : top.maps("grandstands")) {
    Grandstand stand;
    std::tie(stand.u_begin_m, stand.u_end_m) = map.range();
    stand.side = map.side();
    stand.from_road_edge_m = map.number("from_road_edge_m", 1.0, 200.0, stand.from_road_edge_m);
    stand.depth_m = map.number("depth_m", 1.0, 100.0, stand.depth_m);
    stand.height_m = map.number("height_m", 1.0, 60.0, stand.height_m);
    stand.roof_overhang_m = map.number("roof_overhang_m", 0.0, 60.0, stand.roof_overhang_m);
    map.finish();
    design.grandstands.push_back(stand);
  }
  for (Map& map : top.maps("gantries")) {
    Gantry gantry;
    gantry.u_m = map.number("u_m", 0.0, 1e6);
    gantry.clearance_m = map.number("clearance_m", 3.0, 40.0, gantry.clearance_m);
    gantry.length_m = map.number("length_m", 0.1, 30.0, gantry.length_m);
    gantry.height_m = map.number("height_m", 0.1, 10.0, gantry.height_m);
    map.finish();
    design.gantries.push_back(gantry);
  }
  for (Map& map : top.maps("bridges")) {
    BridgeDesign bridge;
    std::tie(bridge.u_begin_m, bridge.u_end_m) = map.range();
    bridge.thickness_m = map.number("thickness_m", 0.2, 4.0, bridge.thickness_m);
    bridge.underside_named_as_road = map.flag("underside_named_as_road", false);
    map.finish();
    design.bridges.push_back(bridge);
  }
  for (Map& map : top.maps("start_strips")) {
    StartStrip strip;
    std::tie(strip.u_begin_m, strip.u_end_m) = map.range();
    map.finish();
    design.start_strips.push_back(strip);
  }
}

CircuitDesign read_design(const std::string& path, const YAML::Node& root) {
  Map top(path, "the circuit", root);
  CircuitDesign design;
  const YAML::Node name = top.child("name");
  if (!name || !name.IsScalar() || name.Scalar().empty() ||
      name.Scalar().find_first_of("/\\ \t") != std::string::npos) {
    fail(path, name ? name.Mark() : root.Mark(),
         "name is missing or no plain word; it becomes a file name");
  }
  design.name = name.Scalar();
  design.seed = static_cast<std::uint64_t>(top.number("seed", 0.0, 9e15, 1.0));
  design.closed = top.flag("closed", true);
  if (top.has("start")) {
    Map start(path, "start", top.child("start"));
    design.start_x_m = start.number("x_m", -1e7, 1e7, 0.0);
    design.start_y_m = start.number("y_m", -1e7, 1e7, 0.0);
    design.start_heading_rad = start.number("heading_deg", -360.0, 360.0, 0.0) * kDegree;
    start.finish();
  } else {
    top.child("start");
  }
  design.plan = read_plan(top);

  design.width_left_m = top.knots("width_left_m", 1.0, 30.0, 5.0);
  design.width_right_m = top.knots("width_right_m", 1.0, 30.0, 5.0);
  design.elevation_m = top.knots("elevation_m", -9000.0, 9000.0, 0.0);
  design.banking = top.knots("banking_deg", -45.0, 45.0, 0.0);
  for (double& value : design.banking.value) value = std::tan(value * kDegree);
  design.runoff_left_m = top.knots("runoff_left_m", 0.0, 100.0, 4.0);
  design.runoff_right_m = top.knots("runoff_right_m", 0.0, 100.0, 4.0);
  design.runoff_slope_left = top.knots("runoff_slope_left", -0.5, 0.5, 0.0);
  design.runoff_slope_right = top.knots("runoff_slope_right", -0.5, 0.5, 0.0);

  if (const YAML::Node node = top.child("roughness")) {
    Map map(path, "roughness", node);
    RoughnessOptions roughness;
    roughness.iso_class = map.word("iso_class", {"A", "B", "C", "D", "E", "F", "G", "H"}, "A")[0];
    roughness.seed = static_cast<std::uint64_t>(map.number("seed", 0.0, 9e15, 1.0));
    roughness.n_min_cpm = map.number("n_min_cpm", 1e-4, 10.0, roughness.n_min_cpm);
    roughness.n_max_cpm = map.number("n_max_cpm", 1e-4, 10.0, roughness.n_max_cpm);
    map.finish();
    design.roughness = roughness;
  }
  if (const YAML::Node node = top.child("terrain")) {
    Map map(path, "terrain", node);
    design.terrain.present = map.flag("present", true);
    design.terrain.cell_m = map.number("cell_m", 2.0, 100.0, design.terrain.cell_m);
    design.terrain.margin_m = map.number("margin_m", 0.0, 1000.0, design.terrain.margin_m);
    design.terrain.hill_m = map.number("hill_m", 0.0, 500.0, design.terrain.hill_m);
    map.finish();
  }
  read_features(top, design);
  top.finish();
  return design;
}

}  // namespace

Circuit read_circuit(const std::string& path) {
  constexpr std::size_t kLargestFileBytes = 1u << 20;
  const std::string text = base::read_file(path, kLargestFileBytes);
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    fail(path, error.mark, "no valid YAML: " + error.msg);
  }
  try {
    return Circuit(read_design(path, root));
  } catch (const YAML::Exception& error) {
    fail(path, error.mark, "no valid circuit: " + error.msg);
  } catch (const Error& error) {
    const std::string said = error.what();
    if (said.rfind(path, 0) == 0) throw;
    throw Error(path + ": " + said);
  }
}

}  // namespace road
