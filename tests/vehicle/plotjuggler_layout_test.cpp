// The layouts of examples/plotjuggler name what drives hold, and leave none of its groups out.
#include <gtest/gtest.h>

#include <pugixml.hpp>
#include <set>
#include <string>

#include "recording/channels.h"
#include "recording/table.h"
#include "recording/telemetry_mcap.h"
#include "support/places.h"

namespace plotjuggler_layout_test {

/// The curves that a layout draws over time or over one another.
std::set<std::string> curves_of(const std::string& file) {
  pugi::xml_document layout;
  EXPECT_TRUE(layout.load_file((places::source() + "/examples/plotjuggler/" + file).c_str()));
  std::set<std::string> names;
  for (const pugi::xpath_node& found : layout.select_nodes("/root/tabbed_widget//plot/curve")) {
    const pugi::xml_node curve = found.node();
    if (curve.attribute("curve_x")) {
      names.insert(curve.attribute("curve_x").value());
      names.insert(curve.attribute("curve_y").value());
    } else {
      names.insert(curve.attribute("name").value());
    }
  }
  return names;
}

/// Topic and field as PlotJuggler joins them, from the descriptions in the file of a drive.
std::set<std::string> fields_of_drive() {
  recording::Table table;
  for (const std::string& name : recording::telemetry_channels()) table.add(name, {0.0, 1.0});
  const std::string bytes = recording::format_mcap(table, "");
  std::set<std::string> fields;
  for (const char* topic : {"/place", "/motion", "/controls", "/engine", "/wheels"}) {
    const std::size_t schema = bytes.rfind(std::string("kerbstone") + topic);
    EXPECT_NE(schema, std::string::npos) << topic;
    const std::size_t end = bytes.find("kerbstone/", schema + 1);
    const std::string text = bytes.substr(schema, end - schema);
    for (const std::string& name : recording::telemetry_channels())
      if (text.find('"' + name + '"') != std::string::npos)
        fields.insert(std::string(topic) + "/" + name);
  }
  return fields;
}

TEST(PlotJugglerLayout, NamesWhatADriveHolds) {
  const std::set<std::string> drive = fields_of_drive(), mcap = curves_of("drive_mcap.xml");
  EXPECT_EQ(drive.size(), recording::telemetry_channels().size());
  EXPECT_GT(mcap.size(), 40U);
  for (const std::string& name : mcap) EXPECT_EQ(drive.count(name), 1U) << name;

  const std::set<std::string> csv = curves_of("drive_csv.xml");
  EXPECT_EQ(csv.size(), mcap.size());
  const auto channels = recording::telemetry_channels();
  const std::set<std::string> columns(channels.begin(), channels.end());
  for (const std::string& name : csv) EXPECT_EQ(columns.count(name), 1U) << name;
}

}  // namespace plotjuggler_layout_test
