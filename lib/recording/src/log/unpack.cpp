#include "unpack.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "base/error.h"

namespace recording {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 17;

[[noreturn]] void cannot_unpack(const char* packer, const char* what) {
  throw base::Error(fmt::format("packed by {}, and {}", packer, what));
}

/// Makes room for the next bytes; refuses what holds more than `most`.
void more_room(std::string& out, std::size_t filled, std::size_t most, const char* packer) {
  if (filled > most)
    cannot_unpack(packer, "more than was stated or than a log can be; it is damaged");
  if (out.size() - filled < kStep / 2) out.resize(filled + std::max(kStep, filled / 2));
}

}  // namespace

bool is_zstd(std::string_view bytes) { return bytes.starts_with("\x28\xb5\x2f\xfd"); }

std::string unpack_zstd(std::string_view bytes, std::size_t most) {
  const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                          ZSTD_freeDStream);
  if (!stream) cannot_unpack("zstd", "there is no memory to unpack it");
  ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, 27);
  std::string out;
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  std::size_t filled = 0, left = bytes.empty() ? 0 : 1;
  while (left != 0 || in.pos < in.size) {
    more_room(out, filled, most, "zstd");
    ZSTD_outBuffer to{out.data(), out.size(), filled};
    const std::size_t in_before = in.pos;
    left = ZSTD_decompressStream(stream.get(), &to, &in);
    if (ZSTD_isError(left) != 0) cannot_unpack("zstd", ZSTD_getErrorName(left));
    if (left != 0 && in.pos == in_before && to.pos == filled) cannot_unpack("zstd", "cut off");
    filled = to.pos;
  }
  if (filled > most) more_room(out, filled, most, "zstd");
  out.resize(filled);
  return out;
}

std::string unpack_lz4(std::string_view bytes, std::size_t most) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0)
    cannot_unpack("LZ4", "there is no memory to unpack it");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, LZ4F_freeDecompressionContext);
  std::string out;
  std::size_t filled = 0, at = 0, left = bytes.empty() ? 0 : 1;
  while (left != 0 || at < bytes.size()) {
    more_room(out, filled, most, "LZ4");
    std::size_t written = out.size() - filled, read = bytes.size() - at;
    left = LZ4F_decompress(context.get(), out.data() + filled, &written, bytes.data() + at, &read,
                           nullptr);
    if (LZ4F_isError(left) != 0) cannot_unpack("LZ4", LZ4F_getErrorName(left));
    if (left != 0 && written == 0 && read == 0) cannot_unpack("LZ4", "cut off");
    filled += written;
    at += read;
  }
  if (filled > most) more_room(out, filled, most, "LZ4");
  out.resize(filled);
  return out;
}

}  // namespace recording
