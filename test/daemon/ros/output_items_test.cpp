// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/output_items.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Config& vehicle() {
  static const Config config = parse_config(R"(
sensors:
  left: {topic: left}
  roof: {topic: roof}
merged_scans:
  around: {laserscan_topics: [left], profile: strict, range_max: 20, free_required: 15, also: {around_safe: safety}}
virtual_scans:
  around: {cloud_topic: roof, virtual_laser_scan: [bumper, chest]}
)",
                                            "p");
  return config;
}

std::vector<std::string> names_of(Reconfigurable output) {
  std::vector<std::string> names;
  for (const Key& item : items_of(output)) names.emplace_back(item.name);
  return names;
}

TEST(OutputItems, AreThoseOfTheAncestorForItsNodes) {
  auto outputs = changeable_outputs(vehicle(), ReconfigureNames::node);
  ASSERT_EQ(outputs.size(), 1U);
  EXPECT_EQ(outputs[0].server, "");
  EXPECT_THAT(names_of(outputs[0]), ElementsAre("angle_min", "angle_max", "angle_increment", "time_increment",
                                                "scan_time", "range_min", "range_max"));
  const Keys items = items_of(outputs[0]);
  EXPECT_EQ(items[0].lowest, -M_PI);
  EXPECT_EQ(items[5].highest, 50);
  EXPECT_EQ(items[6].highest, 1000);
}

TEST(OutputItems, HaveAServerForEachEntryOfTheConfiguration) {
  const auto outputs = changeable_outputs(vehicle(), ReconfigureNames::entries);
  ASSERT_EQ(outputs.size(), 2U);
  EXPECT_EQ(outputs[0].server, "around");
  EXPECT_EQ(outputs[1].server, "around_virtual");
  EXPECT_THAT(outputs[0].topics, ElementsAre("around", "around_safe"));
  EXPECT_THAT(outputs[1].topics, ElementsAre("bumper", "chest"));
  EXPECT_EQ(names_of(outputs[1]).size() + 1, names_of(outputs[0]).size()) << "virtual scans without profile";
}

TEST(OutputItems, HaveTheTopicsOfFurtherVirtualScansToo) {
  const Config config = parse_config(
      "sensors: {roof: {model: velodyne_vlp16}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [chest, low], profile: strict, also: "
      "{near: "
      "safety}}}",
      "f");
  const auto outputs = changeable_outputs(config, ReconfigureNames::entries);
  ASSERT_FALSE(outputs.empty());
  EXPECT_THAT(outputs.back().topics, ElementsAre("chest", "chest/near", "low", "low/near"));
}

TEST(OutputItems, ChangeOneByOneAndKeepTheRest) {
  Reconfigurable output = changeable_outputs(vehicle(), ReconfigureNames::entries)[0];
  EXPECT_EQ(beams_of(output.config), 1440U);
  EXPECT_EQ(change(output, {{"range_max", 18.0}, {"profile", "safety"}}), "");
  EXPECT_EQ(output.config.grid.range_max, 18);
  EXPECT_EQ(output.config.profile, Profile::safety);
  EXPECT_EQ(beams_of(output.config), 1440U) << "a full turn stays one";
  EXPECT_EQ(change(output, {{"angle_min", -M_PI / 2}, {"angle_max", M_PI / 2}}), "");
  EXPECT_EQ(beams_of(output.config), 721U);
  EXPECT_EQ(change(output, {{"min_height", 0.1}}), "");
  EXPECT_EQ(output.config.min_height, 0.1);
  EXPECT_FALSE(output.config.max_height);
  EXPECT_EQ(change(output, {{"min_height", -10000.0}}), "");
  EXPECT_FALSE(output.config.min_height);
}

TEST(OutputItems, OfAVelodyneAreThoseOfItsFormerNodes) {
  const Config config = parse_config(
      "sensors: {roof: {model: velodyne_vlp16, min_range: 0.9, max_range: 130, scan_ring: auto}}", "p");
  EXPECT_TRUE(changeable_outputs(config, ReconfigureNames::entries).empty());
  Reconfigurable output = changeable_outputs(config, ReconfigureNames::node).at(0);
  EXPECT_EQ(output.server, "");
  EXPECT_THAT(names_of(output), ElementsAre("time_offset", "min_range", "max_range", "view_direction",
                                            "view_width", "organize_cloud"));
  EXPECT_EQ(std::get<double>(values_of(output).at("max_range")), 130);
  EXPECT_FALSE(std::get<bool>(values_of(output).at("organize_cloud")));
  EXPECT_EQ(change(output, {{"max_range", 500.0}, {"time_offset", 0.25}, {"organize_cloud", true}}), "");
  EXPECT_EQ(output.sensor->driver.max_range, 200) << "the limit of its item";
  EXPECT_EQ(output.sensor->driver.time_offset, std::chrono::milliseconds(250));
  EXPECT_EQ(output.sensor->layout.order, CloudOrder::firing_rows);
  EXPECT_EQ(output.sensor->ring_scan->range_max, 200) << "the scan of a ring has the limits of the cloud";
  EXPECT_EQ(change(output, {{"view_width", 0.0}}), "");
  EXPECT_EQ(output.sensor->driver.view_width, 2 * M_PI)
      << "no sector is all of them, as in velodyne_pointcloud";
  EXPECT_THAT(change(output, {{"min_range", 5.0}, {"max_range", 4.0}}), HasSubstr("max_range is not above"));
  EXPECT_EQ(output.sensor->driver.max_range, 200);
  const auto message = config_message(output);
  ASSERT_EQ(message.bools.size(), 1U);
  EXPECT_EQ(message.bools[0].name, "organize_cloud");
  EXPECT_TRUE(std::get<bool>(read_values(message).at("organize_cloud")));
  const auto description = description_message(output);
  EXPECT_EQ(description.groups.at(0).parameters.back().type, "bool");
  EXPECT_EQ(description.max.bools.size(), 1U);
}

TEST(OutputItems, AreBroughtIntoTheirLimits) {
  Reconfigurable output = changeable_outputs(vehicle(), ReconfigureNames::node)[0];
  EXPECT_EQ(change(output, {{"range_max", 5000.0}, {"angle_max", 9.0}}), "");
  EXPECT_EQ(output.config.grid.range_max, 1000);
  EXPECT_EQ(output.config.grid.angle_max, M_PI);
}

TEST(OutputItems, AreRefusedTogetherWithWhatWouldBeRight) {
  Reconfigurable output = changeable_outputs(vehicle(), ReconfigureNames::entries)[0];
  const auto refused = [&](const ItemValues& wanted) {
    const auto before = config_message(output);
    const std::string why = change(output, wanted);
    EXPECT_EQ(config_message(output), before) << why;
    return why;
  };
  EXPECT_THAT(refused({{"range_max", 30.0}, {"angle_max", -3.2}}),
              HasSubstr("expected angle_min < angle_max"));
  EXPECT_THAT(refused({{"angle_increment", 0.0}}), HasSubstr("expected a value above 0"));
  EXPECT_THAT(refused({{"angle_increment", 1e-5}}), HasSubstr("expected 1 to 32767: change angle_increment"));
  EXPECT_THAT(refused({{"range_min", 25.0}}), HasSubstr("expected range_min < range_max"));
  EXPECT_THAT(refused({{"range_max", 10.0}}), HasSubstr("range_max is below free_required"));
  EXPECT_THAT(refused({{"min_height", 1.0}, {"max_height", 0.5}}),
              HasSubstr("expected min_height < max_height"));
  EXPECT_THAT(refused({{"range_max", std::nan("")}}), HasSubstr("range_max is not a number"));
  EXPECT_THAT(refused({{"profile", "loose"}}), HasSubstr("expected one of strict, safety, flatten"));
}

TEST(OutputItems, KeepProfileFlattenWhereASourceProvesNothing) {
  const Config config = parse_config(R"(
sensors:
  roof: {topic: roof}
virtual_scans:
  levels: {cloud_topic: roof, virtual_laser_scan: [bumper]}
merged_scans:
  around: {laserscan_topics: [bumper]}
)",
                                     "p");
  Reconfigurable output = changeable_outputs(config, ReconfigureNames::entries).at(0);
  EXPECT_THAT(change(output, {{"profile", "strict"}}), HasSubstr("the source bumper is a virtual scan"));
  EXPECT_EQ(output.config.profile, Profile::flatten);
}

TEST(OutputItems, TravelAsDynamicReconfigureHasThem) {
  const Reconfigurable output = changeable_outputs(vehicle(), ReconfigureNames::entries)[0];
  const auto config = config_message(output);
  EXPECT_EQ(config.doubles.size() + config.strs.size(), names_of(output).size());
  ASSERT_EQ(config.groups.size(), 1U);
  EXPECT_TRUE(config.groups[0].state);
  const ItemValues read = read_values(config);
  EXPECT_EQ(std::get<double>(read.at("range_max")), 20);
  EXPECT_EQ(std::get<std::string>(read.at("profile")), "strict");
  const auto description = description_message(output);
  EXPECT_EQ(description.groups.at(0).parameters.size(), names_of(output).size());
  for (const auto* part : {&description.min, &description.max, &description.dflt})
    EXPECT_EQ(part->doubles.size() + part->strs.size(), names_of(output).size());
  dynamic_reconfigure::Config with_int;
  with_int.ints.emplace_back();
  with_int.ints[0].name = "range_max";
  with_int.ints[0].value = 18;
  EXPECT_EQ(std::get<double>(read_values(with_int).at("range_max")), 18);
}

}  // namespace
}  // namespace lidard
