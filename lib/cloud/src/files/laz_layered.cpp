// Items of versions 3 and 4: a stream per field (a layer) and models per scanner channel.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "laz_item.h"

namespace cloud::laz {
namespace {

// Returns of a pulse: [number of returns][return number] -> which differences are alike; for 16
// by 16 numbers.
constexpr const char* kAlike16[16] = {
    "0123453445555555", "1013333333333333", "2124444444433333", "3345444444444444",
    "4344544444444444", "5344454444444444", "3344445444444444", "4344444544444444",
    "4344444454444444", "5344444445444444", "5344444444544444", "5334444444455444",
    "5334444444455544", "5334444444445554", "5334444444444555", "5334444444444455"};

// Of a record of point formats 6 to 10.
constexpr std::size_t kClass14 = 16, kUser14 = 17, kAngle14 = 18, kSource14 = 20, kTime14 = 22,
                      kPoint14 = 30;

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

/// Stays as the first record of the chunk has it.
class Unread final : public Item {
 public:
  void next(Byte*, unsigned&) override {}
};

struct ExtraBytes14 {
  Decoder* layers;
  std::vector<Symbols> differences;

  void next(Byte* p) {
    for (std::size_t k = 0; k < differences.size(); ++k)
      if (layers[k].is_open()) p[k] = static_cast<Byte>(p[k] + differences[k].decode(layers[k]));
  }
};

}  // namespace

std::size_t layers_of(const ItemKind& item) {
  switch (item.type) {
    case kP14:
      return kLayers;
    case kRgb14:
    case kWave14:
      return 1;
    case kRgbNir14:
      return 2;
    default:
      return item.size;
  }
}

std::unique_ptr<Item> layered_item(const ItemKind& kind, Decoder* layers, const Byte* first,
                                   unsigned channel) {
  const bool mended = kind.version >= 4;
  if (kind.type == kP14) return std::make_unique<Point14>(layers, first, mended);
  if (kind.type == kWave14) return std::make_unique<Unread>();
  if (kind.type == kBytes14)
    return std::make_unique<PerChannel<ExtraBytes14>>(
        first, kind.size, channel, mended,
        ExtraBytes14{layers, std::vector<Symbols>(kind.size, Symbols(256))});
  return std::make_unique<PerChannel<Colour14>>(
      first, kind.size, channel, mended,
      Colour14{layers, kind.type == kRgbNir14 ? layers + 1 : nullptr});
}

}  // namespace cloud::laz
