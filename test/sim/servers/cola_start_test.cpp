// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The start of another driver against the devices of a scene, over a real socket. What sick_scan_xd 3.9.0
// sends is in driver/src/sick_scan_common.cpp (init_cmdTables, init_scanner, readParseSafetyFields); which of
// it a model gets, in sick_generic_parser.cpp.
#include <gtest/gtest.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cmath>

#include "drivers/sick/cola/cola_scan.h"
#include "test/sim/devices/cola_device.h"
#include "test/sim/servers/device_server.h"
#include "test/sim/servers/test_scene.h"

namespace lidard::sim {
namespace {

using boost::asio::ip::tcp;
using sick::ColaDialect;
using sick::ColaTelegram;

struct Number {
  std::uint32_t value;
  int bytes;
};

/// A device of a scene behind a socket, and a client that knows nothing of lidard's dialogue.
class Session {
 public:
  Session(const std::string& model, ColaDialect dialect, const std::string& options = "")
      : dialect_(dialect),
        scene_(room(model, "options: {dialect: " + std::string(dialect == ColaDialect::a ? "a" : "b") +
                               options + "}")),
        server_({IpAddress::v4(127, 0, 0, 1), 0},
                scene_.sensors.at(0).make_device(scene_, 0, now_of_host(), Span(0))) {
    connect();
  }

  void connect() {
    socket_ = tcp::socket(io_);
    socket_.connect({boost::asio::ip::address_v4::loopback(), server_.port()});
    const timeval patience{5, 0};
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    stream_.interrupt();
  }
  void speak(ColaDialect dialect) { dialect_ = dialect; }

  void send(const std::string& bytes) { boost::asio::write(socket_, boost::asio::buffer(bytes)); }
  /// The next telegram; one without payload if none comes.
  const ColaTelegram& next() {
    telegram_ = {};
    while (!stream_.next(telegram_)) {
      char bytes[4096];
      const ssize_t got = ::recv(socket_.native_handle(), bytes, sizeof bytes, 0);
      if (got <= 0) return telegram_ = {};
      chunk_.assign(bytes, static_cast<std::size_t>(got));
      stream_.add(ByteView(chunk_));
    }
    return telegram_;
  }
  /// The first telegram that is no event.
  const ColaTelegram& ask(const std::string& command, const std::vector<Number>& arguments = {},
                          const std::string& letters = "") {
    sick::ColaWriter words(dialect_, command);
    for (const Number& each : arguments) {
      if (each.bytes == 1) words.u8(static_cast<std::uint8_t>(each.value));
      if (each.bytes == 2) words.u16(static_cast<std::uint16_t>(each.value));
      if (each.bytes == 4) words.u32(each.value);
    }
    if (!letters.empty()) words.letters(letters).u8(1);
    const std::vector<std::uint8_t> bytes = words.finish();
    send({bytes.begin(), bytes.end()});
    while (next().kind() == "sSN") {
    }
    return telegram_;
  }
  /// Its arguments as numbers of so many bytes, if there are exactly these.
  std::vector<std::uint32_t> numbers(const std::vector<int>& widths) const {
    return read_arguments(telegram_, [&](auto in) {
      std::vector<std::uint32_t> all;
      for (const int width : widths) all.push_back(width == 1 ? in.u8() : width == 2 ? in.u16() : in.u32());
      if (!in.ok() || in.left() != 0) all.clear();
      return all;
    });
  }
  std::string text() const {
    return read_arguments(telegram_, [](auto in) {
      const std::string all(in.text(in.u16()));
      return in.ok() && in.left() == 0 ? all : "no text";
    });
  }
  const ColaTelegram& answer() const { return telegram_; }
  unsigned refusal() const { return telegram_.kind() == "sFA" ? sick::cola_error_code(telegram_) : 0; }
  std::string answered() const { return std::string(telegram_.kind()) + " " + std::string(telegram_.name()); }
  void log_in(std::uint32_t password = 0xF4724744) {
    ask("sMN SetAccessMode", {{3, 1}, {password, 4}});
    EXPECT_EQ(numbers({1}), std::vector<std::uint32_t>{1});
  }
  void write(const std::string& name, const std::vector<Number>& arguments) {
    ask("sWN " + name, arguments);
    EXPECT_EQ(answered(), "sWA " + name);
  }
  /// The next scan of the stream.
  const sick::ColaScan& scan() {
    while (next().name() != "LMDscandata" && !telegram_.payload.empty()) {
    }
    EXPECT_EQ(parse_cola_scan(telegram_, scan_), Reject::none);
    return scan_;
  }

 private:
  ColaDialect dialect_;
  Scene scene_;
  DeviceServer server_;
  boost::asio::io_context io_;
  tcp::socket socket_{io_};
  Counters counters_;
  sick::ColaStream stream_{counters_};
  std::string chunk_;
  ColaTelegram telegram_;
  sick::ColaScan scan_;
};

/// What a model has of the sequence.
struct Start {
  const char* model;
  std::uint32_t password = 0xF4724744;
  int fields = 0;         ///< evaluation fields that are read
  bool has_list = false;  ///< its scans are chosen from a list, instead of by their range
  bool stops = false;     ///< its measurement is stopped before
  bool filters_echoes = false;
  std::vector<int> compensation = {};
};
const Start starts[] = {
    {"sick_lms1xx", 0xF4724744, 30},
    {"sick_lms5xx", 0xF4724744, 30, false, false, true},
    {"sick_lms1000", 0xF4724744, 0, false, true},
    {"sick_lms4000"},
    {"sick_tim240"},
    {"sick_tim4xx"},
    {"sick_tim5xx"},
    {"sick_tim7xx", 0xF4724744, 48},
    {"sick_tim7xxs", 0x6FD62C05, 48},
    {"sick_lrs36x0", 0xF4724744, 0, true, true},
    {"sick_lrs36x1", 0xF4724744, 0, true, true},
    {"sick_nav2xx", 0xF4724744, 0, false, false, false, {4, 4, 4}},
    {"sick_nav31x", 0xF4724744, 0, true, true, false, {2, 4, 2}},
    {"sick_oem15xx", 0xF4724744, 0, true, true},
    {"sick_mrs1000", 0xF4724744, 0, false, true, true},
};

using Case = std::tuple<Start, ColaDialect>;
class ColaStart : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Models, ColaStart,
                         ::testing::Combine(::testing::ValuesIn(starts),
                                            ::testing::Values(ColaDialect::a, ColaDialect::b)),
                         [](const auto& each) {
                           return std::get<0>(each.param).model +
                                  std::string(std::get<1>(each.param) == ColaDialect::b ? "_b" : "_a");
                         });

const std::vector<int> outputs = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2};

/// Reads the variable, whose value must have that form; returns it.
std::vector<std::uint32_t> read(Session& session, const std::string& name, const std::vector<int>& widths) {
  session.ask("sRN " + name);
  EXPECT_EQ(session.answered(), "sRA " + name);
  const std::vector<std::uint32_t> value = session.numbers(widths);
  EXPECT_EQ(value.size(), widths.size()) << name;
  return value;
}

void call(Session& session, const std::string& name, std::uint32_t expected,
          const std::vector<Number>& arguments = {}) {
  session.ask("sMN " + name, arguments);
  EXPECT_EQ(session.answered(), "sAN " + name);
  EXPECT_EQ(session.numbers({1}), std::vector<std::uint32_t>{expected}) << name;
}

/// "sRN LMPscancfg", and the same again as a setting.
void set_scan(Session& session) {
  const auto scan = read(session, "LMPscancfg", {4, 2, 4, 4, 4});
  ASSERT_EQ(scan.size(), 5U);
  session.ask("sMN mLMPsetscancfg", {{scan[0], 4}, {1, 2}, {scan[2], 4}, {scan[3], 4}, {scan[4], 4}});
  EXPECT_EQ(session.answered(), "sAN mLMPsetscancfg");
  EXPECT_EQ(session.numbers({1, 4, 2, 4, 4, 4}),
            (std::vector<std::uint32_t>{0, scan[0], 1, scan[2], scan[3], scan[4]}));
}

TEST_P(ColaStart, EachTelegramIsAnsweredAndScansCome) {
  const auto& [start, dialect] = GetParam();
  Session session(start.model, dialect);
  EXPECT_EQ(read(session, "SCdevicestate", {1}).at(0), 1U);
  session.log_in(start.password);
  session.write("EIHstCola", {{dialect == ColaDialect::b ? 1U : 0U, 1}});
  if (start.stops) call(session, "LMCstopmeas", 0);
  if (!start.compensation.empty()) read(session, "MCAngleCompSin", start.compensation);
  if (start.filters_echoes) {
    session.ask("sWN SetActiveApplications", {{1, 2}}, "RANG");
    EXPECT_EQ(session.answered(), "sWA SetActiveApplications");
  }
  session.ask("sRN DeviceIdent");
  EXPECT_EQ(session.answered(), "sRA DeviceIdent");
  for (const char* name : {"SerialNumber", "FirmwareVersion", "LocationName", "OrdNum"}) {
    session.ask("sRN " + std::string(name));
    EXPECT_EQ(session.answered(), "sRA " + std::string(name));
    EXPECT_NE(session.text(), "no text") << name;
  }
  EXPECT_EQ(read(session, "SCdevicestate", {1}).at(0), 0U) << "no scans during a login";
  read(session, "ODoprh", {4});
  read(session, "ODpwrc", {4});
  if (start.has_list) {
    call(session, "mCLsetscancfglist", 0, {{1, 1}});
    call(session, "Run", 1);
    session.log_in(start.password);
    set_scan(session);
  } else {
    const auto range = read(session, "LMPoutputRange", {2, 4, 4, 4});
    session.write("LMPoutputRange", {{1, 2}, {range.at(1), 4}, {range.at(2), 4}, {range.at(3), 4}});
    EXPECT_EQ(read(session, "LMPoutputRange", {2, 4, 4, 4}), range);
  }
  for (int i = 0; i < start.fields; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "field%03d", i);
    read(session, name, {1});
  }
  read(session, "LIDinputstate", {2, 4, 1, 1, 1, 1, 2});
  const std::vector<std::uint32_t> wanted = {1, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1, 1};
  std::vector<Number> arguments;
  for (std::size_t i = 0; i < wanted.size(); ++i) arguments.push_back({wanted[i], outputs[i]});
  session.write("LMDscandatacfg", arguments);
  EXPECT_EQ(read(session, "LMDscandatacfg", outputs), wanted);
  if (!start.has_list) set_scan(session);
  if (start.filters_echoes) session.write("FREchoFilter", {{2, 1}});
  for (const char* event : {"LFErec", "LIDoutputstate", "LIDinputstate"}) {
    session.ask("sEN " + std::string(event), {{1, 1}});
    EXPECT_EQ(session.answered(), "sEA " + std::string(event));
  }
  EXPECT_EQ(read(session, "LFErec", {2}).at(0), 0U);
  call(session, "LMCstartmeas", 0);
  session.ask("sRN STlms");
  EXPECT_EQ(read_arguments(session.answer(), [](auto in) { return in.u16(); }), 7U)
      << "so the LMS1xx driver waits";
  call(session, "Run", 1);
  EXPECT_EQ(read(session, "SCdevicestate", {1}).at(0), 1U);
  session.ask("sEN LMDscandata", {{1, 1}});
  EXPECT_EQ(session.numbers({1}), std::vector<std::uint32_t>{1});
  for (int i = 0; i < 3; ++i) {
    const sick::ColaScan& scan = session.scan();
    ASSERT_NE(scan.channel("DIST1"), nullptr);
    EXPECT_GT(scan.channel("DIST1")->values.size(), 200U);
    ASSERT_NE(scan.channel("RSSI1"), nullptr);
    EXPECT_TRUE(scan.channel("RSSI1")->wide) << "asked for with 16 bits";
  }
}

class ColaClient : public ::testing::TestWithParam<ColaDialect> {};
INSTANTIATE_TEST_SUITE_P(Dialects, ColaClient, ::testing::Values(ColaDialect::a, ColaDialect::b),
                         [](const auto& each) { return each.param == ColaDialect::b ? "b" : "a"; });

TEST_P(ColaClient, WhatTheDeviceDoesNotKnowOrAllowIsRefused) {
  Session session("sick_lms1xx", GetParam());
  const auto refusal = [&session](const std::string& command, const std::vector<Number>& arguments = {}) {
    session.ask(command, arguments);
    return session.refusal();
  };
  EXPECT_EQ(refusal("sMN mNoSuchMethod"), 2U);
  EXPECT_EQ(refusal("sRN field030"), 3U);
  EXPECT_EQ(refusal("sWN NoSuchVariable", {{1, 1}}), 3U);
  EXPECT_EQ(refusal("sEN InertialMeasurementUnit", {{1, 1}}), 15U);
  EXPECT_EQ(refusal("sXN DeviceIdent"), 12U);
  EXPECT_EQ(refusal("sRN"), 3U);
  EXPECT_EQ(refusal("sMN LMCstartmeas"), 1U) << "nobody is logged in";
  EXPECT_EQ(refusal("sWN LocationName", {{0, 2}}), 10U) << "nobody is logged in";
  EXPECT_EQ(refusal("sMN SetAccessMode", {{3, 1}}), 8U);
  EXPECT_EQ(refusal("sEN LMDscandata"), 8U);
  session.log_in();
  EXPECT_EQ(refusal("sWN SerialNumber", {{0, 2}}), 10U);
  EXPECT_EQ(refusal("sWN DeviceIdent", {{0, 2}}), 10U);
  EXPECT_EQ(refusal("sWN LMDscandatacfg", {{1, 1}, {0, 1}}), 8U);
  EXPECT_EQ(refusal("sWN LMPoutputRange", {{1, 2}}), 8U);
  EXPECT_EQ(refusal("sWN LMPoutputRange", {{1, 2}, {2500, 4}, {0, 4}, {900000, 4}}), 4U) << "another step";
  EXPECT_EQ(refusal("sWN LMPoutputRange", {{1, 2}, {5000, 4}, {2260000, 4}, {2270000, 4}}), 5U);
  EXPECT_EQ(refusal("sWN FREchoFilter", {{3, 1}}), 5U);
  EXPECT_EQ(refusal("sWN FREchoFilter", {{1, 1}, {1, 1}}), 8U);
  EXPECT_EQ(refusal("sMN mLMPsetscancfg", {{5000, 4}}), 8U);
  session.ask("sMN mLMPsetscancfg", {{2500, 4}, {1, 2}, {5000, 4}, {0, 4}, {0, 4}});
  EXPECT_EQ(session.numbers({1, 4, 2, 4, 4, 4}).at(0), 1U) << "another rate";
  session.ask("sMN mLMPsetscancfg", {{5000, 4}, {1, 2}, {2500, 4}, {0, 4}, {0, 4}});
  EXPECT_EQ(session.numbers({1, 4, 2, 4, 4, 4}).at(0), 2U) << "another step";
  session.ask("sRN SerialNumber");
  EXPECT_EQ(session.text(), "18090362") << "after all of this it still answers";
}

TEST(ColaTelegrams, DamagedFramesDoNotHideTheNextTelegram) {
  Session session("sick_lms1xx", ColaDialect::b);
  using namespace std::string_literals;
  session.send("\2\2\2\2\xff\xff\xff\xffsRN DeviceIdent"s);  // too long for any device
  session.send("\2\2\2\2\0\0\0\x0fsRN DeviceIdent\x01"s);    // wrong checksum
  session.send("\2\2\2\2\0\0\0\0\0"s);                       // nothing in it
  EXPECT_EQ((session.next(), session.refusal()), 12U);
  session.ask("sRN SCdevicestate");
  EXPECT_EQ(session.numbers({1}), std::vector<std::uint32_t>{1});
}

TEST(ColaTelegrams, ATextDeviceAnswersTextAlone) {
  Session session("sick_lms1xx", ColaDialect::a);
  using namespace std::string_literals;
  session.send("\2\2\2\2\0\0\0\x11sRN SCdevicestate\x30"s);
  EXPECT_EQ(read(session, "SCdevicestate", {1}).at(0), 1U) << "one answer, to the telegram behind";
  session.send("\3\2hello\3"s);
  EXPECT_EQ((session.next(), session.refusal()), 12U);
}

TEST(ColaTelegrams, NumbersOfTextMayHaveLeadingZerosOrASign) {
  Session session("sick_lms1xx", ColaDialect::a);
  // So the LMS1xx driver of ROS logs in and writes (LMS1xx.cpp).
  session.send("\2sMN SetAccessMode 03 F4724744\3");
  EXPECT_EQ((session.next(), session.numbers({1})), std::vector<std::uint32_t>{1});
  session.send("\2sWN LMDscandatacfg 01 00 1 1 0 00 00 0 0 0 0 +2\3");
  EXPECT_EQ((session.next(), session.answered()), "sWA LMDscandatacfg");
  EXPECT_EQ(read(session, "LMDscandatacfg", outputs).at(11), 2U);
  session.send("\2sWN LMPoutputRange 1 +5000 -450000 +900000\3");
  EXPECT_EQ((session.next(), session.answered()), "sWA LMPoutputRange");
  session.send("\2sWN LMPoutputRange 1 what 0 0\3");
  EXPECT_EQ((session.next(), session.refusal()), 8U);
  session.send("\2sRI 0\3");
  EXPECT_EQ(std::string(session.next().payload.text()), "sRA 0 6 LMS111 5 V1.80");
  EXPECT_EQ(read(session, "LMPoutputRange", {2, 4, 4, 4}),
            (std::vector<std::uint32_t>{1, 5000, 0xFFF92230, 900000}));
}

TEST_P(ColaClient, WrittenVariablesAreKeptUntilTheNextClient) {
  Session session("sick_mrs1000", GetParam());
  session.log_in();
  session.write("LFPmeanfilter", {{1, 1}, {4, 2}, {0, 1}});
  session.connect();
  EXPECT_EQ(read(session, "LFPmeanfilter", {1, 2, 1}), (std::vector<std::uint32_t>{1, 4, 0}));
}

TEST_P(ColaClient, TheDialectCanBeChanged) {
  Session session("sick_tim5xx", GetParam());
  const ColaDialect other = GetParam() == ColaDialect::a ? ColaDialect::b : ColaDialect::a;
  session.log_in();
  session.write("EIHstCola", {{other == ColaDialect::b ? 1U : 0U, 1}});
  session.connect();
  session.speak(other);
  session.ask("sRN LocationName");
  EXPECT_EQ(session.text(), "not defined");
}

/// Beams of the room see its walls 5 m away.
double wall(double azimuth) { return 5 / std::max(std::abs(std::cos(azimuth)), std::abs(std::sin(azimuth))); }

TEST_P(ColaClient, TheScanFollowsTheOutputRange) {
  Session session("sick_lms1xx", GetParam());
  session.log_in();
  session.write("LMPoutputRange", {{1, 2}, {5000, 4}, {300000, 4}, {1000000, 4}});
  call(session, "Run", 1);
  session.ask("sEN LMDscandata", {{1, 1}});
  const sick::ColaChannel* distance = session.scan().channel("DIST1");
  ASSERT_NE(distance, nullptr);
  EXPECT_DOUBLE_EQ(distance->start_deg, 30);
  ASSERT_EQ(distance->values.size(), 141U);
  for (std::size_t i = 0; i < distance->values.size(); ++i) {
    const double azimuth = (30 + 0.5 * static_cast<double>(i) - 90) * std::acos(-1) / 180;
    EXPECT_NEAR(distance->values[i], 1000 * wall(azimuth), 0.51) << i;
  }
}

TEST_P(ColaClient, AScanIsSentOnRequest) {
  Session session("sick_lms5xx", GetParam());
  session.ask("sRN LMDscandata");
  EXPECT_EQ(session.answered(), "sRA LMDscandata");
  session.ask("sRN SCdevicestate");
  EXPECT_EQ(session.answered(), "sRA SCdevicestate") << "one scan";
}

TEST_P(ColaClient, NoScansWhileTheMeasurementIsStopped) {
  Session session("sick_lms4000", GetParam());
  session.log_in();
  call(session, "LMCstopmeas", 0);
  call(session, "Run", 1);
  session.ask("sEN LMDscandata", {{1, 1}});
  EXPECT_EQ(read(session, "SCdevicestate", {1}).at(0), 0U);
  session.log_in();
  call(session, "LMCstartmeas", 0);
  call(session, "Run", 1);
  EXPECT_EQ(session.next().kind(), "sSN");
}

}  // namespace
}  // namespace lidard::sim
