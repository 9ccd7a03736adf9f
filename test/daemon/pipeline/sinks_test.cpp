// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/health/pipeline_health.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/maker.h"
#include "daemon/pipeline/pipeline.h"
#include "test/support/recording_sink.h"
#include "test/support/ros_samples.h"
#include "test/support/says.h"

namespace lidard {
namespace {

Config front_and_roof(const std::string& more = "") {
  return parse_config("sensors: {" + more + "front: {model: sick_microscan3}, roof: {model: velodyne_vlp16}}",
                      "f");
}

TEST(Sinks, WhatCameOutIsCountedByTopicAndStaysCountedOverAReload) {
  test::RecordingSink sink;
  Router router(sink);
  router.configure(front_and_roof());
  Route& front_scan = router.topic("front/scan");
  front_scan.deliver(test::sample_scan(), Stamp{1'000'000'000});
  front_scan.deliver(test::sample_scan(), Stamp{1'500'000'000});
  const auto report_of = [&](const std::string& name) {
    for (const TopicTotals& one : router.reports())
      if (one.name == name) return one;
    return TopicTotals();
  };
  for (const bool reloaded : {false, true}) {
    if (reloaded) router.configure(front_and_roof("first: {model: sick_lms1xx, ip_address: 10.0.0.1}, "));
    EXPECT_EQ(&router.topic("front/scan"), &front_scan) << "whoever publishes there need not ask again";
    const TopicTotals scans = report_of("front/scan");
    EXPECT_EQ(scans.messages, 2U);
    EXPECT_EQ(scans.rate(), 2);
    EXPECT_TRUE(scans.promised);
    const TopicTotals fixes = report_of("roof/fix");
    EXPECT_EQ(fixes.name, "roof/fix");
    EXPECT_EQ(fixes.messages, 0U);
    EXPECT_FALSE(fixes.promised);
  }
}

TEST(Sinks, APipelineTellsOfEveryTopicWhatCameAndWhyNothingCame) {
  const Config config = parse_config(
      "sensors: {a: {topic: /a, pose: {xyz: [0, 0, 0]}}, b: {topic: /b, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {both: {laserscan_topics: [a, b], range_max: 20}}",
      "f");
  NoTransforms none;
  test::RecordingSink sink;
  Pipeline pipeline(config, none, sink);
  const Stamp begin{1'700'000'000'000'000'000};
  for (const char* source : {"a", "b"}) {
    PlanarScan scan = test::sample_scan();
    scan.stamp = begin;
    pipeline.scan_message(source, scan, begin);
  }
  pipeline.tick(begin + std::chrono::seconds(1));
  const auto reports = topic_totals(pipeline);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports[0].name, "both");
  EXPECT_GE(reports[0].messages, 1U);
  Pipeline silent(config, none, sink);
  EXPECT_THAT(topic_totals(silent)[0].remark,
              testing::AllOf(test::Says(says::no_input), testing::HasSubstr("; a: nothing received")));
}

}  // namespace
}  // namespace lidard
