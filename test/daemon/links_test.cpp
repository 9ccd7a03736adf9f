// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/links.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>

#include "daemon/tf_poses.h"
#include "test/daemon/line_driver.h"
#include "test/support/tcp_peer.h"

namespace lidard::test {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

const IpAddress loopback = IpAddress::v4(127, 0, 0, 1);

Stamp wall_clock() {
  return Stamp{std::chrono::duration_cast<Span>(std::chrono::system_clock::now().time_since_epoch()).count()};
}

/// A pipeline with its links, as the daemon has them.
struct Bench {
  explicit Bench(const Config& config)
      : pipeline(config, poses, sink),
        driver(*last_line_driver()),
        links(io, config,
              {[this](std::size_t sensor, const Packet& packet) { pipeline.chunk(sensor, packet); },
               [this](std::size_t sensor, Stamp now) { pipeline.connected(sensor, now); },
               [this](std::size_t sensor) { pipeline.disconnected(sensor); },
               [this](std::size_t sensor) { return pipeline.frames(sensor); }}) {
    pipeline.set_links(&links);
    links.start();
  }
  void run(milliseconds time) {
    const auto end = Clock::now() + time;
    do {
      io.restart();
      io.run_for(milliseconds(5));
      pipeline.tick(wall_clock());
      links.tick();
    } while (Clock::now() < end);
  }
  template <class Condition>
  bool until(Condition done) {
    const auto limit = Clock::now() + std::chrono::seconds(8);
    while (!done()) {
      if (Clock::now() > limit) return false;
      run(milliseconds(5));
    }
    return true;
  }
  std::string message(std::size_t item) {
    std::vector<DiagnosticItem> items;
    links.add_diagnostics(items);
    return items.at(item).message;
  }

  boost::asio::io_context io;
  NoPoses poses;
  CountingSink sink;
  Pipeline pipeline;
  LineDriver& driver;
  Links links;
};

struct TcpBench {
  TcpPeer peer;
  Model model = line_model(Transport::tcp, peer.port());
  Bench b{config()};

  Config config() const {
    Config out;
    out.sensors.push_back(line_sensor(model, "front", loopback));
    return out;
  }
};

TEST(Links, CarryADialogueAndAStreamToFrames) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("scan\nsc"));
  ASSERT_TRUE(t.peer.send("an\n"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.scans["front/scan"] == 2; }));
  EXPECT_EQ(t.peer.read(), "hello\n");
  EXPECT_EQ(t.b.links.summary(), "1 of 1 devices connected");
  EXPECT_EQ(t.b.message(0), "connected");
  const auto report = t.b.pipeline.report();
  EXPECT_TRUE(report[0].seen);
  EXPECT_EQ(report[0].link_trouble, "");
}

TEST(Links, SayWhyThereIsNoConnectionInTheSensorsDiagnosticsToo) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.peer.accept(); }));
  t.peer.stop_listening();
  t.peer.close_client();
  ASSERT_TRUE(t.b.until([&] { return !t.b.pipeline.report()[0].link_trouble.empty(); }));
  t.b.run(milliseconds(300));
  EXPECT_THAT(t.b.message(0), HasSubstr("refuses the connection"));
  EXPECT_EQ(t.b.links.summary(), "0 of 1 devices connected");
  const auto items = t.b.pipeline.diagnostics(wall_clock());
  EXPECT_EQ(items[0].health, Health::error);
  EXPECT_THAT(items[0].message, HasSubstr("refuses the connection"));
}

TEST(Links, BeginTheDialogueAnewAfterAResetAndForgetHalfALine) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("scan\nhal"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.scans["front/scan"] == 1; }));
  t.peer.reset_client();
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 2 && t.peer.accept(); }));
  EXPECT_EQ(t.b.driver.ends, 1);
  ASSERT_TRUE(t.peer.send("scan\n"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.scans["front/scan"] == 2; }));
}

TEST(Links, NoticeAStreamThatFellSilentWithinAboutASecond) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("scan\n"));
  ASSERT_TRUE(t.b.until([&] { return t.b.sink.scans["front/scan"] == 1; }));
  const auto since = Clock::now();
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.ends == 1; }));
  EXPECT_GT(Clock::now() - since, milliseconds(900));
  EXPECT_LT(Clock::now() - since, milliseconds(1500));
  EXPECT_THAT(t.b.message(0), HasSubstr("sent nothing for 1.0 s"));
}

TEST(Links, WaitLongerForTheFirstScanAfterAnAnswer) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("starting\n"));
  t.b.run(milliseconds(2500));
  EXPECT_EQ(t.b.driver.ends, 0);
}

TEST(Links, OpenAConnectionAnewWhenTheDriverAsks) {
  TcpBench t;
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 1 && t.peer.accept(); }));
  ASSERT_TRUE(t.peer.send("refused\nignored"));
  ASSERT_TRUE(t.b.until([&] { return t.b.driver.dialogues == 2 && t.peer.accept(); }));
  EXPECT_THAT(t.b.driver.lines, ElementsAre("refused"));
  EXPECT_EQ(t.b.driver.ends, 1);
}

TEST(Links, DialWhatStreamsOverUdpOnlyWhenItsDriverAsks) {
  TcpPeer peer;
  const Model model = line_model(Transport::udp, 6060, peer.port());
  Config config;
  config.sensors.push_back(line_sensor(model, "front", loopback));
  Bench b(config);
  b.run(milliseconds(100));
  EXPECT_FALSE(peer.accept());
  EXPECT_EQ(b.links.summary(), "");
  Packet ask;
  ask.payload = ByteView("ask");
  ask.from = {loopback, 5000};
  ask.to.port = 6060;
  ask.arrival = wall_clock();
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

TEST(Links, DialTheSenderWhereNoAddressIsConfiguredAndNobodyInListenOnlyMode) {
  for (const bool listen_only : {false, true}) {
    TcpPeer peer;
    const Model model = line_model(Transport::udp, 6060, peer.port());
    Config config;
    config.sensors.push_back(line_sensor(model, "front", loopback));
    config.sensors[0].ip_address.reset();
    config.sensors[0].driver.requests.listen_only = listen_only;
    Bench b(config);
    Packet ask;
    ask.payload = ByteView("ask");
    ask.from = {loopback, 5000};
    ask.to.port = 6060;
    ask.arrival = wall_clock();
    b.pipeline.packet(ask);
    b.run(milliseconds(100));
    EXPECT_EQ(b.driver.dialogues, listen_only ? 0 : 1);
  }
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

TEST(PipelineOfConnections, TakesWhatTheDeviceSentOutOfACaptureAndNothingElse) {
  const Model model = line_model(Transport::tcp, 2112);
  Config config;
  const Endpoint device{IpAddress::v4(192, 168, 0, 1), 2112}, host{IpAddress::v4(192, 168, 0, 9), 40000};
  const Endpoint other{IpAddress::v4(192, 168, 0, 2), 2112}, web{IpAddress::v4(192, 168, 0, 2), 80};
  config.sensors.push_back(line_sensor(model, "front", device.address));
  NoPoses poses;
  CountingSink sink;
  Pipeline pipeline(config, poses, sink);
  pipeline.packet(chunk("hello\n", host, device, true));
  pipeline.packet(chunk("scan\nsc", device, host, true));
  pipeline.packet(chunk("scan\n", other, host, true));
  pipeline.packet(chunk("GET", web, host, true));
  pipeline.packet(chunk("an\n", device, host));
  EXPECT_EQ(sink.scans["front/scan"], 2);
  EXPECT_THAT(pipeline.unclaimed_senders(), ElementsAre("192.168.0.2:2112 over TCP (1 packets)"));
}

TEST(PipelineOfConnections, NeverMixesTwoConnectionsToOneDevice) {
  const Model model = line_model(Transport::tcp, 2112);
  Config config;
  const Endpoint device{IpAddress::v4(192, 168, 0, 1), 2112};
  const Endpoint first{IpAddress::v4(192, 168, 0, 9), 1}, second{IpAddress::v4(192, 168, 0, 9), 2};
  config.sensors.push_back(line_sensor(model, "front", device.address));
  NoPoses poses;
  CountingSink sink;
  Pipeline pipeline(config, poses, sink);
  pipeline.packet(chunk("scan\nsc", device, first, true));
  pipeline.packet(chunk("scan\nsca", device, second, true));
  pipeline.packet(chunk("an\nscan\n", device, first));
  pipeline.packet(chunk("n\n", device, second));
  EXPECT_THAT(last_line_driver()->lines, ElementsAre("scan", "scan", "scan"));
}

}  // namespace
}  // namespace lidard::test
