#include "report/track_report.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "report_data.h"

#ifdef KERBSTONE_PAGE
asm(".section .rodata\n"
    ".global kerbstone_page_begin\n"
    ".global kerbstone_page_end\n"
    "kerbstone_page_begin:\n"
    ".incbin \"" KERBSTONE_PAGE
    "\"\n"
    "kerbstone_page_end:\n"
    ".byte 0\n"
    ".previous\n");
extern "C" const char kerbstone_page_begin[];
extern "C" const char kerbstone_page_end[];
#endif

namespace report {
namespace {

static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");

std::string base64(const void* data, std::size_t size) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::string text(4 * ((size + 2) / 3), '=');
  char* out = text.data();
  for (std::size_t k = 0; k < size; k += 3) {
    const std::uint32_t left = static_cast<std::uint32_t>(std::min<std::size_t>(3, size - k));
    std::uint32_t word = static_cast<std::uint32_t>(bytes[k]) << 16U;
    if (left > 1) word |= static_cast<std::uint32_t>(bytes[k + 1]) << 8U;
    if (left > 2) word |= bytes[k + 2];
    for (std::uint32_t digit = 0; digit <= left; ++digit)
      *out++ = kDigits[(word >> (18U - 6U * digit)) & 63U];
    out += 3 - left;
  }
  return text;
}

std::string deflated(const std::vector<unsigned char>& bytes) {
  constexpr int kLevel = 6;
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<unsigned char> out(size);
  if (compress2(out.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), kLevel) != Z_OK)
    throw std::logic_error("zlib: the report's numbers could not be packed");
  return base64(out.data(), size);
}

/// Integers as differences from the one before, all as planes of their first, second ... bytes:
/// rows of a road are smooth, so that what is left packs to a fifth.
template <typename T>
Json packed(std::vector<T> values) {
  static_assert(std::is_same_v<T, float> || std::is_same_v<T, std::int16_t>);
  if constexpr (std::is_same_v<T, std::int16_t>)
    for (std::size_t k = values.size(); k-- > 1;)
      values[k] = static_cast<std::int16_t>(static_cast<std::uint16_t>(values[k]) -
                                            static_cast<std::uint16_t>(values[k - 1]));
  const std::size_t count = values.size();
  std::vector<unsigned char> raw(count * sizeof(T)), planes(raw.size());
  if (count > 0) std::memcpy(raw.data(), values.data(), raw.size());
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t p = 0; p < sizeof(T); ++p) planes[p * count + k] = raw[k * sizeof(T) + p];
  return {{"type", std::is_same_v<T, float> ? "f32" : "i16"}, {"data", deflated(planes)}};
}

constexpr std::int16_t kMissing = std::numeric_limits<std::int16_t>::min();
constexpr std::int16_t kNothingToCompareWith = kMissing + 1;

/// value = begin[row] + step * integer; kMissing: NaN. The step is the smallest that spans every
/// row, but no finer than `finest`.
Json packed_rows(const std::vector<float>& values, std::size_t columns, bool row_offsets,
                 float finest = 1e-5f, const std::vector<std::uint8_t>* without = nullptr) {
  const std::size_t rows = columns > 0 ? values.size() / columns : 0;
  std::vector<float> begin(rows, 0.0f);
  float reach = 0.0f;
  for (std::size_t i = 0; i < rows; ++i) {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (std::size_t k = i * columns; k < (i + 1) * columns; ++k) {
      if (!std::isfinite(values[k])) continue;
      low = std::min(low, values[k]);
      high = std::max(high, values[k]);
    }
    if (low > high) continue;
    if (row_offsets) begin[i] = 0.5f * (low + high);
    reach = std::max({reach, std::abs(low - begin[i]), std::abs(high - begin[i])});
  }
  const float step = std::max({finest, reach / 32766.0f, 1e-30f});
  std::vector<std::int16_t> integers(values.size(), kMissing);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k]))
      integers[k] = static_cast<std::int16_t>(std::lround((values[k] - begin[k / columns]) / step));
    else if (without != nullptr && (*without)[k] != 0)
      integers[k] = kNothingToCompareWith;
  }
  Json json = {{"step", step}, {"values", packed(std::move(integers))}};
  if (row_offsets) json["begin"] = packed(std::move(begin));
  return json;
}

/// A curve in blocks that begin anew: fine steps where it runs far. The last block is padded.
Json packed_curve(std::vector<float> values) {
  constexpr std::size_t kBlock = 64;
  const std::size_t count = values.size();
  values.resize((count + kBlock - 1) / kBlock * kBlock, std::numeric_limits<float>::quiet_NaN());
  Json json = packed_rows(values, kBlock, true, 0.0f);
  json["columns"] = kBlock;
  json["count"] = count;
  return json;
}

std::vector<float> floats(const std::vector<double>& values, double base = 0.0) {
  std::vector<float> result;
  result.reserve(values.size());
  for (const double value : values) result.push_back(static_cast<float>(value - base));
  return result;
}

/// A thirtieth of what is usual: colours show no more.
float shown_step(std::vector<float> errors) {
  std::erase_if(errors, [](float error) { return !std::isfinite(error); });
  for (float& error : errors) error = std::abs(error);
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  if (middle == errors.end()) return 1e-7f;
  std::nth_element(errors.begin(), middle, errors.end());
  return std::max(1e-7f, *middle / 20.0f);
}

/// Heights of a sheet: no finer than its picture shows.
Json sheet_json(const Sheet& sheet, double x_base_m, double y_base_m, float finest_m) {
  Json fields = Json::array();
  for (const SheetField& field : sheet.fields) {
    fields.push_back(
        {{"key", field.key},
         {"name", field.name},
         {"unit", field.unit},
         {"show_factor", field.show_factor},
         {"signed_scale", field.signed_scale},
         {"categories", field.categories},
         {"values",
          packed_rows(field.values, sheet.v_m.size(), false,
                      field.key.starts_with("error_") ? shown_step(field.values) : 1e-5f)}});
  }
  return {{"title", sheet.title},
          {"u_begin_m", sheet.u_begin_m},
          {"u_step_m", sheet.u_step_m},
          {"rows", sheet.x_m.size()},
          {"x", packed(floats(sheet.x_m, x_base_m))},
          {"y", packed(floats(sheet.y_m, y_base_m))},
          {"normal_x", packed(floats(sheet.normal_x))},
          {"normal_y", packed(floats(sheet.normal_y))},
          {"v_m", numbers(sheet.v_m)},
          {"z_base_m", sheet.z_base_m},
          {"z", packed_rows(sheet.z_m, sheet.v_m.size(), true, finest_m)},
          {"fields", std::move(fields)}};
}

/// JSON inside a script element: no character that could end it or open a comment.
std::string escaped_for_script(const std::string& json) {
  std::string safe;
  safe.reserve(json.size() + json.size() / 64);
  for (const char c : json) {
    switch (c) {
      case '<':
        safe += "\\u003c";
        break;
      case '>':
        safe += "\\u003e";
        break;
      case '&':
        safe += "\\u0026";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string_view page_template() {
#ifdef KERBSTONE_PAGE
  return {kerbstone_page_begin,
          static_cast<std::size_t>(kerbstone_page_end - kerbstone_page_begin)};
#else
  return {};
#endif
}

}  // namespace

bool page_available() { return !page_template().empty(); }

std::string report_page(const TrackReport& report) {
  if (!page_available())
    throw std::logic_error(
        "this build has no report page: run scripts/setup, configure and build again");
  Json json = common_json(report);
  const double x_base_m = report.sheet.x_m.empty() ? 0.0 : std::round(report.sheet.x_m.front());
  const double y_base_m = report.sheet.y_m.empty() ? 0.0 : std::round(report.sheet.y_m.front());
  json["x_base_m"] = x_base_m;
  json["y_base_m"] = y_base_m;
  json["sheet"] = sheet_json(report.sheet, x_base_m, y_base_m, 1e-4f);
  const Sheet& detail = report.detail;
  json["detail"] = detail.z_m.empty()
                       ? Json(nullptr)
                       : Json{{"u_begin_m", detail.u_begin_m},
                              {"u_step_m", detail.u_step_m},
                              {"v_m", numbers(detail.v_m)},
                              {"z_base_m", detail.z_base_m},
                              {"z", packed_rows(detail.z_m, detail.v_m.size(), true)}};
  json["windows"] = Json::array();
  for (const Sheet& window : report.windows)
    json["windows"].push_back(sheet_json(window, x_base_m, y_base_m, 2e-5f));
  for (std::size_t k = 0; k < report.roughness.size(); ++k)
    json["roughness"][k]["psd"] = {{"n_cpm", packed(floats(report.roughness[k].n_cpm))},
                                   {"psd_m3", packed(floats(report.roughness[k].psd_m3))}};
  json["curves"] = Json::array();
  for (const Curve& curve : report.curves) {
    json["curves"].push_back({{"key", curve.key},
                              {"name", curve.name},
                              {"unit", curve.unit},
                              {"show_factor", curve.show_factor},
                              {"values", packed_curve(curve.values)}});
  }
  for (std::size_t k = 0; k < report.comparisons.size(); ++k) {
    const ComparisonView& c = report.comparisons[k];
    json["comparisons"][k]["map"] = {
        {"u_begin_m", c.u_begin_m},
        {"u_cell_m", c.u_cell_m},
        {"rows", c.rows},
        {"v_m", numbers(c.v_m)},
        {"error", packed_rows(c.error_m, c.v_m.size(), false, shown_step(c.error_m),
                              c.without_reference.size() == c.error_m.size() ? &c.without_reference
                                                                             : nullptr)}};
  }
  static constexpr std::string_view kSlot = "@REPORT_DATA@";
  const std::string_view page = page_template();
  const std::size_t at = page.find(kSlot);
  if (at == std::string_view::npos)
    throw std::logic_error("the report page has no place for its data");
  const std::string data = escaped_for_script(dump(json, -1));
  std::string html;
  html.reserve(page.size() + data.size());
  html.append(page.substr(0, at));
  html.append(data);
  html.append(page.substr(at + kSlot.size()));
  return html;
}

}  // namespace report
