#include <csetjmp>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "report/picture.h"

// After the C headers that it needs.
#include <jpeglib.h>

namespace report {
namespace {

constexpr int kMostScans = 32;  // pictures in use have about ten
constexpr long kMostMemory = 160'000'000;

/// libjpeg's structure, and where it leaves to.
struct Reader {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf leave{};
  char reason[JMSG_LENGTH_MAX] = "";
};

Reader& reader_of(j_common_ptr jpeg) { return *static_cast<Reader*>(jpeg->client_data); }

[[noreturn]] void leave(j_common_ptr jpeg) {
  Reader& reader = reader_of(jpeg);
  jpeg->err->format_message(jpeg, reader.reason);
  std::longjmp(reader.leave, 1);
}

void begin(Reader& reader, std::string_view bytes) {
  jpeg_decompress_struct& jpeg = reader.jpeg;
  jpeg.err = jpeg_std_error(&reader.errors);
  jpeg.client_data = &reader;
  reader.errors.error_exit = leave;
  reader.errors.emit_message = [](j_common_ptr common, int level) {
    if (level < 0) leave(common);  // damaged, though it could be guessed at
  };
  reader.errors.output_message = [](j_common_ptr) {};
  jpeg_create_decompress(&jpeg);
  jpeg.client_data = &reader;  // a newer libjpeg clears it
  jpeg.mem->max_memory_to_use = kMostMemory;
  jpeg.progress = &reader.progress;
  reader.progress.progress_monitor = [](j_common_ptr common) {
    Reader& seen = reader_of(common);
    if (seen.jpeg.input_scan_number <= kMostScans) return;
    std::snprintf(seen.reason, sizeof seen.reason, "more than %d scans", kMostScans);
    std::longjmp(seen.leave, 1);
  };
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()),
               static_cast<unsigned long>(bytes.size()));
}

// libjpeg leaves by longjmp, so nothing in these may need a destructor.
bool read_header(Reader& reader, std::string_view bytes) {
  if (setjmp(reader.leave)) return false;
  begin(reader, bytes);
  jpeg_read_header(&reader.jpeg, TRUE);
  return true;
}

bool start(Reader& reader) {
  if (setjmp(reader.leave)) return false;
  reader.jpeg.scale_num = 1;
  reader.jpeg.scale_denom = 8;
  reader.jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&reader.jpeg);
  return true;
}

/// `row`: room for one, `rgba`: for all.
bool read_rows(Reader& reader, JSAMPROW row, std::uint8_t* rgba) {
  if (setjmp(reader.leave)) return false;
  jpeg_decompress_struct& jpeg = reader.jpeg;
  while (jpeg.output_scanline < jpeg.output_height) {
    std::uint8_t* to = rgba + std::size_t{4} * jpeg.output_width * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
    for (std::size_t k = 0; k < jpeg.output_width; ++k, to += 4) {
      to[0] = row[3 * k], to[1] = row[3 * k + 1], to[2] = row[3 * k + 2], to[3] = 255;
    }
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

}  // namespace

Picture decode_jpeg_eighth(std::string_view bytes, std::size_t most_pixels) {
  Reader reader;
  struct Closed {  // also what was never begun
    jpeg_decompress_struct& jpeg;
    ~Closed() {
      if (jpeg.mem != nullptr) jpeg_destroy_decompress(&jpeg);
    }
  } const closed{reader.jpeg};
  const auto damaged = [&] {
    return std::invalid_argument(std::string("a damaged JPEG: ") + reader.reason);
  };
  if (!read_header(reader, bytes)) throw damaged();
  const jpeg_decompress_struct& jpeg = reader.jpeg;
  if (std::size_t{jpeg.image_width} * jpeg.image_height > most_pixels)
    throw std::invalid_argument("a picture of " + std::to_string(jpeg.image_width) + " x " +
                                std::to_string(jpeg.image_height) + " pixels; wanted at most " +
                                std::to_string(most_pixels) + " in all");
  if (jpeg.num_components != 1 && jpeg.num_components != 3)
    throw std::invalid_argument("a JPEG of " + std::to_string(jpeg.num_components) +
                                " channels; wanted 1 or 3");
  if (!start(reader)) throw damaged();
  Picture picture{static_cast<int>(jpeg.output_width), static_cast<int>(jpeg.output_height), {}};
  picture.rgba.resize(std::size_t{4} * jpeg.output_width * jpeg.output_height);
  std::vector<std::uint8_t> row(std::size_t{3} * jpeg.output_width);
  if (!read_rows(reader, row.data(), picture.rgba.data())) throw damaged();
  return picture;
}

}  // namespace report
