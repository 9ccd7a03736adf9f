// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/udp_ports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <sstream>

#include "test/support/recording_sink.h"
#include "test/support/ros_master.h"
#include "test/support/udp_peer.h"

namespace lidard::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// What is logged meanwhile.
class Logged {
 public:
  Logged() : before_(spdlog::default_logger()) {
    auto logger =
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(text_));
    logger->set_pattern("%l: %v");
    spdlog::set_default_logger(logger);
  }
  ~Logged() { spdlog::set_default_logger(before_); }
  Logged(const Logged&) = delete;
  Logged& operator=(const Logged&) = delete;
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

struct Ports {
  explicit Ports(const std::string& yaml)
      : config(parse_config(yaml, "c")), ports(io, config, [this](const std::vector<Packet>& packets) {
          for (const Packet& packet : packets) received.emplace_back(packet.to.port, packet.payload.size());
        }) {
    ports.start();
  }
  ~Ports() { ports.stop(); }
  Ports(const Ports&) = delete;
  Ports& operator=(const Ports&) = delete;
  template <class Condition>
  bool until(Condition done) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!done() && std::chrono::steady_clock::now() < limit) {
      io.restart();
      io.run_for(std::chrono::milliseconds(5));
    }
    return done();
  }
  std::vector<DiagnosticItem> items() const {
    std::vector<DiagnosticItem> all;
    ports.add_diagnostics(all);
    return all;
  }

  boost::asio::io_context io;
  std::vector<std::pair<std::uint16_t, std::size_t>> received;
  Config config;
  UdpPorts ports;
};

/// Its telemetry has a port of its own: tests that run beside each other must not meet at the model's.
std::string roof(std::uint16_t port, const std::string& more = "") {
  return "roof: {model: velodyne_vlp16, ip_port: " + std::to_string(port) +
         ", telemetry_port: " + std::to_string(free_port()) + more + "}";
}

TEST(UdpPorts, AreOneForEachPortOfDataAndTelemetryHoweverManySensorsSendThere) {
  const std::uint16_t one = free_port(), two = free_port(), telemetry = free_port();
  const auto velodyne = [&](const std::string& host) {
    return "{model: velodyne_vlp16, ip_port: " + std::to_string(one) + ", ip_address: " + host +
           ", telemetry_port: " + std::to_string(telemetry) + "}";
  };
  Ports ports("sensors: {roof: " + velodyne("127.0.0.1") + ", mast: " + velodyne("127.0.0.2") +
              ", rear: {model: sick_microscan3, ip_port: " + std::to_string(two) +
              ", ip_address: 127.0.0.1}, other: {topic: /scan}}");
  const auto items = ports.items();
  std::vector<std::string> names;
  for (const DiagnosticItem& item : items) {
    names.push_back(item.name);
    EXPECT_EQ(item.hardware_id, item.name);
    EXPECT_TRUE(item.is_up.has_value());
  }
  std::vector<std::string> wanted = {"port " + std::to_string(one), "port " + std::to_string(two),
                                     "port " + std::to_string(telemetry)};
  EXPECT_THAT(names, ::testing::UnorderedElementsAreArray(wanted));
}

TEST(UdpPorts, HandOnWhatTheSensorSendsAndCountWhatOthersSend) {
  const std::uint16_t port = free_port();
  Ports open("sensors: {" + roof(port) + "}");
  const UdpPeer sender;
  sender.send(port, ByteView("hello"));
  sender.send(port, ByteView("you"));
  ASSERT_TRUE(open.until([&] { return open.received.size() == 2; }));
  EXPECT_THAT(open.received, ElementsAre(std::pair(port, std::size_t{5}), std::pair(port, std::size_t{3})));
  for (const DiagnosticItem& item : open.items()) {
    if (item.name != "port " + std::to_string(port)) continue;
    EXPECT_EQ(value_of(item, "Datagrams"), "2");
    EXPECT_EQ(value_of(item, "Kernel drops"), "0");
    EXPECT_EQ(value_of(item, "Truncated"), "0");
    EXPECT_EQ(value_of(item, "From unknown senders"), "0");
    EXPECT_NE(value_of(item, "Receive buffer (bytes)"), "0");
    EXPECT_NE(item.health, Health::error);
  }

  const std::uint16_t other = free_port();
  Ports closed("sensors: {" + roof(other, ", ip_address: 127.0.0.9") + "}");
  for (int i = 0; i < 20; ++i) sender.send(other, ByteView("stranger"));
  EXPECT_TRUE(closed.until([&] {
    for (const DiagnosticItem& item : closed.items())
      if (item.name == "port " + std::to_string(other) && value_of(item, "From unknown senders") != "0")
        return true;
    sender.send(other, ByteView("stranger"));
    return false;
  }));
}

TEST(UdpPorts, SayWhoHasAPortAndOpenItWhenItIsFree) {
  const Logged log;
  const std::uint16_t port = free_port();
  auto other = std::make_unique<UdpPeer>();
  ASSERT_TRUE(other->take(port));
  Ports ports("sensors: {" + roof(port) + "}");
  const auto item = [&] {
    for (const DiagnosticItem& one : ports.items())
      if (one.name == "port " + std::to_string(port)) return one;
    return DiagnosticItem();
  };
  ASSERT_TRUE(ports.until([&] { return item().health == Health::error; }));
  EXPECT_THAT(item().message, HasSubstr("port " + std::to_string(port) + " is in use"));
  EXPECT_EQ(item().is_up, false);
  ports.ports.note_changes();
  EXPECT_THAT(item().message, HasSubstr("in use by another program"));
  EXPECT_THAT(item().message, testing::EndsWith(", process " + std::to_string(getpid()) + ")"));
  EXPECT_FALSE(item().logged) << "the journal logs it as anything else";
  EXPECT_EQ(log.text().find("in use"), std::string::npos) << log.text();
  other.reset();
  ASSERT_TRUE(ports.until([&] { return item().health != Health::error; }));
  EXPECT_EQ(item().is_up, true);
  EXPECT_TRUE(item().message == "listening" || item().health == Health::warn) << item().message;
  ports.ports.note_changes();
  ports.ports.note_changes();
  const std::string said = "info: listening on port " + std::to_string(port) + "\n";
  EXPECT_THAT(log.text(), HasSubstr(said));
  EXPECT_EQ(log.text().find(said, log.text().find(said) + 1), std::string::npos) << "once";
}

TEST(UdpPorts, AreNoneWithoutASensorThatSendsDatagrams) {
  const Ports ports("sensors: {other: {topic: /scan}}");
  EXPECT_TRUE(ports.items().empty());
}

}  // namespace
}  // namespace lidard::test
