// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/sensor_loop.h"

#include <gtest/gtest.h>

#include <boost/asio/ip/udp.hpp>
#include <thread>

#include "daemon/offline/no_transforms.h"
#include "test/daemon/pipeline/line_driver.h"
#include "test/support/pipeline_bench.h"
#include "test/support/ros_master.h"
#include "test/support/starved.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::atomic<int> taken{0};

/// Takes 10 ms for each packet, as where a machine is overloaded.
class SlowDriver final : public Driver {
 public:
  Verdict receive(const Packet&, FrameReceiver&) override {
    ++counters_.packets;
    std::this_thread::sleep_for(10ms);
    ++taken;
    return {true, Reject::none};
  }
  void restart() override {}
  const Counters& counters() const override { return counters_; }
  const DeviceInfo& info() const override { return info_; }

 private:
  Counters counters_;
  DeviceInfo info_;
};

TEST(SensorLoop, ShowsThatItLivesWhileItCatchesUp) {
  boost::asio::io_context io;
  boost::asio::ip::udp::socket sender(io, {boost::asio::ip::address_v4::loopback(), 0});
  const std::uint16_t port = free_port();
  Model model = line_model(Transport::udp, port);
  model.make = [](const DriverConfig&) -> std::unique_ptr<Driver> { return std::make_unique<SlowDriver>(); };
  Config config;
  config.sensors.push_back(line_sensor(model, "front", IpAddress::v4(127, 0, 0, 1)));
  DaemonClock clock;
  BlackBox box({}, [](bool, const std::string&) {});
  NoTransforms poses;
  RecordingSink sink{false};
  SensorLoop loop(config, clock, box, poses, sink);
  std::thread thread([&] { loop.run(); });
  const boost::asio::ip::udp::endpoint to(boost::asio::ip::address_v4::loopback(), port);
  for (taken = 0; taken == 0; std::this_thread::sleep_for(20ms))
    sender.send_to(boost::asio::buffer("first", 5), to);
  constexpr int backlog = 250;
  const int before = taken;
  for (int i = 0; i < backlog; ++i) sender.send_to(boost::asio::buffer("more", 4), to);
  const Starved starved;
  std::uint64_t rounds = loop.rounds();
  Clock::time_point changed = Clock::now();
  Span longest{0};
  while (taken < before + 150 && Clock::now() - changed < 20s) {
    std::this_thread::sleep_for(5ms);
    longest = std::max<Span>(longest, Clock::now() - changed);
    if (std::exchange(rounds, loop.rounds()) != loop.rounds()) changed = Clock::now();
  }
  EXPECT_LT(longest, 400ms + starved.time()) << "a round is due every 100 ms";
  loop.stop();
  thread.join();
}

}  // namespace
}  // namespace lidard::test
