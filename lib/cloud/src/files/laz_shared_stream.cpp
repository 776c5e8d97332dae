// Items of versions 1 and 2: one stream per chunk, a field after the other.
#include <algorithm>
#include <array>

#include "laz_item.h"

namespace cloud::laz {
namespace {

// Returns of a pulse: [number of returns][return number] -> which differences are alike; for 8 by
// 8 numbers.
constexpr const char* kAlike8[8] = {"ponmlkji", "oabdgkkj", "nbcehllk", "mdefimml",
                                    "lghijnnm", "kklmnoon", "jklmnopo", "ijklmnop"};

// Of a record of point formats 0 to 5.
constexpr std::size_t kClass = 15, kAngle = 16, kUser = 17, kSource = 18;

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

}  // namespace

std::unique_ptr<Item> shared_stream_item(const ItemKind& kind, Decoder& from, Byte* first) {
  const bool oldest = kind.version == 1;
  switch (kind.type) {
    case kP10:
      if (oldest) return std::make_unique<Point10Version1>(from);
      return std::make_unique<Point10>(from, first);
    case kGps11:
      if (oldest) return std::make_unique<GpsTimeVersion1>(from);
      return std::make_unique<GpsTime>(from, first);
    case kRgb12:
      if (oldest) return std::make_unique<RgbVersion1>(from);
      return std::make_unique<Rgb>(from);
    default:
      if (oldest) return std::make_unique<ExtraBytesVersion1>(from, kind.size);
      return std::make_unique<ExtraBytes>(from, kind.size);
  }
}

}  // namespace cloud::laz
