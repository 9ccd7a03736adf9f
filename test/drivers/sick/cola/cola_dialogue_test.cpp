// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_dialogue.h"

#include <gmock/gmock.h>

#include "test/drivers/sick/cola/fake_cola_device.h"

namespace lidard::test {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ColaDialogue, ByDefaultItAsksForWhatTheStreamNeedsAndNothingElse) {
  ColaBench bench;
  FakeDevice device(bench);
  device.connect();
  EXPECT_THAT(bench.requests, ElementsAre(binary("sRN DeviceIdent"), binary("sRN LMPoutputRange"),
                                          binary("sRN LMDscandatacfg"), subscribe(Cola::binary)));
  bench.send_next();
  for (int i = 0; i < 100; ++i) {
    bench.send_next();
    device.wait(0.6);
  }
  // Beside the stream: contamination, every 10 s.
  EXPECT_EQ(bench.requests.size(), 4U + 6);
  for (std::size_t i = 4; i < bench.requests.size(); ++i)
    EXPECT_EQ(bench.requests[i], binary("sRN LCMstate"));
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  EXPECT_TRUE(bench.notes.empty());
  EXPECT_EQ(bench.detail("Device"), "LMS1xx, V1.80");
  EXPECT_EQ(bench.detail("Output range"), "-45.0000 to 225.0000 deg in steps of 0.5000 deg");
  EXPECT_EQ(bench.detail("Echoes sent"), "1");
  EXPECT_EQ(bench.detail("Intensities sent"), "no");
}

TEST(ColaDialogue, EveryConnectionStartsTheStreamAnew) {
  ColaBench bench;
  FakeDevice device(bench);
  for (std::size_t i = 1; i <= 3; ++i) {
    device.connect();
    EXPECT_EQ(bench.requests.size(), 4 * i);
    bench.send_next();
    bench.driver->disconnected();
  }
  EXPECT_EQ(bench.scans.size(), 3U);
}

TEST(ColaDialogue, SpeaksTheTextDialectWhereTheBinaryOneIsNotUnderstood) {
  ColaBench bench;
  FakeDevice device(bench, Cola::text);
  device.connect();
  EXPECT_EQ(bench.requests.size(), 1U);
  device.wait(2.1);
  EXPECT_THAT(bench.requests,
              ElementsAre(binary("sRN DeviceIdent"), text("sRN DeviceIdent"), text("sRN LMPoutputRange"),
                          text("sRN LMDscandatacfg"), text("sEN LMDscandata 1")));
  EXPECT_EQ(bench.detail("Device"), "LMS1xx, V1.80");
}

TEST(ColaDialogue, SwitchesWhenTheAnswerComesInTheOtherDialect) {
  ColaBench bench;
  FakeDevice device(bench);
  device.answers["sRN DeviceIdent"] = text("sFA C");
  device.connect();
  ASSERT_GE(bench.requests.size(), 2U);
  EXPECT_EQ(bench.requests[1], text("sRN DeviceIdent")) << "the device may not have understood it";
  ColaBench other;
  FakeDevice answering(other);
  answering.answers["sRN DeviceIdent"] = text("sRA DeviceIdent 6 LMS1xx 5 V1.80");
  answering.connect();
  EXPECT_EQ(other.requests.at(1), text("sRN LMPoutputRange"));
}

TEST(ColaDialogue, ADeviceThatAnswersInNoDialectIsLeftAndTriedAgain) {
  ColaBench bench;
  FakeDevice device(bench, Cola::text);
  bench.driver->connected(bench.now, bench);
  for (int i = 0; i < 14; ++i) bench.tick(0.1);
  EXPECT_EQ(bench.requests.size(), 3U) << "both dialects, and the first again";
  EXPECT_TRUE(bench.has_warning("did not answer 'sRN DeviceIdent' in time; check that ip_port"));
  EXPECT_EQ(bench.reconnects, 0) << "it may be slow";
  for (int i = 0; i < 100; ++i) bench.tick(0.1);
  EXPECT_LE(bench.requests.size(), 6U);
  EXPECT_EQ(bench.reconnects, 1);
}

TEST(ColaDialogue, ADeviceThatTakesSecondsForEachAnswerGetsThrough) {
  for (const double answer_s : {3.0, 9.0}) {
    for (const Cola dialect : {Cola::binary, Cola::text}) {
      ColaBench bench;
      bench.dialect = dialect;
      FakeDevice device(bench, dialect);
      bench.driver->connected(bench.now, bench);
      for (int answer = 0; answer < 10 && bench.requests.back() != subscribe(dialect); ++answer) {
        for (double s = 0; s < answer_s; s += 0.1) bench.tick(0.1);
        EXPECT_TRUE(bench.has_warning("did not answer")) << "people learn why there are no scans";
        device.run(1);
      }
      EXPECT_THAT(bench.requests, ::testing::Contains(subscribe(dialect)));
      bench.send_next();
      EXPECT_EQ(bench.scans.size(), 1U);
      EXPECT_EQ(bench.reconnects, 0);
      EXPECT_TRUE(bench.driver->info().warnings.empty());
    }
  }
}

TEST(ColaDialogue, AReadThatIsRefusedDoesNotStopTheStream) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    ColaBench bench;
    FakeDevice device(bench, dialect);
    device.answers["sRN LMPoutputRange"] = refusal(dialect, 3);
    device.connect();
    device.wait(2.1);
    bench.dialect = dialect;
    bench.send_next();
    EXPECT_THAT(bench.requests, ::testing::Contains(subscribe(dialect)));
    EXPECT_THAT(bench.detail("Refused sRN LMPoutputRange"),
                HasSubstr("(sFA 3): the device does not know that variable"));
    EXPECT_TRUE(bench.driver->info().warnings.empty()) << "it costs nothing";
    EXPECT_EQ(bench.reconnects, 0);
  }
}

TEST(ColaDialogue, ARefusalIsAWarningWhereTheConfigurationNeedsTheAnswer) {
  DriverConfig config;
  config.requests.skip = 1;
  ColaBench bench("sick_lms1xx", config);
  FakeDevice device(bench);
  device.answers["sRN LMDscandatacfg"] = refusal(Cola::binary, 3);
  device.connect();
  bench.send_next();
  EXPECT_TRUE(bench.has_warning("the device refused 'sRN LMDscandatacfg' (sFA 3)"));
}

TEST(ColaDialogue, ADeviceThatIsAnotherModelIsNamedBesideTheConfiguredOne) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    ColaBench bench("sick_lms1xx");
    FakeDevice device(bench, dialect);
    // As recorded from an MRS1000.
    device.answers["sRN DeviceIdent"] =
        ColaWords(dialect, "sRA DeviceIdent").text("MRS1xxxx", 2).text("1.3.0.0R", 2).bytes();
    device.connect();
    device.wait(0.7);
    bench.dialect = dialect;
    bench.send_next();
    EXPECT_TRUE(
        bench.has_warning("reports the name MRS1xxxx, 1.3.0.0R, which is a sick_mrs1000, but sick_lms1xx "
                          "is configured; set model: sick_mrs1000"));
    EXPECT_EQ(bench.requests.back(), subscribe(dialect)) << "its scans come all the same";
  }
}

// As SICK's own test server, which replays a recording (SICKAG/sick_scan_xd,
// test/python/sopas_json_test_server.py).
TEST(ColaDialogue, ADeviceThatSendsScansButDoesNotAnswerIsKept) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    ColaBench bench;
    bench.dialect = dialect;
    bench.driver->connected(bench.now, bench);
    for (int i = 0; i < 1000; ++i) {
      bench.send_next();
      bench.driver->tick(bench.now, bench);
    }
    EXPECT_EQ(bench.reconnects, 0);
    EXPECT_EQ(bench.scans.size(), 1000U);
    EXPECT_THAT(bench.requests, ::testing::Contains(subscribe(dialect)));
    EXPECT_EQ(bench.detail("Refused sRN LMPoutputRange"), "no answer");
    EXPECT_TRUE(bench.driver->info().warnings.empty());
  }
}

TEST(ColaDialogue, VariantsOfAModelAreNotTakenForAnother) {
  ColaBench bench("sick_tim7xxs");
  FakeDevice device(bench);
  device.answers["sRN DeviceIdent"] =
      ColaWords(Cola::binary, "sRA DeviceIdent").text("TiM781S", 2).text("V2.53", 2).bytes();
  device.connect();
  bench.send_next();
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ColaDialogue, ARefusedSubscriptionIsToldAndTriedAgain) {
  ColaBench bench;
  FakeDevice device(bench);
  device.answers["sEN LMDscandata"] = refusal(Cola::binary, 1);
  device.connect();
  EXPECT_EQ(bench.reconnects, 1);
  EXPECT_TRUE(bench.has_warning("(sFA 1): the user level has no permission; set user_level"));
  // The warning stays while the next attempt goes on, and goes when scans come.
  bench.driver->connected(bench.now, bench);
  EXPECT_TRUE(bench.has_warning("(sFA 1)"));
  device.answers.clear();
  device.run();
  bench.send_next();
  EXPECT_FALSE(bench.has_warning("(sFA 1)"));
}

TEST(ColaDialogue, AStreamThatStopsIsAskedForAgainAfterThreeOfItsScans) {
  for (const unsigned interval : {1U, 30U}) {  // at 25 Hz a scan every 1.2 s
    SCOPED_TRACE(interval);
    ColaBench bench;
    FakeDevice device(bench);
    device.answers["sRN LMDscandatacfg"] = settings(Cola::binary, "sRA LMDscandatacfg", 1, 0, interval);
    device.connect();
    bench.send_next();
    bench.tick(interval == 1 ? 0.9 : 3.6);
    EXPECT_EQ(bench.reconnects, 0);
    bench.tick(interval == 1 ? 0.2 : 4);
    EXPECT_EQ(bench.reconnects, 1);
    EXPECT_TRUE(bench.has_warning("sends no scans any more"));
  }
}

TEST(ColaDialogue, LogsInForTheSubscriptionWhenALevelIsConfigured) {
  DriverConfig config;
  config.requests.user_level = "4";
  config.requests.password_hash = "0BE23AA1";
  ColaBench bench("sick_lms1xx", config);
  FakeDevice device(bench);
  device.answers["sMN SetAccessMode"] = ColaWords(Cola::binary, "sAN SetAccessMode").number(1, 1).bytes();
  device.answers["sEN LMDscandata"] = refusal(Cola::binary, 1);
  bench.driver->connected(bench.now, bench);
  device.run();
  EXPECT_THAT(device.commands(), ElementsAre("sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg",
                                             "sEN LMDscandata", "sMN SetAccessMode", "sEN LMDscandata"));
  EXPECT_EQ(bench.requests[4],
            ColaWords(Cola::binary, "sMN SetAccessMode").number(4, 1).number(0x0BE23AA1, 4).bytes());
  EXPECT_EQ(bench.reconnects, 1) << "it was refused again";
}

TEST(ColaDialogue, AfterALoginItLetsTheDeviceRun) {
  DriverConfig config;
  config.requests.user_level = "3";
  ColaBench bench("sick_tim7xxs", config);
  FakeDevice device(bench);
  device.options().password = 0x6FD62C05;
  device.answers["sEN LMDscandata"] = refusal(Cola::binary, 1);
  bench.driver->connected(bench.now, bench);
  for (int i = 0; i < 10; ++i) {
    if (bench.requests.size() == 5) device.answers.clear();
    device.run(1);
  }
  EXPECT_THAT(device.commands(),
              ElementsAre("sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg", "sEN LMDscandata",
                          "sMN SetAccessMode", "sEN LMDscandata", "sMN Run"));
  EXPECT_EQ(bench.reconnects, 0);
  EXPECT_EQ(bench.requests.at(4),
            ColaWords(Cola::binary, "sMN SetAccessMode").number(3, 1).number(0x6FD62C05, 4).bytes())
      << "the password of a TiM7xxS";
}

TEST(ColaDialogue, WritesNothingWithoutPermissionAndSaysWhatDiffers) {
  DriverConfig config;
  config.requests.skip = 2;
  config.publish_multiecho = true;
  ColaBench bench("sick_lms1xx", config);
  FakeDevice device(bench);
  device.connect();
  bench.send_next();
  EXPECT_EQ(bench.requests.size(), 4U);
  EXPECT_TRUE(bench.has_warning("echoes 1 -> 1+2, output interval 1 -> 3"));
  EXPECT_TRUE(bench.has_warning("set allow_write: true"));
}

TEST(ColaDialogue, WritesWhatDiffersWhenItMayAndTellsOldAndNew) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    DriverConfig config;
    config.requests.skip = 1;
    config.requests.allow_write = true;
    ColaBench bench("sick_lms1xx", config);
    FakeDevice device(bench, dialect);
    device.connect();
    device.wait(2.1);
    std::vector<std::string> commands = device.commands();
    if (dialect == Cola::text) commands.erase(commands.begin());
    EXPECT_THAT(commands,
                ElementsAre("sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg",
                            "sMN SetAccessMode", "sWN LMDscandatacfg", "sMN Run", "sEN LMDscandata"));
    EXPECT_THAT(bench.requests, ::testing::Contains(settings(dialect, "sWN LMDscandatacfg", 1, 1, 2)));
    EXPECT_THAT(bench.notes, ElementsAre("LMDscandatacfg: intensity off -> on, output interval 1 -> 2"));
    EXPECT_EQ(bench.detail("Setting written"), bench.notes.at(0));
  }
}

TEST(ColaDialogue, WritesNothingWhereTheDeviceAgrees) {
  DriverConfig config;
  config.requests.skip = 0;
  config.requests.allow_write = true;
  ColaBench bench("sick_lms1xx", config);
  FakeDevice device(bench);
  device.answers["sRN LMDscandatacfg"] = settings(Cola::binary, "sRA LMDscandatacfg", 1, 1, 1);
  device.connect();
  EXPECT_THAT(device.commands(),
              ElementsAre("sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg", "sEN LMDscandata"));
}

TEST(ColaDialogue, ARefusedLoginSkipsTheWritesAndTheStreamStarts) {
  DriverConfig config;
  config.requests.allow_write = true;
  ColaBench bench("sick_lms1xx", config);
  FakeDevice device(bench);
  device.answers["sMN SetAccessMode"] = ColaWords(Cola::binary, "sAN SetAccessMode").number(0, 1).bytes();
  device.connect();
  bench.send_next();
  EXPECT_EQ(device.commands().back(), "sEN LMDscandata");
  EXPECT_THAT(device.commands(), ::testing::Not(::testing::Contains("sWN LMDscandatacfg")));
  EXPECT_TRUE(bench.has_warning("refused the login: the password"));
  EXPECT_TRUE(bench.notes.empty());
}

TEST(ColaDialogue, ARefusedWriteIsToldAndTheDeviceRunsAgain) {
  DriverConfig config;
  config.requests.allow_write = true;
  ColaBench bench("sick_lms1xx", config);
  FakeDevice device(bench);
  device.answers["sWN LMDscandatacfg"] = refusal(Cola::binary, 10);
  device.connect();
  bench.send_next();
  EXPECT_THAT(device.commands(), ::testing::Contains("sMN Run"));
  EXPECT_TRUE(bench.has_warning("refused 'sWN LMDscandatacfg' (sFA 10): the setting may not be written"));
  EXPECT_TRUE(bench.notes.empty());
}

TEST(ColaDialogue, SubscribesToTheDevicesStateWhenAsked) {
  DriverConfig config;
  config.requests.device_states = true;
  ColaBench bench("sick_lms5xx", config);
  FakeDevice device(bench);
  device.answers["sEN LFErec"] = refusal(Cola::binary, 15);
  device.connect();
  bench.send_next();
  EXPECT_THAT(device.commands(),
              ElementsAre("sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg", "sEN LFErec",
                          "sEN LIDoutputstate", "sEN LIDinputstate", "sEN LMDscandata"));
  EXPECT_TRUE(bench.has_warning("refused 'sEN LFErec' (sFA 15): the device has no such event"));
}

TEST(ColaDialogue, ASubscriptionWithoutScansIsToldAndTriedAgain) {
  ColaBench bench;
  FakeDevice device(bench);
  device.connect();
  device.wait(3);
  EXPECT_EQ(bench.reconnects, 0);
  device.wait(2);
  EXPECT_EQ(bench.reconnects, 1);
  EXPECT_TRUE(bench.has_warning("accepts 'sEN LMDscandata 1' but sends no scans"));
}

TEST(ColaDialogue, AConnectionThatEndsUnansweredIsTriedInTheOtherDialect) {
  ColaBench bench;
  FakeDevice device(bench, Cola::text);
  device.connect();
  bench.driver->disconnected();
  device.connect();
  EXPECT_EQ(device.commands().size(), 5U);
  EXPECT_EQ(bench.requests.back(), subscribe(Cola::text));
  bench.driver->disconnected();
  EXPECT_TRUE(bench.has_warning("but sends no scans")) << "it ended before any came";
}

TEST(ColaDialogue, EveryRefusalHasWordsAndARemedy) {
  for (unsigned code = 1; code <= 27; ++code) {
    const std::string words = sick::cola_error_words(static_cast<std::uint8_t>(code));
    EXPECT_GT(words.size(), 20U);
    EXPECT_THAT(words, AnyOf(HasSubstr(";"), HasSubstr("set ")));
  }
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    Counters counters;
    sick::ColaStream stream(counters);
    const Bytes bytes = refusal(dialect, 15);
    stream.add({bytes.data(), bytes.size()});
    sick::ColaTelegram telegram;
    ASSERT_TRUE(stream.next(telegram));
    EXPECT_EQ(sick::cola_error_code(telegram), 15);
  }
}

TEST(ColaDialogue, InReplayItAsksForNothing) {
  ColaBench bench;
  bench.send(refusal(Cola::binary, 1), 0, true);
  bench.send_next();
  bench.driver->tick(bench.now, bench);
  EXPECT_TRUE(bench.requests.empty());
  EXPECT_EQ(bench.reconnects, 0);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

}  // namespace
}  // namespace lidard::test
