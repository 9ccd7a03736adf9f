// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/sick/safety_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/ros/out/message_rows.h"
#include "test/daemon/config/config_support.h"
#include "test/support/allocations.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

template <class Message>
Bytes bytes_of(const Message& message) {
  const RawMessage made = raw(message);
  return {made.data.message_start, made.data.message_start + made.size()};
}

TEST(SafetyMessages, OutputPathsTravelAsListsOfTruthValues) {
  DeviceState state;
  state.values = {{"active_monitoring_case", 258},
                  {"status_1", 1},
                  {"is_safe_1", 0},
                  {"is_valid_1", 1},
                  {"status_2", 0},
                  {"is_safe_2", 1},
                  {"is_valid_2", 1}};
  OutputPathsMessage message;
  test::to_message(state, message);
  const Bytes expected{2, 0, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1, 2, 0, 0, 0, 1, 1, 2, 1, 0, 0};
  EXPECT_EQ(bytes_of(message), expected);
  test::to_message(state, message);
  EXPECT_EQ(bytes_of(message), expected) << "a message is filled again and again";
}

/// A scan of eight beams with these flags.
PlanarScan scan_with(const Bytes& flags) {
  PlanarScan scan;
  scan.frame_id = "left";
  scan.reset(8);
  scan.set_angles(-1, 0.25F);
  scan.range_max = 40;
  for (std::size_t i = 0; i < scan.beams; ++i) scan.set_hit(i, 2);
  scan.flags = flags;
  return scan;
}

TEST(SafetyMessages, FlagsOfBeamsStandBesideTheScan) {
  ExtendedScanMessage message;
  // valid, reflector, contamination, and what SICK does not describe
  test::to_message(scan_with({0x01, 0x09, 0x09, 0x09, 0x11, 0x19, 0xc1, 0x09}), message);
  EXPECT_EQ(message.laser_scan.header.frame_id, "left");
  EXPECT_EQ(message.laser_scan.ranges.size(), 8U);
  EXPECT_THAT(message.reflector, ElementsAre(0, 1, 1, 1, 0, 1, 0, 1));
  EXPECT_THAT(message.intrusion, ElementsAre(0, 0, 0, 0, 1, 1, 0, 0));
  EXPECT_THAT(message.reflector_median, ElementsAre(0, 0, 1, 0, 0, 1, 0, 0));
  test::to_message(scan_with({}), message);
  EXPECT_THAT(message.reflector, ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_EQ(message.reflector_median, message.reflector);
  EXPECT_EQ(message.intrusion, message.reflector);
}

TEST(SafetyMessages, TheMiddleOfARunIsTheOneThatSickSafetyscannersMarks) {
  const auto medians = [](const Bytes& reflectors) {
    Bytes flags;
    for (const auto one : reflectors) flags.push_back(one != 0 ? 0x09 : 0x01);
    ExtendedScanMessage message;
    test::to_message(scan_with(flags), message);
    return message.reflector_median;
  };
  // What getMedianReflectors() does with them, step by step by hand: a run of two marks the second, and one
  // that the last beam ends is a beam shorter.
  EXPECT_THAT(medians({1, 1, 0, 1, 0, 0, 1, 1}), ElementsAre(0, 1, 0, 1, 0, 0, 1, 0));
  EXPECT_THAT(medians({1, 1, 1, 1, 1, 1, 1, 1}), ElementsAre(0, 0, 0, 1, 0, 0, 0, 0));
}

TEST(SafetyMessages, ABeamMoreOrLessAllocatesNothingAfterWarmUp) {
  const PlanarScan scan = scan_with({0x01, 0x09, 0x09, 0x09, 0x11, 0x19, 0xc1, 0x09});
  ExtendedScanMessage message;
  test::to_message(scan, message);
  const std::uint64_t before = test::allocations();
  test::to_message(scan, message);
  EXPECT_EQ(test::allocations() - before, 0U);
}

TEST(SafetyMessages, TopicsAreThereWhereTheKeysAreSet) {
  const auto topics_of = [](const std::string& keys) {
    const Config config =
        parse_config("sensors: {a: {ip_address: 10.0.0.1, model: sick_microscan3" + keys + "}}", "f");
    std::string text;
    for (const OutputTopic& topic : output_topics(config))
      text += topic.name + " " + row_of(topic).maker()->type().name + "\n";
    return text;
  };
  EXPECT_THAT(topics_of(""), ::testing::Not(HasSubstr("sick_safetyscanners")));
  const std::string all =
      topics_of(", extended_scan_topic: extended, output_paths_topic: paths, publish_states: true");
  EXPECT_THAT(all, HasSubstr("extended sick_safetyscanners/ExtendedLaserScanMsg\n"));
  EXPECT_THAT(all, HasSubstr("paths sick_safetyscanners/OutputPathsMsg\n"));
  EXPECT_THAT(topics_of(", publish_states: true"),
              HasSubstr("a/output_paths diagnostic_msgs/DiagnosticArray\n"));
  EXPECT_THAT(all, ::testing::Not(HasSubstr("a/output_paths"))) << "the typed topic stands in for it";
  EXPECT_THAT(topics_of(", output_paths_topic: /a/output_paths"),
              HasSubstr("/a/output_paths sick_safetyscanners/OutputPathsMsg\n"));
  EXPECT_THAT(
      test::error_of("sensors: {a: {ip_address: 10.0.0.1, model: hokuyo_scip, output_paths_topic: p}}"),
      HasSubstr("sensors.a.output_paths_topic is not available for hokuyo_scip, only for SICK safety "
                "scanners"));
}

}  // namespace
}  // namespace lidard
