// What names of objects, materials and textures say about their class.
#include "road/clean.h"

namespace road {

std::vector<NameRule> default_name_rules() {
  using enum NameRule::Field;
  using enum SurfaceClass;
  const auto torcs = [](NameRule::Field field, const char* pattern, SurfaceClass surface_class) {
    return NameRule{field, pattern, surface_class, "torcs"};
  };
  const auto assetto = [](const char* pattern, SurfaceClass surface_class) {
    return NameRule{object, pattern, surface_class, "assetto corsa"};
  };
  const auto words = [](NameRule::Field field, const char* pattern, SurfaceClass surface_class) {
    return NameRule{field, pattern, surface_class, "words"};
  };
  return {
      // Trees and boards first: most objects are of these, and the first match decides.
      torcs(object, "^(obj|tree|trib|pub|poutre|box|rect|poly|roue|toptent)", scenery),
      torcs(object, R"(^(b[0-9r][lr]t|p\d+ts|s[0-9t]bg))", barrier),
      torcs(object, "^terr", scenery),
      torcs(texture, "wall|barr|fence|armco|pylon", barrier),
      torcs(object, "^tkmn", road),
      torcs(object, "^[tx]k[lr]s", runoff),
      torcs(texture, "kerb|curb|^rmbl|^rsa", kerb),
      torcs(object, R"(^[tx]\d[lr]b)", runoff),
      // Surfaces that count are numbered: "1ROAD", "12KERB".
      assetto(R"(^\d+(road|asph|pit|conc))", road),
      assetto(R"(^\d+(kerb|curb))", kerb),
      assetto(R"(^\d+(grass|sand|gravel|runoff|dirt|turf))", runoff),
      assetto(R"(^\d+(wall|fence|armco|barr))", barrier),
      // Plain words, rFactor's four-letter ones among them. Scenery and walls by the object's name
      // first; else the
      // material tells more than the object: one object "track" may hold grass, asphalt and painted
      // lines.
      words(object,
            "(^|[^a-z])(tree|bush|forest|crowd|stand|grandstand|gantry|building|house|sign|board|"
            "light|car|tent|sky|terrain|hill|mountain)",
            scenery),
      words(object, "(^|[^a-z])(wall|fence|barrier|armco|guard|tyre|tire|cone|pylon)", barrier),
      words(material,
            "(^|[^a-z])(tree|bush|forest|crowd|stand|gantry|building|house|sign|board|leaf|leaves|"
            "trunk|sky|terrain)",
            scenery),
      words(material, "(^|[^a-z])(wall|fence|barrier|armco|guard|tyre|tire)", barrier),
      words(material, "(^|[^a-z])(kerb|curb|rmbl|rumble)", kerb),
      words(material, "(^|[^a-z])(road|asphalt|tarmac|rdap)", road),
      words(material, "(^|[^a-z])(run_?-?off|grass|grss|gravel|grav|sand|verge|shoulder|dirt|cemt)",
            runoff),
      words(object, "(^|[^a-z])(kerb|curb|rmbl|rumble)", kerb),
      words(object, "(^|[^a-z])(road|asphalt|tarmac|track|rdap|racingsurface|pitlane)", road),
      words(object,
            "(^|[^a-z])(run_?-?off|grass|grss|gravel|grav|sand|verge|shoulder|dirt|concrete|cemt)",
            runoff),
  };
}

}  // namespace road
