// What the commands that fit a drive by its windows have in common: reading and telling.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.h"
#include "identify/measure.h"

namespace crgidentify {

/// Throws command::UsageError on a stretch that is none.
identify::MeasureRequest request_of(const DriveCommand& command);

/// The first lines of a sheet: log, its sum, fuel.
std::string drive_header(const DriveCommand& command, const identify::ReadDrive& drive,
                         const std::string& what);
/// Windows, numbers and remarks of a fit, as text and as JSON.
std::string drive_text(const identify::Measured& measured);
nlohmann::ordered_json drive_json(const identify::Measured& measured);

/// Whether a file is asked for and nothing speaks against it; says so where something does.
bool may_write(const std::vector<std::string>& doubts, const std::string& path, Terminal& terminal);

/// What a command tells beside its numbers, behind them.
struct Beside {
  std::string text, key;
  nlohmann::ordered_json json;
};

/// Prints the fit as a table behind the sheet, or as JSON; writes the sheet where -o names a file
/// and there is no doubt.
/// Returns the exit code.
int tell(const DriveCommand& command, const identify::ReadDrive& drive,
         const identify::Measured& measured, const std::string& what, const std::string& lines,
         Terminal& terminal, const Beside& beside = {});

}  // namespace crgidentify
