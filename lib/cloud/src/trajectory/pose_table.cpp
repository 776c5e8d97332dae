#include "pose_table.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <vector>

#include "base/read_file.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr std::size_t kTum = 8, kKitti = 12;
const char* const kWanted = "time_s,x_m,y_m,z_m,qx,qy,qz,qw";

/// Of a line between blanks; empty where any of them is none.
std::vector<double> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  for (std::string_view word = base::take_word(line); !word.empty(); word = base::take_word(line)) {
    const std::optional<double> number = base::to_number<double>(word);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/// Of the first line that is no remark.
std::size_t numbers_in_first_row(std::string_view text) {
  base::Lines lines(text);
  std::string_view line;
  while (lines.next(line))
    if (!base::is_blank_or_remark(line)) return numbers_of(line).size();
  return 0;
}

base::CsvTable tum_table(std::string_view text, const std::string& path) {
  base::CsvTable table;
  table.columns = kTum;
  table.names = {"time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"};
  table.present.assign(kTum, true);
  base::Lines lines(text);
  std::string_view line;
  while (lines.next(line)) {
    if (base::is_blank_or_remark(line)) continue;
    const std::vector<double> numbers = numbers_of(line);
    if (numbers.size() != kTum)
      throw Error(fmt::format("{}:{}: '{:.80}' seen, eight numbers wanted: time x y z qx qy qz qw",
                              path, lines.number(), base::trimmed(line)));
    table.values.insert(table.values.end(), numbers.begin(), numbers.end());
    table.line.push_back(lines.number());
  }
  return table;
}

}  // namespace

base::CsvTable pose_table(const std::string& path) {
  const std::string bytes = base::read_file(path);
  if (std::string_view(bytes).substr(0, 4096).find('\0') != std::string_view::npos &&
      !bytes.starts_with("\xFF\xFE") && !bytes.starts_with("\xFE\xFF"))
    throw Error(fmt::format(
        "{}: is binary{}; export the poses as text in the map's frame, metres, and name the "
        "columns {}",
        path,
        bytes.size() % 136 == 0 ? ", as a trajectory in SBET is (latitude and longitude in radians)"
                                : "",
        kWanted));
  const std::string_view text = base::behind_byte_order_mark(bytes, path);
  const std::size_t numbers = numbers_in_first_row(text);
  if (numbers == kTum) return tum_table(text, path);
  if (numbers == kKitti)
    throw Error(
        fmt::format("{}: twelve numbers a line, as poses of KITTI, which have no times; join them "
                    "with those of "
                    "its times.txt to a CSV with the columns {}",
                    path, kWanted));
  return base::read_csv(path, {"time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"});
}

}  // namespace cloud
