// Name rules, compiled, and which naming convention a mesh follows. Private to cleaning.
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "road/clean.h"
#include "road/name_pattern.h"

namespace road {

/// Name rules, compiled. Materials and textures recur, so their answers are kept.
class NameTable {
 public:
  /// Throws Error naming the rule whose pattern is none.
  NameTable(const std::vector<NameRule>& rules, const std::string& convention);

  /// Of the first rule that matches.
  std::optional<SurfaceClass> class_of(const MeshObject& object);
  /// That rule's place in the table that was given.
  std::optional<std::size_t> rule_of(const MeshObject& object);

 private:
  struct Rule {
    std::size_t place;
    NameRule::Field field;
    SurfaceClass surface_class;
    NamePattern pattern;
    std::unordered_map<std::string, bool> answers;
  };
  const Rule* match(const MeshObject& object);
  std::vector<Rule> compiled_;
};

/// The first naming convention of the table one of whose road rules matches one of the objects.
std::string convention_of(const std::vector<MeshObject>& objects,
                          const std::vector<NameRule>& rules);

}  // namespace road
