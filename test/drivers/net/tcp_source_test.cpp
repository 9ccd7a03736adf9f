// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/tcp_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <thread>

#include "test/support/allocations.h"
#include "test/support/starved.h"
#include "test/support/tcp_peer.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using test::TcpPeer;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

TcpOptions to_port(std::uint16_t port) {
  TcpOptions options;
  options.device = {IpAddress::v4(127, 0, 0, 1), port};
  options.first_retry = milliseconds(10);
  options.last_retry = milliseconds(100);
  return options;
}

struct Bench {
  explicit Bench(const TcpOptions& options)
      : source(io, options,
               {[this](const Packet& packet) {
                  received += packet.payload.text();
                  starts += packet.stream_start ? 1 : 0;
                  last = packet;
                  if (on_receive) on_receive();
                },
                [this](HostStamp) {
                  ++connects;
                  if (on_connect) on_connect();
                },
                [this] { ++disconnects; }}) {}

  void run(milliseconds time) {
    io.restart();
    io.run_for(time);
  }
  /// Runs until `done`, at most 20 s: machines that run tests are busy.
  template <class Condition>
  bool until(Condition done) {
    const auto limit = Clock::now() + std::chrono::seconds(20);
    while (!done()) {
      if (Clock::now() > limit) return false;
      run(milliseconds(2));
    }
    return true;
  }
  bool until_connected(int times = 1) {
    return until([&] { return connects >= times; });
  }
  const TcpFault& fault() const { return source.state().fault; }

  boost::asio::io_context io;
  std::string received;
  int starts = 0, connects = 0, disconnects = 0;
  std::function<void()> on_receive, on_connect;
  Packet last;
  TcpSource source;
};

TEST(TcpSource, CarriesBytesBothWaysWithEndpointsAndKernelStamp) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  EXPECT_EQ(b.source.state().phase, TcpState::Phase::connected);
  EXPECT_TRUE(b.source.send(ByteView("question")));
  const test::Starved starved;
  ASSERT_TRUE(peer.send("answer"));
  const double late = starved.seconds();
  const auto sent = std::chrono::system_clock::now();
  std::this_thread::sleep_for(milliseconds(60));  // the stamp is the kernel's, not the reader's
  ASSERT_TRUE(b.until([&] { return b.received == "answer"; }));
  EXPECT_EQ(peer.read(), "question");
  EXPECT_EQ(b.last.transport, Transport::tcp);
  EXPECT_EQ(b.last.from.to_string(), "127.0.0.1:" + std::to_string(peer.port()));
  EXPECT_EQ(b.last.to.address.to_string(), "127.0.0.1");
  EXPECT_NE(b.last.to.port, 0);
  EXPECT_TRUE(b.last.stream_start);
  const double sent_s = std::chrono::duration<double>(sent.time_since_epoch()).count();
  EXPECT_NEAR(seconds(Span(b.last.received.ns)), sent_s, 0.03 + late);
  EXPECT_EQ(b.source.stats().sent, 8U);
  EXPECT_EQ(b.source.stats().received, 6U);
}

TEST(TcpSource, ComesFromTheSamePortAfterAConnectionThatTheDeviceMayStillHold) {
  TcpPeer peer;
  TcpOptions options = to_port(peer.port());
  options.read_time_out = milliseconds(100);
  Bench b(options);
  b.source.start();
  ASSERT_TRUE(b.until([&] { return peer.accept(); }));
  ASSERT_TRUE(peer.send("x"));
  ASSERT_TRUE(b.until([&] { return b.received == "x"; }));
  const std::uint16_t port = b.last.to.port;
  ASSERT_TRUE(b.until([&] { return peer.accept(); }));  // after the silence
  ASSERT_TRUE(peer.send("y"));
  ASSERT_TRUE(b.until([&] { return b.received == "xy"; }));
  EXPECT_EQ(b.last.to.port, port);
  peer.close_client();
  ASSERT_TRUE(b.until([&] { return peer.accept(); }));
  ASSERT_TRUE(peer.send("z"));
  ASSERT_TRUE(b.until([&] { return b.received == "xyz"; }));
  EXPECT_NE(b.last.to.port, port) << "a device that closed it keeps the pair of ports for a while";
}

TEST(TcpSource, SaysThatAPortRefusesAndConnectsSoonAfterItListens) {
  TcpPeer peer;
  peer.stop_listening();
  Bench b(to_port(peer.port()));
  b.source.start();
  b.run(milliseconds(400));
  EXPECT_TRUE(b.until([&] { return b.source.stats().attempts >= 4; }));
  EXPECT_EQ(b.fault().kind, TcpFault::Kind::not_connected);
  EXPECT_EQ(b.fault().error, ECONNREFUSED);
  EXPECT_LE(b.source.stats().attempts, 9U);  // ever later
  peer.listen_again();
  const test::Starved starved;
  const auto since = Clock::now();
  ASSERT_TRUE(b.until_connected());
  EXPECT_LT(Clock::now() - since, milliseconds(300) + starved.time());
  EXPECT_FALSE(b.fault());
  EXPECT_EQ(b.disconnects, 0);
}

TEST(TcpSource, TriesAgainEachSecondByDefault) {
  const TcpOptions defaults;
  EXPECT_EQ(defaults.first_retry, milliseconds(100));
  // An attempt that times out is followed by the next after first_retry.
  EXPECT_LE(std::max(defaults.last_retry, defaults.connect_time_out + defaults.first_retry),
            milliseconds(1000));
}

TEST(TcpSource, GivesUpAnAttemptThatNobodyAnswers) {
  TcpPeer full(0, 0);  // holds one client that is never accepted; the kernel drops what others send
  Bench first(to_port(full.port()));
  first.source.start();
  ASSERT_TRUE(first.until_connected());
  TcpOptions options = to_port(full.port());
  options.connect_time_out = milliseconds(100);
  Bench b(options);
  b.source.start();
  ASSERT_TRUE(b.until([&] { return b.source.stats().attempts > 2; }));
  EXPECT_EQ(b.connects, 0);
  EXPECT_EQ(b.fault().error, ETIMEDOUT);
}

TEST(TcpSource, SaysThatNoWayLeadsToTheDevice) {
  TcpOptions options = to_port(2112);
  options.device.address = IpAddress::v4(255, 255, 255, 255);
  Bench b(options);
  b.source.start();
  ASSERT_TRUE(b.until([&] { return b.source.state().phase == TcpState::Phase::waiting; }));
  EXPECT_EQ(b.fault().kind, TcpFault::Kind::not_connected);
  EXPECT_NE(b.fault().error, 0);
}

TEST(TcpSource, ConnectsAgainWhenTheDeviceClosesOrResets) {
  for (const bool reset : {false, true}) {
    TcpPeer peer;
    Bench b(to_port(peer.port()));
    b.source.start();
    ASSERT_TRUE(b.until_connected());
    ASSERT_TRUE(peer.accept());
    ASSERT_TRUE(peer.send("one"));
    ASSERT_TRUE(b.until([&] { return b.received == "one"; }));
    reset ? peer.reset_client() : peer.close_client();
    ASSERT_TRUE(b.until([&] { return b.disconnects == 1; }));
    EXPECT_EQ(b.fault().kind, TcpFault::Kind::ended);
    EXPECT_EQ(b.fault().error, reset ? ECONNRESET : 0);
    ASSERT_TRUE(b.until_connected(2));
    ASSERT_TRUE(peer.accept());
    ASSERT_TRUE(peer.send("two"));
    ASSERT_TRUE(b.until([&] { return b.received == "onetwo"; }));
    EXPECT_EQ(b.starts, 2);
  }
}

TEST(TcpSource, MakesOneAttemptAndOneConnectionWhereItNeedNotLast) {
  TcpPeer peer;
  TcpOptions options = to_port(peer.port());
  options.keep_up = false;
  Bench b(options);
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  peer.close_client();
  ASSERT_TRUE(b.until([&] { return b.disconnects == 1; }));
  EXPECT_EQ(b.source.state().phase, TcpState::Phase::stopped);
  EXPECT_FALSE(b.fault()) << "that the device closes is no trouble";
  peer.stop_listening();
  b.source.start();
  ASSERT_TRUE(b.until([&] { return b.disconnects == 2; })) << "told also of an attempt that failed";
  EXPECT_EQ(b.fault().error, ECONNREFUSED);
  b.run(milliseconds(200));
  EXPECT_EQ(b.source.stats().attempts, 2U);
  EXPECT_EQ(b.connects, 1);
}

TEST(TcpSource, OpensASilentConnectionAnew) {
  TcpPeer peer;
  TcpOptions options = to_port(peer.port());
  options.read_time_out = milliseconds(150);
  Bench b(options);
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(peer.send("x"));
    b.run(milliseconds(40));
  }
  EXPECT_EQ(b.disconnects, 0);  // as long as it talks
  ASSERT_TRUE(b.until([&] { return b.disconnects == 1; }));
  EXPECT_EQ(b.source.stats().silences, 1U);
  EXPECT_EQ(b.fault().kind, TcpFault::Kind::silent);
  EXPECT_EQ(b.fault().silence, options.read_time_out);
  EXPECT_TRUE(b.until_connected(2));
}

TEST(TcpSource, TakesASleepOfItsOwnForNoSilence) {
  TcpPeer peer;
  TcpOptions options = to_port(peer.port());
  options.read_time_out = milliseconds(100);
  Bench b(options);
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  ASSERT_TRUE(peer.send("a"));
  std::this_thread::sleep_for(milliseconds(300));
  b.run(milliseconds(20));
  EXPECT_EQ(b.received, "a");
  EXPECT_EQ(b.disconnects, 0);
}

TEST(TcpSource, NoticesADeviceThatVanishedWithoutAWord) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  if (!peer.vanish()) GTEST_SKIP() << "needs CAP_NET_ADMIN";
  const test::Starved starved;
  const auto since = Clock::now();
  ASSERT_TRUE(b.until([&] { return b.disconnects == 1; }));  // a host without that connection resets it
  EXPECT_LT(Clock::now() - since, milliseconds(1500) + starved.time());
  ASSERT_TRUE(b.until_connected(2));
}

TEST(TcpSource, LeavesADeviceAloneThatIsSilentButAnswersTheKeepAlive) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  b.run(milliseconds(6000));
  EXPECT_TRUE(b.source.send(ByteView("are you there?")));  // and does not read
  b.run(milliseconds(3000));
  EXPECT_EQ(b.disconnects, 0) << b.fault().error;
}

TEST(TcpSource, TriesAtOnceWhenAnInterfaceCameInsteadOfWaiting) {
  TcpPeer peer;
  peer.stop_listening();
  TcpOptions options = to_port(peer.port());
  options.first_retry = options.last_retry = std::chrono::hours(1);
  Bench b(options);
  b.source.interfaces_changed();
  EXPECT_EQ(b.source.stats().attempts, 0U) << "it is stopped";
  b.source.start();
  ASSERT_TRUE(b.until([&] { return b.source.state().phase == TcpState::Phase::waiting; }));
  peer.listen_again();
  b.source.interfaces_changed();
  ASSERT_TRUE(b.until_connected());
  EXPECT_EQ(b.source.stats().attempts, 2U);
  b.source.interfaces_changed();
  b.run(milliseconds(50));
  EXPECT_EQ(b.disconnects, 0) << "a connection that stands is left alone";
}

TEST(TcpSource, KeepsABoundedAmountForADeviceThatDoesNotRead) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  const std::string block(10'000, 'q');
  std::size_t accepted = 0;
  while (b.source.send(ByteView(block)) && accepted < 100'000'000) accepted += block.size();
  EXPECT_LT(accepted, 100'000'000U);
  EXPECT_EQ(b.source.stats().requests_dropped, 1U);
  EXPECT_GE(accepted, b.source.stats().sent + TcpOptions().send_limit - block.size());
  std::size_t read = 0;
  EXPECT_TRUE(b.until([&] { return (read += peer.read().size()) == accepted; }));
  EXPECT_EQ(b.source.stats().sent, accepted);
  EXPECT_EQ(b.disconnects, 0);
}

TEST(TcpSource, SendsNothingWithoutAConnection) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  EXPECT_FALSE(b.source.send(ByteView("x")));
  EXPECT_EQ(b.source.stats().requests_dropped, 1U);
}

TEST(TcpSource, MayBeStoppedAndDisconnectedFromItsOwnHandlers) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  b.on_receive = [&] { b.source.disconnect(true); };
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  ASSERT_TRUE(peer.send("a"));
  ASSERT_TRUE(b.until([&] { return b.disconnects == 1; }));
  EXPECT_EQ(b.fault().kind, TcpFault::Kind::dialogue_failed);
  ASSERT_TRUE(b.until_connected(2));
  b.on_receive = [&] { b.source.disconnect(false); };
  ASSERT_TRUE(peer.accept());
  ASSERT_TRUE(peer.send("b"));
  ASSERT_TRUE(b.until([&] { return b.disconnects == 2; }));
  EXPECT_EQ(b.source.state().phase, TcpState::Phase::stopped);
  b.on_connect = [&] { b.source.stop(); };
  b.source.start();
  ASSERT_TRUE(b.until_connected(3));
  b.run(milliseconds(150));
  EXPECT_EQ(b.connects, 3);
  EXPECT_EQ(b.disconnects, 2);  // stop() tells of nothing
}

TEST(TcpSource, AllocatesNothingPerChunkOnceWarm) {
  TcpPeer peer;
  Bench b(to_port(peer.port()));
  b.received.reserve(1'000'000);
  b.source.start();
  ASSERT_TRUE(b.until_connected());
  ASSERT_TRUE(peer.accept());
  const std::string block(1000, 'x');
  std::uint64_t before = 0;
  for (int i = 0; i < 60; ++i) {
    if (i == 10) before = test::allocations();
    ASSERT_TRUE(peer.send(block));
    b.source.send(ByteView("ping"));
    b.io.restart();
    while (b.received.size() < 1000U * static_cast<std::size_t>(i + 1)) b.io.run_one_for(milliseconds(100));
  }
  EXPECT_EQ(test::allocations(), before);
}

TEST(TcpSource, LeaksNothingOverAThousandDisconnects) {
  TcpPeer peer;
  TcpOptions options = to_port(peer.port());
  options.first_retry = options.last_retry = milliseconds(0);
  Bench b(options);
  b.source.start();
  std::size_t memory = 0, files = 0;
  for (int i = 1; i <= 1200; ++i) {
    ASSERT_TRUE(b.until([&] { return b.connects >= i && peer.accept(); })) << i;
    if (i == 200) memory = test::resident_bytes(), files = test::open_files();
    ASSERT_TRUE(peer.send("x"));
    b.source.send(ByteView("y"));
    i % 3 == 0 ? peer.reset_client() : peer.close_client();
    ASSERT_TRUE(b.until([&] { return b.disconnects >= i; })) << i;
  }
  ASSERT_TRUE(b.until([&] { return b.connects == 1201 && peer.accept(); }));
  peer.close_client();
  EXPECT_LE(test::open_files(), files);
#ifndef __SANITIZE_ADDRESS__  // which keeps for a while what was freed, and finds leaks itself
  EXPECT_LE(test::resident_bytes(), memory + 256 * 1024);
#endif
}

}  // namespace
}  // namespace lidard
