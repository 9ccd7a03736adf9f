// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Recorded connections through decode, inspect and replay. How many scans each holds was counted by others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/offline/player.h"
#include "test/daemon/pipeline/line_driver.h"
#include "test/drivers/capture/pcap_testing.h"
#include "test/sim/devices/cola_telegram.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

struct Recorded {
  const char* file;
  const char* model;
  int packets, scans;  // some came twice
  double hz;           // by the telegrams' own times
};
const Recorded lms111{"sick/lms111_colab_20210302.pcap", "sick_lms1xx", 175, 172, 49.72};
const Recorded tim781s{"sick/tim781s_colab_20210125.pcap", "sick_tim7xx", 140, 140, 15};

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
  EXPECT_EQ(sensor["data_packets"], GetParam().packets) << "answers and events are no data";
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

/// What decode says of a recorded stream of LMDscandata in segments of 1000 bytes, of which `is_kept` keeps
/// some.
template <class Kept>
std::string why_undecoded(const char* model, Kept is_kept, std::size_t encoders = 0) {
  sim::SickScan scan;
  scan.encoders.resize(encoders);
  scan.channels = {{"DIST1", 1, 0, -50000, 1667, true, std::vector<std::uint16_t>(1141, 3000)}};
  Bytes stream;
  for (int i = 0; i < 20; ++i) {
    ++scan.telegram_counter;
    stream = stream + scan.bytes(sim::Cola::binary);
  }
  PcapBytes capture;
  for (std::size_t at = 0, n = 0; at < stream.size(); at += 1000, ++n) {
    const auto begin = stream.begin() + static_cast<std::ptrdiff_t>(at);
    const Bytes part(begin,
                     begin + static_cast<std::ptrdiff_t>(std::min<std::size_t>(1000, stream.size() - at)));
    if (is_kept(n))
      capture.add(ethernet(ipv4(tcp(part, static_cast<std::uint32_t>(at + 1)), of_tcp())),
                  static_cast<int>(n));
  }
  const MemoryFile file(capture.bytes);
  DecodeOptions options;
  options.capture = file.path();
  options.model = model;
  options.output = "/dev/null";
  std::ostringstream err;
  EXPECT_EQ(run_decode(options, err), exit_failed);
  EXPECT_THAT(err.str(), ::testing::Not(HasSubstr("no packets")));
  return err.str();
}

TEST(DecodeTcp, SaysWhatWasFoundAndWhyItCannotBeRead) {
  for (const char* model : {"", "sick_lms5xx"}) {
    const auto every_second = [](std::size_t n) { return n % 2 == 0; };
    EXPECT_THAT(why_undecoded(model, every_second),
                HasSubstr("none could be read: 23000 bytes of the connection are not in the capture"));
    const auto all = [](std::size_t) { return true; };
    EXPECT_THAT(why_undecoded(model, all, 9), HasSubstr("20 rejected for field"));
    EXPECT_THAT(why_undecoded(model, all, 9), HasSubstr("2112 over TCP: LMDscandata of a SICK scanner"));
    const auto first = [](std::size_t n) { return n == 0; };
    EXPECT_THAT(why_undecoded(model, first), HasSubstr("no telegram is complete"));
  }
}

}  // namespace
}  // namespace lidard::test
