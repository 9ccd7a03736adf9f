// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/output.h"
#include "daemon/pipeline/pipeline.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using testing::ElementsAre;

/// Keeps the points of a cloud, as a queue to another thread does.
class KeepingSink final : public FrameSink {
 public:
  void publish(const OutputTopic& topic, const Payload& payload, Stamp) override {
    names.push_back(topic.name);
    if (Cloud* const* const cloud = std::get_if<Cloud*>(&payload)) points.swap((*cloud)->points_bytes);
  }
  void diagnostics(const std::vector<DiagnosticItem>&, Stamp) override { names.emplace_back("diagnostics"); }

  std::vector<std::string> names;
  PointBytes points;
};

TEST(Sinks, EachOfSeveralGetsAllThatComesOutThoughOneKeepsThePoints) {
  KeepingSink first, second;
  Outlet outlet({&first, &second});
  outlet.configure(test::sample_topics(), 2);
  Cloud cloud = test::sample_cloud(100);
  const PointBytes points = cloud.points_bytes;
  outlet.publish(test::roof_points, cloud, Stamp{1});
  outlet.publish(test::front_scan, test::sample_scan(), Stamp{2});
  outlet.publish(test::roof_imu, DeviceMessage(test::sample_imu()), Stamp{3});
  outlet.publish(std::vector<DiagnosticItem>{{}}, Stamp{4});
  for (const KeepingSink* sink : {&first, &second}) {
    EXPECT_THAT(sink->names, ElementsAre("roof/points", "front/scan", "roof/imu", "diagnostics"));
    EXPECT_EQ(sink->points, points);
  }
}

TEST(Sinks, WhatCameOutIsCountedByTopic) {
  KeepingSink sink;
  Outlet outlet({&sink});
  outlet.configure(test::sample_topics(), 2);
  outlet.publish(test::front_scan, test::sample_scan(), Stamp{1'000'000'000});
  outlet.publish(test::front_scan, test::sample_scan(), Stamp{1'500'000'000});
  const OutputReport& scans = outlet.reports().at(test::front_scan.id);
  EXPECT_EQ(scans.name, "front/scan");
  EXPECT_EQ(scans.messages, 2U);
  EXPECT_EQ(scans.rate(), 2);
  EXPECT_TRUE(scans.promised);
  EXPECT_EQ(outlet.reports().at(test::roof_imu.id).messages, 0U);
  EXPECT_FALSE(outlet.reports().at(test::roof_imu.id).promised);
}

TEST(Sinks, APipelineTellsOfEveryTopicWhatCameAndWhyNothingCame) {
  const Config config = parse_config(
      "sensors: {a: {topic: /a, pose: {xyz: [0, 0, 0]}}, b: {topic: /b, pose: {xyz: [0, 0, 0]}}}\n"
      "merged_scans: {both: {laserscan_topics: [a, b], range_max: 20}}",
      "f");
  NoTransforms none;
  KeepingSink first, second;
  Pipeline pipeline(config, none, {&first, &second});
  const Stamp begin{1'700'000'000'000'000'000};
  for (const char* source : {"a", "b"}) {
    PlanarScan scan = test::sample_scan();
    scan.stamp = begin;
    pipeline.scan_message(source, scan, begin);
  }
  pipeline.tick(begin + std::chrono::seconds(1));
  const auto reports = pipeline.output_report();
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports[0].name, "both");
  EXPECT_GE(reports[0].messages, 1U);
  EXPECT_EQ(reports[0].remark, "");
  EXPECT_EQ(first.names, second.names);
  Pipeline silent(config, none, first);
  EXPECT_EQ(
      silent.output_report()[0].remark,
      "source a gave no scans (no message came on /a, which another node publishes); source b gave no scans "
      "(no message came on /b, which another node publishes)");
}

}  // namespace
}  // namespace lidard
