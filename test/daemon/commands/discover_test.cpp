// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/discover.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "drivers/hokuyo/models.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_models.h"
#include "test/sim/devices/scip_device.h"
#include "test/sim/servers/device_server.h"

namespace lidard {
namespace {

using testing::HasSubstr;

const IpAddress here = IpAddress::v4(127, 0, 0, 1);

std::string sick_answer() {
  return std::string("\x10\x00\x00\x00garbage before", 18) +
         "<?xml version=\"1.0\"?><NetScanResult><Item key=\"IPAddress\" value=\"192.168.0.77\"/>"
         "<Item key=\"DeviceType\" value=\"LMS111\"/><Item key=\"SerialNumber\" value=\"12345678\"/>"
         "<FirmwareVersion>V1.2</FirmwareVersion></NetScanResult>";
}

/// A SICK device on loopback: answers the first datagram with `answer`.
class Responder {
 public:
  explicit Responder(std::string answer) : answer_(std::move(answer)) {
    fd_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    const timeval limit{5, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    socklen_t size = sizeof address;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Responder() {
    thread_.join();
    ::close(fd_);
  }
  Responder(const Responder&) = delete;
  Responder& operator=(const Responder&) = delete;

  std::uint16_t port = 0;
  std::string request;  ///< valid once an answer came

 private:
  void serve() {
    char buffer[256];
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto got = ::recvfrom(fd_, buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (got <= 0) return;
    request.assign(buffer, static_cast<std::size_t>(got));
    ::sendto(fd_, answer_.data(), answer_.size(), 0, reinterpret_cast<sockaddr*>(&from), size);
  }

  std::string answer_;
  int fd_ = -1;
  std::thread thread_;
};

TEST(Discover, TheSearchIsTwentyFourBytesWithOwnAddressAndMask) {
  const std::string bytes =
      sick::discovery().question(0x01020304, IpAddress::v4(192, 168, 0, 2), IpAddress::v4(255, 255, 255, 0));
  const std::array<std::uint8_t, 24> expected = {0x10, 0,    0, 0x08, 0xff, 0xff, 0xff, 0xff,
                                                 0xff, 0xff, 1, 2,    3,    4,    0x01, 0x02,
                                                 192,  168,  0, 2,    255,  255,  255,  0};
  EXPECT_EQ(bytes, std::string(expected.begin(), expected.end()));
}

TEST(Discover, ReadsAnswersOfSickDevicesAndNothingElse) {
  const std::string text = sick_answer();
  const auto read = [](std::string_view answer) {
    return sick::discovery().read_answer(ByteView(answer), here);
  };
  const auto device = read(text);
  ASSERT_TRUE(device);
  EXPECT_EQ(device->product, "LMS111");
  EXPECT_EQ(device->serial, "12345678");
  EXPECT_EQ(device->firmware, "V1.2");
  EXPECT_EQ(device->address, IpAddress::v4(192, 168, 0, 77));
  EXPECT_EQ(device->model, "sick_lms1xx");
  for (std::size_t length = 0; length + 1 < text.size(); ++length)
    EXPECT_FALSE(read(std::string_view(text).substr(0, length))) << length;
  EXPECT_FALSE(read("<?xml version=\"1.0\"?><Other/>"));
  EXPECT_EQ(read("<NetScanResult/>")->address, here);
}

TEST(Discover, ReadsAnswersOfHokuyosThatAnswerTheQuestion) {
  const auto read = [](std::string_view answer) {
    return hokuyo::discovery().read_answer(ByteView(answer), here);
  };
  ASSERT_TRUE(read("VV\n00P\n\n"));
  EXPECT_FALSE(read("VV\n10Q\n\n")) << "a refusal";
  EXPECT_FALSE(read("II\n00P\n\n")) << "an answer to another question";
  EXPECT_TRUE(read("II\n00P\n\nVV\n00P\n\n"));
}

TEST(Discover, EachWayOfAskingHasAnOptionOfItsOwn) {
  std::set<std::string_view> names;
  for (const Family& family : families()) {
    if (family.discovery == nullptr) continue;
    EXPECT_TRUE(names.insert(family.discovery->name).second) << family.discovery->name;
  }
  EXPECT_EQ(names, (std::set<std::string_view>{"hokuyo", "sick"}));
}

TEST(Discover, ListsWhatAnswersOnLoopback) {
  sim::ScipDeviceOptions ust;
  ust.product = "UST-20LX";
  sim::DeviceServer device({here, 0},
                           std::make_unique<sim::ScipDevice>(
                               ust, [](Stamp) { return std::vector<sim::ScipStep>(); }, sim::now_of_host()));
  Responder responder(sick_answer());
  DiscoverOptions options;
  options.targets = {{&hokuyo::discovery(), {here, device.port()}},
                    {&sick::discovery(), {here, responder.port}}};
  options.wait = 1;
  options.json = true;
  std::ostringstream out, err;
  EXPECT_EQ(run_discover(options, out, err), 0);
  const auto list = nlohmann::json::parse(out.str());
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].at("product"), "UST-20LX");
  EXPECT_EQ(list[0].at("model"), "hokuyo_ust_20lx");
  EXPECT_EQ(list[0].at("serial"), "H1234567");
  EXPECT_EQ(list[0].at("address"), "127.0.0.1");
  EXPECT_EQ(list[1].at("product"), "LMS111");
  EXPECT_EQ(list[1].at("address"), "192.168.0.77");
  EXPECT_EQ(responder.request.size(), 24U);
  device.with<sim::ScipDevice>([](sim::ScipDevice& asked) { EXPECT_EQ(asked.received(), "VV\n"); });
}

TEST(Discover, SaysWhereItAskedWhenNothingAnswers) {
  DiscoverOptions options;
  options.targets = {{&hokuyo::discovery(), {here, 1}}, {&sick::discovery(), {here, 1}}};
  options.wait = 0.2;
  std::ostringstream out, err;
  EXPECT_EQ(run_discover(options, out, err), 1);
  EXPECT_EQ(out.str(), "");
  EXPECT_THAT(err.str(), HasSubstr("nothing answered within 0.2 s from 127.0.0.1:1"));
}

}  // namespace
}  // namespace lidard
