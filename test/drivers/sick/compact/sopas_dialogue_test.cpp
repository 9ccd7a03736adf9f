// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include "drivers/registry/registry.h"
#include "test/drivers/sick/compact/segment_bench.h"
#include "test/sim/devices/sopas_device.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;
using testing::ElementsAre;
using testing::HasSubstr;

/// A picoScan150's driver with its device at the other end of the cable.
class Cable final : public DriverBench {
 public:
  explicit Cable(DeviceRequests requests) : DriverBench("sick_picoscan150", config_of(std::move(requests))) {}
  void connect() override { dialled = true; }
  void disconnect(bool) override { open = false; }
  void request(ByteView bytes) override { to_device += bytes.text(); }

  /// Time passes in ticks of 0.1 s; what is asked is answered at once, in pieces of `piece` bytes.
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 10 + 0.5); ++i) {
      now = now + std::chrono::milliseconds(100);
      driver->tick(now, *this);
      if (dialled && reachable) {
        dialled = false;
        open = true;
        ++connections;
        driver->connected(now, *this);
      }
      exchange();
    }
  }
  /// A segment of the stream came.
  void hear() {
    const SegmentBench bench;
    const auto bytes = bench.encode(bench.segment(heard / 10, static_cast<int>(heard % 10)));
    ++heard;
    Packet packet;
    packet.payload = view_of(bytes);
    packet.arrival = now;
    driver->receive(packet, *this);
  }
  std::string warning() const {
    return driver->info().warnings.empty() ? std::string() : driver->info().warnings.back();
  }

  sim::SopasDevice device;
  bool reachable = true, answers = true, closes = false;
  bool dialled = false, open = false;
  int connections = 0;
  std::size_t piece = 5;
  std::uint64_t heard = 0;

 private:
  static DriverConfig config_of(DeviceRequests requests) {
    DriverConfig config;
    config.requests = std::move(requests);
    return config;
  }
  void exchange() {
    if (closes && open && !to_device.empty()) {
      to_device.clear();
      open = false;
      driver->disconnected();
    }
    while (open && answers && !to_device.empty()) {
      const std::string asked = std::move(to_device);
      to_device.clear();
      const std::string reply = device.receive(asked);
      feed_in_pieces(reply, piece, open);
    }
    if (!open) {
      to_device.clear();
      device.disconnected();
      driver->disconnected();
    }
  }
  std::string to_device;
};

DeviceRequests to_host(const char* address, bool allow_write = false) {
  DeviceRequests requests;
  requests.host_address = IpAddress::parse(address);
  requests.allow_write = allow_write;
  return requests;
}

const char* const reads[] = {"sRN ScanDataEthSettings", "sRN ScanDataFormat", "sRN ScanDataEnable",
                             "sRN ImuDataEthSettings", "sRN ImuDataEnable"};

TEST(SopasDialogue, NothingIsConnectedByDefaultOrWhenOnlyListening) {
  DeviceRequests listening = to_host("192.168.0.100", true);
  listening.listen_only = true;
  for (const DeviceRequests& requests : {DeviceRequests(), listening}) {
    Cable cable(requests);
    cable.run(5);
    EXPECT_EQ(cable.connections, 0);
    EXPECT_FALSE(cable.dialled);
  }
}

TEST(SopasDialogue, ADeviceThatAgreesIsReadAndNothingElse) {
  for (const bool allow_write : {false, true}) {
    Cable cable(to_host("192.168.0.100", allow_write));
    cable.run(0.5);
    cable.hear();
    cable.run(0.5);
    EXPECT_EQ(cable.connections, 1);
    EXPECT_FALSE(cable.open);
    EXPECT_EQ(cable.device.commands, std::vector<std::string>(std::begin(reads), std::end(reads)));
    EXPECT_TRUE(cable.warning().empty()) << cable.warning();
  }
}

TEST(SopasDialogue, AStreamThatIsSwitchedOffIsStarted) {
  Cable cable(to_host("192.168.0.100"));
  cable.device.variables["ScanDataEnable"] = "0";
  cable.run(0.5);
  const std::vector<std::string> written(cable.device.commands.begin() + 5, cable.device.commands.end());
  EXPECT_THAT(written, ElementsAre("sMN SetAccessMode 3 F4724744", "sWN ScanDataEnable 1", "sMN Run",
                                   "sMN SetAccessMode 3 F4724744", "sMN LMCstartmeas"));
  EXPECT_THAT(cable.notes, ElementsAre("ScanDataEnable: 0 -> 1"));
  EXPECT_TRUE(cable.device.measuring);
  EXPECT_FALSE(cable.open);
}

TEST(SopasDialogue, OtherSettingsAreNamedButNotWrittenWithoutLeave) {
  Cable cable(to_host("192.168.0.5"));
  cable.run(0.5);
  EXPECT_EQ(cable.device.commands.size(), 5U);
  EXPECT_THAT(cable.warning(), HasSubstr("192.168.0.100:2115 -> 192.168.0.5:2115"));
  EXPECT_THAT(cable.warning(), HasSubstr("allow_write: true"));
  EXPECT_TRUE(cable.notes.empty());
}

TEST(SopasDialogue, WithLeaveOnlyWhatDiffersIsWritten) {
  Cable cable(to_host("192.168.0.5", true));
  cable.device.variables["ScanDataFormat"] = "3";
  cable.device.variables["ImuDataEnable"] = "0";
  cable.run(0.5);
  const std::vector<std::string> written(cable.device.commands.begin() + 5, cable.device.commands.end());
  const std::string login = "sMN SetAccessMode 3 F4724744";
  EXPECT_THAT(written,
              ElementsAre(login, "sWN ScanDataEthSettings 1 +192 +168 +0 +5 +2115", "sWN ScanDataFormat 2",
                          "sWN ImuDataEthSettings 1 +192 +168 +0 +5 +7503", "sMN Run", login,
                          "sWN ImuDataEnable 1", "sMN Run", login, "sMN LMCstartmeas"));
  EXPECT_THAT(
      cable.notes,
      ElementsAre("ScanDataEthSettings: 192.168.0.100:2115 -> 192.168.0.5:2115", "ScanDataFormat: 3 -> 2",
                  "ImuDataEthSettings: 192.168.0.100:7503 -> 192.168.0.5:7503", "ImuDataEnable: 0 -> 1"));
  EXPECT_TRUE(cable.warning().empty()) << cable.warning();
  // It repeats what it was given, so the next dialogue finds nothing to write.
  cable.run(6);
  EXPECT_EQ(cable.connections, 2);
  EXPECT_EQ(cable.device.commands.size(), 20U);
}

TEST(SopasDialogue, WhatAPowerCycleTookAwayIsWrittenAgain) {
  Cable cable(to_host("192.168.0.5", true));
  cable.run(0.5);
  cable.hear();
  EXPECT_EQ(cable.connections, 1);
  cable.device.power_cycle();
  cable.reachable = false;
  cable.run(10);
  cable.reachable = true;
  cable.run(0.3);
  EXPECT_EQ(cable.connections, 2);
  EXPECT_EQ(cable.device.variables["ScanDataEthSettings"], "1 +192 +168 +0 +5 +2115");
  EXPECT_TRUE(cable.device.measuring);
}

TEST(SopasDialogue, RefusalsAreToldInWords) {
  {
    Cable cable(to_host("192.168.0.5", true));
    cable.device.password = "12345678";
    cable.run(0.5);
    EXPECT_THAT(cable.warning(), HasSubstr("user_level_password"));
  }
  {
    Cable cable(to_host("192.168.0.5", true));
    cable.device.refusals["sWN ScanDataEthSettings"] = 5;
    cable.run(0.5);
    EXPECT_THAT(cable.warning(), HasSubstr("refuses ScanDataEthSettings"));
    EXPECT_THAT(cable.warning(), HasSubstr("not allowed"));
    EXPECT_TRUE(cable.notes.empty());
  }
  {
    // No licence for the inertial unit: the scans come all the same.
    Cable cable(to_host("192.168.0.5", true));
    cable.device.variables["ImuDataEnable"] = "0";
    cable.device.refusals["sWN ImuDataEnable"] = 3;
    cable.run(0.5);
    EXPECT_TRUE(cable.device.measuring);
    EXPECT_THAT(cable.warning(), HasSubstr("licence"));
  }
  {
    Cable cable(to_host("192.168.0.5", true));
    cable.device.refusals["sRN Imu"] = 3;
    cable.run(0.5);
    EXPECT_TRUE(cable.device.measuring);
    EXPECT_TRUE(cable.warning().empty()) << cable.warning();
  }
}

TEST(SopasDialogue, ADeviceThatDoesNotAnswerIsGivenUpAndAskedAgain) {
  Cable cable(to_host("192.168.0.100"));
  cable.answers = false;
  cable.run(12);
  EXPECT_THAT(cable.warning(), HasSubstr("does not answer"));
  EXPECT_GE(cable.connections, 2);
  cable.answers = true;
  cable.run(30);
  EXPECT_GE(cable.device.commands.size(), 5U);
  EXPECT_TRUE(cable.warning().empty());
}

TEST(SopasDialogue, WhatFailsAgainAndAgainIsTriedLessAndLess) {
  Cable mute(to_host("192.168.0.5", true));
  mute.answers = false;
  double open = 0;
  for (int i = 0; i < 6000; ++i) {
    mute.run(0.1);
    mute.hear();
    open += mute.open ? 0.1 : 0;
  }
  EXPECT_GE(mute.connections, 8);
  EXPECT_LE(open, 120) << "of 600 s another client cannot connect";
  Cable locked(to_host("192.168.0.5", true));
  locked.device.password = "12345678";
  locked.run(600);
  EXPECT_GE(locked.connections, 8);
  EXPECT_LE(locked.connections, 14);
}

TEST(SopasDialogue, AStreamOfFewScansIsNoReasonToAskAgain) {
  Cable cable(to_host("192.168.0.100"));
  for (int i = 0; i < 30; ++i) {
    cable.run(2);
    cable.hear();
  }
  EXPECT_LE(cable.connections, 3);
}

TEST(SopasDialogue, ADeviceThatClosesTheConnectionIsReportedAndAskedAgain) {
  Cable cable(to_host("192.168.0.5", true));
  cable.closes = true;
  cable.run(12);
  EXPECT_THAT(cable.warning(), HasSubstr("closes the connection before it answers"));
  EXPECT_GE(cable.connections, 2);
  EXPECT_LE(cable.connections, 4);
  cable.closes = false;
  cable.run(6);
  EXPECT_TRUE(cable.warning().empty()) << cable.warning();
  EXPECT_EQ(cable.device.variables["ScanDataEthSettings"], "1 +192 +168 +0 +5 +2115");
}

TEST(SopasDialogue, ADeviceThatIsSilentOnceIsAskedAgainThoughItsStreamFlows) {
  Cable cable(to_host("192.168.0.5", true));
  cable.answers = false;
  for (int i = 0; i < 300; ++i) {
    if (i == 100) cable.answers = true;
    cable.run(0.1);
    cable.hear();
    const auto answered = testing::Not(testing::Contains(HasSubstr("does not answer")));
    if (i == 99) {
      EXPECT_THAT(cable.driver->info().warnings, testing::Not(answered));
    }
    if (i == 299) {
      EXPECT_THAT(cable.driver->info().warnings, answered);
    }
  }
  EXPECT_EQ(cable.device.variables["ScanDataEthSettings"], "1 +192 +168 +0 +5 +2115");
  EXPECT_GE(cable.connections, 2);
  EXPECT_LE(cable.connections, 5);
}

TEST(SopasDialogue, LevelAndPasswordAreConfigurable) {
  DeviceRequests requests = to_host("192.168.0.5", true);
  requests.user_level = "4";
  requests.password_hash = "81BE23AA";
  Cable cable(requests);
  cable.run(0.5);
  ASSERT_GT(cable.device.commands.size(), 5U);
  EXPECT_EQ(cable.device.commands[5], "sMN SetAccessMode 4 81BE23AA");
}

}  // namespace
}  // namespace lidard::sick
