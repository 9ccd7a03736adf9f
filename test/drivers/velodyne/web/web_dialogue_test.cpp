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

VelodyneControl faster() {
  VelodyneControl control;
  control.allow_write = true;
  control.address = loopback;
  control.wanted.rpm = 1200;
  return control;
}

/// A sensor and the dialogue with it, in a time of their own.
class Talk final : public FrameReceiver {
 public:
  explicit Talk(const VelodyneControl& control = faster()) : dialogue(control) {}

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
    if (sends) last_data = now;
    dialogue.tick(now, last_data, *this);
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
  void pass(Span time) {
    for (const Stamp end = now + time; now < end;) step();
  }
  std::size_t comparisons() const { return sensor.requests("GET").size(); }
  Texts posts() const { return sensor.requests("POST"); }
  const DeviceInfo& info() const { return dialogue.info(); }
  std::string warning() const { return info().warnings.empty() ? "" : info().warnings.front(); }

  FakeVelodyne sensor;
  bool is_on = true, sends = true;  // its web interface; data
  Texts notes;
  std::vector<Stamp> asked;

 private:
  Stamp now{1'700'000'000'000'000'000};
  std::optional<Stamp> last_data;
  WebDialogue dialogue;
  bool dialled = false, connected = false, answered = false;
  FakeVelodyne::Reply reply;
};

const Texts set_rpm = {"POST /cgi/setting rpm=1200"};

TEST(WebDialogue, ComparesOnceAndWritesNothingWhereTheSnapshotAgrees) {
  VelodyneControl control = faster();
  control.wanted = {600, VelodyneReturns::strongest, 0, 360, IpAddress::v4(255, 255, 255, 255), 2368, 8308};
  Talk talk(control);
  talk.pass(10min);
  EXPECT_THAT(talk.sensor.requests(), ElementsAre("GET /cgi/snapshot.hdl"));
  EXPECT_EQ(talk.info().serial, "AG29999999");
  EXPECT_THAT(talk.info().warnings, IsEmpty());
}

TEST(WebDialogue, PostsOnlyWhatDiffersAndReadsItBack) {
  VelodyneControl control = faster();
  control.wanted = {1200, VelodyneReturns::strongest, 0, 360, loopback, 2368, 8309};
  Talk talk(control);
  talk.sensor.set("config.fov.end", "90");
  talk.pass(10min);
  EXPECT_THAT(talk.sensor.requests(),
              ElementsAre("GET /cgi/snapshot.hdl", "POST /cgi/setting rpm=1200",
                          "POST /cgi/setting/fov end=359", "POST /cgi/setting/host tport=8309",
                          "POST /cgi/setting/host addr=127.0.0.1", "GET /cgi/snapshot.hdl"));
  EXPECT_THAT(talk.info().warnings, IsEmpty());
  EXPECT_EQ(talk.notes.size(), 4U);
  EXPECT_EQ(talk.notes.front(), "writes rpm: 600 -> 1200 to 127.0.0.1:80");
}

TEST(WebDialogue, GoesOnAfterEveryKindOfBadAnswer) {
  for (const auto& [fault, message] :
       {std::pair(Fault::error_500, "127.0.0.1:80/cgi/snapshot.hdl answers with HTTP status 500; is this"),
        std::pair(Fault::garbage, "does not answer with a JSON object"),
        std::pair(Fault::half_closed, "the connection was closed without an answer; the sensor may be busy"),
        std::pair(Fault::hang, "no answer in time; the sensor may be busy")}) {
    Talk talk;
    talk.sensor.misbehave(fault, 2, "GET");
    ASSERT_TRUE(talk.until([&] { return !talk.warning().empty(); }));
    EXPECT_THAT(talk.warning(), HasSubstr(message));
    EXPECT_THAT(talk.posts(), IsEmpty());
    ASSERT_TRUE(talk.until([&] { return talk.comparisons() == 4 && talk.warning().empty(); })) << message;
    EXPECT_EQ(talk.posts(), set_rpm);
  }
}

TEST(WebDialogue, AsksABusySensorEverLessOften) {
  Talk talk;
  talk.sensor.misbehave(Fault::error_500, 1'000'000, "GET");
  talk.pass(10min);
  EXPECT_THAT(talk.posts(), IsEmpty());
  EXPECT_LT(talk.comparisons(), 16U);
  EXPECT_GE(talk.asked[1] - talk.asked[0], 5s);
  EXPECT_LE(talk.asked.back() - talk.asked[talk.asked.size() - 2], 61s);
}

TEST(WebDialogue, AcceptsHttp10AndLengthsThatAreTooLarge) {
  for (const Fault fault : {Fault::http_1_0, Fault::length_too_large}) {
    Talk talk;
    talk.sensor.misbehave(fault, 1'000'000);
    talk.pass(1min);
    EXPECT_EQ(talk.warning(), "");
    EXPECT_EQ(talk.posts(), set_rpm);
    EXPECT_EQ(talk.info().serial, "AG29999999");
  }
}

TEST(WebDialogue, RepeatsAWriteThatFailed) {
  for (const Fault fault : {Fault::error_500, Fault::half_closed, Fault::hang}) {
    Talk talk;
    talk.sensor.misbehave(fault, 1, "POST");
    talk.pass(2min);
    EXPECT_EQ(talk.sensor.get("config.rpm"), "1200");
    // A change that was applied without an answer is not written again.
    EXPECT_EQ(talk.posts().size(), fault == Fault::error_500 ? 2U : 1U);
    EXPECT_THAT(talk.info().warnings, IsEmpty());
  }
}

TEST(WebDialogue, SaysWhatTheSensorDoesNotApplyAndTriesEverLessOften) {
  Talk talk;
  talk.sensor.ignore_settings();
  ASSERT_TRUE(talk.until([&] { return !talk.warning().empty(); }));
  EXPECT_EQ(talk.warning(),
            "the sensor did not apply rpm: 600 -> 1200; set it in the sensor's web page, or remove it from "
            "control");
  EXPECT_EQ(talk.posts(), set_rpm);
  talk.pass(10min);
  EXPECT_LT(talk.posts().size(), 16U);
  EXPECT_EQ(talk.notes.size(), 1U);
  talk.sensor.set("config.rpm", "1200");
  talk.pass(70s);
  EXPECT_EQ(talk.warning(), "");
}

TEST(WebDialogue, DoesNotWriteWhatTheSensorDoesNotReport) {
  Talk talk;
  talk.sensor.forget("config.rpm");
  talk.pass(1min);
  EXPECT_THAT(talk.sensor.requests(), ElementsAre("GET /cgi/snapshot.hdl"));
  EXPECT_EQ(talk.warning(), "the sensor does not report rpm, so it is not written; remove it from control");
}

TEST(WebDialogue, WritesAgainToASensorThatForgotItsSettingsWhileItWasAway) {
  Talk talk;
  talk.pass(1min);
  EXPECT_EQ(talk.posts(), set_rpm);
  talk.is_on = talk.sends = false;
  talk.pass(30s);
  talk.sensor.set("config.rpm", "600");
  talk.is_on = true;
  ASSERT_TRUE(talk.until([&] { return talk.sensor.get("config.rpm") == "1200"; }));
  talk.sends = true;
  talk.pass(1min);
  EXPECT_EQ(talk.posts().size(), 2U);
  EXPECT_EQ(talk.warning(), "");
}

TEST(WebDialogue, ComparesAgainWhileASensorSendsNothing) {
  Talk talk;
  talk.sends = false;
  talk.pass(1min);
  EXPECT_EQ(talk.posts(), set_rpm);
  talk.sensor.set("config.rpm", "600");  // restarted, and sends elsewhere
  talk.pass(70s);
  EXPECT_EQ(talk.sensor.get("config.rpm"), "1200");
}

TEST(WebDialogue, NeverAsksFasterThanItsPace) {
  VelodyneControl control = faster();
  control.wanted.returns = VelodyneReturns::dual;
  Talk talk(control);
  talk.pass(1min);
  ASSERT_EQ(talk.asked.size(), 4U);
  for (std::size_t i = 1; i < talk.asked.size(); ++i) EXPECT_GE(talk.asked[i] - talk.asked[i - 1], 1s) << i;
  EXPECT_GE(talk.asked[3] - talk.asked[2], 2s) << "the sensor settles";
}

}  // namespace
}  // namespace lidard::velodyne
