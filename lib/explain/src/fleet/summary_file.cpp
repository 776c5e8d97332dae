// The bytes of a summary (docs/formats.md).
#include <fmt/format.h>

#include <cmath>

#include "base/archive.h"
#include "explain/summary.h"
#include "vehicle/error.h"

namespace explain {

template <class Archive, class Sums>
requires std::is_same_v<std::remove_const_t<Sums>, Information>
void fields(Archive& archive, Sums& s) {
  archive(s.rows, s.square, s.right, s.knot, s.next, s.across, s.among);
}

template <class Archive, class Column>
requires std::is_same_v<std::remove_const_t<Column>, SummaryColumn>
void fields(Archive& archive, Column& c) {
  archive(c.key, c.id, c.channel, c.name, c.unit);
  archive(c.of_car, c.candidate, c.parameter, c.one_sided);
  archive(c.stated, c.deviation, c.width, c.form, c.least, c.most);
}

template <class Archive, class Summary>
requires std::is_same_v<std::remove_const_t<Summary>, DriveSummary>
void fields(Archive& archive, Summary& s) {
  archive(s.program, s.road_sha256, s.car_sha256, s.recording_sha256, s.settings_sha256, s.car,
          s.recording);
  archive(s.length_m, s.closed, s.knots, s.laps, s.driven_s, s.columns, s.by_sensors, s.by_forces);
}

namespace {

constexpr base::ArchiveKind kSummary{"kerbstone drive summary", 2};
constexpr std::size_t kLongestText = 2000;

/// Refuses what no summary can say.
struct Judge {
  const std::string& path;

  [[noreturn]] void refuse(const std::string& why) const {
    throw vehicle::Error(fmt::format("{}: {}; make it anew with crgexplain summary", path, why));
  }
  void count(std::size_t seen, const char* what, std::size_t least, std::size_t most) const {
    if (seen < least || seen > most)
      refuse(fmt::format("{} {} seen, {} to {} wanted", seen, what, least, most));
  }
  void number(double seen, const char* what, double least, double most) const {
    if (!(seen >= least && seen <= most))
      refuse(fmt::format("{} of {:.4g} seen, {:.4g} to {:.4g} wanted", what, seen, least, most));
  }
  void text(const std::string& seen) const {
    count(seen.size(), "letters of a name", 0, kLongestText);
    for (const char c : seen)
      if (static_cast<unsigned char>(c) < 32 || c == 127) refuse("a name has control characters");
  }
  void sums(const Information& s, std::size_t road, std::size_t q) const {
    number(s.rows, "rows", 0, 1e12);
    number(s.square, "a sum of squares", 0, 1e100);
    const std::pair<const std::vector<double>*, std::size_t> lists[] = {
        {&s.right, road + q},
        {&s.knot, road * kRoadKinds},
        {&s.next, road * kRoadKinds},
        {&s.across, road * q},
        {&s.among, q * (q + 1) / 2}};
    for (const auto& [list, size] : lists) {
      count(list->size(), "sums", size, size);
      for (const double value : *list)
        if (!(std::abs(value) < 1e100)) refuse("a sum is no finite number");
    }
    std::size_t at = 0;
    for (std::size_t k = 0; k < q; ++k) {
      at += k;
      if (s.among[at++] < 0) refuse("a sum of squares is negative");
    }
  }
  void column(const SummaryColumn& c) const {
    for (const std::string* t : {&c.key, &c.id, &c.channel, &c.name, &c.unit}) text(*t);
    if (c.candidate && !c.of_car) refuse("a sensor's error that is a candidate");
    number(c.stated, "a stated value", -1e100, 1e100);
    number(c.deviation, "a prior's deviation", 1e-100, 1e100);
    number(c.width, "a prior's width", 0, 1e100);
    number(c.form, "a share of an interval", 0, 1e100);
    number(c.least, "the least that counts", 0, 1e100);
    number(c.most, "the most that counts", 0, 1e301);
  }
  void summary(const DriveSummary& s) const {
    constexpr double kMostLength_m = 1e6;
    for (const std::string* t : {&s.program, &s.road_sha256, &s.car_sha256, &s.recording_sha256,
                                 &s.settings_sha256, &s.car, &s.recording})
      text(*t);
    number(s.length_m, "a length of the road", 1.0, kMostLength_m);
    count(s.knots, "knots", kLeastKnots, kMostKnots);
    count(s.laps, "laps", 0, 1000000);
    number(s.driven_s, "a time", 0, 1e9);
    count(s.columns.size(), "columns", 0, kMostSummaryColumns);
    for (const SummaryColumn& c : s.columns) column(c);
    sums(s.by_sensors, s.road_columns(), s.columns.size());
    sums(s.by_forces, s.road_columns(), s.columns.size());
  }
};

}  // namespace

std::string to_bytes(const DriveSummary& summary) {
  base::ArchiveWriter out(kSummary);
  out(summary);
  return out.finish();
}

DriveSummary summary_from_bytes(std::string_view bytes, const std::string& path) {
  if (!bytes.starts_with(kSummary.name))
    throw vehicle::Error(path + ": no summary of a drive; wanted is what crgexplain summary wrote");
  const Judge judge{path};
  base::ArchiveReader in(bytes, kSummary);
  DriveSummary s;
  in(s);
  if (!in.finish()) judge.refuse(in.problem());
  judge.summary(s);
  return s;
}

}  // namespace explain
