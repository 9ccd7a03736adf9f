// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <thread>

#include "test/drivers/net/udp_bench.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using test::Sender;
using test::UdpBench;

/// Sends `packets_per_s` to a port for as long as it lives.
class Stream {
 public:
  Stream(std::uint16_t port, int packets_per_s)
      : thread_([this, port, packets_per_s] {
          Sender sender;
          auto next = std::chrono::steady_clock::now();
          for (; !ended_; std::this_thread::sleep_until(next += milliseconds(1))) {
            for (int i = 0; i < packets_per_s / 1000; ++i) sent_ += sender.send(port, std::string(1206, 'v'));
          }
        }) {}
  ~Stream() { end(); }
  std::uint64_t end() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
    return sent_;
  }

 private:
  std::atomic<bool> ended_{false};
  std::uint64_t sent_ = 0;
  std::thread thread_;
};

TEST(UdpSource, ReadsABusyPortByTheClockAndLosesNothing) {
  UdpOptions options;
  options.packets_per_s = 8000;
  UdpBench bench(options);
  Stream stream(bench.port(), 8000);
  bench.run_until_count(4000);
  const std::uint64_t wakeups = bench.source.stats().wakeups, count = bench.count;
  const auto begin = std::chrono::steady_clock::now();
  bench.run_until_count(count + 8000);
  const double passed_ms = 1e3 * seconds(std::chrono::steady_clock::now() - begin);
  EXPECT_LE(static_cast<double>(bench.source.stats().wakeups - wakeups), passed_ms + 10);
  const std::uint64_t sent = stream.end();
  EXPECT_TRUE(bench.run_until_count(sent));
  EXPECT_EQ(bench.count, sent);
  EXPECT_EQ(bench.source.stats().kernel_drops, 0U);
}

TEST(UdpSource, SleepsUntilTheNextDatagramOnceABusyPortIsQuiet) {
  UdpBench bench;
  {
    Stream stream(bench.port(), 8000);
    bench.run_until_count(4000);
  }
  bench.run(milliseconds(500));
  const std::uint64_t wakeups = bench.source.stats().wakeups, count = bench.count;
  bench.run(milliseconds(300));
  EXPECT_EQ(bench.source.stats().wakeups, wakeups);
  Sender sender;
  sender.send(bench.port(), "one");
  ASSERT_TRUE(bench.run_until_count(count + 1));
  EXPECT_EQ(bench.source.stats().wakeups, wakeups + 1);
  EXPECT_EQ(bench.text, "one");
}

TEST(UdpSource, CatchesUpWithABusyPortBeforeItsTime) {
  UdpBench bench;
  Stream stream(bench.port(), 8000);
  bench.run_until_count(4000);
  const std::uint64_t sent = stream.end();
  for (int i = 0; i < 100 && bench.count < sent; ++i) bench.source.catch_up();  // without the loop
  EXPECT_EQ(bench.count, sent);
}

TEST(UdpSource, ABusyPortStopsAndStartsAgain) {
  UdpBench bench;
  Stream stream(bench.port(), 8000);
  bench.run_until_count(4000);
  bench.source.stop();
  stream.end();
  const std::uint64_t count = bench.count;
  bench.source.catch_up();
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.count, count);
  EXPECT_TRUE(bench.io.stopped()) << "something keeps the loop alive";
  bench.source.start();
  Sender sender;
  sender.send(bench.port(), "again");
  ASSERT_TRUE(bench.run_until_count(count + 1));
  EXPECT_EQ(bench.text, "again");
}

}  // namespace
}  // namespace lidard
