// The entropy coder of .laz: adaptive arithmetic coding of symbols and of integers as corrections
// of a prediction. Sources: A. Said 2004, "Introduction to Arithmetic Coding", HPL-2004-76; ASPRS
// "LAZ Specification 1.4 R1", sections on entropy coding.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace cloud::laz {

/// A stream that no encoder writes; `at` is the first byte not understood.
struct Damage {
  const char* what;
  const char* at;
};

/// What is left of a stream: `value` lies in [0, length).
class Decoder {
 public:
  Decoder() = default;
  /// Throws Damage where there are fewer than four bytes.
  explicit Decoder(std::string_view bytes)
      : here_(bytes.data()), end_(bytes.data() + bytes.size()) {
    for (int k = 0; k < 4; ++k) value = value << 8 | byte();
    if (value == length) throw Damage{"no arithmetic code", here_};
  }

  /// `count` bits (1 to 32), all values equally likely.
  std::uint32_t bits(unsigned count) {
    if (count > 19) {
      const std::uint32_t low = bits(16);
      return bits(count - 16) << 16 | low;
    }
    length >>= count;
    const std::uint32_t found = value / length;
    if (found >> count != 0) throw Damage{"no arithmetic code", here_};
    value -= found * length;
    refill();
    return found;
  }
  void refill() {
    while (length < 1u << 24) {
      value = value << 8 | byte();
      length <<= 8;
    }
  }
  bool is_open() const { return here_ != nullptr; }
  const char* here() const { return here_; }
  std::size_t left() const { return static_cast<std::size_t>(end_ - here_); }

  std::uint32_t value = 0, length = 0xffffffff;

 private:
  std::uint32_t byte() {
    if (here_ == end_) throw Damage{"truncated: the points go on, their bytes end", here_};
    return static_cast<std::uint8_t>(*here_++);
  }
  const char *here_ = nullptr, *end_ = nullptr;
};

/// One of `symbols` symbols (2 to 1024), as often as they came before. Memory comes with first use.
class Symbols {
 public:
  explicit Symbols(unsigned symbols) : symbols_(symbols) {}

  unsigned decode(Decoder& from) {
    if (begin_.empty()) start();
    const std::uint32_t step = from.length >> kBits;
    const std::uint32_t place = from.value / step;
    unsigned low = 0, high = symbols_;  // the symbol lies in [low, high)
    if (!table_.empty()) {
      const std::uint32_t row = place >> shift_;
      low = table_[row];
      high = table_[row + 1] + 1u;
    }
    while (high > low + 1) {
      const unsigned middle = (low + high) / 2;
      (begin_[middle] > place ? high : low) = middle;
    }
    const std::uint32_t below = begin_[low] * step;
    // The last symbol gets what rounding leaves.
    from.length = (low + 1 < symbols_ ? begin_[low + 1] * step : from.length) - below;
    from.value -= below;
    from.refill();
    ++counts_[low];
    if (--until_update_ == 0) update();
    return low;
  }

 private:
  static constexpr unsigned kBits = 15;  // of the cumulative distribution

  void start() {
    counts_.assign(symbols_, 1);
    begin_.resize(symbols_);
    if (symbols_ > 16) {
      unsigned bits = 3;
      while (symbols_ > 1u << (bits + 2)) ++bits;
      table_.resize((std::size_t{1} << bits) + 2);
      shift_ = kBits - bits;
    }
    cycle_ = symbols_;
    update();
    until_update_ = cycle_ = (symbols_ + 6) / 2;
  }

  void update() {
    total_ += cycle_;
    if (total_ > 1u << kBits) {
      total_ = 0;
      for (std::uint32_t& count : counts_) total_ += count = (count + 1) / 2;
    }
    const std::uint32_t scale = (1u << 31) / total_;
    std::uint32_t sum = 0;
    std::size_t row = 0;
    for (unsigned k = 0; k < symbols_; ++k) {
      begin_[k] = scale * sum >> (31 - kBits);
      sum += counts_[k];
      // Row r of the table: the last symbol that begins in a row before r.
      if (!table_.empty())
        for (const std::size_t its_row = begin_[k] >> shift_; row < its_row;)
          table_[++row] = static_cast<std::uint16_t>(k - 1);
    }
    if (!table_.empty())
      while (row + 1 < table_.size()) table_[++row] = static_cast<std::uint16_t>(symbols_ - 1);
    cycle_ = std::min(5 * cycle_ / 4, 8 * (symbols_ + 6));
    until_update_ = cycle_;
  }

  unsigned symbols_, shift_ = 0;
  std::uint32_t total_ = 0, cycle_ = 0, until_update_ = 0;
  std::vector<std::uint32_t> begin_, counts_;  // of each symbol
  std::vector<std::uint16_t> table_;           // empty for few symbols
};

/// 0 or 1.
class Bit {
 public:
  unsigned decode(Decoder& from) {
    const std::uint32_t below = zero_share_ * (from.length >> kBits);
    const bool one = from.value >= below;
    if (one) {
      from.value -= below;
      from.length -= below;
    } else {
      from.length = below;
      ++zeros_;
    }
    from.refill();
    if (--until_update_ == 0) update();
    return one;
  }

 private:
  static constexpr unsigned kBits = 13;

  void update() {
    total_ += cycle_;
    if (total_ > 1u << kBits) {
      total_ = (total_ + 1) / 2;
      zeros_ = (zeros_ + 1) / 2;
      if (zeros_ == total_) ++total_;
    }
    zero_share_ = zeros_ * ((1u << 31) / total_) >> (31 - kBits);
    cycle_ = std::min(5 * cycle_ / 4, 64u);
    until_update_ = cycle_;
  }

  std::uint32_t zeros_ = 1, total_ = 2, zero_share_ = 1u << (kBits - 1);
  std::uint32_t cycle_ = 4, until_update_ = 4;
};

/// Integers modulo 2^bits (bits: 8, 16 or 32), near a prediction.
class Integers {
 public:
  Integers(unsigned bits, std::size_t contexts) : bits_(bits), sizes_(contexts, Symbols(bits + 1)) {
    for (unsigned k = 1; k <= bits; ++k) corrections_.emplace_back(1u << std::min(k, kCoded));
  }

  std::uint32_t decode(Decoder& from, std::uint32_t prediction, std::size_t context) {
    return prediction + correction(from, context);
  }
  /// The last correction lay in [-2^k + 1, 2^k].
  unsigned k() const { return k_; }

 private:
  static constexpr unsigned kCoded = 8;  // leading bits of a correction; the others are raw

  std::uint32_t correction(Decoder& from, std::size_t context) {
    k_ = sizes_[context].decode(from);
    if (k_ == 0) return zero_or_one_.decode(from);
    if (k_ == 32) return 1u << 31;
    std::uint32_t found = corrections_[k_ - 1].decode(from);
    if (k_ > kCoded) found = found << (k_ - kCoded) | from.bits(k_ - kCoded);
    // 0, 1, ... stand for the negative half from -2^k + 1 up, then for 2^(k-1) + 1 and up.
    return found < 1u << (k_ - 1) ? found - ((1u << k_) - 1) : found + 1;
  }

  unsigned bits_, k_ = 0;
  std::vector<Symbols> sizes_;        // per context: k
  std::vector<Symbols> corrections_;  // per k
  Bit zero_or_one_;
};

}  // namespace cloud::laz
