#include "stages.h"

#include <algorithm>
#include <filesystem>

#include "base/read_file.h"
#include "base/write_file.h"

namespace explain {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPart = "part ";  ///< of the relations, which are not finished

}  // namespace

Stages::Stages(std::string folder, const std::string& inputs)
    : folder_(std::move(folder) + "/.unfinished"), inputs_(inputs.substr(0, 16)) {
  fs::create_directories(folder_);
  for (const auto& entry : fs::directory_iterator(folder_))
    if (!entry.path().filename().string().ends_with("-" + inputs_)) fs::remove_all(entry.path());
}

std::vector<std::string> Stages::taken_up() const {
  std::vector<std::string> out;
  bool parts = false;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.is_directory()) continue;  // scratch()
    const std::string file = entry.path().filename().string(),
                      name = file.substr(0, file.rfind('-'));
    if (name.starts_with(kPart))
      parts = true;
    else
      out.push_back(name);
  }
  std::sort(out.begin(), out.end());
  if (out.empty() && parts) out.emplace_back("a part of the relations");
  return out;
}

bool Stages::load_part(const std::string& part, std::string& bytes) const {
  return load(kPart + part, bytes);
}

void Stages::keep_part(const std::string& part, const std::string& bytes) const {
  keep(kPart + part, bytes);
}

std::string Stages::scratch() const {
  std::string out = path("scratch");
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
