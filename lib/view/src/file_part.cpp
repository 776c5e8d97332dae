#include "file_part.h"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "base/text_lines.h"
#include "wish.h"

namespace view {

std::string part_of_file(const std::string& path, const std::string& begin,
                         const std::string& bytes) {
  constexpr std::uint64_t kMost = 16'000'000;
  if (std::filesystem::path(path).extension() != ".tiles")
    throw Refusal(403, "not a kind of file that is shown in parts");
  const auto from = base::to_number<std::uint64_t>(begin),
             count = base::to_number<std::uint64_t>(bytes);
  if (!from || !count) throw Refusal(400, "begin and bytes: whole numbers wanted");
  if (*count > kMost)
    throw Refusal(400, fmt::format("bytes: {} seen, at most {} wanted", *count, kMost));
  const std::uint64_t size = std::filesystem::file_size(path);
  if (*from > size || *count > size - *from)
    throw Refusal(416, fmt::format("bytes {} to {} of {} wanted: the points are not those of this "
                                   "index; make the tiles again",
                                   *from, *from + *count, size));
  std::string out(*count, '\0');
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(*from));
  if (!file.read(out.data(), static_cast<std::streamsize>(out.size())))
    throw Refusal(422, "the file cannot be read");
  return out;
}

}  // namespace view
