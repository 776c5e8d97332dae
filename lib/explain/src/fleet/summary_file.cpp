// The bytes of a summary (docs/formats.md): little-endian, counts before what they count.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "explain/summary.h"
#include "vehicle/error.h"

namespace explain {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic = "kerbstone drive summary\n";
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kLongestText = 2000;
constexpr double kMostLength_m = 1e6;

class Writer {
 public:
  void number(std::uint32_t value) { bytes_.append(reinterpret_cast<const char*>(&value), 4); }
  void number(double value) { bytes_.append(reinterpret_cast<const char*>(&value), 8); }
  void text(const std::string& value) {
    const std::string cut = value.substr(0, kLongestText);
    number(static_cast<std::uint32_t>(cut.size()));
    bytes_ += cut;
  }
  void numbers(const std::vector<double>& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), 8 * values.size());
  }
  std::string bytes_{kMagic};
};

void write(Writer& out, const Information& sums) {
  out.number(sums.rows);
  out.number(sums.square);
  for (const auto* part : {&sums.right, &sums.knot, &sums.next, &sums.across, &sums.among})
    out.numbers(*part);
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& path) : left_(bytes), path_(path) {}

  [[noreturn]] void refuse(const std::string& why) const {
    throw vehicle::Error(fmt::format("{}: {}; make it anew with crgexplain summary", path_, why));
  }
  std::string_view take(std::size_t count) {
    if (count > left_.size())
      refuse(fmt::format("the summary is cut short: {} bytes are there where {} are wanted",
                         left_.size(), count));
    const std::string_view out = left_.substr(0, count);
    left_.remove_prefix(count);
    return out;
  }
  std::uint32_t count(const char* what, std::uint32_t least, std::uint32_t most) {
    std::uint32_t out = 0;
    std::memcpy(&out, take(4).data(), 4);
    if (out < least || out > most)
      refuse(fmt::format("{} {} seen, {} to {} wanted", out, what, least, most));
    return out;
  }
  double number(const char* what, double least, double most) {
    double out = 0.0;
    std::memcpy(&out, take(8).data(), 8);
    if (!(out >= least && out <= most))
      refuse(fmt::format("{} of {:.4g} seen, {:.4g} to {:.4g} wanted", what, out, least, most));
    return out;
  }
  bool flag(const char* what) { return count(what, 0, 1) == 1; }
  std::string text() {
    const std::string_view out = take(count("letters of a name", 0, kLongestText));
    for (const char c : out)
      if (static_cast<unsigned char>(c) < 32 || c == 127) refuse("a name has control characters");
    return std::string(out);
  }
  std::vector<double> numbers(std::size_t count) {
    const std::string_view raw = take(8 * count);  // before memory is taken
    std::vector<double> out(count);
    if (count > 0) std::memcpy(out.data(), raw.data(), raw.size());
    for (const double value : out)
      if (!(std::abs(value) < 1e100)) refuse("a sum is no finite number");
    return out;
  }
  std::string_view left() const { return left_; }

 private:
  std::string_view left_;
  const std::string& path_;
};

Information read(Reader& in, const DriveSummary& of) {
  const std::size_t road = of.road_columns(), q = of.columns.size();
  Information out;
  out.rows = in.number("rows", 0, 1e12);
  out.square = in.number("a sum of squares", 0, 1e100);
  out.right = in.numbers(road + q);
  out.knot = in.numbers(road * kRoadKinds);
  out.next = in.numbers(road * kRoadKinds);
  out.across = in.numbers(road * q);
  out.among = in.numbers(q * (q + 1) / 2);
  std::size_t at = 0;
  for (std::size_t k = 0; k < q; ++k) {
    at += k;
    if (out.among[at++] < 0) in.refuse("a sum of squares is negative");
  }
  return out;
}

SummaryColumn read_column(Reader& in) {
  SummaryColumn out;
  for (std::string* text : {&out.key, &out.id, &out.channel, &out.name, &out.unit})
    *text = in.text();
  for (bool* flag : {&out.of_car, &out.candidate, &out.parameter, &out.one_sided})
    *flag = in.flag("as a flag");
  if (out.candidate && !out.of_car) in.refuse("a sensor's error that is a candidate");
  out.stated = in.number("a stated value", -1e100, 1e100);
  out.deviation = in.number("a prior's deviation", 1e-100, 1e100);
  out.width = in.number("a prior's width", 0, 1e100);
  out.form = in.number("a share of an interval", 0, 1e100);
  out.least = in.number("the least that counts", 0, 1e100);
  out.most = in.number("the most that counts", 0, 1e301);
  return out;
}

}  // namespace

std::uint64_t check_of(std::string_view bytes) {
  // Every bit moves all those above it, and the fold brings them down again.
  std::uint64_t out = 0x9E3779B97F4A7C15ull ^ bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    out = (out ^ word) * 0xBF58476D1CE4E5B9ull;
    out ^= out >> 29;
  }
  return out;
}

std::string to_bytes(const DriveSummary& s) {
  Writer out;
  out.number(kVersion);
  for (const std::string* text : {&s.program, &s.road_sha256, &s.car_sha256, &s.recording_sha256,
                                  &s.settings_sha256, &s.car, &s.recording})
    out.text(*text);
  out.number(s.length_m);
  out.number(std::uint32_t{s.closed});
  out.number(s.knots);
  out.number(s.laps);
  out.number(s.driven_s);
  out.number(static_cast<std::uint32_t>(s.columns.size()));
  for (const SummaryColumn& c : s.columns) {
    for (const std::string* text : {&c.key, &c.id, &c.channel, &c.name, &c.unit}) out.text(*text);
    for (const bool flag : {c.of_car, c.candidate, c.parameter, c.one_sided})
      out.number(std::uint32_t{flag});
    for (const double value : {c.stated, c.deviation, c.width, c.form, c.least, c.most})
      out.number(value);
  }
  write(out, s.by_sensors);
  write(out, s.by_forces);
  const std::uint64_t check = check_of(out.bytes_);
  out.bytes_.append(reinterpret_cast<const char*>(&check), 8);
  return std::move(out.bytes_);
}

DriveSummary summary_from_bytes(std::string_view bytes, const std::string& path) {
  Reader in(bytes, path);
  if (!bytes.starts_with(kMagic))
    throw vehicle::Error(path + ": no summary of a drive; wanted is what crgexplain summary wrote");
  in.take(kMagic.size());
  if (const std::uint32_t version = in.count("as the version", 0, 0xFFFFFFFFu); version != kVersion)
    in.refuse(fmt::format("a summary of version {} seen, {} wanted", version, kVersion));
  if (in.left().size() < 8) in.refuse("the summary is cut short");
  std::uint64_t check = 0;
  std::memcpy(&check, bytes.data() + bytes.size() - 8, 8);
  if (check != check_of(bytes.substr(0, bytes.size() - 8)))
    in.refuse("the summary is damaged or cut short: its check does not fit its bytes");
  DriveSummary s;
  for (std::string* text : {&s.program, &s.road_sha256, &s.car_sha256, &s.recording_sha256,
                            &s.settings_sha256, &s.car, &s.recording})
    *text = in.text();
  s.length_m = in.number("a length of the road", 1.0, kMostLength_m);
  s.closed = in.flag("as whether the road is closed");
  s.knots = in.count("knots", kLeastKnots, kMostKnots);
  s.laps = in.count("laps", 0, 1000000);
  s.driven_s = in.number("a time", 0, 1e9);
  const std::uint32_t columns = in.count("columns", 0, kMostSummaryColumns);
  for (std::uint32_t k = 0; k < columns; ++k) s.columns.push_back(read_column(in));
  s.by_sensors = read(in, s);
  s.by_forces = read(in, s);
  if (in.left().size() != 8) in.refuse("bytes follow the end of the summary");
  return s;
}

}  // namespace explain
