// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The daemon in a process of its own: what it tells the service manager and the log until a signal ends it.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <thread>

#include "daemon/commands/commands.h"
#include "daemon/live/service.h"
#include "test/support/ros_master.h"
#include "test/support/udp_peer.h"
#include "test/support/velodyne_wire.h"

namespace lidard::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A daemon with one VLP-16; reads what it says.
class RunningDaemon {
 public:
  RunningDaemon() : port_(free_port()), config_(path()) {
    std::ofstream(config_) << "sensors: {roof: {model: velodyne_vlp16, ip_port: " << port_
                           << ", telemetry_port: " << free_port() << "}}\n";
    notified_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "lidard-run-" + std::to_string(getpid());
    name.copy(address.sun_path + 1, name.size());
    bind(notified_, reinterpret_cast<sockaddr*>(&address),
         static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size()));
    if (pipe(ends_) != 0) std::abort();
    fcntl(ends_[0], F_SETFL, O_NONBLOCK);
    const std::string master = "http://127.0.0.1:" + std::to_string(free_port());
    child_ = Child([&] {
      dup2(ends_[1], STDERR_FILENO);
      setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
      setenv("ROS_MASTER_URI", master.c_str(), 1);
      setenv("ROS_IP", "127.0.0.1", 1);
      set_up_logging("info");
      const int code = run_daemon(config_, {}, std::cerr);
      dprintf(STDERR_FILENO, "exit %d\n", code);
    });
  }
  ~RunningDaemon() {
    child_.kill();
    for (const int fd : {notified_, ends_[0], ends_[1]}) close(fd);
    std::remove(config_.c_str());
  }
  RunningDaemon(const RunningDaemon&) = delete;
  RunningDaemon& operator=(const RunningDaemon&) = delete;

  /// Waits until the log, or what the service manager was told, has these words.
  bool says(const std::string& words, int seconds = 60) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    while (std::chrono::steady_clock::now() < limit) {
      read_all();
      if ((log_ + told_).find(words) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  void read_all() {
    char buffer[4096];
    for (ssize_t n = 0; (n = read(ends_[0], buffer, sizeof buffer)) > 0;)
      log_.append(buffer, static_cast<std::size_t>(n));
    for (ssize_t n = 0; (n = recv(notified_, buffer, sizeof buffer, 0)) > 0;)
      told_.append(buffer, static_cast<std::size_t>(n)).append("\n");
  }
  void signal(int number) const { ::kill(child_.pid(), number); }
  void send(const std::vector<std::uint8_t>& bytes) const {
    UdpPeer().send(port_, ByteView(bytes.data(), bytes.size()));
  }
  const std::string& log() const { return log_; }
  const std::string& told() const { return told_; }

 private:
  static std::string path() {
    return testing::TempDir() + "lidard-run-" + std::to_string(getpid()) + ".yaml";
  }

  std::uint16_t port_;
  std::string config_;
  int notified_ = -1;
  int ends_[2] = {-1, -1};
  std::string log_, told_;
  Child child_;
};

std::size_t count(const std::string& text, const std::string& words) {
  std::size_t all = 0;
  for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++all;
  return all;
}

TEST(RunDaemon, TellsItsStateToTheServiceManagerAndTheLogUntilASignal) {
  RunningDaemon daemon;
  ASSERT_TRUE(daemon.says("READY=1")) << daemon.log();
  EXPECT_THAT(daemon.told(), HasSubstr("READY=1\nSTATUS=0/1 lidars, "));
  ASSERT_TRUE(daemon.says("STATUS=0/1 lidars, 2 of 2 ports open, ROS master absent")) << daemon.told();
  ASSERT_TRUE(daemon.says("WATCHDOG=1"));
  // Trouble is told once.
  ASSERT_TRUE(daemon.says("error: sensor roof: nothing received from any sender to port")) << daemon.log();
  EXPECT_EQ(count(daemon.log(), "sensor roof: "), 1U) << daemon.log();
  // The line is a second old at most, of items that are a second old at most.
  const auto packets = spin({"velodyne_vlp16", sim::ReturnMode::strongest, ""}, 40);
  std::size_t sent = 0;
  while (!daemon.says("STATUS=1/1 lidars", 0) && sent < packets.size()) {
    daemon.send(packets[sent++].bytes);
    daemon.read_all();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (daemon.told().find("STATUS=1/1 lidars") != std::string::npos) break;
  }
  EXPECT_THAT(daemon.told(), HasSubstr("STATUS=1/1 lidars, 2 of 2 ports open, ROS master absent"));
  daemon.signal(SIGTERM);
  ASSERT_TRUE(daemon.says("exit ")) << daemon.log();
  EXPECT_THAT(daemon.log(), AllOf(HasSubstr("info: stopping on signal 15\n"), HasSubstr("exit 0\n"),
                                  HasSubstr("info: roof (velodyne_vlp16): ")));
  EXPECT_THAT(daemon.log(), HasSubstr(" lost, rejected 0\n"));
  EXPECT_THAT(daemon.log(), Not(HasSubstr("roof (velodyne_vlp16): 0 packets")));
  EXPECT_THAT(daemon.told(), HasSubstr("STOPPING=1"));
  EXPECT_GE(count(daemon.told(), "WATCHDOG=1"), 8U) << "ten times a second, for more than one";
  EXPECT_LE(count(daemon.told(), "STATUS="), count(daemon.told(), "WATCHDOG=1") / 3) << "once a second";
}

TEST(RunDaemon, EndsWellWhileItReadsItsConfigurationAgain) {
  for (int i = 0; i < 5; ++i) {
    RunningDaemon daemon;
    ASSERT_TRUE(daemon.says("READY=1"));
    daemon.signal(SIGHUP);
    std::this_thread::sleep_for(std::chrono::milliseconds(2 * i));
    daemon.signal(SIGTERM);
    ASSERT_TRUE(daemon.says("exit 0")) << daemon.log();
  }
}

}  // namespace
}  // namespace lidard::test
