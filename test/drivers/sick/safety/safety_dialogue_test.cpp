// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/drivers/sick/safety/ms3_encoder.h"
#include "test/sim/devices/safety_settings.h"

namespace lidard::sick {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A driver and a scanner, whose connection passes everything in chunks of `chunk` bytes.
class Talk final : public test::DriverBench {
 public:
  explicit Talk(const DeviceRequests& requests, std::size_t chunk = 7)
      : DriverBench("sick_microscan3", config_of(requests)), chunk_(chunk) {
    settings.current = settings.persistent;
  }
  void request(ByteView bytes) override { to_device_.insert(to_device_.end(), bytes.begin(), bytes.end()); }
  void connect() override {
    ++dials;
    refused_ = !reachable;
    if (!reachable) return;
    settings.connect();
    connected_ = true;
    greet_ = true;
  }
  void disconnect(bool again) override {
    EXPECT_FALSE(again);
    connected_ = false;
    ++hang_ups;
    driver->disconnected();
  }
  /// Time passes in steps of 100 ms; every byte arrives at once.
  void run(double seconds_to_go) {
    for (int i = 0; i < static_cast<int>(seconds_to_go * 10 + 0.5); ++i) {
      now = now + std::chrono::milliseconds(100);
      if (streaming()) send_datagram();
      driver->tick(now, *this);
      if (std::exchange(refused_, false)) driver->disconnected();
      if (greet_) {
        greet_ = false;
        driver->connected(now, *this);
      }
      pass_bytes();
    }
  }
  /// The scanner sends to us.
  bool streaming() const { return settings.current.enabled && settings.current.host == home; }
  void send_datagram() {
    ++sample.sequence;
    sample.scan += 3;
    for (const test::Bytes& datagram : test::ms3_datagrams(sample.instance(), ++identification_))
      driver->receive(test::packet_of(datagram, now), *this);
  }
  std::vector<std::string> warnings() const { return driver->info().warnings; }

  static inline const IpAddress home = IpAddress::v4(192, 168, 0, 5);
  sim::SafetySettings settings;
  test::Ms3Sample sample;
  bool reachable = true;
  int dials = 0, hang_ups = 0;

 private:
  static DriverConfig config_of(const DeviceRequests& requests) {
    DriverConfig config;
    config.requests = requests;
    return config;
  }
  void pass_bytes() {
    while (connected_ && !to_device_.empty()) {
      const auto asked = std::move(to_device_);
      to_device_.clear();
      const auto answer = settings.answer(ByteView(asked.data(), asked.size()));
      feed_in_pieces(ByteView(answer.data(), answer.size()).text(), chunk_, connected_);
    }
    to_device_.clear();
  }

  std::size_t chunk_;
  std::vector<std::uint8_t> to_device_;
  bool connected_ = false;
  bool refused_ = false;
  bool greet_ = false;
  std::uint32_t identification_ = 0;
};

DeviceRequests wants(bool write) {
  DeviceRequests requests;
  requests.host_address = Talk::home;
  requests.host_port = 6060;
  requests.allow_write = write;
  return requests;
}

TEST(SafetyDialogue, DoesNotTakePlaceUnasked) {
  Talk talk({});
  talk.run(20);
  EXPECT_EQ(talk.dials, 0);
  EXPECT_THAT(talk.settings.heard, IsEmpty());
  DeviceRequests listening = wants(true);
  listening.listen_only = true;
  Talk silent(listening);
  silent.run(20);
  EXPECT_EQ(silent.dials, 0);
}

TEST(SafetyDialogue, ReadsAndTellsADifferenceButWritesNothingUnlessAllowed) {
  Talk talk(wants(false));
  talk.settings.current.enabled = true;
  talk.run(10);
  EXPECT_EQ(talk.dials, 1) << "done is done";
  EXPECT_EQ(talk.hang_ups, 1);
  EXPECT_THAT(talk.settings.heard, ElementsAre("open", "read 13", "read 3", "read 4", "read 17", "read 18",
                                               "read 33", "read 23", "read 16", "read 178", "close"));
  EXPECT_EQ(talk.driver->info().serial, "12345678");
  EXPECT_EQ(talk.detail("Type Code"), "MICS3-ACAZ40ZA1P01");
  EXPECT_EQ(talk.detail("Firmware Version"), "R 01.20");
  EXPECT_EQ(talk.detail("Device Name"), "front left");
  EXPECT_EQ(talk.detail("Project Name"), "yard");
  EXPECT_EQ(talk.detail("Application Name"), "forklift");
  EXPECT_THAT(talk.detail("Status"), HasSubstr("powered on 42 times, no error"));
  EXPECT_EQ(talk.detail("Data Output"), "192.168.0.1:6060, every scan");
  EXPECT_THAT(talk.warnings(), ElementsAre(HasSubstr(
                                   "sends to 192.168.0.1:6060, every scan, wanted is 192.168.0.5:6060, every "
                                   "scan; set allow_write: true")));
  EXPECT_THAT(talk.notes, IsEmpty());
}

TEST(SafetyDialogue, WritesNothingThatIsAlreadySo) {
  Talk talk(wants(true));
  talk.settings.persistent.enabled = true;
  talk.settings.persistent.host = Talk::home;
  talk.settings.current = talk.settings.persistent;
  talk.run(10);
  EXPECT_THAT(talk.settings.heard, testing::Not(Contains("call 176")));
  EXPECT_THAT(talk.warnings(), IsEmpty());
  EXPECT_GT(talk.scans.size(), 90U);
}

TEST(SafetyDialogue, WritesWhatDiffersOnceAndSaysSo) {
  for (const std::size_t chunk : {1U, 3U, 100'000U}) {
    DeviceRequests requests = wants(true);
    requests.skip = 1;
    Talk talk(requests, chunk);
    talk.settings.persistent.features = 0;
    talk.settings.current = talk.settings.persistent;
    talk.run(10);
    EXPECT_EQ(std::count(talk.settings.heard.begin(), talk.settings.heard.end(), "call 176"), 1);
    EXPECT_TRUE(talk.settings.current.enabled);
    EXPECT_EQ(talk.settings.current.host, Talk::home);
    EXPECT_EQ(talk.settings.current.every, 2);
    EXPECT_EQ(talk.settings.current.features, 6)
        << "geometry and measurement, nothing that was not asked for";
    EXPECT_THAT(talk.notes, ElementsAre("data output: off -> 192.168.0.5:6060, 1 of 2 scans"));
    EXPECT_EQ(talk.detail("Setting Written"), "off -> 192.168.0.5:6060, 1 of 2 scans");
    EXPECT_THAT(talk.warnings(), IsEmpty());
    EXPECT_GT(talk.scans.size(), 90U);
  }
}

TEST(SafetyDialogue, WritesNothingOverADataOutputThatItCannotRead) {
  Talk talk(wants(true));
  talk.settings.hides_output = true;
  talk.settings.current.features = 0x1e;
  talk.run(10);
  EXPECT_THAT(talk.settings.heard, testing::Not(Contains("call 176")));
  EXPECT_EQ(talk.settings.current.features, 0x1e);
  EXPECT_THAT(talk.warnings(),
              ElementsAre(HasSubstr("neither compared nor written; set it in Safety Designer")));
}

TEST(SafetyDialogue, SendsTheVolatileSettingAgainAfterAPowerCycle) {
  Talk talk(wants(true));
  talk.run(5);
  ASSERT_TRUE(talk.streaming());
  talk.reachable = false;
  talk.settings.power_cycle();
  talk.run(10);
  EXPECT_FALSE(talk.streaming());
  talk.reachable = true;
  talk.run(1);
  EXPECT_TRUE(talk.streaming()) << "whoever cannot be reached is dialled twice a second";
  EXPECT_EQ(talk.notes.size(), 2U);
}

TEST(SafetyDialogue, ReadsAgainFromTheScannerThatStreamsAfterAPauseThoughItMayNotWrite) {
  Talk talk(wants(false));
  talk.settings.current.enabled = true;
  talk.settings.current.host = Talk::home;
  talk.run(5);
  ASSERT_TRUE(talk.streaming());
  EXPECT_EQ(talk.dials, 1);
  talk.reachable = false;
  talk.settings.current.enabled = false;
  talk.run(5);
  EXPECT_FALSE(talk.streaming());
  talk.reachable = true;
  talk.settings.current.enabled = true;
  talk.settings.heard.clear();
  talk.run(10);
  EXPECT_EQ(std::count(talk.settings.heard.begin(), talk.settings.heard.end(), "open"), 1);
}

TEST(SafetyDialogue, TellsEveryRefusalWithARemedy) {
  const char* const parts[] = {
      "general error", "no channel is free; switch", "interface is not supported", "start angle", "end angle",
      "reserved bit"};
  for (std::uint8_t result = 1; result <= 6; ++result) {
    Talk talk(wants(true));
    talk.settings.refuse_with = result;
    talk.run(3);
    EXPECT_THAT(talk.warnings(), Contains(HasSubstr(parts[result - 1])));
    EXPECT_THAT(talk.warnings(), Contains(HasSubstr("refuses to send to 192.168.0.5:6060")));
    EXPECT_EQ(talk.settings.heard.back(), "close");
  }
}

TEST(SafetyDialogue, TellsASessionRefusedAnAcceptedChangeThatIsNoneAndAMuteScanner) {
  Talk refused(wants(true));
  refused.settings.refuse_session = true;
  refused.run(2);
  EXPECT_THAT(refused.warnings(), Contains(HasSubstr("refuses the CoLa 2 session")));
  Talk ignored(wants(true));
  ignored.settings.ignore_changes = true;
  ignored.run(2);
  EXPECT_THAT(ignored.warnings(),
              Contains(HasSubstr("accepted 192.168.0.5:6060, every scan but reports off")));
  Talk mute(wants(true));
  mute.settings.mute = true;
  mute.run(2);
  EXPECT_THAT(mute.warnings(), IsEmpty());
  mute.run(2);
  EXPECT_THAT(mute.warnings(), Contains(HasSubstr("does not answer on its TCP port")));
  mute.settings.mute = false;
  mute.run(4);
  EXPECT_TRUE(mute.streaming()) << "it tries again";
  EXPECT_THAT(mute.warnings(), IsEmpty());
}

TEST(SafetyDialogue, NoticesARangeThatIsNotTheModelsAndWhatTheUserShallDo) {
  Talk talk(wants(false));
  talk.settings.type_code = "MICS3-CBAZ90PZ1P01";
  talk.settings.user_action = 1U << 2U | 1U << 4U;
  talk.run(3);
  EXPECT_THAT(talk.warnings(),
              Contains(HasSubstr("is that of a scanner for 64 m, but microScan3 is configured")));
  EXPECT_THAT(talk.warnings(),
              Contains(HasSubstr("asks its user to check the environment, check the device")));
}

}  // namespace
}  // namespace lidard::sick
