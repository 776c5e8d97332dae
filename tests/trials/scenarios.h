// Named trials behind the proofs of docs/evidence.md.
#pragma once

#include <filesystem>
#include <string>

namespace trials {

/// "NAME:SEED" drives another route and is called NAMESEED. Writes DIR/NAME with car, road and
/// recordings and DIR/sealed/NAME.json with the truth. `laps`: 0: as many as the scenario has.
/// False, and the names that there are on stderr, when there is no such scenario.
bool make_scenario(const std::string& name, const std::filesystem::path& folder, int laps = 0);

}  // namespace trials
