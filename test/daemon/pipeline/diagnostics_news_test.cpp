// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "daemon/health/pipeline_health.h"
#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/pipeline.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

constexpr Stamp at(double seconds) { return Stamp{static_cast<std::int64_t>(seconds * 1e9)}; }

TEST(DiagnosticsNews, AreToldAtOnceAndTheRestOncePerSecond) {
  const Config config = parse_config(R"(
sensors:
  left: {topic: left, pose: {xyz: [0, 0, 0]}}
merged_scans:
  around: {laserscan_topics: [left], range_max: 20}
)",
                                     "p");
  NoTransforms none;
  test::RecordingSink sink;
  Pipeline pipeline(config, none, sink);
  const HealthReporter reporter(pipeline, sink);
  pipeline.tick(at(10));
  EXPECT_EQ(sink.tellings, 1);
  for (const auto& item : sink.newest)
    EXPECT_EQ(item.health, Health::ok) << item.name << " may still come: " << item.message;
  pipeline.tick(at(10.1));
  pipeline.tick(at(10.9));
  EXPECT_EQ(sink.tellings, 1) << "nothing new";
  pipeline.tick(at(11));
  EXPECT_EQ(sink.tellings, 2);
  EXPECT_EQ(sink.newest.at(0).health, Health::error) << "nothing has come yet";
  EXPECT_EQ(sink.newest.at(1).health, Health::error) << sink.newest.at(1).name;

  PlanarScan scan;
  scan.frame_id = "left";
  scan.reset(2, 1, false);
  scan.range_max = 10;
  scan.set_angles(0, 0.1F);
  scan.stamp = at(11.2);
  pipeline.scan_message("left", scan, at(11.2));
  pipeline.tick(at(11.3));
  EXPECT_EQ(sink.tellings, 3) << "both are well now";
  EXPECT_EQ(sink.newest.at(0).health, Health::ok);
  pipeline.tick(at(11.32));
  EXPECT_EQ(sink.tellings, 3);
  pipeline.tick(at(11.7));
  EXPECT_EQ(sink.tellings, 4) << "the only source is lost by now";
}

}  // namespace
}  // namespace lidard
