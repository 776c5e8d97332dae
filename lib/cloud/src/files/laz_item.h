// The items of a packed record: decoders of a field each, and what most of them share. Sources as
// in laz.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "laz_coder.h"

namespace cloud::laz {

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

// Types of items as the file numbers them.
enum : unsigned {
  kBytes = 0,
  kP10 = 6,
  kGps11 = 7,
  kRgb12 = 8,
  kP14 = 10,
  kRgb14 = 11,
  kRgbNir14 = 12,
  kWave14 = 13,  ///< where the waveform of a point lies: not unpacked
  kBytes14 = 14
};

struct ItemKind {
  unsigned type, size, version;
};

/// How many streams of its own a layered item has.
std::size_t layers_of(const ItemKind& item);

/// An item of a record whose items share one stream (versions 1 and 2). `first`: its field in the
/// first record of the chunk.
std::unique_ptr<Item> shared_stream_item(const ItemKind& kind, Decoder& from, Byte* first);

/// A layered item (versions 3 and 4), from its first layer on. `channel`: of the first record.
std::unique_ptr<Item> layered_item(const ItemKind& kind, Decoder* layers, const Byte* first,
                                   unsigned channel);

// Places in a record, of all point formats; the returns of formats 6 to 10 have four bits each.
constexpr std::size_t kIntensity = 12, kReturns = 14;
// Of formats 6 to 10: scanner channel, among other things.
constexpr std::size_t kFlags14 = 15;

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

inline std::size_t level_of(unsigned returns, unsigned number) {
  return std::min<std::size_t>(returns > number ? returns - number : number - returns, 7);
}

/// The context of a coordinate: single returns apart, and how large the corrections before were.
inline std::size_t size_context(unsigned k, unsigned most, bool single) {
  return (k < most ? k & ~1u : most) + (single ? 1 : 0);
}

inline void add_to(Byte* coordinate, std::uint32_t difference) {
  store(coordinate, load<std::uint32_t>(coordinate) + difference);
}

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

inline Byte clamped(int value) { return static_cast<Byte>(std::clamp(value, 0, 255)); }

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

}  // namespace cloud::laz
