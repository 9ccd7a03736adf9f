// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/tcp_connections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/health/network_health.h"
#include "daemon/offline/no_transforms.h"
#include "test/daemon/live/live_bench.h"
#include "test/support/allocations.h"
#include "test/support/ros_master.h"
#include "test/support/says.h"
#include "test/support/tcp_peer.h"
#include "test/support/udp_peer.h"

namespace lidard::test {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

const IpAddress this_host = IpAddress::v4(127, 0, 0, 1);

struct Bench : LiveBench {
  explicit Bench(const Config& config, const TcpOptions& options = {})
      : LiveBench(config, options), driver(*last_line_driver()) {}
  LineDriver& driver;
};

struct TcpBench {
  TcpPeer peer;
  Model model = line_model(Transport::tcp, peer.port());
  Bench b{config()};

  Config config() const {
    Config out;
    out.sensors.push_back(line_sensor(model, "front", this_host));
    return out;
  }
};

TEST(TcpConnections, CarryADialogueAndAStreamToFrames) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("scan\nsc"));
  ASSERT_TRUE(t.peer.send("an\n"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.count("front/scan") == 2; }));
  EXPECT_EQ(t.peer.read(), "hello\n");
  EXPECT_EQ(t.b.items().at(0).is_up, true);
  EXPECT_EQ(t.b.message(0), "connected");
  const auto report = t.b.pipeline.status(t.b.pipeline.now()).sensors;
  EXPECT_TRUE(report[0].seen);
  EXPECT_FALSE(report[0].connection.tcp.fault);
}

TEST(TcpConnections, SayWhyThereIsNoConnectionInTheSensorsDiagnosticsToo) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.peer.accept(); }));
  t.peer.stop_listening();
  t.peer.close_client();
  ASSERT_TRUE(t.b.until(
      [&] { return bool(t.b.pipeline.status(t.b.pipeline.now()).sensors[0].connection.tcp.fault); }));
  t.b.run(milliseconds(300));
  EXPECT_THAT(t.b.message(0), HasSubstr("refuses the connection"));
  EXPECT_EQ(t.b.items().at(0).is_up, false);
  const auto items = items_of(t.b.pipeline, now_of_host());
  EXPECT_EQ(items[0].health, Health::error);
  EXPECT_THAT(items[0].message, HasSubstr("refuses the connection"));
}

TEST(TcpConnections, NameWhatIsWrongWithThisHostBeforeTheConnectionBreaks) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  const SensorConfig sensor = t.config().sensors[0];
  EXPECT_EQ(why_unreachable(t.b.connections.status(0), sensor), "");
  t.b.host.network.emplace().interfaces = {{"lidar0", this_host, 24, true, false}};
  EXPECT_EQ(t.b.message(0), "connected") << "TCP notices it a second later";
  EXPECT_THAT(why_unreachable(t.b.connections.status(0), sensor), test::Says(says::no_link));
  t.peer.stop_listening();
  t.peer.close_client();
  ASSERT_TRUE(t.b.until([&] { return bool(t.b.connections.status(0).tcp.fault); }));
  EXPECT_THAT(why_unreachable(t.b.connections.status(0), sensor), test::Says(says::no_link));
}

TEST(TcpConnections, SayThatADialogueThatFailedIsBegunAgain) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  t.b.connections.disconnect(0, true);
  EXPECT_THAT(t.b.message(0), test::Says(says::dialogue_failed));
}

TEST(TcpConnections, BeginTheDialogueAnewAfterAResetAndForgetHalfALine) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("scan\nhal"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.count("front/scan") == 1; }));
  t.peer.reset_client();
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 2 && t.peer.accept(); }));
  EXPECT_EQ(t.b.driver.ends, 1);
  ASSERT_TRUE(t.peer.send("scan\n"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.count("front/scan") == 2; }));
}

TEST(TcpConnections, LeaveItToTheDriverHowLongAScanMayTake) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("scan\n"));
  t.b.run(milliseconds(2500));
  EXPECT_EQ(t.b.driver.ends, 0);
}

TEST(TcpConnections, OpenAConnectionAnewWhenTheDriverAsks) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("refused\nignored"));
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 2 && t.peer.accept(); }));
  EXPECT_THAT(t.b.driver.lines, ElementsAre("refused"));
  EXPECT_EQ(t.b.driver.ends, 1);
}

TEST(TcpConnections, DialWhatStreamsOverUdpOnlyWhenItsDriverAsks) {
  TcpPeer peer;
  const Model model = line_model(Transport::udp, 6060, peer.port());
  Config config;
  config.sensors.push_back(line_sensor(model, "front", this_host));
  Bench b(config);
  b.run(milliseconds(100));
  EXPECT_FALSE(peer.accept());
  EXPECT_TRUE(b.items().empty());
  Packet ask;
  ask.payload = ByteView("ask");
  ask.from = {this_host, 5000};
  ask.to.port = 6060;
  ask.arrival = now_of_host();
  b.pipeline.packet(ask);
  ASSERT_TRUE(b.until([&] { return b.driver.dialogues == 1 && peer.accept(); }));
  ASSERT_TRUE(peer.send("done\n"));
  ASSERT_TRUE(b.until([&] { return b.driver.ends == 1; }));
  b.run(milliseconds(300));
  EXPECT_FALSE(peer.accept());  // over
  EXPECT_EQ(b.message(0), "not needed now");
  b.pipeline.packet(ask);
  EXPECT_TRUE(b.until([&] { return b.driver.dialogues == 2 && peer.accept(); }));
}

TEST(TcpConnections, DialTheSenderWhereNoAddressIsConfiguredAndNobodyInListenOnlyMode) {
  for (const bool listen_only : {false, true}) {
    TcpPeer peer;
    const Model model = line_model(Transport::udp, 6060, peer.port());
    Config config;
    config.sensors.push_back(line_sensor(model, "front", this_host));
    config.sensors[0].ip_address.reset();
    config.sensors[0].driver.requests.listen_only = listen_only;
    Bench b(config);
    Packet ask;
    ask.payload = ByteView("ask");
    ask.from = {this_host, 5000};
    ask.to.port = 6060;
    ask.arrival = now_of_host();
    b.pipeline.packet(ask);
    b.run(milliseconds(100));
    EXPECT_EQ(b.driver.dialogues, listen_only ? 0 : 1);
  }
}

TEST(TcpConnections, LoseNothingOfOtherSensorsAndLeakNothingWhileOneDisconnectsAThousandTimes) {
  TcpPeer peer;
  const Model planar = line_model(Transport::tcp, peer.port());
  const Model other = line_model(Transport::udp, free_port());
  Config config;
  config.sensors.push_back(line_sensor(planar, "front", this_host));
  config.sensors.push_back(line_sensor(other, "rear", this_host));
  TcpOptions options;
  options.first_retry = options.last_retry = milliseconds(0);
  Bench b(config, options);
  const UdpPeer sender;
  std::uint64_t sent = 0;
  const auto turn = [&] {
    sender.send(other.port, ByteView("data"));
    ++sent;
    b.io.restart();
    b.io.run_for(milliseconds(1));
  };
  std::size_t memory = 0, files = 0;
  for (int i = 1; i <= 1100; ++i) {
    const auto limit = Clock::now() + std::chrono::seconds(20);
    while (!peer.accept()) {
      ASSERT_LT(Clock::now(), limit) << i;
      turn();
    }
    if (i == 100) memory = resident_bytes(), files = open_files();
    ASSERT_TRUE(peer.send("scan\nhalf"));
    while (b.pipeline.frames(0) < static_cast<std::uint64_t>(i)) {
      ASSERT_LT(Clock::now(), limit) << i;
      turn();
    }
    if (i % 100 == 0) b.pipeline.tick(now_of_host());
    i % 2 == 0 ? peer.reset_client() : peer.close_client();
  }
  b.run(milliseconds(100));
  EXPECT_EQ(b.sink.count("front/scan"), 1100U);
  EXPECT_EQ(b.pipeline.status(b.pipeline.now()).sensors[1].counters.packets, sent);
  EXPECT_LE(open_files(), files);
#ifndef __SANITIZE_ADDRESS__  // which keeps for a while what was freed, and finds leaks itself
  EXPECT_LE(resident_bytes(), memory + 512 * 1024);
#endif
}

Packet chunk(std::string_view bytes, const Endpoint& from, const Endpoint& to, bool start = false) {
  Packet out;
  out.payload = ByteView(bytes);
  out.transport = Transport::tcp;
  out.from = from;
  out.to = to;
  out.stream_start = start;
  return out;
}

TEST(PipelineOfConnections, NeverMixesTwoConnectionsToOneDevice) {
  const Model model = line_model(Transport::tcp, 2112);
  Config config;
  const Endpoint device{IpAddress::v4(192, 168, 0, 1), 2112};
  const Endpoint first{IpAddress::v4(192, 168, 0, 9), 1}, second{IpAddress::v4(192, 168, 0, 9), 2};
  config.sensors.push_back(line_sensor(model, "front", device.address));
  NoTransforms poses;
  RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  pipeline.packet(chunk("scan\nsc", device, first, true));
  pipeline.packet(chunk("scan\nsca", device, second, true));
  pipeline.packet(chunk("an\nscan\n", device, first));
  pipeline.packet(chunk("n\n", device, second));
  EXPECT_THAT(last_line_driver()->lines, ElementsAre("scan", "scan", "scan"));
}

}  // namespace
}  // namespace lidard::test
