#include "cloud/map_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/archive.h"
#include "cloud/error.h"
#include "map_steps.h"
#include "visits.h"

namespace cloud {

// Fields of what goes from process to process, in the order of the bytes.

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, DriftStation>
void fields(Archive& archive, Value& s) {
  archive(s.piece, s.pass, s.driven_m, s.u_m, s.correction, s.stddev, s.base_believed);
}

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, ChangedPlace>
void fields(Archive& archive, Value& c) {
  archive(c.pass, c.u_begin_m, c.u_end_m, c.v_begin_m, c.v_end_m, c.area_m2, c.change_m);
}

/// What is known before the heights.
template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, MapReport>
void fields(Archive& archive, Value& r) {
  archive(r.looked_at, r.without_pose, r.off_road, r.far_from_base, r.on_obstacles, r.on_grass);
  archive(r.converged, r.iterations, r.last_move_m, r.sections, r.passes, r.rms_before_m,
          r.rms_after_m, r.pass_rms_before_m, r.pass_rms_after_m, r.inlier_share, r.base_stddev_m,
          r.base_tilt, r.base_tilt_stddev, r.base_crown, r.view_stddev_factor, r.base_together,
          r.view_together, r.typical_stddev, r.unfixed, r.drift, r.changed, r.remarks, r.faults);
}

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, StretchDeviation>
void fields(Archive& archive, Value& s) {
  archive(s.v_m, s.var_height, s.cov_height_slope, s.var_slope, s.var_along, s.var_across, s.seen);
}

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, PassApart>
void fields(Archive& archive, Value& p) { archive(p.pass, p.deviation); }

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, Sheet>
void fields(Archive& archive, Value& s) { archive(s.v_m, s.deviation_m); }

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, HeightCells>
void fields(Archive& archive, Value& c) {
  archive(c.along, c.across, c.cell_rows, c.v_begin_m, c.cell_m, c.closed, c.height_m,
          c.cut_above_m, c.sheet, c.first_pass, c.agrees_m);
}

/// All but sections and corrections, which no later step wants, and what the trajectory says.
template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, MapState>
void fields(Archive& archive, Value& s) {
  archive(s.step, s.due, s.poses.poses.position_m, s.poses.poses.orientation, s.taken_out,
          s.base_tilt, s.sections.excess_m2, s.drift.stretch, s.drift.apart, s.surface, s.report);
}

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, SectionCell>
void fields(Archive& archive, Value& c) {
  archive(c.x_m, c.y_m, c.z_m, c.points, c.driven_m, c.driven2_m2, c.square_m2, c.freedom, c.sine2,
          c.cut_above_m, c.cut_points, c.sheet, c.doubtful, c.beyond, c.beside);
}

template <typename Archive, typename Value>
requires std::is_same_v<std::remove_const_t<Value>, NodeSum>
void fields(Archive& archive, Value& s) { archive(s.points, s.height, s.height2, s.range); }

namespace {

constexpr base::ArchiveKind kReading{"kerbstone map, what was read", 4},
    kState{"kerbstone map, its state", 3};

/// After the last value. Throws Error.
void require_whole(base::ArchiveReader& taker) {
  if (!taker.finish()) throw Error(taker.problem());
}

[[noreturn]] void refuse_other_road() {
  throw Error("what was read is of another road or trajectory");
}

template <typename Archive, typename Value>
void counts(Archive& archive, Value& s) {
  archive(s.points, s.without_pose, s.off_road, s.far_from_base, s.on_obstacles, s.time_begin_s,
          s.time_end_s, s.min_m, s.max_m);
}

void keep(base::ArchiveWriter& keeper, const Look& look) {
  const Sections& sections = look.sections;
  counts(keeper, sections);
  std::vector<std::size_t> seen;
  for (std::size_t s = 0; s < sections.list.size(); ++s)
    if (sections.list[s].has_data()) seen.push_back(s);
  keeper(seen);
  for (const std::size_t s : seen) keeper(sections.list[s].cells, look.standing.kept[s]);
  std::vector<std::uint32_t> cells;  // number, standing, clear
  for (std::size_t k = 0; k < look.standing.seen.size(); ++k)
    if (const Standing::Seen& here = look.standing.seen[k]; here.standing + here.clear > 0)
      cells.insert(cells.end(), {static_cast<std::uint32_t>(k), here.standing, here.clear});
  keeper(cells);
}

void take(base::ArchiveReader& taker, Look& look) {
  Sections& sections = look.sections;
  counts(taker, sections);
  std::vector<std::size_t> seen;
  taker(seen);
  for (const std::size_t s : seen) {
    if (s >= sections.list.size()) refuse_other_road();
    taker(sections.list[s].cells, look.standing.kept[s]);
    if (sections.list[s].cells.size() != look.standing.kept[s].size()) refuse_other_road();
    for (const std::uint32_t road_cell : look.standing.kept[s])
      if (road_cell >= look.standing.seen.size()) refuse_other_road();
  }
  std::vector<std::uint32_t> cells;
  taker(cells);
  for (std::size_t k = 0; k + 2 < cells.size(); k += 3) {
    if (cells[k] >= look.standing.seen.size()) refuse_other_road();
    look.standing.seen[cells[k]] = {cells[k + 1], cells[k + 2]};
  }
}

void keep(base::ArchiveWriter& keeper, const NodeSums& sums) {
  keeper(sums.size());
  for (std::size_t s = 0; s < sums.stripes(); ++s) keeper(sums.stripe(s));
}

void take(base::ArchiveReader& taker, NodeSums& sums) {
  std::size_t size = 0;
  taker(size);
  if (size != sums.size()) refuse_other_road();
  std::vector<NodeSum> stripe;
  for (std::size_t s = 0; s < sums.stripes(); ++s) {
    taker(stripe);
    if (stripe.empty()) continue;
    std::vector<NodeSum>& to = sums.filled_stripe(s);
    if (to.size() != stripe.size()) refuse_other_road();
    to = stripe;
  }
}

void keep(base::ArchiveWriter& keeper, const RoadSums& sums) {
  keeper(sums.read, sums.used);
  keep(keeper, sums.all), keep(keeper, sums.left_out);
}

void take(base::ArchiveReader& taker, RoadSums& sums) {
  taker(sums.read, sums.used);
  take(taker, sums.all), take(taker, sums.left_out);
}

}  // namespace

struct TileCut::Places {
  RoadTrajectory trajectory;
  Sections sections;
  std::vector<std::size_t> tile_of_section;
  std::optional<Visits> visits;
  std::size_t pose = 0;
};

TileCut::TileCut(const crg::Crg& base, const Trajectory& trajectory, std::size_t tiles)
    : places_(std::make_unique<Places>()) {
  const RoadFrame frame(base);
  places_->trajectory = place_on_road(trajectory, frame);
  places_->sections = empty_sections(frame, &places_->trajectory);
  const std::vector<Section>& list = places_->sections.list;
  if (tiles < 1 || tiles > list.size())
    throw Error(
        fmt::format("{} tiles wanted of a drive of {} pieces of {:g} m; 1 to {} can be made", tiles,
                    list.size(), kSectionLength_m, list.size()));
  std::vector<std::size_t> order(list.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return list[a].row < list[b].row; });
  places_->tile_of_section.resize(list.size());
  places_->visits.emplace(list.size());
  stretches_.resize(tiles);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t tile = k * tiles / order.size();
    const double u_m = frame.u_begin_m() + list[order[k]].row * frame.u_step_m();
    Stretch& stretch = stretches_[tile];
    if (stretch.driven_m == 0.0) stretch.u_begin_m = u_m;
    stretch.u_end_m = u_m, stretch.driven_m += kSectionLength_m;
    places_->tile_of_section[order[k]] = tile;
  }
}

TileCut::~TileCut() = default;

TileCut::Where TileCut::next(double time_s, bool looked_at) {
  const Trajectory& poses = places_->trajectory.poses;
  PosedInstant pose;
  if (!pose_at(poses, time_s, places_->pose, pose)) return {};
  const std::size_t section = places_->sections.index_at(poses.piece[places_->pose], pose.driven_m);
  return {places_->tile_of_section[section],
          looked_at ? (*places_->visits)(section).number : std::uint8_t{0}};
}

struct TiledMap::Parts {
  RoadFrame frame;
  const Trajectory& trajectory;
  MapOptions options;
  RoadTrajectory placed;
  MapInputs inputs;
  MapState state;

  Parts(const crg::Crg& base, const Trajectory& given, const MapOptions& wanted)
      : frame(base),
        trajectory(given),
        options(wanted),
        placed(place_on_road(given, frame)),
        inputs{frame, base.grid, &placed, options, false},
        state(first_state(inputs)) {}

  Look nothing_seen() const {
    Sections sections = empty_sections(frame, &state.poses);
    Standing standing(frame, sections.list.size());
    return {std::move(sections), std::move(standing)};
  }

  Reading reading_of(std::string_view bytes) const {
    base::ArchiveReader taker(bytes, kReading);
    MapStep step{};
    bool due = false;
    taker(step, due);
    if (!taker.good()) throw Error(taker.problem());
    if (step != state.step || due != state.due) throw Error("what was read is of another step");
    Reading reading;
    if (due && step == MapStep::heights)
      take(taker, reading.sums.emplace(frame, state.drift));
    else if (due)
      take(taker, reading.look.emplace(nothing_seen()));
    require_whole(taker);
    return reading;
  }
};

TiledMap::TiledMap(const crg::Crg& base, const Trajectory& trajectory, const MapOptions& options,
                   std::string_view state)
    : parts_(std::make_unique<Parts>(base, trajectory, options)) {
  if (state.empty()) return;
  MapState& now = parts_->state;
  base::ArchiveReader taker(state, kState);
  taker(now);
  require_whole(taker);
  if (now.poses.poses.position_m.size() != trajectory.size() ||
      now.poses.poses.orientation.size() != trajectory.size())
    refuse_other_road();
}

TiledMap::~TiledMap() = default;

int TiledMap::step() const { return static_cast<int>(parts_->state.step) + 1; }
bool TiledMap::due() const { return parts_->state.due; }

std::string TiledMap::read(const CloudSource& looked_at, const CloudSource& all) const {
  const MapState& state = parts_->state;
  MapOptions options = parts_->options;
  options.estimate_every = 1;
  const MapInputs inputs{parts_->frame, parts_->inputs.base, &parts_->placed, options, true};
  MapReport times;
  const Reading reading =
      read_for(state, state.step == MapStep::heights ? all : looked_at, inputs, times);
  base::ArchiveWriter keeper(kReading);
  keeper(state.step, state.due);
  if (reading.look) keep(keeper, *reading.look);
  if (reading.sums) keep(keeper, *reading.sums);
  return keeper.finish();
}

MapResult TiledMap::join(std::size_t tiles, const std::function<std::string(std::size_t)>& reading,
                         const CloudSource& scans) {
  return with_causes(scans, parts_->frame, &parts_->trajectory, parts_->options, [&] {
    Reading all;
    for (std::size_t tile = 0; tile < tiles; ++tile)
      cloud::join(all, parts_->reading_of(reading(tile)));
    MapResult result;
    advance(parts_->state, std::move(all), parts_->inputs, result);
    return result;
  });
}

std::string TiledMap::state() const {
  base::ArchiveWriter keeper(kState);
  keeper(parts_->state);
  return keeper.finish();
}

}  // namespace cloud
