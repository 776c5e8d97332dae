#include "stages.h"

#include <algorithm>
#include <filesystem>

#include "base/read_file.h"
#include "base/write_file.h"

namespace explain {

namespace fs = std::filesystem;

Stages::Stages(std::string folder, std::string inputs)
    : folder_(std::move(folder) + "/.unfinished"), inputs_(inputs.substr(0, 16)) {
  fs::create_directories(folder_);
  for (const auto& entry : fs::directory_iterator(folder_))
    if (!entry.path().filename().string().ends_with("-" + inputs_)) fs::remove_all(entry.path());
}

std::vector<std::string> Stages::taken_up() const {
  std::vector<std::string> out;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.is_directory()) continue;  // scratch()
    const std::string name = entry.path().filename().string();
    out.push_back(name.substr(0, name.rfind('-')));
  }
  std::sort(out.begin(), out.end());
  return out;
}

std::string Stages::scratch() const {
  const std::string out = path("scratch");
  fs::remove_all(out);
  fs::create_directories(out);
  return out;
}

bool Stages::load(const std::string& stage, std::string& bytes) const {
  if (!fs::exists(path(stage))) return false;
  bytes = base::read_file(path(stage), std::size_t{1} << 30);
  return true;
}

void Stages::keep(const std::string& stage, const std::string& bytes) const {
  base::write_file(path(stage), bytes);
}

void Stages::done() const { fs::remove_all(folder_); }

}  // namespace explain
