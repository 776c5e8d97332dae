// Every claim of the page of crgexplain, made again from findings.json by a second reader.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace support {

/// EXPECTs that the page says what findings.json says: the verdict, both rates of false alarms, lap
/// times, every finding with amounts, intervals, places, evidence and rivals, and every row of
/// every table. Numbers agree within the digits that the page prints.
void expect_page_says(const nlohmann::json& findings, const std::string& page);

}  // namespace support
