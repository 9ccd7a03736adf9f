// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What laserscan_topics, cloud_topic, trigger and source_settings may name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/offline/remarks.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using test::merged_error;
using test::roof_and_rear;
using test::virtual_error;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ConfigSources, FindsSourcesByNameAndByTopic) {
  const std::string sensors =
      "sensors: {a: {model: sick_microscan3}, b: {topic: /b_scan}, c: {topic: c_scan}}\nmerged_scans: {m: "
      "{laserscan_topics: ";
  const auto names = [&](const std::string& list) {
    return parse_config(sensors + list + "}}", "f").merged_scans.at(0).laserscan_topics;
  };
  EXPECT_THAT(names("[a, b, c]"), ElementsAre("a", "b", "c"));
  EXPECT_THAT(names("/a /b_scan  c"), ElementsAre("a", "b", "c"));
  EXPECT_THAT(names("[/a/scan, b_scan, /c_scan]"), ElementsAre("a", "b", "c"));
}

TEST(ConfigSources, FindsASensorByTheTopicThatItReallyPublishes) {
  const std::string sensors =
      "sensors: {front: {model: sick_microscan3, scan_topic: front_scan}, back: {model: sick_microscan3, "
      "ip_port: 6061, scan_topic: /vehicle/back}, roof: {model: velodyne_vlp16, scan_ring: auto, scan_topic: "
      "level}}\n";
  const auto names = [&](const std::string& list, const std::string& keys = "") {
    const Config config =
        parse_config(sensors + "merged_scans: {m: {laserscan_topics: [" + list + "]" + keys + "}}", "f");
    return config.merged_scans.at(0).laserscan_topics;
  };
  EXPECT_THAT(names("front_scan"), ElementsAre("front"));
  EXPECT_THAT(names("/front_scan, vehicle/back, /level"), ElementsAre("front", "back", "roof"));
  EXPECT_THAT(names("front, /vehicle/back"), ElementsAre("front", "back"));
  const auto error = [&](const std::string& list) {
    return error_of(sensors + "merged_scans: {m: {laserscan_topics: [" + list + "]}}");
  };
  EXPECT_EQ(
      error("front/scan"),
      "f:2:39: merged_scans.m.laserscan_topics[0] names \"front/scan\", which is no sensor and no topic "
      "of one; expected front_scan")
      << "nobody publishes it";
  EXPECT_THAT(error("fron_scan"), ::testing::EndsWith("expected front_scan"));
  EXPECT_EQ(error("roof/points"),
            "f:2:39: merged_scans.m.laserscan_topics[0] names roof/points, of a velodyne_vlp16, which gives "
            "clouds; expected names of sensors that give scans: front, back, roof");
  EXPECT_THAT(error("front, front_scan"),
              ::testing::EndsWith("names front again; expected every source once"));
  EXPECT_THAT(error_of("sensors: {roof: {model: velodyne_vlp16}}\nvirtual_scans: {v: {cloud_topic: roof, "
                       "virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 0]}}, profile: strict}}\n"
                       "merged_scans: {m: {laserscan_topics: [low, low]}}"),
              ::testing::EndsWith("names low again; expected every source once"));
}

TEST(ConfigSources, TriggerAndSettingsOfASourceTakeTheNamesOfItsList) {
  const std::string begin =
      "sensors: {front: {model: sick_microscan3, scan_topic: front_scan}, back: {model: sick_microscan3, "
      "ip_port: 6061}}\nmerged_scans: {m: {laserscan_topics: [back, /front_scan], ";
  for (const char* name : {"/front_scan", "front"}) {
    const Config config =
        parse_config(begin + "trigger: " + name + ", source_settings: {" + name + ": {range_max: 7}}}}", "f");
    const MergedScanConfig& merged = config.merged_scans.at(0);
    EXPECT_EQ(merged.schedule.trigger, 1U) << name;
    ASSERT_EQ(merged.source_settings.count("front"), 1U) << name;
    EXPECT_EQ(merged.source_settings.at("front").range_max, 7) << name;
    EXPECT_EQ(to_yaml(parse_config(to_yaml(config), "again")), to_yaml(config));
  }
  const Config first = parse_config(begin + "source_settings: {back: {range_max: 7}}}}", "f");
  EXPECT_EQ(first.merged_scans.at(0).source_settings.count("back"), 1U);
  EXPECT_THAT(error_of(begin + "source_settings: {front: {}, /front_scan: {}}}}"),
              HasSubstr("is front, which has settings already; expected one entry for each source"));
  EXPECT_THAT(error_of(begin + "trigger: front_scam}}"), HasSubstr("which is no source of it"));
}

TEST(ConfigSources, RefusesANameThatTwoThingsHave) {
  EXPECT_EQ(
      error_of("sensors: {front: {model: sick_microscan3}, back: {model: sick_microscan3, ip_port: 6061, "
               "scan_topic: /front}}\nmerged_scans: {m: {laserscan_topics: [front]}}"),
      "f:2:39: merged_scans.m.laserscan_topics[0] names \"front\", which is sensors.front and the topic of "
      "sensors.back; expected a name that only one of them has");
  const std::string bumpers =
      "sensors: {bumper: {model: sick_microscan3}, roof: {model: velodyne_vlp16}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: bumper}}\n"
      "merged_scans: {m: {laserscan_topics: ";
  EXPECT_THAT(error_of(bumpers + "bumper}}"),
              HasSubstr("is sensors.bumper and the topic of virtual_scans.v; expected a name that only one"));
  EXPECT_EQ(error_of(bumpers + "bumper/scan}}"), "no error") << "the scanner's own topic is its alone";
  EXPECT_THAT(error_of("sensors: {front: {model: sick_microscan3}, roof: {model: velodyne_vlp16}}\n"
                       "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: roof}}\n"
                       "merged_scans: {m: {laserscan_topics: [front, roof]}}"),
              HasSubstr("is the topic of virtual_scans.v and sensors.roof; expected a name that only one"));
}

TEST(ConfigSources, FindsACloudByTheTopicThatItsSensorPublishes) {
  const std::string begin =
      "sensors: {roof: {model: velodyne_vlp16, points_topic: velodyne_points}}\n"
      "virtual_scans: {v: {virtual_laser_scan: a, cloud_topic: ";
  for (const char* name : {"roof", "velodyne_points", "/velodyne_points"})
    EXPECT_EQ(parse_config(begin + name + "}}", "f").virtual_scans.at(0).cloud_topic, "roof") << name;
  EXPECT_THAT(error_of(begin + "roof/points}}"), HasSubstr("which is no sensor and no topic of one"));
}

TEST(ConfigSources, TakesNoTopicThatADeviceMayPublishOn) {
  EXPECT_THAT(error_of("sensors: {front: {model: sick_microscan3, publish_states: true}}\nmerged_scans: {m: "
                       "{laserscan_topics: front, scan_destination_topic: front/intrusion}}"),
              HasSubstr("would publish on front/intrusion, the topic of sensors.front"));
}

TEST(ConfigSources, RefusesSourcesThatAreNone) {
  EXPECT_EQ(
      merged_error("laserscan_topics: [raer]"),
      "f:7:26: merged_scans.m.laserscan_topics[0] names \"raer\", which is no sensor and no topic of one; "
      "expected rear");
  EXPECT_EQ(
      merged_error("laserscan_topics: [something]"),
      "f:7:26: merged_scans.m.laserscan_topics[0] names \"something\", which is no sensor and no topic of "
      "one; expected names of sensors that give scans: rear");
  EXPECT_EQ(merged_error("laserscan_topics: [rear, roof]"),
            "f:7:32: merged_scans.m.laserscan_topics[1] names roof, a velodyne_vlp16, which gives clouds; "
            "expected names of sensors that give scans: rear");
  EXPECT_EQ(merged_error("laserscan_topics: [rear, /rear]"),
            "f:7:32: merged_scans.m.laserscan_topics[1] names rear again; expected every source once");
}

TEST(ConfigSources, RefusesCloudsThatAreNone) {
  EXPECT_EQ(virtual_error("cloud_topic: rof, virtual_laser_scan: a"),
            "f:7:20: virtual_scans.v.cloud_topic names \"rof\", which is no sensor and no topic of one; "
            "expected roof");
  EXPECT_EQ(virtual_error("virtual_laser_scan: a"),
            "f:7:3: virtual_scans.v has no cloud_topic; expected a sensor that gives clouds: roof, rear");
  EXPECT_EQ(error_of("sensors: {a: {model: sick_microscan3}}\n"
                     "virtual_scans: {v: {cloud_topic: a, virtual_laser_scan: b}}"),
            "f:2:34: virtual_scans.v.cloud_topic names a, a sick_microscan3, which gives scans; expected a "
            "sensor that gives clouds: none is configured");
}

TEST(ConfigSources, RefusesATopicTakenForBothKinds) {
  EXPECT_EQ(error_of(roof_and_rear + "merged_scans: {m: {laserscan_topics: rear}}\n"
                                     "virtual_scans: {v: {cloud_topic: rear, virtual_laser_scan: a}}\n"),
            "f:6:38: merged_scans.m.laserscan_topics[0] names rear, which virtual_scans.v takes for a cloud; "
            "expected a topic to be one or the other");
}

TEST(MergedScanConfig, AsksWhichSourceMustSeeAFreeBeamWhereHeightsDiffer) {
  const std::string sensors =
      "sensors:\n"
      "  low: {model: sick_microscan3, pose: {xyz: [0, 1, 0.2]}}\n"
      "  high: {model: sick_lms5xx, ip_address: 10.0.0.2, pose: {xyz: [0, -1, 0.6]}}\n"
      "vehicle: {footprint: [[-1, -1], [1, -1], [0, 1]]}\n"
      "merged_scans: {m: {laserscan_topics: [low, high], profile: strict, range_max: 30";
  const Config open = parse_config(sensors + "}}", "f");
  ASSERT_EQ(remarks_on(open).size(), 1U);
  EXPECT_THAT(remarks_on(open)[0], HasSubstr("0.20 to 0.60 m high"));
  const Config answered = parse_config(sensors + ", free_requires: low}}", "f");
  EXPECT_TRUE(remarks_on(answered).empty());
  const MergedScanConfig& m = answered.merged_scans[0];
  EXPECT_EQ(m.free_requires, std::vector<std::string>{"low"});
  EXPECT_FALSE(m.source_settings.at("high").proves_free);
  const auto low = m.source_settings.find("low");
  EXPECT_TRUE(low == m.source_settings.end() || low->second.proves_free);
  EXPECT_EQ(
      merged_error("laserscan_topics: rear, free_requires: [rear, front]"),
      "f:7:53: merged_scans.m.free_requires[1] is \"front\", which is no source of it; expected sources of "
      "it: rear");
}

}  // namespace
}  // namespace lidard
