#include "support/laz_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <random>

namespace support {
namespace {

using U8 = std::uint8_t;
using U16 = std::uint16_t;
using U32 = std::uint32_t;
using I32 = std::int32_t;
using U64 = std::uint64_t;
using I64 = std::int64_t;

template <typename T>
T get(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <typename T>
void put_at(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <typename T>
std::string packed(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Frequencies of symbols, brought up to date ever more seldom.
struct Model {
  explicit Model(U32 size) : counts(size, 1) { refresh(size), wait = cycle = (size + 6) >> 1; }

  U32 below(U32 symbol) const { return cumulative[symbol]; }
  bool is_last(U32 symbol) const { return symbol + 1 == counts.size(); }
  void seen(U32 symbol) {
    ++counts[symbol];
    if (--wait == 0) refresh(cycle);
  }
  void refresh(U32 passed) {
    total += passed;
    if (total > 32768) {
      total = 0;
      for (U32& count : counts) total += (count = (count + 1) >> 1);
    }
    cumulative.assign(1, 0);
    U32 sum = 0;
    for (const U32 count : counts) {
      sum += count;
      cumulative.push_back((0x80000000u / total) * sum >> 16);
    }
    cycle = std::min(passed * 5 >> 2, static_cast<U32>(counts.size() + 6) << 3);
    wait = cycle;
  }
  std::vector<U32> counts, cumulative;
  U32 total = 0, cycle = 0, wait = 0;
};

struct BitModel {
  U32 zeros = 1, all = 2, share = 4096, cycle = 4, wait = 4;
  void seen(U32 bit) {
    zeros += bit == 0;
    if (--wait != 0) return;
    if ((all += cycle) > 8192) {
      all = (all + 1) >> 1;
      zeros = (zeros + 1) >> 1;
      all += zeros == all;
    }
    share = zeros * (0x80000000u / all) >> 18;
    wait = cycle = std::min(cycle * 5 >> 2, 64u);
  }
};

class Stream {
 public:
  void symbol(Model& model, U32 value) {
    const U32 unit = length_ >> 15, begin = unit * model.below(value);
    narrow(begin, (model.is_last(value) ? length_ : unit * model.below(value + 1)) - begin);
    model.seen(value);
  }
  void bit(BitModel& model, U32 value) {
    const U32 middle = model.share * (length_ >> 13);
    value == 0 ? narrow(0, middle) : narrow(middle, length_ - middle);
    model.seen(value);
  }
  void raw(U32 count, U32 value) {
    if (count > 19) {
      raw(16, value & 0xffff);
      raw(count - 16, value >> 16);
      return;
    }
    const U32 unit = length_ >> count;
    narrow(unit * value, unit);
  }
  std::string finish() {
    const bool wide = length_ > 0x2000000;
    narrow(wide ? 0x1000000 : 0x800000, wide ? 0x800000 : 0x8000);
    return bytes_ + std::string(wide ? 3 : 2, '\0');
  }

 private:
  void narrow(U32 begin, U32 length) {
    if (base_ + begin < base_) {  // carry
      auto byte = bytes_.rbegin();
      for (; *byte == '\xff'; ++byte) *byte = '\0';
      ++*byte;
    }
    base_ += begin;
    for (length_ = length; length_ < 0x1000000; length_ <<= 8, base_ <<= 8)
      bytes_ += static_cast<char>(base_ >> 24);
  }
  std::string bytes_;
  U32 base_ = 0, length_ = 0xffffffff;
};

/// An integer as what it differs from its prediction: the number of bits of that, then the bits.
struct Number {
  Number(U32 width, U32 contexts) : bits(width) {
    for (U32 c = 0; c < contexts; ++c) sizes.emplace_back(width + 1);
    for (U32 k = 0; k < width; ++k) tops.emplace_back(1u << std::min(k + 1, 8u));
  }
  void write(Stream& to, I64 prediction, I64 value, U32 context) {
    I64 off = value - prediction;
    const I64 range = I64{1} << bits;
    while (off < -range / 2) off += range;
    while (off >= range / 2) off -= range;
    size = 0;
    for (I64 rest = off <= 0 ? -off : off - 1; rest != 0; rest >>= 1) ++size;
    to.symbol(sizes[context], size);
    if (size == 0) return to.bit(small, static_cast<U32>(off));
    if (size == 32) return;
    const auto code = static_cast<U32>(off < 0 ? off + (I64{1} << size) - 1 : off - 1);
    const U32 low = size > 8 ? size - 8 : 0;
    to.symbol(tops[size - 1], code >> low);
    if (low > 0) to.raw(low, code & ((1u << low) - 1));
  }
  U32 bits, size = 0;
  std::vector<Model> sizes, tops;
  BitModel small;
};

/// Models by a key, new ones where there is none yet.
struct Models {
  U32 symbols;
  std::map<U32, Model> of = {};
  Model& operator[](U32 key) { return of.try_emplace(key, symbols).first->second; }
};

struct Median {
  std::vector<I32> five = std::vector<I32>(5, 0);
  bool upper = true;  // the largest goes
  void add(I32 value) {
    const I32 middle = five[2];
    five.erase(upper ? five.end() - 1 : five.begin());
    five.insert(std::lower_bound(five.begin(), five.end(), value), value);
    upper = upper ? value < middle : !(middle < value);
  }
};

constexpr U8 kMap8[8][8] = {{15, 14, 13, 12, 11, 10, 9, 8},  {14, 0, 1, 3, 6, 10, 10, 9},
                            {13, 1, 2, 4, 7, 11, 11, 10},    {12, 3, 4, 5, 8, 12, 12, 11},
                            {11, 6, 7, 8, 9, 13, 13, 12},    {10, 10, 11, 12, 13, 14, 14, 13},
                            {9, 10, 11, 12, 13, 14, 15, 14}, {8, 9, 10, 11, 12, 13, 14, 15}};

U32 map16(int n, int r) {
  constexpr int kNone[16] = {0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5};
  if (n == 0 || r == 0) return static_cast<U32>(kNone[n + r]);
  if (n < 3 && r < 3) return static_cast<U32>(n + r - 2);
  if (n == 1 || r == 1) return 3;
  if (n == 2) return r < 11 ? 4 : 3;
  if (r == 2) return n < 11 ? 4 : 3;
  const int off = r - n;
  const bool same = off == 0 || (n > 10 && off == 1) || (n > 11 && off == 2 && n < 14);
  if (n >= 11) {
    constexpr const char* kRows[5] = {"4444444455444", "4444444455544", "4444444445554",
                                      "4444444444555", "4444444444455"};
    return static_cast<U32>(kRows[n - 11][r - 3] - '0');
  }
  return same ? 5 : 4;
}

U32 even(U32 k, U32 most) { return k < most ? k & ~1u : most; }

/// The times of a sequence of points.
struct TimeCoder {
  explicit TimeCoder(I64 first, bool unchanged)
      : says_unchanged(unchanged), zero(unchanged ? 6 : 5), multi(unchanged ? 516 : 515) {
    last[0] = first;
  }
  U32 zero_code(U32 v2) const { return says_unchanged ? v2 : v2 - 1; }
  U32 multi_code(U32 v2) const { return says_unchanged || v2 < 511 ? v2 : v2 - 1; }

  void write(Stream& to, I64 time) {
    if (says_unchanged && time == last[now])
      return step[now] == 0 ? to.symbol(zero, 0) : to.symbol(multi, 511);
    const auto fits = [&](U32 k) {
      const I64 off = time - last[k];
      return off == static_cast<I32>(off);
    };
    if (!fits(now)) {
      for (U32 i = 1; i < 4; ++i)
        if (fits((now + i) & 3)) {
          step[now] == 0 ? to.symbol(zero, zero_code(i + 2))
                         : to.symbol(multi, multi_code(512 + i));
          now = (now + i) & 3;
          return write(to, time);
        }
      step[now] == 0 ? to.symbol(zero, zero_code(2)) : to.symbol(multi, multi_code(512));
      steps.write(to, last[now] >> 32, time >> 32, 8);
      to.raw(16, static_cast<U32>(time) & 0xffff), to.raw(16, static_cast<U32>(time) >> 16);
      now = newest = (newest + 1) & 3;
      last[now] = time, step[now] = 0, extreme[now] = 0;
      return;
    }
    const auto off = static_cast<I32>(time - last[now]);
    last[now] = time;
    if (step[now] == 0) {
      to.symbol(zero, zero_code(1));
      steps.write(to, 0, off, 0);
      step[now] = off, extreme[now] = 0;
      return;
    }
    const float ratio = static_cast<float>(off) / static_cast<float>(step[now]);
    const auto times = static_cast<I32>(ratio >= 0 ? ratio + 0.5f : ratio - 0.5f);
    const I32 used = std::clamp(times, -10, 500);
    to.symbol(multi, static_cast<U32>(used >= 0 ? used : 500 - used));
    const U32 context = used == 1     ? 1
                        : used == 0   ? 7
                        : used == -10 ? 6
                        : used < 0    ? 5
                        : used == 500 ? 4
                        : used < 10   ? 2
                                      : 3;
    steps.write(to, static_cast<I32>(static_cast<U32>(used) * static_cast<U32>(step[now])), off,
                context);
    if (used == 1) extreme[now] = 0;
    if (used != 0 && used != -10 && used != 500) return;
    if (++extreme[now] > 3) step[now] = off, extreme[now] = 0;
  }

  bool says_unchanged;
  Model zero, multi;
  Number steps{32, 9};
  U32 now = 0, newest = 0;
  I64 last[4] = {0, 0, 0, 0};
  I32 step[4] = {0, 0, 0, 0};
  int extreme[4] = {0, 0, 0, 0};
};

struct ColourCoder {
  Model used{128};
  Models differences{256};
  /// True where anything differs.
  bool write(Stream& to, const U8* last, const U8* p) {
    U32 sym = 0;
    for (U32 k = 0; k < 6; ++k) sym |= static_cast<U32>(last[k] != p[k]) << k;
    const bool differs = sym != 0;
    if (p[0] != p[2] || p[0] != p[4] || p[1] != p[3] || p[1] != p[5]) sym |= 64;
    to.symbol(used, sym);
    const auto put = [&](U32 k, int expected) {
      if (sym >> k & 1)
        to.symbol(differences[k], static_cast<U8>(p[k] - std::clamp(expected, 0, 255)));
    };
    put(0, last[0]), put(1, last[1]);
    for (U32 h = 0; sym & 64 && h < 2; ++h) {
      const int red = p[h] - last[h];
      put(2 + h, last[2 + h] + red);
      put(4 + h, last[4 + h] + (red + p[2 + h] - last[2 + h]) / 2);
    }
    return differs;
  }
};

I32 coordinate(const U8* p, int axis) {
  I32 value;
  std::memcpy(&value, p + 4 * axis, 4);
  return value;
}

U32 short_at(const U8* p, std::size_t at) { return p[at] | static_cast<U32>(p[at + 1]) << 8; }

I64 long_at(const U8* p) {
  I64 value;
  std::memcpy(&value, p, 8);
  return value;
}

/// Points of formats 0 to 3, item version 2.
struct Points2 {
  Model changed{64};
  Models returns{256}, classes{256}, users{256}, angles{256};
  Number intensity{16, 4}, source{16, 1}, dx{32, 2}, dy{32, 22}, z{32, 20};
  Median mx[16], my[16];
  U32 last_intensity[16] = {};
  I32 last_z[8] = {};

  void write(Stream& to, const U8* last, const U8* p) {
    const int n = p[14] >> 3 & 7, r = p[14] & 7;
    const U32 m = kMap8[n][r], l = static_cast<U32>(std::abs(n - r));
    const bool value[6] = {short_at(p, 18) != short_at(last, 18),
                           p[17] != last[17],
                           p[16] != last[16],
                           p[15] != last[15],
                           short_at(p, 12) != last_intensity[m],
                           p[14] != last[14]};
    U32 sym = 0;
    for (U32 k = 0; k < 6; ++k) sym |= static_cast<U32>(value[k]) << k;
    to.symbol(changed, sym);
    if (value[5]) to.symbol(returns[last[14]], p[14]);
    if (value[4]) {
      intensity.write(to, last_intensity[m], short_at(p, 12), std::min(m, 3u));
      last_intensity[m] = short_at(p, 12);
    }
    if (value[3]) to.symbol(classes[last[15]], p[15]);
    if (value[2]) to.symbol(angles[p[14] >> 6 & 1u], static_cast<U8>(p[16] - last[16]));
    if (value[1]) to.symbol(users[last[17]], p[17]);
    if (value[0]) source.write(to, short_at(last, 18), short_at(p, 18), 0);
    const auto off = [&](int axis) {
      return static_cast<I32>(static_cast<U32>(coordinate(p, axis)) -
                              static_cast<U32>(coordinate(last, axis)));
    };
    const U32 one = n == 1;
    dx.write(to, mx[m].five[2], off(0), one), mx[m].add(off(0));
    dy.write(to, my[m].five[2], off(1), one + even(dx.size, 20)), my[m].add(off(1));
    z.write(to, last_z[l], coordinate(p, 2), one + even((dx.size + dy.size) / 2, 18));
    last_z[l] = coordinate(p, 2);
  }
};

/// The same, item version 1.
struct Points1 {
  Model changed{64};
  Models returns{256}, classes{256}, users{256};
  Number intensity{16, 1}, angle{8, 2}, source{16, 1}, dx{32, 1}, dy{32, 20}, z{32, 20};
  std::vector<I32> x{0, 0, 0}, y{0, 0, 0};  // the last three, the newest last

  static I32 middle(std::vector<I32> three) {
    std::nth_element(three.begin(), three.begin() + 1, three.end());
    return three[1];
  }
  void write(Stream& to, const U8* last, const U8* p) {
    const auto off = [&](int axis) {
      return static_cast<I32>(static_cast<U32>(coordinate(p, axis)) -
                              static_cast<U32>(coordinate(last, axis)));
    };
    dx.write(to, middle(x), off(0), 0);
    dy.write(to, middle(y), off(1), std::min(dx.size, 19u));
    const U32 k = (dx.size + dy.size) / 2;
    z.write(to, coordinate(last, 2), coordinate(p, 2), std::min(k, 19u));
    x.erase(x.begin()), x.push_back(off(0));
    y.erase(y.begin()), y.push_back(off(1));
    const bool value[6] = {short_at(p, 18) != short_at(last, 18),
                           p[17] != last[17],
                           p[16] != last[16],
                           p[15] != last[15],
                           p[14] != last[14],
                           short_at(p, 12) != short_at(last, 12)};
    U32 sym = 0;
    for (U32 bit = 0; bit < 6; ++bit) sym |= static_cast<U32>(value[bit]) << bit;
    to.symbol(changed, sym);
    if (value[5]) intensity.write(to, short_at(last, 12), short_at(p, 12), 0);
    if (value[4]) to.symbol(returns[last[14]], p[14]);
    if (value[3]) to.symbol(classes[last[15]], p[15]);
    if (value[2]) angle.write(to, last[16], p[16], k < 3);
    if (value[1]) to.symbol(users[last[17]], p[17]);
    if (value[0]) source.write(to, short_at(last, 18), short_at(p, 18), 0);
  }
};

/// Times of item version 1: multiples of the last regular step, or all 64 bits.
struct Times1 {
  Model zero{3}, multi{512};
  Number steps{32, 6};
  I32 step = 0;
  int extreme = 0;
  void write(Stream& to, I64 last, I64 time) {
    const I64 whole = time - last;
    const auto off = static_cast<I32>(whole);
    const bool fits = off == whole;
    const auto all_bits = [&] {
      for (int part = 0; part < 4; ++part)
        to.raw(16, static_cast<U32>(static_cast<U64>(time) >> 16 * part) & 0xffff);
    };
    if (step == 0) {
      to.symbol(zero, whole == 0 ? 0 : fits ? 1 : 2);
      if (whole != 0 && !fits) all_bits();
      if (whole == 0 || !fits) return;
      steps.write(to, 0, off, 0);
      step = off;
      return;
    }
    if (whole == 0) return to.symbol(multi, 511);
    if (!fits) {
      to.symbol(multi, 510);
      return all_bits();
    }
    const I64 near = std::llround(static_cast<double>(off) / step);
    const I32 used = static_cast<I32>(std::clamp<I64>(near, 0, 509));
    to.symbol(multi, static_cast<U32>(used));
    steps.write(
        to,
        used == 0 ? step / 4 : static_cast<I32>(static_cast<U32>(used) * static_cast<U32>(step)),
        off,
        used == 1   ? 1
        : used == 0 ? 2
        : used < 10 ? 3
        : used < 50 ? 4
                    : 5);
    if (used == 1) step = off, extreme = 0;
    if ((used == 0 || used == 509) && ++extreme > 3) step = off, extreme = 0;
  }
};

/// A layer: its bytes are left out where nothing in it changes.
struct LayerOut {
  Stream stream;
  bool needed = false;
  std::string finish() { return needed ? stream.finish() : std::string(); }
};

/// Points of formats 6 to 8.
struct Points3 {
  struct Channel {
    explicit Channel(const U8* first) : last(first, first + 30), times(long_at(first + 22), false) {
      std::fill(last_z, last_z + 8, coordinate(first, 2));
      std::fill(last_intensity, last_intensity + 8, short_at(first, 12));
    }
    std::vector<U8> last;
    bool time_changed = false;
    Models changed{128}, returns{16}, numbers{16}, classes{256}, flags{64}, users{256};
    Model channel{3}, same_time{13};
    Number dx{32, 2}, dy{32, 22}, z{32, 20}, intensity{16, 4}, angle{16, 2}, source{16, 1};
    TimeCoder times;
    Median mx[12], my[12];
    I32 last_z[8];
    U32 last_intensity[8];
  };
  std::map<U32, Channel> channels;
  U32 current;
  LayerOut layers[9];

  explicit Points3(const U8* first) : current(first[15] >> 4 & 3) {
    channels.emplace(current, first);
    layers[0].needed = true;
  }
  static U32 place(int n, int r) { return (r == 1 ? 1u : 0u) + (r >= n ? 2u : 0u); }
  static U32 flags_of(const U8* p) { return (p[15] & 15u) | (p[15] >> 2 & 48u); }

  void write(const U8* p) {
    Channel* c = &channels.at(current);
    Channel& from = *c;
    const U32 model = place(c->last[14] >> 4, c->last[14] & 15) + (c->time_changed ? 4 : 0);
    const U32 to = p[15] >> 4 & 3;
    if (to != current) c = &channels.try_emplace(to, c->last.data()).first->second;
    const U8* last = c->last.data();
    const int n = p[14] >> 4, r = p[14] & 15, ln = last[14] >> 4, lr = last[14] & 15;
    const bool new_time = long_at(p + 22) != long_at(last + 22);
    const bool angle_changes = short_at(p, 18) != short_at(last, 18);
    const bool source_changes = short_at(p, 20) != short_at(last, 20);
    const int turn = (r - lr + 16) % 16;
    const U32 how = turn == 0 ? 0 : turn == 1 ? 1 : turn == 15 ? 2 : 3;
    Stream& xy = layers[0].stream;
    xy.symbol(from.changed[model], how | (n != ln ? 4u : 0u) | (angle_changes ? 8u : 0u) |
                                       (new_time ? 16u : 0u) | (source_changes ? 32u : 0u) |
                                       (to != current ? 64u : 0u));
    if (to != current) xy.symbol(from.channel, (to - current + 3) % 4);
    current = to;
    if (n != ln) xy.symbol(c->returns[static_cast<U32>(ln)], static_cast<U32>(n));
    if (how == 3 && new_time) xy.symbol(c->numbers[static_cast<U32>(lr)], static_cast<U32>(r));
    if (how == 3 && !new_time) xy.symbol(c->same_time, static_cast<U32>(turn - 2));
    const U32 m = 2 * map16(n, r) + (new_time ? 1 : 0);
    const U32 level = static_cast<U32>(std::min(std::abs(n - r), 7)), one = n == 1;
    const auto off = [&](int axis) {
      return static_cast<I32>(static_cast<U32>(coordinate(p, axis)) -
                              static_cast<U32>(coordinate(last, axis)));
    };
    c->dx.write(xy, c->mx[m].five[2], off(0), one), c->mx[m].add(off(0));
    c->dy.write(xy, c->my[m].five[2], off(1), one + even(c->dx.size, 20)), c->my[m].add(off(1));
    const U32 what = place(n, r);
    const auto layer = [&](int k, bool changes) -> Stream& {
      layers[k].needed |= changes;
      return layers[k].stream;
    };
    c->z.write(layer(1, off(2) != 0), c->last_z[level], coordinate(p, 2),
               one + even((c->dx.size + c->dy.size) / 2, 18));
    c->last_z[level] = coordinate(p, 2);
    layer(2, p[16] != last[16])
        .symbol(c->classes[(last[16] & 31u) << 1 | (what == 3 ? 1 : 0)], p[16]);
    layer(3, flags_of(p) != flags_of(last)).symbol(c->flags[flags_of(last)], flags_of(p));
    U32& light = c->last_intensity[what << 1 | (new_time ? 1u : 0u)];
    c->intensity.write(layer(4, short_at(p, 12) != short_at(last, 12)), light, short_at(p, 12),
                       what);
    light = short_at(p, 12);
    if (angle_changes)
      c->angle.write(layer(5, true), short_at(last, 18), short_at(p, 18), new_time);
    layer(6, p[17] != last[17]).symbol(c->users[last[17] / 4u], p[17]);
    if (source_changes) c->source.write(layer(7, true), short_at(last, 20), short_at(p, 20), 0);
    if (new_time) c->times.write(layer(8, true), long_at(p + 22));
    c->last.assign(p, p + 30);
    c->time_changed = new_time;
  }
};

/// Colours and extra bytes of formats 6 to 8: what was before is, in version 3, the value of the
/// channel that was left, unless the channel is new.
template <typename Coder>
struct PerChannel {
  int version;
  std::size_t size;
  std::map<U32, std::vector<U8>> last;
  std::map<U32, Coder> coders;
  U32 current;

  PerChannel(int v, std::size_t n, const U8* first, U32 channel)
      : version(v), size(n), current(channel) {
    last[current].assign(first, first + n);
  }
  template <typename Write>
  void next(const U8* p, U32 channel, Write write) {
    const bool is_new = last.count(channel) == 0;
    if (is_new) last[channel] = last[current];
    std::vector<U8>& before = last[is_new || version > 3 ? channel : current];
    current = channel;
    write(coders[channel], before.data());
    before.assign(p, p + size);
  }
};

struct NirCoder {
  Model used{4};
  Models differences{256};
};
struct Colour3 {
  ColourCoder rgb;
  NirCoder nir;
};
struct Bytes3 {
  Models differences{256};
};

std::string chunk_of(const U8* records, std::size_t length, std::size_t count, int format,
                     int version) {
  const bool timed = format == 1 || format == 3, coloured = format == 2 || format == 3;
  std::string bytes(reinterpret_cast<const char*>(records), length);
  const std::size_t colour14 = format == 7                   ? 6u
                               : format == 8 || format == 10 ? 8u
                                                             : 0u,
                    base = format >= 6 ? 30u + colour14 + (format >= 9 ? 29u : 0u)
                                       : 20u + (timed ? 8 : 0) + (coloured ? 6 : 0);
  const std::size_t extra = length - base;
  if (format >= 6) {
    Points3 points(records);
    const U32 first_channel = records[15] >> 4 & 3;
    PerChannel<Colour3> colours(version, colour14, records + 30, first_channel);
    PerChannel<Bytes3> extras(version, extra, records + base, first_channel);
    LayerOut rgb, nir;
    std::vector<LayerOut> others(extra);
    for (std::size_t i = 1; i < count; ++i) {
      const U8* p = records + i * length;
      points.write(p);
      // LASzip's version 3 hands the channel on only where it changes (LASzip issue 74).
      const U32 own = p[15] >> 4 & 3, before = p[15 - static_cast<std::ptrdiff_t>(length)] >> 4 & 3;
      const U32 channel = version > 3 || own != before ? own : 0;
      if (colour14 > 0)
        colours.next(p + 30, channel, [&](Colour3& coder, const U8* last) {
          rgb.needed |= coder.rgb.write(rgb.stream, last, p + 30);
          if (colour14 != 8) return;
          const U32 sym = (last[6] != p[36] ? 1u : 0u) | (last[7] != p[37] ? 2u : 0u);
          nir.needed |= sym != 0;
          nir.stream.symbol(coder.nir.used, sym);
          for (U32 k = 0; k < 2; ++k)
            if (sym >> k & 1)
              nir.stream.symbol(coder.nir.differences[k], static_cast<U8>(p[36 + k] - last[6 + k]));
        });
      if (extra > 0)
        extras.next(p + base, channel, [&](Bytes3& coder, const U8* last) {
          for (U32 k = 0; k < extra; ++k) {
            others[k].needed |= p[base + k] != last[k];
            others[k].stream.symbol(coder.differences[k], static_cast<U8>(p[base + k] - last[k]));
          }
        });
    }
    std::vector<std::string> layers;
    for (LayerOut& layer : points.layers) layers.push_back(layer.finish());
    if (colour14 > 0) layers.push_back(rgb.finish());
    if (colour14 == 8) layers.push_back(nir.finish());
    if (format >= 9) layers.emplace_back(3 * count, '\xC3');  // whatever an encoder writes
    for (LayerOut& layer : others) layers.push_back(layer.finish());
    bytes += packed(static_cast<U32>(count));
    for (const std::string& layer : layers) bytes += packed(static_cast<U32>(layer.size()));
    for (const std::string& layer : layers) bytes += layer;
    return bytes;
  }
  Stream to;
  Points1 points1;
  Points2 points2;
  TimeCoder times(timed ? long_at(records + 20) : 0, true);
  Times1 times1;
  ColourCoder colour;
  Model used1(64);
  Number colour1(8, 6), extra1(8, static_cast<U32>(std::max<std::size_t>(extra, 1)));
  Models differences{256};
  for (std::size_t i = 1; i < count; ++i) {
    const U8 *p = records + i * length, *last = p - length;
    version == 1 ? points1.write(to, last, p) : points2.write(to, last, p);
    if (timed)
      version == 1 ? times1.write(to, long_at(last + 20), long_at(p + 20))
                   : times.write(to, long_at(p + 20));
    const std::size_t c = timed ? 28 : 20;
    if (coloured && version == 2) colour.write(to, last + c, p + c);
    if (coloured && version == 1) {
      U32 sym = 0;
      for (U32 k = 0; k < 6; ++k) sym |= static_cast<U32>(last[c + k] != p[c + k]) << k;
      to.symbol(used1, sym);
      for (U32 k = 0; k < 6; ++k)
        if (sym >> k & 1) colour1.write(to, last[c + k], p[c + k], k);
    }
    for (U32 k = 0; k < extra; ++k)
      version == 1 ? extra1.write(to, last[base + k], p[base + k], k)
                   : to.symbol(differences[k], static_cast<U8>(p[base + k] - last[base + k]));
  }
  return bytes + to.finish();
}

}  // namespace

std::string as_laz(const std::string& las, const LazOptions& options) {
  const std::size_t data = get<U32>(las, 96), length = get<U16>(las, 105);
  const int format = las[104];
  std::size_t count = get<U32>(las, 107);
  if (las[25] == 4 && count == 0) count = get<U64>(las, 247);
  const int version = options.version != 0 ? options.version : format < 6 ? 2 : 3;

  std::vector<std::array<std::size_t, 2>> items;  // type, size
  if (format < 6) {
    items.push_back({6, 20});
    if (format == 1 || format == 3) items.push_back({7, 8});
    if (format == 2 || format == 3) items.push_back({8, 6});
  } else {
    items.push_back({10, 30});
    if (format == 7) items.push_back({11, 6});
    if (format == 8 || format == 10) items.push_back({12, 8});
    if (format >= 9) items.push_back({13, 29});
  }
  std::size_t size = 0;
  for (const auto& item : items) size += item[1];
  if (length > size) items.push_back({format < 6 ? 0u : 14u, length - size});
  std::string vlr(34, '\0');
  put_at<U16>(vlr, 0, format >= 6 ? 3 : options.chunked ? 2 : 1);
  vlr[4] = 3, vlr[5] = 4;
  put_at<U32>(vlr, 12, options.chunks.empty() ? options.chunk_points : 0xffffffff);
  put_at<I64>(vlr, 16, -1), put_at<I64>(vlr, 24, -1);
  put_at<U16>(vlr, 32, static_cast<U16>(items.size()));
  for (const auto& item : items)
    vlr += packed(static_cast<U16>(item[0])) + packed(static_cast<U16>(item[1])) +
           packed(static_cast<U16>(version));
  std::string head(54, '\0');
  std::memcpy(head.data() + 2, "laszip encoded", 14);
  put_at<U16>(head, 18, 22204), put_at<U16>(head, 20, static_cast<U16>(vlr.size()));

  std::string bytes = las.substr(0, data) + head + vlr;
  put_at<U32>(bytes, 96, static_cast<U32>(bytes.size()));
  put_at<U32>(bytes, 100, get<U32>(bytes, 100) + 1);
  bytes[104] = static_cast<char>(format | 0x80);
  const auto* records = reinterpret_cast<const U8*>(las.data()) + data;
  if (!options.chunked && format < 6)
    return bytes + chunk_of(records, length, count, format, version);
  const std::size_t place = bytes.size();
  bytes += packed(I64{-1});
  std::vector<std::array<U32, 2>> chunks;  // points, bytes
  for (std::size_t begin = 0; begin < count;) {
    const std::size_t wanted = options.chunks.empty()
                                   ? options.chunk_points
                                   : options.chunks[chunks.size() % options.chunks.size()];
    const std::size_t points = std::min(wanted, count - begin);
    const std::string chunk = chunk_of(records + begin * length, length, points, format, version);
    bytes += chunk;
    chunks.push_back({static_cast<U32>(points), static_cast<U32>(chunk.size())});
    begin += points;
  }
  const auto table = static_cast<I64>(bytes.size());
  Stream to;
  Number numbers(32, 2);
  for (std::size_t k = 0; k < chunks.size(); ++k)
    for (const U32 which : {0u, 1u})
      if (which == 1 || !options.chunks.empty())
        numbers.write(to, k == 0 ? 0 : static_cast<I32>(chunks[k - 1][which]),
                      static_cast<I32>(chunks[k][which]), which);
  bytes += packed(U32{0}) + packed(static_cast<U32>(chunks.size())) + to.finish();
  if (options.table_at_end)
    bytes += packed(table);
  else
    put_at<I64>(bytes, place, table);
  return bytes;
}

std::string busy_las(int format, std::size_t extra_bytes, std::size_t points, unsigned seed,
                     unsigned channels) {
  constexpr std::size_t kLength[] = {20, 28, 26, 34, 0, 0, 30, 36, 38, 59, 67};
  const std::size_t length = kLength[format] + extra_bytes;
  const U16 header = format < 6 ? 227 : 375;
  std::string las(header, '\0');
  std::memcpy(las.data(), "LASF", 4);
  las[24] = 1, las[25] = format < 6 ? 2 : 4;
  put_at<U16>(las, 94, header), put_at<U32>(las, 96, header);
  las[104] = static_cast<char>(format);
  put_at<U16>(las, 105, static_cast<U16>(length));
  put_at<U32>(las, 107, format < 6 ? static_cast<U32>(points) : 0);
  if (format >= 6) put_at<U64>(las, 247, points);
  for (std::size_t axis = 0; axis < 3; ++axis) put_at(las, 131 + 8 * axis, 0.001);

  std::mt19937 random(seed);
  const auto up_to = [&](I32 most) {
    return static_cast<I32>(random() % (static_cast<U32>(most) + 1));
  };
  const auto about = [&](I32 most) { return up_to(2 * most) - most; };
  const auto one_in = [&](I32 many) { return up_to(many - 1) == 0; };
  const int most_returns = format < 6 ? 7 : 15;
  std::string p(length, '\0');
  std::vector<U16> colour{100, 200, 300, 400};
  double time = 1000.0;
  int number = 1, returns = 1;
  unsigned channel = static_cast<unsigned>(up_to(3)) % channels;
  int flags = 0, angle = 0;
  for (std::size_t i = 0; i < points; ++i) {
    if (number >= returns || one_in(50)) {
      returns = one_in(2) ? 1 : 1 + up_to(most_returns - 1);
      number = 1;
      if (one_in(50)) number = up_to(most_returns), returns = up_to(most_returns);
      constexpr double kSteps[] = {1, 1, 1, 1, 2, 3, 0.4, 12, 1000, -3, -20, 0};
      time += 1e-5 * kSteps[up_to(11)];
      if (one_in(20)) time = std::array{5.0, 1000.0, 2e8, -4.0}[random() % 4] + 0.001 * up_to(1000);
    } else {
      ++number;
    }
    if (one_in(20)) channel = random() % channels;
    const I32 reach = one_in(10) ? std::array{3, 300, 30000, 3000000}[random() % 4] : 20;
    for (std::size_t axis = 0; axis < 3; ++axis)
      put_at(p, 4 * axis,
             one_in(300) ? static_cast<U32>(random())
                         : get<U32>(p, 4 * axis) + static_cast<U32>(about(reach)));
    if (!one_in(3)) put_at(p, 12, static_cast<U16>(get<U16>(p, 12) + about(30)));
    if (one_in(10)) flags = up_to(63);
    if (one_in(3)) angle = std::clamp(angle + about(50), -30000, 30000);
    const bool new_class = one_in(10), new_user = one_in(10), new_source = one_in(20);
    const auto any = [&] { return static_cast<char>(random()); };
    if (format < 6) {
      p[14] = static_cast<char>((number & 7) | (returns & 7) << 3 | (flags & 3) << 6);
      if (new_class) p[15] = any();
      p[16] = static_cast<char>(angle / 300);
      if (new_user) p[17] = any();
      if (new_source) put_at(p, 18, static_cast<U16>(random()));
      if (format % 2 == 1) put_at(p, 20, time);
    } else {
      p[14] = static_cast<char>(number | returns << 4);
      p[15] = static_cast<char>((flags & 15) | static_cast<int>(channel) << 4 | (flags & 48) << 2);
      if (new_class) p[16] = any();
      if (new_user) p[17] = any();
      put_at(p, 18, static_cast<std::int16_t>(angle));
      if (new_source) put_at(p, 20, static_cast<U16>(random()));
      put_at(p, 22, time);
    }
    const int shade = about(10) * (one_in(2) ? 257 : 1);
    for (U16& c : colour)
      if (!one_in(3)) c = static_cast<U16>(c + shade + about(3));
    if (one_in(10)) colour[1] = colour[2] = colour[0];
    const std::size_t colours = format == 8 || format == 10                 ? 4
                                : format == 2 || format == 3 || format == 7 ? 3
                                                                            : 0;
    const std::size_t wave = format >= 9 ? 29 : 0;
    for (std::size_t k = 0; k < colours; ++k)
      put_at(p, kLength[format] - wave - 2 * colours + 2 * k, colour[k]);
    for (std::size_t k = 0; k < wave; ++k) p[kLength[format] - wave + k] = any();
    for (std::size_t k = 0; k < extra_bytes; ++k)  // the second stays as it is
      if (k != 1 && one_in(3))
        p[kLength[format] + k] = static_cast<char>(p[kLength[format] + k] + about(3));
    las += p;
  }
  return las;
}

}  // namespace support
