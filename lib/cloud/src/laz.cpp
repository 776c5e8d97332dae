// Source: ASPRS/rapidlasso "LAZ Specification 1.4 R1"; M. Isenburg 2013, "LASzip: lossless
// compression of LiDAR data", PE&RS 79(2). Item versions 1 and 2 share one stream per chunk, a
// field after the other; versions 3 and 4 have a stream per field (a layer) and models per scanner
// channel.
#include "laz.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "cloud/error.h"
#include "laz_coder.h"

namespace cloud {
namespace {

using laz::Damage;
using laz::Decoder;
using laz::Integers;
using laz::Symbols;
using Byte = std::uint8_t;

template <typename T>
T load(const void* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <typename T>
void store(void* to, T value) {
  std::memcpy(to, &value, sizeof value);
}

/// A field of a record, decoded in place from its value at the point before.
class Item {
 public:
  virtual ~Item() = default;
  /// `channel`: of the scanner, set by the first item of a layered record.
  virtual void next(Byte* field, unsigned& channel) = 0;
};

/// The median of five values. A new one replaces the largest, or the smallest, on the side on which
/// the one before it came to lie.
class RunningMedian {
 public:
  std::uint32_t get() const { return static_cast<std::uint32_t>(sorted_[2]); }
  void add(std::uint32_t added) {
    const auto value = static_cast<std::int32_t>(added);
    std::size_t place;
    if (drop_largest_) {
      for (place = 4; place > 0 && value < sorted_[place - 1]; --place)
        sorted_[place] = sorted_[place - 1];
      drop_largest_ = place <= 2;
    } else {
      for (place = 0; place < 4 && sorted_[place + 1] < value; ++place)
        sorted_[place] = sorted_[place + 1];
      drop_largest_ = place < 2;
    }
    sorted_[place] = value;
  }

 private:
  std::array<std::int32_t, 5> sorted_{};
  bool drop_largest_ = true;
};

// Returns of a pulse: [number of returns][return number] -> which differences are alike; for 16 by
// 16 and for 8 by 8 numbers.
constexpr const char* kAlike16[16] = {
    "0123453445555555", "1013333333333333", "2124444444433333", "3345444444444444",
    "4344544444444444", "5344454444444444", "3344445444444444", "4344444544444444",
    "4344444454444444", "5344444445444444", "5344444444544444", "5334444444455444",
    "5334444444455544", "5334444444445554", "5334444444444555", "5334444444444455"};
constexpr const char* kAlike8[8] = {"ponmlkji", "oabdgkkj", "nbcehllk", "mdefimml",
                                    "lghijnnm", "kklmnoon", "jklmnopo", "ijklmnop"};

std::size_t level_of(unsigned returns, unsigned number) {
  return std::min<std::size_t>(returns > number ? returns - number : number - returns, 7);
}

/// The context of a coordinate: single returns apart, and how large the corrections before were.
std::size_t size_context(unsigned k, unsigned most, bool single) {
  return (k < most ? k & ~1u : most) + (single ? 1 : 0);
}

void add_to(Byte* coordinate, std::uint32_t difference) {
  store(coordinate, load<std::uint32_t>(coordinate) + difference);
}

// Of a record of point formats 0 to 5.
constexpr std::size_t kIntensity = 12, kReturns = 14, kClass = 15, kAngle = 16, kUser = 17,
                      kSource = 18;

class Point10 final : public Item {
 public:
  Point10(Decoder& from, Byte* first) : from_(from) { store<std::uint16_t>(first + kIntensity, 0); }

  void next(Byte* p, unsigned&) override {
    const unsigned changed = changed_.decode(from_);
    if (changed & 32) p[kReturns] = static_cast<Byte>(returns_[p[kReturns]].decode(from_));
    const unsigned number = p[kReturns] & 7, returns = p[kReturns] >> 3 & 7;
    const auto alike = static_cast<std::size_t>(kAlike8[returns][number] - 'a');
    const std::size_t level = level_of(returns, number);
    if (changed != 0) {
      std::uint16_t& last = last_intensity_[alike];
      if (changed & 16)
        last = static_cast<std::uint16_t>(
            intensity_.decode(from_, last, std::min<std::size_t>(alike, 3)));
      store(p + kIntensity, last);
      if (changed & 8) p[kClass] = static_cast<Byte>(classes_[p[kClass]].decode(from_));
      if (changed & 4)
        p[kAngle] = static_cast<Byte>(p[kAngle] + angles_[p[kReturns] >> 6 & 1].decode(from_));
      if (changed & 2) p[kUser] = static_cast<Byte>(users_[p[kUser]].decode(from_));
      if (changed & 1)
        store(p + kSource, static_cast<std::uint16_t>(
                               source_.decode(from_, load<std::uint16_t>(p + kSource), 0)));
    }
    const bool single = returns == 1;
    const std::uint32_t dx = dx_.decode(from_, x_[alike].get(), single);
    x_[alike].add(dx), add_to(p, dx);
    const std::uint32_t dy = dy_.decode(from_, y_[alike].get(), size_context(dx_.k(), 20, single));
    y_[alike].add(dy), add_to(p + 4, dy);
    last_z_[level] =
        z_.decode(from_, last_z_[level], size_context((dx_.k() + dy_.k()) / 2, 18, single));
    store(p + 8, last_z_[level]);
  }

 private:
  Decoder& from_;
  Symbols changed_{64};
  std::vector<Symbols> returns_{256, Symbols(256)}, classes_{256, Symbols(256)},
      users_{256, Symbols(256)}, angles_{2, Symbols(256)};
  Integers intensity_{16, 4}, source_{16, 1}, dx_{32, 2}, dy_{32, 22}, z_{32, 20};
  std::array<RunningMedian, 16> x_, y_;
  std::array<std::uint16_t, 16> last_intensity_{};
  std::array<std::uint32_t, 8> last_z_{};
};

class Point10Version1 final : public Item {
 public:
  explicit Point10Version1(Decoder& from) : from_(from) {}

  void next(Byte* p, unsigned&) override {
    const std::uint32_t dx = dx_.decode(from_, median_of(x_), 0);
    unsigned k = dx_.k();
    const std::uint32_t dy = dy_.decode(from_, median_of(y_), std::min(k, 19u));
    k = (k + dy_.k()) / 2;
    add_to(p, dx), add_to(p + 4, dy);
    store(p + 8, z_.decode(from_, load<std::uint32_t>(p + 8), std::min(k, 19u)));
    x_[turn_] = static_cast<std::int32_t>(dx), y_[turn_] = static_cast<std::int32_t>(dy);
    turn_ = (turn_ + 1) % 3;
    const unsigned changed = changed_.decode(from_);
    const auto integer = [&](Integers& coder, std::size_t at) {
      store(p + at,
            static_cast<std::uint16_t>(coder.decode(from_, load<std::uint16_t>(p + at), 0)));
    };
    if (changed & 32) integer(intensity_, kIntensity);
    if (changed & 16) p[kReturns] = static_cast<Byte>(returns_[p[kReturns]].decode(from_));
    if (changed & 8) p[kClass] = static_cast<Byte>(classes_[p[kClass]].decode(from_));
    if (changed & 4) p[kAngle] = static_cast<Byte>(angle_.decode(from_, p[kAngle], k < 3));
    if (changed & 2) p[kUser] = static_cast<Byte>(users_[p[kUser]].decode(from_));
    if (changed & 1) integer(source_, kSource);
  }

 private:
  static std::uint32_t median_of(std::array<std::int32_t, 3> values) {
    std::sort(values.begin(), values.end());
    return static_cast<std::uint32_t>(values[1]);
  }

  Decoder& from_;
  Symbols changed_{64};
  std::vector<Symbols> returns_{256, Symbols(256)}, classes_{256, Symbols(256)},
      users_{256, Symbols(256)};
  Integers intensity_{16, 1}, angle_{8, 2}, source_{16, 1}, dx_{32, 1}, dy_{32, 20}, z_{32, 20};
  std::array<std::int32_t, 3> x_{}, y_{};
  std::size_t turn_ = 0;
};

/// Times as the integers that their bits are: steps of multiples of the last regular step, in up to
/// four sequences side by side.
class Times {
 public:
  /// `says_unchanged`: there are symbols for a time that stays as it is.
  Times(std::uint64_t first, bool says_unchanged)
      : hidden_(says_unchanged ? 0 : 1), start_(6 - hidden_), multiples_(516 - hidden_) {
    time_[0] = first;
  }

  std::uint64_t next(Decoder& from) {
    for (;;) {
      std::int32_t& step = step_[now_];
      unsigned found;  // 0: unchanged, 1: a step, 2: a new sequence, 3 and up: another sequence
      if (step == 0) {
        found = start_.decode(from) + hidden_;
        if (found == 1) {
          step = static_cast<std::int32_t>(steps_.decode(from, 0, 0));
          move(step);
          odd_[now_] = 0;
        }
      } else {
        unsigned multiple = multiples_.decode(from);
        if (multiple >= kUnchanged) multiple += hidden_;
        found = multiple < kUnchanged ? 1 : multiple - kUnchanged == 0 ? 0 : multiple - 510;
        if (found == 1) take_multiple(from, static_cast<std::int32_t>(multiple));
      }
      if (found == 2) {
        const std::uint32_t high =
            steps_.decode(from, static_cast<std::uint32_t>(time_[now_] >> 32), 8);
        newest_ = (newest_ + 1) % 4;
        now_ = newest_;
        time_[now_] = std::uint64_t{high} << 32 | from.bits(32);
        step_[now_] = 0;
        odd_[now_] = 0;
      }
      if (found <= 2) return time_[now_];
      now_ = (now_ + found - 2) % 4;
    }
  }

 private:
  static constexpr unsigned kUnchanged = 511;
  static constexpr std::int32_t kMost = 500, kLeast = -10;

  void move(std::int32_t step) {
    time_[now_] += static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
  }

  void take_multiple(Decoder& from, std::int32_t multiple) {
    if (multiple > kMost) multiple = kMost - multiple;
    const std::size_t context = multiple == 1       ? 1
                                : multiple == 0     ? 7
                                : multiple < 0      ? (multiple == kLeast ? 6 : 5)
                                : multiple == kMost ? 4
                                : multiple < 10     ? 2
                                                    : 3;
    const auto step = static_cast<std::int32_t>(steps_.decode(
        from, static_cast<std::uint32_t>(multiple) * static_cast<std::uint32_t>(step_[now_]),
        context));
    move(step);
    if (multiple == 1) odd_[now_] = 0;
    // The fourth step in a row that is no multiple becomes the regular one.
    if ((multiple == 0 || multiple == kMost || multiple == kLeast) && ++odd_[now_] > 3) {
      step_[now_] = step;
      odd_[now_] = 0;
    }
  }

  unsigned hidden_;
  Symbols start_, multiples_;
  Integers steps_{32, 9};
  std::size_t now_ = 0, newest_ = 0;
  std::array<std::uint64_t, 4> time_{};
  std::array<std::int32_t, 4> step_{};
  std::array<int, 4> odd_{};
};

class GpsTime final : public Item {
 public:
  GpsTime(Decoder& from, const Byte* first)
      : from_(from), times_(load<std::uint64_t>(first), true) {}
  void next(Byte* p, unsigned&) override { store(p, times_.next(from_)); }

 private:
  Decoder& from_;
  Times times_;
};

class GpsTimeVersion1 final : public Item {
 public:
  explicit GpsTimeVersion1(Decoder& from) : from_(from) {}

  void next(Byte* p, unsigned&) override {
    auto time = load<std::uint64_t>(p);
    const auto new_time = [&] {
      const std::uint64_t low = from_.bits(32);
      time = std::uint64_t{from_.bits(32)} << 32 | low;
    };
    const auto step_near = [&](std::int32_t prediction, std::size_t context) {
      const auto step = static_cast<std::int32_t>(
          steps_.decode(from_, static_cast<std::uint32_t>(prediction), context));
      time += static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
      return step;
    };
    if (step_ == 0) {
      const unsigned found = start_.decode(from_);
      if (found == 1) step_ = step_near(0, 0);
      if (found == 2) new_time();
    } else {
      const unsigned multiple = multiples_.decode(from_);
      if (multiple == kNew) new_time();
      if (multiple < kNew) {
        const std::int32_t prediction =
            multiple == 0 ? step_ / 4
                          : static_cast<std::int32_t>(multiple * static_cast<std::uint32_t>(step_));
        const std::int32_t step = step_near(prediction, multiple == 1   ? 1
                                                        : multiple == 0 ? 2
                                                        : multiple < 10 ? 3
                                                        : multiple < 50 ? 4
                                                                        : 5);
        const bool odd = multiple == 0 || multiple == kNew - 1;
        if (odd) ++odd_;
        if (multiple == 1 || (odd && odd_ > 3)) {
          step_ = step;
          odd_ = 0;
        }
      }
    }
    store(p, time);
  }

 private:
  static constexpr unsigned kNew = 510;  // 511: the time stays
  Decoder& from_;
  Symbols start_{3}, multiples_{512};
  Integers steps_{32, 6};
  std::int32_t step_ = 0;
  int odd_ = 0;
};

Byte clamped(int value) { return static_cast<Byte>(std::clamp(value, 0, 255)); }

/// Red, green and blue, two bytes each: what changes in red is expected in green and blue.
class Colour {
 public:
  void next(Decoder& from, Byte* c) {
    const unsigned changed = changed_.decode(from);
    Byte last[6];
    std::copy(c, c + 6, last);
    const auto differ = [&](unsigned which, Byte near) {
      return static_cast<Byte>(near + differences_[which].decode(from));
    };
    for (unsigned half = 0; half < 2; ++half)
      if (changed >> half & 1) c[half] = differ(half, last[half]);
    if (!(changed & 64)) {
      for (unsigned k = 2; k < 6; ++k) c[k] = c[k % 2];
      return;
    }
    for (unsigned half = 0; half < 2; ++half) {
      Byte &red = c[half], &green = c[2 + half], &blue = c[4 + half];
      int rise = red - last[half];
      if (changed >> (2 + half) & 1) green = differ(2 + half, clamped(last[2 + half] + rise));
      rise = (rise + green - last[2 + half]) / 2;
      if (changed >> (4 + half) & 1) blue = differ(4 + half, clamped(last[4 + half] + rise));
    }
  }

 private:
  Symbols changed_{128};
  std::vector<Symbols> differences_{6, Symbols(256)};
};

class Rgb final : public Item {
 public:
  explicit Rgb(Decoder& from) : from_(from) {}
  void next(Byte* p, unsigned&) override { colour_.next(from_, p); }

 private:
  Decoder& from_;
  Colour colour_;
};

class RgbVersion1 final : public Item {
 public:
  explicit RgbVersion1(Decoder& from) : from_(from) {}
  void next(Byte* p, unsigned&) override {
    const unsigned changed = changed_.decode(from_);
    for (unsigned k = 0; k < 6; ++k)
      if (changed >> k & 1) p[k] = static_cast<Byte>(bytes_.decode(from_, p[k], k));
  }

 private:
  Decoder& from_;
  Symbols changed_{64};
  Integers bytes_{8, 6};
};

class ExtraBytes final : public Item {
 public:
  ExtraBytes(Decoder& from, std::size_t size) : from_(from), differences_(size, Symbols(256)) {}
  void next(Byte* p, unsigned&) override {
    for (Symbols& difference : differences_) {
      *p = static_cast<Byte>(*p + difference.decode(from_));
      ++p;
    }
  }

 private:
  Decoder& from_;
  std::vector<Symbols> differences_;
};

class ExtraBytesVersion1 final : public Item {
 public:
  ExtraBytesVersion1(Decoder& from, std::size_t size) : from_(from), size_(size), bytes_(8, size) {}
  void next(Byte* p, unsigned&) override {
    for (std::size_t k = 0; k < size_; ++k, ++p)
      *p = static_cast<Byte>(bytes_.decode(from_, *p, k));
  }

 private:
  Decoder& from_;
  std::size_t size_;
  Integers bytes_;
};

// Of a record of point formats 6 to 10; the returns are those of 0 to 5 with four bits each.
constexpr std::size_t kFlags14 = 15, kClass14 = 16, kUser14 = 17, kAngle14 = 18, kSource14 = 20,
                      kTime14 = 22, kPoint14 = 30;

/// The layers of Point14 in the order of the file; one that is not open holds no change.
enum Layer { kXy, kZ, kClasses, kFlags, kIntensities, kAngles, kUsers, kSources, kTimes, kLayers };

class Point14 final : public Item {
 public:
  Point14(Decoder* layers, const Byte* first, bool mended) : layers_(layers), mended_(mended) {
    channel_ = first[kFlags14] >> 4 & 3;
    channels_[channel_].emplace(first);
  }

  void next(Byte* record, unsigned& channel) override {
    Decoder& xy = layers_[kXy];
    const Channel& before = *channels_[channel_];
    const unsigned changed =
        channels_[channel_]->changed[before.place() + (before.time_changed ? 4u : 0u)].decode(xy);
    if (changed & 64) {
      const unsigned to = (channel_ + channels_[channel_]->channel.decode(xy) + 1) % 4;
      if (!channels_[to]) channels_[to].emplace(before.last.data());
      channel_ = to;
    }
    // Version 3 tells the other items of the point's channel only where it changes.
    channel = mended_ || changed & 64 ? channel_ : 0;
    channels_[channel_]->next(layers_, changed, channel_);
    std::copy_n(channels_[channel_]->last.begin(), kPoint14, record);
  }

 private:
  struct Channel {
    explicit Channel(const Byte* first) : times(load<std::uint64_t>(first + kTime14), false) {
      std::copy_n(first, kPoint14, last.begin());
      last_z.fill(load<std::uint32_t>(first + 8));
      last_intensity.fill(load<std::uint16_t>(first + kIntensity));
    }

    unsigned number() const { return last[kReturns] & 15; }
    unsigned returns() const { return last[kReturns] >> 4; }
    /// Of its last return in its pulse: 1 the first, 2 the last, 3 the only one, 0 between.
    unsigned place() const { return (number() == 1 ? 1u : 0u) + (number() >= returns() ? 2u : 0u); }

    void next(Decoder* layers, unsigned what, unsigned channel_number) {
      Byte* const p = last.data();
      const bool new_time = what & 16;
      next_returns(layers[kXy], what & 7, new_time);
      const auto alike =
          2 * static_cast<std::size_t>(kAlike16[returns()][number()] - '0') + (new_time ? 1 : 0);
      const bool single = returns() == 1;
      const std::uint32_t x = dx.decode(layers[kXy], x_median[alike].get(), single);
      x_median[alike].add(x), add_to(p, x);
      const std::uint32_t y =
          dy.decode(layers[kXy], y_median[alike].get(), size_context(dx.k(), 20, single));
      y_median[alike].add(y), add_to(p + 4, y);
      if (layers[kZ].is_open()) {
        std::uint32_t& height = last_z[level_of(returns(), number())];
        height = z.decode(layers[kZ], height, size_context((dx.k() + dy.k()) / 2, 18, single));
        store(p + 8, height);
      }
      if (layers[kClasses].is_open())
        p[kClass14] = static_cast<Byte>(
            classes[(p[kClass14] & 31u) * 2 + (place() == 3 ? 1 : 0)].decode(layers[kClasses]));
      // Six bits: those of the class, scan direction, edge of flight line.
      unsigned flag_bits = (p[kFlags14] & 15u) | (p[kFlags14] >> 2 & 48u);
      if (layers[kFlags].is_open()) flag_bits = flags[flag_bits].decode(layers[kFlags]);
      p[kFlags14] =
          static_cast<Byte>((flag_bits & 15) | channel_number << 4 | (flag_bits & 48) << 2);
      if (layers[kIntensities].is_open()) {
        std::uint16_t& value = last_intensity[place() * 2 + (new_time ? 1 : 0)];
        value = static_cast<std::uint16_t>(intensity.decode(layers[kIntensities], value, place()));
        store(p + kIntensity, value);
      }
      if (layers[kAngles].is_open() && what & 8)
        store(p + kAngle14, static_cast<std::uint16_t>(angle.decode(
                                layers[kAngles], load<std::uint16_t>(p + kAngle14), new_time)));
      if (layers[kUsers].is_open())
        p[kUser14] = static_cast<Byte>(users[p[kUser14] / 4].decode(layers[kUsers]));
      if (layers[kSources].is_open() && what & 32)
        store(p + kSource14, static_cast<std::uint16_t>(source.decode(
                                 layers[kSources], load<std::uint16_t>(p + kSource14), 0)));
      if (layers[kTimes].is_open() && new_time) store(p + kTime14, times.next(layers[kTimes]));
      time_changed = new_time;
    }

    void next_returns(Decoder& xy, unsigned what, bool new_time) {
      unsigned count = returns(), which = number();
      if (what & 4) count = returns_after[count].decode(xy);
      if ((what & 3) == 1) which += 1;
      if ((what & 3) == 2) which += 15;
      if ((what & 3) == 3)
        which = new_time ? number_after[which].decode(xy) : which + 2 + number_same_time.decode(xy);
      last[kReturns] = static_cast<Byte>(count << 4 | which % 16);
    }

    std::array<Byte, kPoint14> last;
    bool time_changed = false;
    std::vector<Symbols> changed{8, Symbols(128)};
    Symbols channel{3}, number_same_time{13};
    std::vector<Symbols> returns_after{16, Symbols(16)}, number_after{16, Symbols(16)};
    Integers dx{32, 2}, dy{32, 22}, z{32, 20}, intensity{16, 4}, angle{16, 2}, source{16, 1};
    std::vector<Symbols> classes{64, Symbols(256)}, flags{64, Symbols(64)}, users{64, Symbols(256)};
    Times times;
    std::array<RunningMedian, 12> x_median, y_median;
    std::array<std::uint32_t, 8> last_z;
    std::array<std::uint16_t, 8> last_intensity;
  };

  Decoder* layers_;
  bool mended_;
  unsigned channel_;
  std::array<std::optional<Channel>, 4> channels_;
};

/// What the other layered items share: a value and models per scanner channel. In version 3 the
/// value before is that of the channel before, unless the channel is new; version 4 mends this.
template <typename Models>
class PerChannel final : public Item {
 public:
  PerChannel(const Byte* first, std::size_t size, unsigned channel, bool mended, Models fresh)
      : channel_(channel), mended_(mended), fresh_(std::move(fresh)) {
    channels_[channel_].emplace(State{std::vector<Byte>(first, first + size), fresh_});
  }

  void next(Byte* field, unsigned& channel) override {
    State* from = &*channels_[channel_];
    if (channel != channel_) {
      const bool is_new = !channels_[channel];
      if (is_new) channels_[channel].emplace(State{from->last, fresh_});
      if (is_new || mended_) from = &*channels_[channel];
      channel_ = channel;
    }
    channels_[channel_]->models.next(from->last.data());
    std::copy(from->last.begin(), from->last.end(), field);
  }

 private:
  struct State {
    std::vector<Byte> last;
    Models models;
  };
  unsigned channel_;
  bool mended_;
  Models fresh_;
  std::array<std::optional<State>, 4> channels_;
};

struct Colour14 {
  Decoder *rgb, *nir;  // nir null: none
  Colour colour{};
  Symbols nir_changed{4};
  std::vector<Symbols> nir_differences{2, Symbols(256)};

  void next(Byte* p) {
    if (rgb->is_open()) colour.next(*rgb, p);
    if (nir == nullptr || !nir->is_open()) return;
    const unsigned changed = nir_changed.decode(*nir);
    for (unsigned k = 0; k < 2; ++k)
      if (changed >> k & 1)
        p[6 + k] = static_cast<Byte>(p[6 + k] + nir_differences[k].decode(*nir));
  }
};

struct ExtraBytes14 {
  Decoder* layers;
  std::vector<Symbols> differences;

  void next(Byte* p) {
    for (std::size_t k = 0; k < differences.size(); ++k)
      if (layers[k].is_open()) p[k] = static_cast<Byte>(p[k] + differences[k].decode(layers[k]));
  }
};

// Types of items as the file numbers them.
enum : unsigned {
  kBytes = 0,
  kP10 = 6,
  kGps11 = 7,
  kRgb12 = 8,
  kP14 = 10,
  kRgb14 = 11,
  kRgbNir14 = 12,
  kBytes14 = 14
};

struct ItemKind {
  unsigned type, size, version;
};

std::size_t layers_of(const ItemKind& item) {
  switch (item.type) {
    case kP14:
      return kLayers;
    case kRgb14:
      return 1;
    case kRgbNir14:
      return 2;
    default:
      return item.size;
  }
}

/// Type and size of the items that a record has.
std::vector<ItemKind> items_of(int format, std::size_t length) {
  std::vector<ItemKind> items;
  std::size_t size = 0;
  const auto add = [&](unsigned type, unsigned bytes) {
    items.push_back({type, bytes, 0});
    size += bytes;
  };
  if (format < 6) {
    add(kP10, 20);
    if (format == 1 || format == 3) add(kGps11, 8);
    if (format == 2 || format == 3) add(kRgb12, 6);
  } else {
    add(kP14, 30);
    if (format == 7) add(kRgb14, 6);
    if (format == 8) add(kRgbNir14, 8);
  }
  if (length > size) add(format < 6 ? kBytes : kBytes14, static_cast<unsigned>(length - size));
  return items;
}

struct Chunk {
  std::size_t begin = 0, size = 0;  // bytes in the file
  std::uint64_t points = 0;
};

}  // namespace

struct LazReader::State {
  std::string_view file;
  LazLayout layout;
  std::string name;
  bool layered = false;
  std::vector<ItemKind> kinds;
  std::vector<Chunk> chunks;

  std::size_t next_chunk = 0;
  std::uint64_t left = 0;  // points of the chunk
  bool whole = false;      // the chunk has no more points than those
  std::uint64_t read = 0;  // points in all
  std::string record;      // the point before
  unsigned channel = 0;
  std::vector<Decoder> decoders;  // one, or one per layer
  std::vector<std::unique_ptr<Item>> items;

  Error fail(const char* at, const std::string& what) const {
    return fail(static_cast<std::size_t>(at - file.data()), what);
  }
  Error fail(std::size_t at, const std::string& what) const {
    return Error(fmt::format("{}: byte {}: {}", name, at, what));
  }
  template <typename T>
  T number(std::size_t at, const char* what) const {
    if (at > file.size() || file.size() - at < sizeof(T))
      throw fail(file.size(),
                 fmt::format("truncated: {} wanted at byte {}; copy the file again", what, at));
    return load<T>(file.data() + at);
  }

  void read_vlr();
  void read_chunk_table(std::uint64_t chunk_points);
  void open_chunk();
  void open_layers(std::size_t at, std::size_t end, std::uint64_t points);
  void make_items();
  void close_chunk() const;
};

void LazReader::State::read_vlr() {
  const std::string_view vlr = layout.vlr;
  const auto at = static_cast<std::size_t>(vlr.data() - file.data());
  if (vlr.size() < 34 || vlr.size() < 34 + 6 * std::size_t{load<std::uint16_t>(vlr.data() + 32)})
    throw fail(at, fmt::format("the record 'laszip encoded' has {} bytes, 34 and 6 per item wanted",
                               vlr.size()));
  const auto compressor = load<std::uint16_t>(vlr.data()),
             coder = load<std::uint16_t>(vlr.data() + 2);
  const auto chunk_points = load<std::uint32_t>(vlr.data() + 12);
  const std::size_t count = load<std::uint16_t>(vlr.data() + 32);
  if (compressor < 1 || compressor > 3 || coder != 0)
    throw fail(at, fmt::format("compressor {} with coder {} seen; 1, 2 or 3 with coder 0 wanted; "
                               "unpack the file with 'laszip -i in.laz -o out.las'",
                               compressor, coder));
  layered = compressor == 3;
  kinds = items_of(layout.format, layout.length);
  bool fits = count == kinds.size() && layered == (layout.format >= 6);
  for (std::size_t k = 0; fits && k < count; ++k) {
    const char* const item = vlr.data() + 34 + 6 * k;
    kinds[k].version = load<std::uint16_t>(item + 4);
    fits = load<std::uint16_t>(item) == kinds[k].type &&
           load<std::uint16_t>(item + 2) == kinds[k].size;
    const unsigned first = layered ? 3 : 1;
    if (fits && (kinds[k].version < first || kinds[k].version > first + 1))
      throw fail(at + 34 + 6 * k, fmt::format("version {} of item type {} seen, {} or {} wanted",
                                              kinds[k].version, kinds[k].type, first, first + 1));
  }
  if (!fits)
    throw fail(at, fmt::format("the packed items do not make up a record of point format {} and {} "
                               "bytes; copy the file again, or unpack it with 'laszip -i in.laz "
                               "-o out.las'",
                               layout.format, layout.length));
  // Even equal points take a thousandth of a byte.
  if (layout.count / 1000 > file.size() - layout.data)
    throw fail(layout.data, fmt::format("{} points promised, {} bytes follow; copy the file again",
                                        layout.count, file.size() - layout.data));
  if (compressor == 1)
    chunks.push_back({layout.data, file.size() - layout.data, layout.count});
  else
    read_chunk_table(chunk_points);
}

void LazReader::State::read_chunk_table(std::uint64_t chunk_points) {
  const bool variable = chunk_points == 0xffffffff;
  auto place = number<std::int64_t>(layout.data, "the place of the chunk table");
  if (place == -1)  // written to a pipe: at the very end
    place = number<std::int64_t>(file.size() - 8, "the place of the chunk table");
  const std::size_t begin = layout.data + 8;
  if (place < static_cast<std::int64_t>(begin) ||
      place > static_cast<std::int64_t>(file.size()) - 8)
    throw fail(layout.data,
               fmt::format("the chunk table is said to be at byte {} of {}; copy the file again",
                           place, file.size()));
  const auto table = static_cast<std::size_t>(place);
  const auto version = number<std::uint32_t>(table, "the chunk table");
  const std::uint64_t count = number<std::uint32_t>(table + 4, "the number of chunks");
  // Each chunk begins with a whole record.
  const std::uint64_t most = (table - begin) / layout.length;
  if (version != 0 || count == 0 || count > most || chunk_points == 0)
    throw fail(table, fmt::format("a chunk table of version {} with {} chunks of {} points seen; "
                                  "version 0, 1 to {} chunks and at least one point wanted",
                                  version, count, chunk_points, most));
  if (!variable && (layout.count - 1) / chunk_points + 1 > count)
    throw fail(table, fmt::format("truncated: {} points in chunks of {} promised, {} chunks seen",
                                  layout.count, chunk_points, count));
  try {
    Decoder from(file.substr(table + 8));
    Integers numbers(32, 2);
    std::uint32_t points = 0, size = 0;
    std::size_t at = begin;
    std::uint64_t promised = 0;
    chunks.reserve(count);
    for (std::uint64_t k = 0; k < count; ++k) {
      if (variable) points = numbers.decode(from, points, 0);
      size = numbers.decode(from, size, 1);
      if (size > table - at)
        throw fail(table, fmt::format("chunk {} of {} is said to end at byte {}, beyond the "
                                      "points' end at {}; copy the file again",
                                      k + 1, count, at + size, table));
      chunks.push_back(
          {at, size,
           variable ? points
                    : std::min(chunk_points, layout.count - std::min(layout.count, promised))});
      at += size;
      promised += chunks.back().points;
    }
    if (promised < layout.count)
      throw fail(table,
                 fmt::format("{} points promised, the chunk table has {}", layout.count, promised));
  } catch (const Damage& damage) {
    throw fail(damage.at,
               fmt::format("the chunk table is no table ({}); copy the file again", damage.what));
  }
}

void LazReader::State::open_layers(std::size_t at, std::size_t end, std::uint64_t points) {
  std::size_t layers = 0;
  for (const ItemKind& kind : kinds) layers += layers_of(kind);
  if (end - at < 4 + 4 * layers)
    throw fail(at, fmt::format("truncated: {} sizes of layers wanted, {} bytes are left in the "
                               "chunk; copy the file again",
                               layers, end - at));
  const auto counted = number<std::uint32_t>(at, "the points of a chunk");
  if (counted < points)
    throw fail(at, fmt::format("the chunk has {} points, {} wanted; copy the file again", counted,
                               points));
  whole &= counted == points;
  std::size_t begin = at + 4 + 4 * layers;
  decoders.assign(layers, Decoder());
  for (std::size_t k = 0; k < layers; ++k) {
    const std::size_t size = number<std::uint32_t>(at + 4 + 4 * k, "the size of a layer");
    if (size > end - begin)
      throw fail(at + 4 + 4 * k,
                 fmt::format("a layer of {} bytes seen, {} are left in the chunk; copy the file "
                             "again",
                             size, end - begin));
    if (size > 0) decoders[k] = Decoder(file.substr(begin, size));
    begin += size;
  }
  if (!decoders[kXy].is_open()) throw fail(at, "a chunk without positions; copy the file again");
}

void LazReader::State::make_items() {
  items.clear();
  Byte* field = reinterpret_cast<Byte*>(record.data());
  Decoder* decoder = decoders.data();
  channel = layered ? field[kFlags14] >> 4 & 3u : 0;
  for (const ItemKind& kind : kinds) {
    const bool first = kind.version == 1;
    const auto put = [&](auto* item) { items.emplace_back(item); };
    switch (kind.type) {
      case kP10:
        first ? put(new Point10Version1(*decoder)) : put(new Point10(*decoder, field));
        break;
      case kGps11:
        first ? put(new GpsTimeVersion1(*decoder)) : put(new GpsTime(*decoder, field));
        break;
      case kRgb12:
        first ? put(new RgbVersion1(*decoder)) : put(new Rgb(*decoder));
        break;
      case kBytes:
        first ? put(new ExtraBytesVersion1(*decoder, kind.size))
              : put(new ExtraBytes(*decoder, kind.size));
        break;
      case kP14:
        put(new Point14(decoder, field, kind.version >= 4));
        break;
      case kBytes14:
        put(new PerChannel<ExtraBytes14>(field, kind.size, channel, kind.version >= 4,
                                         {decoder, std::vector<Symbols>(kind.size, Symbols(256))}));
        break;
      default:
        put(new PerChannel<Colour14>(field, kind.size, channel, kind.version >= 4,
                                     {decoder, kind.type == kRgbNir14 ? decoder + 1 : nullptr}));
    }
    field += kind.size;
    if (layered) decoder += layers_of(kind);
  }
}

void LazReader::State::open_chunk() {
  while (next_chunk < chunks.size() && chunks[next_chunk].points == 0) ++next_chunk;
  if (next_chunk == chunks.size()) throw fail(file.size(), "no chunk is left; copy the file again");
  const Chunk& chunk = chunks[next_chunk++];
  if (chunk.size < layout.length)
    throw fail(chunk.begin,
               fmt::format("truncated: a chunk of {} bytes seen, a record has {}; copy "
                           "the file again",
                           chunk.size, layout.length));
  record.assign(file.substr(chunk.begin, layout.length));
  left = std::min(chunk.points, layout.count - read);
  whole = left > 1 && left == chunk.points && chunk.begin != layout.data;
  if (left == 1) return;  // nothing is coded
  const std::size_t at = chunk.begin + layout.length, end = chunk.begin + chunk.size;
  if (layered)
    open_layers(at, end, left);
  else
    decoders.assign(1, Decoder(file.substr(at, end - at)));
}

/// A chunk read to its end has used up its bytes: damage in it would hardly end there. (With
/// compressor 1 other things follow, and with fewer points promised than there are.)
void LazReader::State::close_chunk() const {
  constexpr std::size_t kPadding = 4;  // that encoders differ in
  if (!whole) return;
  for (const Decoder& decoder : decoders)
    if (decoder.is_open() && decoder.left() > kPadding)
      throw fail(decoder.here(),
                 fmt::format("damaged: the chunk from byte {} on has {} more bytes than its points "
                             "need; copy the file again",
                             chunks[next_chunk - 1].begin, decoder.left()));
}

LazReader::LazReader(std::string_view file, const LazLayout& layout, std::string name)
    : state_(new State) {
  state_->file = file;
  state_->layout = layout;
  state_->name = std::move(name);
  state_->read_vlr();
}

LazReader::~LazReader() = default;

std::size_t LazReader::chunk_begin() const {
  return state_->next_chunk == 0 ? 0 : state_->chunks[state_->next_chunk - 1].begin;
}

void LazReader::read(std::size_t count, std::string& records) {
  State& s = *state_;
  const std::size_t length = s.layout.length;
  records.resize(count * length);
  try {
    for (std::size_t i = 0; i < count; ++i) {
      char* const to = records.data() + i * length;
      if (s.left == 0) {
        s.open_chunk();
        std::memcpy(to, s.record.data(), length);
        if (s.left > 1) s.make_items();
      } else {
        auto* field = reinterpret_cast<Byte*>(s.record.data());
        for (std::size_t k = 0; k < s.items.size(); ++k) {
          s.items[k]->next(field, s.channel);
          field += s.kinds[k].size;
        }
        std::memcpy(to, s.record.data(), length);
      }
      ++s.read;
      if (--s.left == 0) s.close_chunk();
    }
  } catch (const Damage& damage) {
    throw s.fail(damage.at, std::string(damage.what) + "; copy the file again");
  }
}

}  // namespace cloud
