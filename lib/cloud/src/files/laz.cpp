// Source: ASPRS/rapidlasso "LAZ Specification 1.4 R1"; M. Isenburg 2013, "LASzip: lossless
// compression of LiDAR data", PE&RS 79(2). Item versions 1 and 2 share one stream per chunk, a
// field after the other; versions 3 and 4 have a stream per field (a layer) and models per scanner
// channel.
#include "laz.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "cloud/error.h"
#include "laz_item.h"

namespace cloud {
namespace {

using laz::Byte;
using laz::Damage;
using laz::Decoder;
using laz::Integers;
using laz::Item;
using laz::ItemKind;

/// Type and size of the items that a record has.
std::vector<ItemKind> items_of(int format, std::size_t length) {
  std::vector<ItemKind> items;
  std::size_t size = 0;
  const auto add = [&](unsigned type, unsigned bytes) {
    items.push_back({type, bytes, 0});
    size += bytes;
  };
  if (format < 6) {
    add(laz::kP10, 20);
    if (format == 1 || format == 3) add(laz::kGps11, 8);
    if (format == 2 || format == 3) add(laz::kRgb12, 6);
  } else {
    add(laz::kP14, 30);
    if (format == 7) add(laz::kRgb14, 6);
    if (format == 8 || format == 10) add(laz::kRgbNir14, 8);
    if (format >= 9) add(laz::kWave14, 29);
  }
  if (length > size)
    add(format < 6 ? laz::kBytes : laz::kBytes14, static_cast<unsigned>(length - size));
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
    return laz::load<T>(file.data() + at);
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
  if (vlr.size() < 34 ||
      vlr.size() < 34 + 6 * std::size_t{laz::load<std::uint16_t>(vlr.data() + 32)})
    throw fail(at, fmt::format("the record 'laszip encoded' has {} bytes, 34 and 6 per item wanted",
                               vlr.size()));
  const auto compressor = laz::load<std::uint16_t>(vlr.data()),
             coder = laz::load<std::uint16_t>(vlr.data() + 2);
  const auto chunk_points = laz::load<std::uint32_t>(vlr.data() + 12);
  const std::size_t count = laz::load<std::uint16_t>(vlr.data() + 32);
  if (compressor < 1 || compressor > 3 || coder != 0)
    throw fail(at, fmt::format("compressor {} with coder {} seen; 1, 2 or 3 with coder 0 wanted; "
                               "unpack the file with 'laszip -i in.laz -o out.las'",
                               compressor, coder));
  layered = compressor == 3;
  kinds = items_of(layout.format, layout.length);
  bool fits = count == kinds.size() && layered == (layout.format >= 6);
  for (std::size_t k = 0; fits && k < count; ++k) {
    const char* const item = vlr.data() + 34 + 6 * k;
    kinds[k].version = laz::load<std::uint16_t>(item + 4);
    fits = laz::load<std::uint16_t>(item) == kinds[k].type &&
           laz::load<std::uint16_t>(item + 2) == kinds[k].size;
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
  std::vector<bool> is_read;
  for (const ItemKind& kind : kinds)
    is_read.insert(is_read.end(), laz::layers_of(kind), kind.type != laz::kWave14);
  const std::size_t layers = is_read.size();
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
    if (size > 0 && is_read[k]) decoders[k] = Decoder(file.substr(begin, size));
    begin += size;
  }
  if (!decoders.front().is_open()) throw fail(at, "a chunk without positions; copy the file again");
}

void LazReader::State::make_items() {
  items.clear();
  Byte* field = reinterpret_cast<Byte*>(record.data());
  Decoder* decoder = decoders.data();
  channel = layered ? field[laz::kFlags14] >> 4 & 3u : 0;
  for (const ItemKind& kind : kinds) {
    items.push_back(layered ? laz::layered_item(kind, decoder, field, channel)
                            : laz::shared_stream_item(kind, *decoder, field));
    field += kind.size;
    if (layered) decoder += laz::layers_of(kind);
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
