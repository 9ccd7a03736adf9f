// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/web_dialogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "test/support/fake_velodyne.h"

namespace lidard::velodyne {
namespace {

using namespace std::chrono_literals;
using test::FakeVelodyne;
using Fault = FakeVelodyne::Fault;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Texts = std::vector<std::string>;

const IpAddress loopback = IpAddress::v4(127, 0, 0, 1);

VelodyneControl reading() {
  VelodyneControl control;
  control.read = true;
  control.address = loopback;
  return control;
}

VelodyneControl writing() {
  VelodyneControl control = reading();
  control.allow_write = true;
  return control;
}

/// A sensor and the dialogue with it, in a time of their own.
class Talk final : public FrameReceiver {
 public:
  explicit Talk(const VelodyneControl& control, const WebTiming& timing = {}) : dialogue(control, timing) {}

  void scan(PlanarScan&) override {}
  void cloud(Cloud&) override {}
  void note(std::string_view sentence) override { notes.emplace_back(sentence); }
  void connect() override { dialled = true; }
  void disconnect(bool again) override {
    EXPECT_FALSE(again);
    connected = answered = false;
  }
  void request(ByteView bytes) override {
    ASSERT_TRUE(connected);
    asked.push_back(now);
    reply = sensor.take({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    answered = true;
  }
  /// A tenth of a second, as often as the daemon has a tick.
  void step() {
    now = now + 100ms;
    dialogue.tick(now, *this);
    if (std::exchange(dialled, false)) {
      EXPECT_FALSE(connected) << "one request at a time";
      connected = is_on;
      connected ? dialogue.connected(now, *this) : dialogue.disconnected();
    }
    if (!std::exchange(answered, false)) return;
    // In pieces, as the network has it.
    for (std::size_t at = 0; at < reply.bytes.size() && connected; at += 700) {
      Packet packet;
      const std::string piece = reply.bytes.substr(at, 700);
      packet.payload = ByteView(piece);
      packet.arrival = now;
      packet.to.address = loopback;
      packet.transport = Transport::tcp;
      dialogue.receive(packet, *this);
    }
    if (connected && reply.closes) connected = false, dialogue.disconnected();
  }
  bool until(const std::function<bool()>& condition) {
    for (const Stamp end = now + std::chrono::minutes(10); now < end; step()) {
      if (condition()) return true;
    }
    return false;
  }
  /// So many further rounds of questions have ended: whatever was to be written is written.
  bool rounds(std::size_t count) {
    const std::size_t wanted = sensor.requests("GET /cgi/snapshot.hdl").size() + count + 1;
    return until([&] { return sensor.requests("GET /cgi/snapshot.hdl").size() >= wanted; });
  }
  Texts posts() const { return sensor.requests("POST"); }
  WebState state() const { return dialogue.state(); }

  FakeVelodyne sensor;
  bool is_on = true;
  Texts notes;
  std::vector<Stamp> asked;

 private:
  Stamp now{1'700'000'000'000'000'000};
  WebDialogue dialogue;
  bool dialled = false, connected = false, answered = false;
  FakeVelodyne::Reply reply;
};

TEST(WebDialogue, OnlyReadsWithoutPermissionToWrite) {
  VelodyneControl control = reading();
  control.wanted.rpm = 1200;
  Talk talk(control);
  ASSERT_TRUE(talk.rounds(3));
  const Texts all = talk.sensor.requests();
  EXPECT_EQ(all[0], "GET /cgi/snapshot.hdl");
  EXPECT_EQ(all[1], "GET /cgi/status.json");
  EXPECT_EQ(talk.sensor.requests("GET").size(), all.size());
  const WebState state = talk.state();
  EXPECT_EQ(state.serial, "AG29999999");
  EXPECT_EQ(state.tree.at("status.motor.rpm"), "599");
  EXPECT_EQ(state.trouble, "");
  EXPECT_EQ(state.local_address, "127.0.0.1");
}

TEST(WebDialogue, PostsNothingWhenTheSnapshotAgrees) {
  VelodyneControl control = writing();
  control.wanted = {600, VelodyneReturns::strongest, 0, 360, IpAddress::v4(255, 255, 255, 255), 2368, 8308};
  Talk talk(control);
  ASSERT_TRUE(talk.rounds(3));
  EXPECT_THAT(talk.posts(), IsEmpty());
  EXPECT_EQ(talk.state().writes, 0U);
}

TEST(WebDialogue, PostsOnlyWhatDiffersAndEachOnce) {
  VelodyneControl control = writing();
  control.wanted = {1200, VelodyneReturns::strongest, 0, 360, loopback, 2368, 8309};
  Talk talk(control);
  talk.sensor.set("config.fov.end", "90");
  ASSERT_TRUE(talk.rounds(3));
  EXPECT_THAT(talk.posts(),
              ElementsAre("POST /cgi/setting rpm=1200", "POST /cgi/setting/fov end=359",
                          "POST /cgi/setting/host tport=8309", "POST /cgi/setting/host addr=127.0.0.1"));
  const WebState state = talk.state();
  EXPECT_THAT(state.refused, IsEmpty());
  EXPECT_EQ(state.writes, 4U);
  EXPECT_EQ(talk.sensor.get("config.rpm"), "1200");
}

TEST(WebDialogue, TellsWhatItWrote) {
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  Talk talk(control);
  ASSERT_TRUE(talk.rounds(3));
  EXPECT_THAT(talk.notes, ElementsAre("wrote rpm: 600 -> 1200 to 127.0.0.1:80"));
}

TEST(WebDialogue, GoesOnAfterEveryKindOfBadAnswer) {
  for (const Fault fault : {Fault::error_500, Fault::garbage, Fault::half_closed, Fault::hang}) {
    VelodyneControl control = writing();
    control.wanted.rpm = 1200;
    Talk talk(control);
    talk.sensor.misbehave(fault, 2, "GET /cgi/snapshot.hdl");
    ASSERT_TRUE(talk.until([&] { return !talk.state().trouble.empty(); })) << static_cast<int>(fault);
    ASSERT_TRUE(talk.until([&] {
      return talk.sensor.get("config.rpm") == "1200" && talk.state().trouble.empty();
    })) << static_cast<int>(fault);
    EXPECT_EQ(talk.state().failures, 2U);
    EXPECT_THAT(talk.posts(), ElementsAre("POST /cgi/setting rpm=1200"));
  }
}

TEST(WebDialogue, SaysWhatIsWrongWithAnAnswer) {
  for (const auto& [fault, message] :
       {std::pair(Fault::error_500, "127.0.0.1:80/cgi/snapshot.hdl answers with HTTP status 500; is this"),
        std::pair(Fault::garbage, "does not answer with a JSON object"),
        std::pair(Fault::half_closed, "the connection was closed without an answer; the sensor may be busy"),
        std::pair(Fault::hang, "no answer in time; the sensor may be busy")}) {
    Talk talk(reading());
    talk.sensor.misbehave(fault, 1, "GET /cgi/snapshot.hdl");
    ASSERT_TRUE(talk.until([&] { return !talk.state().trouble.empty(); }));
    EXPECT_THAT(talk.state().trouble, HasSubstr(message));
  }
}

TEST(WebDialogue, WritesNothingWhileTheSnapshotIsUnreadable) {
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  Talk talk(control);
  talk.sensor.misbehave(Fault::error_500, 1'000'000, "GET /cgi/snapshot.hdl");
  ASSERT_TRUE(talk.rounds(5));
  EXPECT_THAT(talk.posts(), IsEmpty());
  EXPECT_THAT(talk.state().trouble, HasSubstr("HTTP status 500"));
}

TEST(WebDialogue, WritesAlthoughTheSensorDoesNotReportItsState) {
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  Talk talk(control);
  talk.sensor.misbehave(Fault::error_500, 1'000'000, "GET /cgi/status.json");
  ASSERT_TRUE(talk.until([&] { return talk.sensor.get("config.rpm") == "1200"; }));
}

TEST(WebDialogue, AcceptsHttp10AndLengthsThatAreTooLarge) {
  for (const Fault fault : {Fault::http_1_0, Fault::length_too_large}) {
    Talk talk(reading());
    talk.sensor.misbehave(fault, 1'000'000);
    ASSERT_TRUE(talk.rounds(2));
    EXPECT_EQ(talk.state().failures, 0U) << static_cast<int>(fault) << " " << talk.state().trouble;
    EXPECT_EQ(talk.state().serial, "AG29999999");
  }
}

TEST(WebDialogue, RepeatsAWriteThatFailed) {
  for (const Fault fault : {Fault::error_500, Fault::half_closed, Fault::hang}) {
    VelodyneControl control = writing();
    control.wanted.rpm = 1200;
    Talk talk(control);
    talk.sensor.misbehave(fault, fault == Fault::error_500 ? 2 : 1, "POST");
    ASSERT_TRUE(talk.until([&] { return talk.sensor.get("config.rpm") == "1200"; }));
    ASSERT_TRUE(talk.rounds(2));
    // What was taken without an answer is not written again.
    EXPECT_EQ(talk.posts().size(), fault == Fault::error_500 ? 3U : 1U);
  }
}

TEST(WebDialogue, GivesUpASettingThatTheSensorIgnores) {
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  Talk talk(control);
  talk.sensor.ignore_settings();
  ASSERT_TRUE(talk.until([&] { return !talk.state().refused.empty(); }));
  ASSERT_TRUE(talk.rounds(4));
  EXPECT_EQ(talk.posts(), Texts(3, "POST /cgi/setting rpm=1200"));
  EXPECT_THAT(talk.state().refused, ElementsAre("rpm: 600 -> 1200"));
}

TEST(WebDialogue, DoesNotWriteWhatTheSensorDoesNotReport) {
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  Talk talk(control);
  talk.sensor.forget("config.rpm");
  ASSERT_TRUE(talk.rounds(2));
  EXPECT_THAT(talk.posts(), IsEmpty());
  EXPECT_THAT(talk.state().unknown, ElementsAre("rpm"));
}

TEST(WebDialogue, WritesAgainToASensorThatForgotItsSettingsWhileItWasAway) {
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  Talk talk(control);
  ASSERT_TRUE(talk.until([&] { return talk.sensor.get("config.rpm") == "1200"; }));
  talk.is_on = false;
  ASSERT_TRUE(talk.until([&] { return talk.state().trouble.find("no web interface") == 0; }));
  ASSERT_TRUE(talk.until([&] { return talk.state().tree.empty(); }));
  EXPECT_EQ(talk.state().serial, "AG29999999");
  talk.sensor.set("config.rpm", "600");
  talk.is_on = true;
  ASSERT_TRUE(talk.until([&] { return talk.sensor.get("config.rpm") == "1200"; }));
  EXPECT_EQ(talk.posts(), Texts(2, "POST /cgi/setting rpm=1200"));
}

TEST(WebDialogue, NeverAsksFasterThanItsPace) {
  EXPECT_GE(WebTiming{}.pace, 1s);
  WebTiming timing;
  timing.settle = timing.period = 0ms;
  VelodyneControl control = writing();
  control.wanted.rpm = 1200;
  control.wanted.returns = VelodyneReturns::dual;
  Talk talk(control, timing);
  talk.sensor.misbehave(Fault::error_500, 3);
  ASSERT_TRUE(talk.until([&] { return talk.posts().size() == 2; }));
  ASSERT_TRUE(talk.rounds(1));
  for (std::size_t i = 1; i < talk.asked.size(); ++i) EXPECT_GE(talk.asked[i] - talk.asked[i - 1], 1s) << i;
}

}  // namespace
}  // namespace lidard::velodyne
