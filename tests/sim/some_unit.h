// Units for tests: a description and a binary, zipped.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "base/read_file.h"
#include "fmu/archive.h"
#include "support/temporary_folder.h"

namespace sim_tests {

inline std::string description_2(const std::string& token, const std::string& variables,
                                 const std::string& more = "") {
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Some" guid="{}">
<CoSimulation modelIdentifier="some" canHandleVariableCommunicationStepSize="true"{}/>
<DefaultExperiment startTime="0" stopTime="3" stepSize="0.01"/>
<ModelVariables>{}</ModelVariables></fmiModelDescription>)",
      token, more, variables);
}

inline std::string description_3(const std::string& token, const std::string& variables) {
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Some" instantiationToken="{}">
<CoSimulation modelIdentifier="some"/>
<DefaultExperiment startTime="0" stopTime="3" stepSize="0.01"/>
<ModelVariables>{}</ModelVariables></fmiModelDescription>)",
      token, variables);
}

inline std::string scalar_2(const std::string& name, int reference, const std::string& causality,
                            const std::string& type = "Real") {
  return fmt::format(
      R"(<ScalarVariable name="{}" valueReference="{}" causality="{}"><{}/></ScalarVariable>)",
      name, reference, causality, type);
}

inline std::string value_3(const std::string& type, const std::string& name, int reference,
                           const std::string& causality, int size = 1) {
  return fmt::format(R"(<{0} name="{1}" valueReference="{2}" causality="{3}">{4}</{0}>)", type,
                     name, reference, causality,
                     size == 1 ? "" : fmt::format(R"(<Dimension start="{}"/>)", size));
}

/// Writes a unit with the test binary of its FMI version, at the place of its platform.
inline std::string write_unit(const support::TemporaryFolder& folder, const std::string& xml,
                              int version, std::vector<fmu::ArchiveFile> more = {},
                              const char* binary = nullptr) {
  more.push_back({"modelDescription.xml", xml});
  more.push_back({version == 2 ? "binaries/linux64/some.so" : "binaries/x86_64-linux/some.so",
                  base::read_file(binary != nullptr ? binary
                                  : version == 2    ? SIM_UNIT_2
                                                    : SIM_UNIT_3)});
  folder.file("unit.fmu", fmu::make_archive(more));
  return folder.path("unit.fmu");
}

}  // namespace sim_tests
