// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/udp_source.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "drivers/net/udp_socket.h"
#include "test/drivers/net/udp_bench.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using test::ip;
using test::Sender;
using test::UdpBench;

TEST(UdpSource, ReceivesUnicastWithSenderAndReceiver) {
  UdpBench bench;
  ASSERT_EQ(bench.source.state().phase, UdpState::Phase::receiving) << bench.source.state().fault.error;
  Sender sender("127.0.0.2");
  ASSERT_TRUE(sender.send(bench.port(), "hello"));
  ASSERT_TRUE(bench.run_until_count(1));
  EXPECT_EQ(bench.text, "hello");
  EXPECT_EQ(bench.last.from.address, IpAddress::v4(127, 0, 0, 2));
  EXPECT_NE(bench.last.from.port, 0);
  EXPECT_EQ(bench.last.to.address, IpAddress::v4(127, 0, 0, 1));
  EXPECT_EQ(bench.last.to.port, bench.port());
  EXPECT_EQ(bench.source.stats().datagrams, 1U);
  EXPECT_EQ(bench.source.stats().bytes, 5U);
  EXPECT_EQ(bench.source.stats().kernel_drops, 0U);
}

TEST(UdpSource, StampsTheArrivalNotTheReading) {
  UdpBench bench;
  Sender sender;
  // The kernel switches stamping on in the background; until then it stamps when the datagram is read.
  double late = 1;
  for (std::uint64_t attempt = 1; attempt <= 20 && late > 20e-3; ++attempt) {
    ASSERT_TRUE(sender.send(bench.port(), "x"));
    const auto sent = std::chrono::system_clock::now().time_since_epoch();
    std::this_thread::sleep_for(milliseconds(50));
    ASSERT_TRUE(bench.run_until_count(attempt));
    late = std::abs(seconds(Span(bench.last.received.ns) - Span(sent)));
  }
  EXPECT_LT(late, 20e-3);
}

TEST(UdpSource, ReceivesBroadcastsFromListedSenders) {
  UdpOptions options;
  options.senders = {IpAddress::v4(127, 0, 0, 3)};
  UdpBench bench(options);
  Sender sender("127.0.0.3");
  ASSERT_TRUE(sender.send(bench.port(), "to all", "127.255.255.255"));
  ASSERT_TRUE(bench.run_until_count(1));
  EXPECT_EQ(bench.text, "to all");
}

TEST(UdpSource, ReceivesMulticastOfJoinedGroups) {
  UdpOptions options;
  options.groups = {{IpAddress::v4(239, 1, 2, 3), "lo"}};
  UdpBench bench(options);
  if (bench.source.state().phase != UdpState::Phase::receiving)
    GTEST_SKIP() << "no multicast on lo here: " << bench.source.state().fault.error;
  Sender sender;
  const in_addr loopback{htonl(INADDR_LOOPBACK)};
  setsockopt(sender.fd(), IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof loopback);
  if (!sender.send(bench.port(), "group", "239.1.2.3")) GTEST_SKIP() << "the kernel sends no multicast on lo";
  ASSERT_TRUE(bench.run_until_count(1));
  EXPECT_EQ(bench.last.to.address, IpAddress::v4(239, 1, 2, 3));
}

TEST(UdpSource, MissingInterfaceIsNamedWhileUnicastGoesOn) {
  UdpOptions options;
  options.groups = {{IpAddress::v4(239, 1, 2, 3), "lidar9"}};
  UdpBench bench(options);
  EXPECT_EQ(bench.source.state().phase, UdpState::Phase::partial);
  EXPECT_EQ(bench.source.state().fault.error, ENXIO);
  EXPECT_EQ(bench.source.state().fault.group.interface, "lidar9");
  Sender sender;
  sender.send(bench.port(), "x");
  EXPECT_TRUE(bench.run_until_count(1));
}

TEST(UdpSource, TellsSensorsOnOnePortApart) {
  UdpBench bench;
  Sender a("127.0.0.2"), b("127.0.0.3"), c("127.0.0.4");
  for (int i = 0; i < 10; ++i) {
    a.send(bench.port(), "a");
    b.send(bench.port(), "b");
    if (i % 2 == 0) c.send(bench.port(), "c");
  }
  ASSERT_TRUE(bench.run_until_count(25));
  EXPECT_EQ(bench.by_sender["127.0.0.2"], 10);
  EXPECT_EQ(bench.by_sender["127.0.0.3"], 10);
  EXPECT_EQ(bench.by_sender["127.0.0.4"], 5);
}

TEST(UdpSource, KernelFilterLetsASampleOfStrangersThrough) {
  UdpOptions options;
  options.senders = {IpAddress::v4(127, 0, 0, 2), IpAddress::v4(127, 0, 0, 3)};
  UdpBench bench(options);
  Sender a("127.0.0.2"), b("127.0.0.3"), stranger("127.0.0.9");
  constexpr int sent = 6400;
  for (int i = 0; i < sent; ++i) {
    stranger.send(bench.port(), "?");
    if (i % 100 == 0) a.send(bench.port(), "a");
    if (i % 100 == 50) b.send(bench.port(), "b");
    if (i % 10 == 0) bench.run(milliseconds(0));
  }
  a.send(bench.port(), "a");
  ASSERT_TRUE(bench.run_until([&] { return bench.by_sender["127.0.0.2"] == 65; }));
  EXPECT_EQ(bench.by_sender["127.0.0.3"], 64);
  // Binomial with mean 100 and deviation 10.
  EXPECT_GT(bench.by_sender["127.0.0.9"], 50);
  EXPECT_LT(bench.by_sender["127.0.0.9"], 150);
  const UdpStats& stats = bench.source.stats();
  EXPECT_EQ(stats.unknown_sampled, static_cast<std::uint64_t>(bench.by_sender["127.0.0.9"]));
  EXPECT_EQ(stats.unknown_sampled + stats.unknown_filtered, static_cast<std::uint64_t>(sent));
  // Those after the last sample are not yet known.
  EXPECT_LE(bench.stands_for, static_cast<std::uint64_t>(sent));
  EXPECT_GT(bench.stands_for, static_cast<std::uint64_t>(sent - 1000));
  EXPECT_EQ(stats.kernel_drops, 0U);
}

TEST(UdpSource, PortInUseIsExplainedAndTakenWhenFree) {
  auto other = std::make_unique<UdpBench>();
  UdpOptions options;
  options.port = other->port();
  UdpBench bench(options);
  EXPECT_EQ(bench.source.state().phase, UdpState::Phase::waiting);
  std::string own_name;
  std::getline(std::ifstream("/proc/self/comm"), own_name);
  const UdpFault& fault = bench.source.state().fault;
  EXPECT_EQ(fault.error, EADDRINUSE);
  EXPECT_EQ(fault.holder.program, own_name);
  EXPECT_EQ(fault.holder.process, std::to_string(getpid()));
  bench.run(milliseconds(250));
  EXPECT_EQ(bench.source.state().phase, UdpState::Phase::waiting);
  other.reset();
  ASSERT_TRUE(bench.run_until([&] { return bench.source.state().phase == UdpState::Phase::receiving; }));
  EXPECT_FALSE(bench.source.state().fault);
  Sender sender;
  sender.send(bench.port(), "late");
  EXPECT_TRUE(bench.run_until_count(1));
}

TEST(UdpSource, TriesAtOnceWhenInterfacesHaveChanged) {
  UdpBench holder;
  UdpOptions options;
  options.port = holder.port();
  UdpBench bench(options);
  bench.run(milliseconds(2500));  // by then the next attempt is a second away
  ASSERT_EQ(bench.source.state().phase, UdpState::Phase::waiting);
  holder.source.stop();
  bench.source.interfaces_changed();
  EXPECT_EQ(bench.source.state().phase, UdpState::Phase::receiving) << bench.source.state().fault.error;
  bench.run(milliseconds(1500));  // the attempt that was planned is forgotten
  Sender sender;
  ASSERT_TRUE(sender.send(bench.port(), "hello"));
  EXPECT_TRUE(bench.run_until_count(1));
  EXPECT_EQ(bench.source.stats().wakeups, 1U);
}

TEST(UdpSource, ForeignAddressIsExplained) {
  UdpOptions options;
  options.address = IpAddress::v4(192, 0, 2, 77);
  UdpBench bench(options);
  EXPECT_EQ(bench.source.state().phase, UdpState::Phase::waiting);
  EXPECT_EQ(bench.source.state().fault.error, EADDRNOTAVAIL);
}

TEST(UdpSource, SharedPortDeliversBroadcastsToBoth) {
  UdpOptions options;
  options.share_port = true;
  UdpBench first(options);
  options.port = first.port();
  UdpBench second(options);
  ASSERT_EQ(second.source.state().phase, UdpState::Phase::receiving) << second.source.state().fault.error;
  Sender sender;
  sender.send(first.port(), "both", "127.255.255.255");
  EXPECT_TRUE(first.run_until_count(1));
  EXPECT_TRUE(second.run_until_count(1));
}

TEST(UdpSource, OversizedDatagramIsCountedAndLeftOut) {
  UdpOptions options;
  options.max_datagram = 1500;
  UdpBench bench(options);
  Sender sender;
  sender.send(bench.port(), std::string(1501, 'x'));
  sender.send(bench.port(), std::string(1500, 'y'));
  sender.send(bench.port(), "");
  ASSERT_TRUE(bench.run_until_count(2));
  EXPECT_EQ(bench.source.stats().truncated, 1U);
  EXPECT_EQ(bench.source.stats().datagrams, 2U);
  EXPECT_EQ(bench.source.stats().bytes, 1500U);
}

TEST(UdpSource, CountsWhatTheKernelDropped) {
  for (const bool filtered : {false, true}) {
    UdpOptions options;
    options.receive_buffer = 8192;
    if (filtered) options.senders = {IpAddress::v4(127, 0, 0, 1)};
    UdpBench bench(options);
    Sender sender;
    constexpr std::uint64_t sent = 200;
    for (std::uint64_t i = 0; i < sent; ++i) sender.send(bench.port(), std::string(1206, 'v'));
    bench.run(milliseconds(50));
    sender.send(bench.port(), "the counter comes with the next datagram");
    ASSERT_TRUE(bench.run_until([&] { return bench.text.size() != 1206; }));
    const UdpStats& stats = bench.source.stats();
    EXPECT_GT(stats.kernel_drops, 100U);
    EXPECT_EQ(stats.kernel_drops + stats.datagrams, sent + 1);
    EXPECT_EQ(stats.unknown_filtered, 0U);
  }
}

TEST(UdpSource, AsksForABufferThatFitsTheRateAndSaysWhatIsMissing) {
  UdpOptions options;
  options.packets_per_s = 1507;
  UdpBench bench(options);
  EXPECT_EQ(bench.source.stats().receive_buffer_asked, 1041638U);  // 1507 / s x 0.6 s x 1152
  options.packets_per_s = 1e6;
  UdpBench greedy(options);
  const UdpStats& stats = greedy.source.stats();
  EXPECT_EQ(stats.receive_buffer_asked, 691200000U);
  EXPECT_LE(
      std::abs(seconds(stats.receive_buffer_lasts) - static_cast<double>(stats.receive_buffer_got) / 1152e6),
      1e-6);
  options.packets_per_s = 1;
  UdpBench modest(options);
  EXPECT_GE(modest.source.stats().receive_buffer_got, 50000U) << "never below the system's default";
  EXPECT_GE(modest.source.stats().receive_buffer_got, modest.source.stats().receive_buffer_asked);
}

TEST(UdpSource, StopsAtOnceAndStartsAgain) {
  UdpBench bench;
  Sender sender;
  const std::uint16_t port = bench.port();
  sender.send(port, "queued");
  bench.source.stop();
  EXPECT_EQ(bench.source.state().phase, UdpState::Phase::stopped);
  EXPECT_EQ(bench.port(), 0);
  bench.run(milliseconds(20));
  EXPECT_EQ(bench.count, 0U);
  bench.source.start();
  sender.send(bench.port(), "again");
  ASSERT_TRUE(bench.run_until_count(1));
  EXPECT_EQ(bench.text, "again");
  bench.source.stop();
  bench.run(milliseconds(2000));
  EXPECT_TRUE(bench.io.stopped()) << "something keeps the loop alive";
}

TEST(UdpSource, HandlerMayStopTheSource) {
  boost::asio::io_context io;
  std::unique_ptr<UdpSource> source;
  int count = 0;
  source = std::make_unique<UdpSource>(io, UdpOptions(), [&](const std::vector<Packet>&) {
    ++count;
    source->stop();
  });
  source->start();
  Sender sender;
  for (int i = 0; i < 5; ++i) sender.send(source->local_port(), "x");
  io.run_for(milliseconds(100));
  EXPECT_EQ(count, 1);
}

TEST(UdpSource, LosesNothingAtTheRateOfADualReturnVlp16) {
  UdpOptions options;
  options.packets_per_s = 1507;
  UdpBench bench(options);
  constexpr std::uint64_t sent = 3014;
  std::thread lidar([port = bench.port()] {
    Sender sender;
    const auto begin = std::chrono::steady_clock::now();
    for (std::uint64_t i = 0; i < sent; ++i) {
      std::this_thread::sleep_until(begin + std::chrono::nanoseconds(663'570) * static_cast<std::int64_t>(i));
      sender.send(port, std::string(1206, 'v'));
    }
  });
  bench.run_until([&] { return bench.count >= 100; });
  const std::uint64_t warm = bench.count, before = test::allocations();
  bench.io.restart();
  bench.io.run_for(milliseconds(500));
  // The handler of the bench keeps a copy of each payload: one allocation each, no more.
  EXPECT_LE(test::allocations() - before, bench.count - warm + 5);
  EXPECT_GT(bench.count, warm);
  bench.run_until([&] { return bench.count >= sent; });
  lidar.join();
  EXPECT_EQ(bench.count, sent);
  EXPECT_EQ(bench.source.stats().kernel_drops, 0U);
  EXPECT_LE(bench.source.stats().wakeups, sent + 10);
}

}  // namespace
}  // namespace lidard
