#include "fmu/saved_state.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/error.h"

namespace fmu {
namespace {

constexpr std::string_view kMagic = "kerbstone car ";
constexpr std::uint64_t kVersion = 3;
constexpr std::size_t kChecksumBytes = 8;

/// FNV-1a (Fowler, Noll, Vo) of 64 bits: a change of one byte always shows.
std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t sum = 0xcbf29ce484222325;
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return sum;
}

/// Appends little-endian words.
class Writer {
 public:
  std::string bytes;

  void word(std::uint64_t value) {
    for (int i = 0; i < 8; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
  }
  void number(const double& value) { word(std::bit_cast<std::uint64_t>(value)); }
  void whole(const std::int64_t& value) { word(static_cast<std::uint64_t>(value)); }
  void text(const std::string& value) {
    word(value.size());
    bytes += value;
  }
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  std::uint64_t word() {
    const std::string_view raw = take(8);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i)
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(raw[i])) << (8 * i);
    return value;
  }
  void number(double& value) { value = std::bit_cast<double>(word()); }
  void whole(std::int64_t& value) { value = static_cast<std::int64_t>(word()); }
  void text(std::string& value) {
    constexpr std::uint64_t kLongest = 65536;
    const std::uint64_t size = word();
    if (size > kLongest) refuse("a text longer than 64 kB");
    value = take(static_cast<std::size_t>(size));
  }
  std::string_view take(std::size_t size) {
    if (size > rest_.size()) refuse("it ends too early");
    const std::string_view out = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return out;
  }
  bool at_end() const { return rest_.empty(); }
  [[noreturn]] static void refuse(std::string_view why) {
    throw base::Error(fmt::format("this is no state of this unit: {}", why));
  }

 private:
  std::string_view rest_;
};

/// An int as a word, whichever way.
template <class Archive, class Int>
void small(Archive& archive, Int& value) {
  std::int64_t whole = value;
  archive.whole(whole);
  if constexpr (!std::is_const_v<Int>) {
    if (!std::in_range<Int>(whole)) Reader::refuse("a whole number that none can be");
    value = static_cast<Int>(whole);
  }
}

template <class Archive, class Actuator>
void each_field_of_actuator(Archive& archive, Actuator& actuator) {
  for (auto& value : actuator.history) archive.number(value);
  archive.number(actuator.place);
  archive.number(actuator.rate);
}

template <class Archive, class Stick>
void each_field_of_stick(Archive& archive, Stick& stick) {
  archive.number(stick.output);
  archive.number(stick.drive);
  small(archive, stick.moving);
}

/// The one order of the fields, for writing and for reading.
template <class Archive, class Simulation>
void each_field_of_simulation(Archive& archive, Simulation& sim) {
  for (auto& value : sim.state.value) archive.number(value);
  auto& d = sim.discrete;
  each_field_of_actuator(archive, d.steer);
  each_field_of_actuator(archive, d.throttle);
  for (auto& brake : d.brake) each_field_of_actuator(archive, brake);
  archive.number(d.stuck_steer_rad);
  archive.number(d.last_steer_rad);
  each_field_of_stick(archive, d.steer_stick);
  archive.number(d.played_steer_rad);
  for (auto& stick : d.brake_stick) each_field_of_stick(archive, stick);
  each_field_of_stick(archive, d.throttle_stick);
  small(archive, d.gear);
  small(archive, d.gear_wanted);
  archive.number(d.shift_left_s);
  archive.whole(d.step);
  archive.number(sim.time_s);
}

template <class Archive, class State>
void each_field(Archive& archive, State& state) {
  archive.number(state.begin_s);
  for (auto& text : state.texts) archive.text(text);
  for (auto& value : state.numbers) archive.number(value);
  for (auto& given : state.given) small(archive, given);
  archive.number(state.place.u_m);
  archive.number(state.place.v_m);
  archive.number(state.place.x_m);
  archive.number(state.place.y_m);
  each_field_of_simulation(archive, state.simulation);
}

void require_sane(const SavedState& state, const std::vector<Variable>& list) {
  const auto want = [](bool holds, std::string_view what) {
    if (!holds) Reader::refuse(what);
  };
  constexpr double kLargest = 1e9;  // in any unit
  const auto& d = state.simulation.discrete;
  want(d.gear >= -1 && d.gear <= 6 && d.gear_wanted >= -1 && d.gear_wanted <= 6, "a gear");
  want(d.step >= 0 && d.step < std::int64_t{1} << 52, "a count of steps");
  want(std::isfinite(d.shift_left_s) && std::isfinite(state.begin_s), "a time");
  for (const signed char given : state.given)
    want(given >= kNotGiven && given <= kGivenAsExported, "a mark that is neither");
  for (const double value : state.simulation.state.value)
    want(!state.started || std::abs(value) <= kLargest, "a state that no car has");
  for (const double value : {state.place.v_m, state.place.x_m, state.place.y_m})
    want(std::abs(value) <= kLargest, "a place");
  want(std::isnan(state.place.u_m) || std::abs(state.place.u_m) <= kLargest, "a place");
  for (const Variable& v : list)
    for (std::size_t i = 0; i < v.size && v.source != Source::kText; ++i) {
      const double value = state.numbers[v.reference + i];
      const bool set = v.causality == Causality::kInput || v.causality == Causality::kParameter;
      want(!set || (value >= v.low && value <= v.high), fmt::format("{} = {}", v.name, value));
      want(!set || v.type == Type::kReal || value == std::floor(value), v.name);
    }
}

}  // namespace

std::string to_bytes(const SavedState& state, std::string_view token) {
  Writer out;
  out.bytes = kMagic;
  out.word(kVersion);
  out.text(std::string(token));
  out.word(static_cast<std::uint64_t>(state.phase));
  out.word(state.started ? 1 : 0);
  each_field(out, state);
  out.word(checksum(out.bytes));
  return std::move(out.bytes);
}

SavedState from_bytes(std::string_view bytes, std::string_view token,
                      const std::vector<Variable>& list) {
  Reader in(bytes);
  if (!bytes.starts_with(kMagic)) Reader::refuse("it does not begin as one");
  in.take(kMagic.size());
  if (const std::uint64_t version = in.word(); version != kVersion)
    Reader::refuse(fmt::format("version {}, wanted {}", version, kVersion));
  if (bytes.size() < kChecksumBytes) Reader::refuse("it ends too early");
  const std::string_view told = bytes.substr(0, bytes.size() - kChecksumBytes);
  if (Reader(bytes.substr(told.size())).word() != checksum(told))
    Reader::refuse("its checksum is not that of its bytes; it was changed or cut");
  std::string own;
  in.text(own);
  if (own != token) Reader::refuse("it was saved by another unit");
  SavedState state;
  const std::uint64_t phase = in.word();
  if (phase > static_cast<std::uint64_t>(Phase::kFailed)) Reader::refuse("a phase");
  state.phase = static_cast<Phase>(phase);
  const std::uint64_t started = in.word();
  if (started > 1) Reader::refuse("a mark that is neither");
  state.started = started == 1;
  if (!state.started && state.phase >= Phase::kStepping) Reader::refuse("it steps without a car");
  const std::uint32_t numbers = count_values(list) - static_cast<std::uint32_t>(kTextCount);
  state.numbers.resize(numbers);
  state.given.resize(numbers);
  each_field(in, state);
  in.word();
  if (!in.at_end()) Reader::refuse("something follows it");
  require_sane(state, list);
  return state;
}

}  // namespace fmu
