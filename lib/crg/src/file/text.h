// Numbers and words as OpenCRG writes them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace crg {

std::string_view trim(std::string_view text);
std::string upper(std::string_view text);

/// A number at the start of `text`: optional sign (also +), D or E exponents. `rest` receives what
/// follows it. Empty when there is none or it is not finite.
std::optional<double> parse_number(std::string_view text, std::string_view* rest = nullptr);

/// The shortest decimal that reads back as the same double.
std::string shortest(double value);

}  // namespace crg
