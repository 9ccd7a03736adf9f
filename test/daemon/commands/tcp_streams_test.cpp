// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Recorded connections through decode, inspect and replay. How many scans each holds was counted by others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/commands/player.h"
#include "daemon/pipeline/frame_tree.h"
#include "test/daemon/pipeline/line_driver.h"
#include "test/drivers/capture/pcap_testing.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

struct Recorded {
  const char* file;
  const char* model;
  int scans;
  double hz;  // by the telegrams' own times
};
const Recorded lms111{"sick/lms111_colab_20210302.pcap", "sick_lms1xx", 175, 50.59};
const Recorded tim781s{"sick/tim781s_colab_20210125.pcap", "sick_tim7xx", 140, 15};

class RecordedConnection : public ::testing::TestWithParam<Recorded> {};

TEST_P(RecordedConnection, IsDecodedWithAndWithoutTheNameOfItsModel) {
  LIDARD_NEED_CAPTURE(path, GetParam().file);
  for (const char* model : {"", GetParam().model}) {
    DecodeOptions options;
    options.capture = path;
    options.model = model;
    options.output = "/dev/null";
    std::ostringstream err;
    EXPECT_EQ(run_decode(options, err), 0) << err.str();
    EXPECT_THAT(err.str(), HasSubstr(" over TCP: " + std::to_string(GetParam().scans) + " frames"));
  }
}

TEST_P(RecordedConnection, IsInspectedAsOneSensorWithAConfigurationThatReplaysIt) {
  LIDARD_NEED_CAPTURE(path, GetParam().file);
  std::ostringstream out, err;
  ASSERT_EQ(run_inspect({path}, true, out, err), 0) << err.str();
  const Json said = Json::parse(out.str());
  ASSERT_EQ(said["sensors"].size(), 1U);
  const Json& sensor = said["sensors"][0];
  EXPECT_EQ(sensor["transport"], "tcp");
  EXPECT_EQ(sensor["sender"], "192.168.0.1");
  EXPECT_EQ(sensor["port"], 2112);
  EXPECT_EQ(sensor["model"], GetParam().model);
  EXPECT_EQ(sensor["frames"], GetParam().scans);
  EXPECT_EQ(sensor["data_packets"], GetParam().scans) << "answers and events are no data";
  EXPECT_NEAR(sensor["rate_hz"].get<double>(), GetParam().hz, 0.05) << "of scans, not of chunks";
  EXPECT_TRUE(said["unknown"].empty());  // the client's side belongs to the conversation

  const Config config = parse_config(said["config"].get<std::string>(), "inspected");
  NoTransforms poses;
  RecordingSink sink{false};
  Pipeline pipeline(config, poses, sink);
  ReplayOptions options;
  options.rate = 0;
  MergedCapture capture({path});
  Player player(options, capture, pipeline);
  player.play([] { return false; });
  EXPECT_EQ(sink.count(config.sensors[0].name + "/scan"), GetParam().scans);
  EXPECT_TRUE(pipeline.unclaimed_senders().empty());
  pipeline.restart();
  capture.rewind();
  Player again(options, capture, pipeline);
  again.play([] { return false; });
  EXPECT_EQ(sink.count(config.sensors[0].name + "/scan"), 2 * GetParam().scans);
}

INSTANTIATE_TEST_SUITE_P(Sick, RecordedConnection, ::testing::Values(lms111, tim781s),
                         [](const auto& recorded) { return std::string(recorded.param.model); });

TEST(InspectTcp, ListsConnectionsThatNoModelClaims) {
  const MemoryFile file(PcapBytes()
                            .add(ethernet(ipv4(tcp({'a', 'b', 'c'}, 1, 80, 50000), of_tcp())), 1)
                            .add(ethernet(ipv4(tcp({'d'}, 4, 80, 50000), of_tcp())), 2)
                            .add(ethernet(ipv4(tcp({'x'}, 9, 80, 50000), of_tcp())), 3)
                            .bytes);
  std::ostringstream out, err;
  ASSERT_EQ(run_inspect({file.path()}, true, out, err), 0);
  const Json said = Json::parse(out.str());
  ASSERT_EQ(said["unknown"].size(), 1U);
  EXPECT_EQ(said["unknown"][0]["transport"], "tcp");
  EXPECT_EQ(said["unknown"][0]["port"], 80);
  EXPECT_EQ(said["unknown"][0]["bytes"], 5);
  EXPECT_EQ(said["captures"][0]["tcp_segments"], 3);
  EXPECT_EQ(said["captures"][0]["tcp_missing"], 4);
}

}  // namespace
}  // namespace lidard::test
