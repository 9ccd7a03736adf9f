// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/capture.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "drivers/capture/pcap_source.h"
#include "test/sim/devices/velodyne_tables.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/sim/servers/truth.h"
#include "test/sim/servers/udp_sender.h"
#include "test/support/captures.h"
#include "test/support/starved.h"

namespace {

using namespace lidard;
using namespace lidard::sim;
namespace fs = std::filesystem;

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// A folder of the test's own.
class Folder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("lidard_sim_" + std::to_string(getpid()) + test->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string in(const std::string& name) const { return folder_ / name; }
  /// Runs the program; its output stands in `output()`.
  int run(const std::string& arguments) const {
    const std::string command = std::string(LIDARD_SIM_BINARY) + " " + arguments + " >" + in("out") + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string output() const { return content(in("out")); }

  fs::path folder_;
};

// Every scene in pcaps/, so that none is forgotten.
std::vector<std::string> shipped_scenes() {
  const std::string end = ".scene.yaml";
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(test::project_file("pcaps"))) {
    const std::string name = entry.path().filename();
    const bool scene =
        name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
    if (scene) names.push_back(name.substr(0, name.size() - end.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

class Shipped : public Folder, public testing::WithParamInterface<std::string> {
 protected:
  std::string shipped() const { return test::project_file("pcaps/" + GetParam()); }
  // The truth is larger than the packets, so few captures come with theirs.
  std::vector<std::string> kinds() const {
    if (fs::exists(shipped() + ".truth")) return {".pcap", ".truth"};
    return {".pcap"};
  }
};

TEST_P(Shipped, CaptureAndTruthComeOutOfTheSceneBitByBit) {
  make_capture(load_scene(shipped() + ".scene.yaml"), in(GetParam()), kinds().size() > 1);
  for (const std::string& kind : kinds()) {
    // Not EXPECT_EQ: it would print megabytes.
    EXPECT_TRUE(content(in(GetParam() + kind)) == content(shipped() + kind))
        << GetParam() << kind << " differs; if that is meant, run: lidard-sim make pcaps/" << GetParam()
        << ".scene.yaml -o pcaps/" << GetParam() << (kinds().size() > 1 ? "" : " --no-truth");
  }
}

TEST_P(Shipped, TruthBelongsToThePacketsOfTheCapture) {
  PcapSource capture(shipped() + ".pcap");
  std::vector<Stamp> arrivals;
  for (Packet packet; capture.next(packet);) arrivals.push_back(packet.arrival);
  EXPECT_EQ(capture.error(), "");
  EXPECT_FALSE(arrivals.empty());
  EXPECT_EQ(capture.counters().datagrams + capture.counters().tcp_segments, capture.counters().frames);
  if (kinds().size() == 1) return;
  for (const SensorTruth& sensor : read_truth(shipped() + ".truth")) {
    ASSERT_FALSE(sensor.records.empty());
    for (const TruthRecord& record : sensor.records) {
      ASSERT_LT(record.record, arrivals.size());
      const double delay = seconds(arrivals[record.record] - record.end);
      ASSERT_GE(delay, 20e-6);
      ASSERT_LE(delay, 70e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Capture, Shipped, testing::ValuesIn(shipped_scenes()),
                         [](const auto& instance) { return instance.param; });

TEST(ShippedCaptures, EveryVelodyneOfTheSimulatorHasOneOfItsOwn) {
  std::set<std::string> models;
  for (const std::string& name : shipped_scenes()) {
    const Scene scene = load_scene(test::project_file("pcaps/" + name + ".scene.yaml"));
    for (const SensorEntry& sensor : scene.sensors) models.insert(sensor.model);
  }
  for (const VelodyneTable& table : velodyne_tables()) EXPECT_EQ(models.count(table.name), 1U) << table.name;
}

TEST_F(Folder, ProgramTellsUseFailureAndSuccessApart) {
  EXPECT_EQ(run("--help"), 0);
  for (const char* command : {"make", "live", "send"}) {
    EXPECT_EQ(run(std::string(command) + " --help"), 0);
    EXPECT_EQ(run(command), 2) << output();
  }
  EXPECT_EQ(run(""), 2);
  EXPECT_EQ(run("fly"), 2);
  const std::string demo = test::project_file("pcaps/demo.pcap");
  EXPECT_EQ(run("send " + demo + " --to nowhere"), 2);
  EXPECT_EQ(run("send " + demo + " --to 127.0.0.1 --rate fast"), 2);
  EXPECT_EQ(run("send " + demo + " --to 127.0.0.1 --source-map 10.0.0.1"), 2);
  EXPECT_EQ(run("send /nowhere.pcap --to 127.0.0.1"), 1);
  EXPECT_EQ(run("make /nowhere.yaml -o " + in("x")), 1);
  EXPECT_NE(output().find("/nowhere.yaml: cannot be read"), std::string::npos) << output();
  EXPECT_EQ(run("make " + test::project_file("pcaps/vlp16_dual.scene.yaml") + " -o /nowhere/x"), 1);
  EXPECT_EQ(run("make " + test::project_file("pcaps/vlp16_dual.scene.yaml") + " -o " + in("x")), 0);
  EXPECT_TRUE(fs::exists(in("x.truth")));
  EXPECT_EQ(run("make --no-truth " + test::project_file("pcaps/vlp16_dual.scene.yaml") + " -o " + in("y")),
            0);
  EXPECT_TRUE(fs::exists(in("y.pcap")));
  EXPECT_FALSE(fs::exists(in("y.truth")));
}

/// Listens on a port of its own on loopback.
class Listener {
 public:
  Listener() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    const int bytes = 8 << 20;
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(socket_, reinterpret_cast<sockaddr*>(&address_), sizeof address_);
    socklen_t length = sizeof address_;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address_), &length);
  }
  ~Listener() { close(socket_); }
  std::uint16_t port() const { return ntohs(address_.sin_port); }
  /// The next datagram and its sender's address, or false.
  bool next(std::string& payload, std::string& from) const {
    char buffer[2000];
    sockaddr_in sender{};
    socklen_t length = sizeof sender;
    const ssize_t size =
        recvfrom(socket_, buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&sender), &length);
    if (size < 0) return false;
    payload.assign(buffer, static_cast<std::size_t>(size));
    from = inet_ntoa(sender.sin_addr);
    return true;
  }

 private:
  int socket_;
  sockaddr_in address_{};
};

// A few packets of two sensors, so that they fit into any receive buffer.
std::string small_scene(std::uint16_t port) {
  const std::string to = ", to: '192.168.0.100:" + std::to_string(port) + "'}\n";
  return "start: 2026-01-01T00:00:00Z\nduration: 0.05\nsensors:\n"
         "  roof: {model: velodyne_vlp16, from: '192.168.1.201:2368'" +
         to + "  left: {model: sick_microscan3, from: '192.168.0.21:6060'" + to;
}

TEST_F(Folder, LiveAndSendGiveTheSamePacketsFromTheirOwnAddresses) {
  const Listener listener;
  std::ofstream(in("s.yaml")) << small_scene(listener.port());
  ASSERT_EQ(run("make " + in("s.yaml") + " -o " + in("s")), 0) << output();
  for (const std::string& command : {"live " + in("s.yaml"), "send " + in("s.pcap")}) {
    ASSERT_EQ(run(command + " --to 127.0.0.1 --source-map 192.168.0.21=127.0.0.21"), 0) << output();
    PcapSource capture(in("s.pcap"));
    std::string payload;
    std::string from;
    std::size_t count = 0;
    for (Packet packet; capture.next(packet); ++count) {
      ASSERT_TRUE(listener.next(payload, from)) << command << " after " << count;
      EXPECT_TRUE(payload == packet.payload.text());
      EXPECT_EQ(from, packet.from.port == 6060 ? "127.0.0.21" : "127.168.1.201");
    }
    EXPECT_GT(count, 35U);
    EXPECT_FALSE(listener.next(payload, from));
    EXPECT_NE(output().find("192.168.0.21:6060 as 127.0.0.21:"), std::string::npos) << output();
  }
}

TEST_F(Folder, SendingFromAForeignAddressFailsWithItsRemedy) {
  EXPECT_EQ(run("send " + test::project_file("pcaps/demo.pcap") +
                " --to 127.0.0.1 --source-map 192.168.1.201=203.0.113.7 --rate max"),
            1);
  EXPECT_NE(output().find("cannot send from 203.0.113.7"), std::string::npos) << output();
}

TEST(Pacer, KeepsAbsoluteTimesAtAnyRate) {
  const auto now = [] { return std::chrono::steady_clock::now(); };
  Pacer pacer(2);
  const test::Starved starved;
  const auto begin = now();
  for (int i = 0; i <= 10; ++i) pacer.wait_until({1'000'000'000 + i * 10'000'000});
  const double elapsed = std::chrono::duration<double>(now() - begin).count();
  EXPECT_GE(elapsed, 0.05);
  EXPECT_LT(elapsed, 0.5 + starved.seconds());
  Pacer fast(0);
  const auto again = now();
  fast.wait_until({0});
  fast.wait_until({3'600'000'000'000});
  EXPECT_LT(std::chrono::duration<double>(now() - again).count(), 1 + starved.seconds());
}

TEST(LocalSource, StaysTellableOnLoopbackAndIsTheSystemsChoiceElsewhere) {
  const IpAddress sender = IpAddress::v4(192, 168, 1, 201);
  Route route;
  EXPECT_EQ(local_source(route, sender, IpAddress::v4(127, 0, 0, 1))->to_string(), "127.168.1.201");
  EXPECT_FALSE(local_source(route, sender, IpAddress::v4(10, 0, 0, 1)).has_value());
  route.sources[sender] = IpAddress::v4(10, 0, 0, 7);
  EXPECT_EQ(local_source(route, sender, IpAddress::v4(10, 0, 0, 1))->to_string(), "10.0.0.7");
}

}  // namespace
