// The rooms of the libraries: folders below lib/<library>/src. A public header belongs to the room
// of the source with its name; one without a source stands for what it includes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/places.h"

namespace cli {
namespace rooms_test {

namespace fs = std::filesystem;

struct File {
  std::string library, room;  ///< "road", "road/line"
  std::vector<std::string> includes;
  std::size_t lines = 0;
};

File read_file(const fs::path& path) {
  static const std::regex kInclude("^\\s*#\\s*include \"([^\"]+)\".*");
  File file;
  std::ifstream in(path);
  std::smatch match;
  for (std::string line; std::getline(in, line); ++file.lines)
    if (std::regex_match(line, match, kInclude)) file.includes.push_back(match[1]);
  return file;
}

/// What the sources, private and public headers of all libraries say.
struct Tree {
  std::vector<File> inside;                           ///< below src
  std::map<std::string, File> header_of_name;         ///< public ones: "road/clean.h"
  std::map<std::string, std::string> room_of_name;    ///< "road:clean.cpp", "road:bands.h"
  std::map<std::string, std::size_t> sources, lines;  ///< of each room
};

Tree read_tree() {
  Tree tree;
  for (const auto& library : fs::directory_iterator(fs::path(places::source()) / "lib")) {
    const std::string name = library.path().filename().string();
    for (const char* part : {"src", "include"}) {
      const fs::path below = library.path() / part;
      if (!fs::exists(below)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(below)) {
        const std::string ending = entry.path().extension().string();
        if (ending != ".cpp" && ending != ".h" && ending != ".def") continue;
        File file = read_file(entry.path());
        file.library = name;
        if (below.filename() == "include") {
          tree.header_of_name[entry.path().lexically_relative(below).generic_string()] = file;
          continue;
        }
        const std::string folder =
            entry.path().parent_path().lexically_relative(below).generic_string();
        file.room = folder == "." ? name : name + "/" + folder;
        tree.room_of_name[name + ":" + entry.path().filename().string()] = file.room;
        tree.sources[file.room] += ending == ".cpp" ? 1 : 0;
        tree.lines[file.room] += file.lines;
        tree.inside.push_back(file);
      }
    }
  }
  for (auto& [name, header] : tree.header_of_name) {
    const auto source =
        tree.room_of_name.find(header.library + ":" + fs::path(name).stem().string() + ".cpp");
    if (source != tree.room_of_name.end()) header.room = source->second;
  }
  return tree;
}

/// The rooms that an include of a file of this library leads to.
void add_rooms(const Tree& tree, const std::string& library, const std::string& include,
               std::set<std::string>& seen, std::set<std::string>& rooms) {
  const auto header = tree.header_of_name.find(include);
  if (header != tree.header_of_name.end()) {
    if (!header->second.room.empty()) {
      rooms.insert(header->second.room);
    } else if (seen.insert(include).second) {
      for (const std::string& next : header->second.includes)
        add_rooms(tree, header->second.library, next, seen, rooms);
    }
    return;
  }
  const auto inside = tree.room_of_name.find(library + ":" + fs::path(include).filename().string());
  if (inside != tree.room_of_name.end()) rooms.insert(inside->second);
}

using Graph = std::map<std::string, std::set<std::string>>;

Graph graph_of(const Tree& tree) {
  Graph graph;
  const auto add = [&](const File& file) {
    for (const std::string& include : file.includes) {
      std::set<std::string> seen, rooms;
      add_rooms(tree, file.library, include, seen, rooms);
      rooms.erase(file.room);
      graph[file.room].insert(rooms.begin(), rooms.end());
    }
  };
  for (const File& file : tree.inside) add(file);
  for (const auto& [name, header] : tree.header_of_name)
    if (!header.room.empty()) add(header);
  return graph;
}

/// A way through the rooms that comes back to where it began; empty: there is none.
std::vector<std::string> circle(const Graph& graph) {
  std::map<std::string, int> left;  // rooms above that are not taken yet
  for (const auto& [room, below] : graph) {
    left.try_emplace(room, 0);
    for (const std::string& next : below) ++left[next];
  }
  std::vector<std::string> free;
  for (const auto& [room, count] : left)
    if (count == 0) free.push_back(room);
  while (!free.empty()) {
    const std::string room = free.back();
    free.pop_back();
    left.erase(room);
    const auto below = graph.find(room);
    if (below == graph.end()) continue;
    for (const std::string& next : below->second)
      if (--left[next] == 0) free.push_back(next);
  }
  std::vector<std::string> names;
  for (const auto& [room, count] : left) names.push_back(room);
  return names;
}

TEST(Rooms, IncludeEachOtherInOneDirection) {
  const Graph graph = graph_of(read_tree());
  ASSERT_GE(graph.size(), 40u);
  ASSERT_TRUE(graph.at("road/surface").contains("road/line"));  // the test sees what is there
  EXPECT_TRUE(circle(graph).empty())
      << "these rooms include each other, in a circle: " << ::testing::PrintToString(circle(graph));
}

TEST(Rooms, ACircleIsFound) {
  EXPECT_EQ(circle({{"a", {"b"}}, {"b", {"c"}}, {"c", {"b"}}}),
            (std::vector<std::string>{"b", "c"}));
  EXPECT_TRUE(circle({{"a", {"b", "c"}}, {"b", {"c"}}}).empty());
}

TEST(Rooms, AreSmall) {
  const Tree tree = read_tree();
  for (const auto& [room, sources] : tree.sources) {
    EXPECT_LE(sources, 25u) << "lib/" << room << ": split it along its subjects";
    EXPECT_LE(tree.lines.at(room), 6000u) << "lib/" << room << ": split it along its subjects";
  }
}

}  // namespace rooms_test
}  // namespace cli
