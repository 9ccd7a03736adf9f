// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which scanner it is that speaks CoLa, where it does not say so itself.
#include <gmock/gmock.h>

#include <cmath>
#include <string_view>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_models.h"
#include "test/sim/devices/cola_telegram.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Shows one telegram of a scan: `beams` values of `raw` from `start_deg` on.
struct Shown {
  double start_deg, step_deg, hz;
  std::size_t beams;
  float scale = 1;
  std::uint16_t raw = 3000;
  std::string name = {};  // what DeviceIdent answered before
};

void show(Recognizer& recognizer, const std::vector<std::uint8_t>& bytes) {
  Packet packet;
  packet.transport = Transport::tcp;
  packet.payload = {bytes.data(), bytes.size()};
  recognizer.add(packet);
}

void show(Recognizer& recognizer, const Shown& shown) {
  sim::SickScan scan;
  scan.scan_frequency = static_cast<std::uint32_t>(shown.hz * 100);
  sim::SickChannel channel;
  channel.scale = shown.scale;
  channel.start = static_cast<std::int32_t>(std::lround(shown.start_deg * 1e4));
  channel.step = static_cast<std::uint16_t>(std::lround(shown.step_deg * 1e4));
  channel.values.assign(shown.beams, shown.raw);
  scan.channels = {channel};
  if (!shown.name.empty())
    show(recognizer, sim::ColaWords(sim::Cola::binary, "sRA DeviceIdent").text(shown.name, 2).bytes());
  show(recognizer, scan.bytes(sim::Cola::binary));
}

struct Verdict {
  std::string model;
  std::vector<std::string_view> others;
};

Verdict verdict_of(const Shown& shown) {
  const auto recognizer = sick::make_cola_recognizer();
  show(*recognizer, shown);
  return {std::string(recognizer->verdict()), recognizer->others()};
}

TEST(ColaRecognizer, StepsOfTwoMillimetresAreAnLms5xx) {
  EXPECT_EQ(verdict_of({0, 0.5, 50, 241, 2}).model, "sick_lms5xx");
  EXPECT_THAT(verdict_of({0, 0.5, 50, 241, 2}).others, IsEmpty());
}

TEST(ColaRecognizer, RatesAndStepsThatOneFamilyAloneHasDecide) {
  // SICK 8013796 p. 85.
  EXPECT_EQ(verdict_of({30, 2.0 / 3, 100, 181}).model, "sick_lms5xx");
  EXPECT_EQ(verdict_of({0, 0.25, 35, 400}).model, "sick_lms5xx");
  EXPECT_EQ(verdict_of({0, 0.5, 75, 200}).model, "sick_lms5xx");
  EXPECT_EQ(verdict_of({0, 1.0 / 6, 25, 600}).model, "sick_lms5xx");
  EXPECT_THAT(verdict_of({0, 1.0 / 6, 25, 600}).others, IsEmpty());
  EXPECT_EQ(verdict_of({-5, 0.5, 25, 381}).model, "sick_lms5xx") << "the whole sweep of one";
}

TEST(ColaRecognizer, WhatSeveralFamiliesSendIsSaidWithTheirNames) {
  const Verdict either = verdict_of({0, 0.5, 50, 241});
  EXPECT_EQ(either.model, "sick_lms1xx");
  EXPECT_THAT(either.others, ElementsAre("sick_lms5xx"));
  const Verdict tim = verdict_of({-45, 1.0 / 3, 15, 811});
  EXPECT_EQ(tim.model, "sick_tim7xx");
  EXPECT_THAT(tim.others, ElementsAre("sick_tim7xxs", "sick_tim5xx"));
  EXPECT_THAT(verdict_of({-45, 0.5, 50, 541}).others, IsEmpty()) << "only an LMS1xx looks so far around";
}

// Begins and rates: sick_scan_xd, README (interlaced modes) and sick_scan_common.cpp (modes of the NAV and
// LRS).
TEST(ColaRecognizer, InterlacedScansOfAnLms1000AndTheModeThatNavAndLrsShare) {
  for (const double start_deg : {-47.8125, -48.0, -48.1875, -48.375})
    EXPECT_EQ(verdict_of({start_deg, 0.75, 150, 369}).model, "sick_lms1000") << start_deg;
  EXPECT_THAT(verdict_of({0, 0.25, 8, 1440}).others,
              ElementsAre("sick_oem15xx", "sick_lrs36x0", "sick_lrs36x1"));
}

TEST(ColaRecognizer, PlanesThatNoMrs1000HasAreThoseOfNoKnownModel) {
  for (const auto& [layer, model] :
       {std::pair<std::int16_t, std::string>(-250, "sick_mrs1000"), {-2638, ""}}) {
    const auto recognizer = sick::make_cola_recognizer();
    sim::SickScan scan;
    scan.layer = layer;
    scan.channels = {sim::SickChannel{}};
    scan.channels[0].values.assign(100, 3000);
    show(*recognizer, scan.bytes(sim::Cola::binary));
    EXPECT_EQ(recognizer->verdict(), model);
    if (model.empty()) {
      EXPECT_THAT(recognizer->remark(), HasSubstr("of no known model"));
    }
  }
}

TEST(ColaRecognizer, FifteenTurnsASecondAreNoLms1xx) {
  EXPECT_EQ(verdict_of({-45, 1, 15, 271}).model, "sick_tim5xx");
  EXPECT_THAT(verdict_of({-45, 1, 15, 271}).others, IsEmpty());
  EXPECT_EQ(verdict_of({-45, 0.5, 15, 541}).model, "sick_tim5xx") << "no step that is known";
  EXPECT_EQ(verdict_of({-45, 0.75, 50, 361}).model, "sick_lms1xx") << "likewise";
}

TEST(ColaRecognizer, ADistanceBeyondTheRangeOfAFamilyRulesItOut) {
  const auto recognizer = sick::make_cola_recognizer();
  show(*recognizer, Shown{0, 0.5, 50, 241});
  EXPECT_EQ(recognizer->verdict(), "sick_lms1xx");
  show(*recognizer, Shown{0, 0.5, 50, 241, 1, 60000});
  EXPECT_EQ(recognizer->verdict(), "sick_lms5xx");
  show(*recognizer, Shown{0, 0.5, 50, 241});
  EXPECT_EQ(recognizer->verdict(), "sick_lms5xx") << "what was seen once counts";
}

TEST(ColaRecognizer, TheNameOfTheDeviceCountsMoreThanItsScans) {
  for (const auto& [name, model] :
       {std::pair{"LMS511_FieldEval", "sick_lms5xx"}, std::pair{"LMS10x_FieldEval", "sick_lms1xx"},
        std::pair{"LMS1000", "sick_lms1000"}, std::pair{"TiM571", "sick_tim5xx"}}) {
    const Verdict named = verdict_of({0, 0.5, 50, 241, 1, 3000, name});
    EXPECT_EQ(named.model, model) << name;
    EXPECT_THAT(named.others, IsEmpty()) << name;
  }
}

TEST(ColaRecognizer, EveryAnswerThatNamesTheDeviceCounts) {
  // sick_tim and sick_scan ask "sRI 0" (SICKAG/sick_scan issue 4), sick_scan_xd also DItype.
  for (const char* answer : {"sRA DeviceIdent 6 TiM561 E V2.51-21.08.15", "sRA 0 6 TiM561 E V2.51-21.08.15",
                             "sRA DItype E TIM561-2050101"}) {
    const auto recognizer = sick::make_cola_recognizer();
    const std::string telegram = std::string("\2") + answer + "\3";
    show(*recognizer, {telegram.begin(), telegram.end()});
    show(*recognizer, Shown{-45, 1.0 / 3, 15, 811});
    EXPECT_EQ(recognizer->verdict(), "sick_tim5xx") << answer;
    EXPECT_THAT(recognizer->others(), IsEmpty()) << answer;
  }
  EXPECT_EQ(verdict_of({-45, 1.0 / 3, 15, 811, 1, 3000, "TiM781S"}).model, "sick_tim7xxs");
}

TEST(ColaRecognizer, TheSizeOfTheAngleCompensationTellsTheNavsApart) {
  for (const auto& [bytes, model] : {std::pair(12, "sick_nav2xx"), std::pair(8, "sick_nav31x")}) {
    const auto recognizer = sick::make_cola_recognizer();
    sim::ColaWords answer(sim::Cola::binary, "sRA MCAngleCompSin");
    for (int i = 0; i < bytes; i += 4) answer.number(0, 4);
    show(*recognizer, answer.bytes());
    show(*recognizer, Shown{0, 0.25, 8, 1440});
    EXPECT_EQ(recognizer->verdict(), model);
    EXPECT_THAT(recognizer->others(), IsEmpty());
  }
}

/// The verdict on one telegram.
Verdict verdict_on(const sim::SickScan& scan) {
  const auto recognizer = sick::make_cola_recognizer();
  show(*recognizer, scan.bytes(sim::Cola::text));
  return {std::string(recognizer->verdict()), recognizer->others()};
}

TEST(ColaRecognizer, TheMeasurementFrequencyTellsHowManyTelegramsMakeATurn) {
  sim::SickScan scan;
  scan.channels = {sim::SickChannel{"DIST1", 1, 0, 0, 2500, true, std::vector<std::uint16_t>(600, 3000)}};
  scan.scan_frequency = 5000;
  scan.measurement_frequency = 180;  // as an MRS1104 sends it, whose head an LMS1000 has
  EXPECT_EQ(verdict_on(scan).model, "sick_lms1000");
  scan.measurement_frequency = 720;
  EXPECT_EQ(verdict_on(scan).model, "sick_lms1xx") << "one telegram for each turn";
}

TEST(ColaRecognizer, TheEchoesThatAScanHoldsRuleFamiliesOut) {
  sim::SickScan scan;
  const std::vector<std::uint16_t> values(241, 3000);
  scan.channels = {sim::SickChannel{"DIST1", 1, 0, 0, 5000, true, values}};
  EXPECT_EQ(verdict_on(scan).model, "sick_lms1xx");
  scan.channels.push_back({"DIST3", 1, 0, 0, 5000, true, values});
  EXPECT_EQ(verdict_on(scan).model, "sick_lms5xx");
  EXPECT_THAT(verdict_on(scan).others, IsEmpty());
}

TEST(ColaRecognizer, TheNameInTheTelegramDecidesBetweenFamiliesThatFit) {
  sim::SickScan scan;
  scan.channels = {
      sim::SickChannel{"DIST1", 1, 0, -450000, 3333, true, std::vector<std::uint16_t>(811, 3000)}};
  scan.scan_frequency = 1500;
  scan.measurement_frequency = 162;
  EXPECT_THAT(verdict_on(scan).others, ElementsAre("sick_tim7xxs", "sick_tim5xx"));
  scan.name = "TiM571";
  EXPECT_EQ(verdict_on(scan).model, "sick_tim5xx");
  EXPECT_THAT(verdict_on(scan).others, IsEmpty());
  scan.name = "LMS5 left";
  EXPECT_EQ(verdict_on(scan).model, "sick_tim7xx") << "no LMS5xx sends such scans";
}

TEST(ColaRecognizer, ReportedCapturesAreNamed) {
  for (const auto& [file, model] : {std::pair("reports/12-identity-by-sRI0/tim561_sRI0.pcap", "sick_tim5xx"),
                                    std::pair("reports/12-identity-by-sRI0/tim561_ident.pcap", "sick_tim5xx"),
                                    std::pair("reports/14-dist2-only/lms100_dist2.pcap", "sick_lms1xx"),
                                    std::pair("reports/20-tim310-592/tim310_592.pcap", "sick_tim5xx")}) {
    LIDARD_NEED_CAPTURE(path, file);
    const auto recognizer = sick::make_cola_recognizer();
    PcapSource source(path);
    for (Packet packet; source.next(packet);) {
      if (packet.from.port == 2112) recognizer->add(packet);
    }
    EXPECT_EQ(recognizer->verdict(), model) << file;
    EXPECT_EQ(recognizer->remark(), "") << file;
  }
}

/// Numbers and sums of the distances were computed by another program from the text of the telegrams.
struct Recorded {
  const char* capture;
  std::size_t beams, hits, beyond_50_m;
  double sum_mm;
};

TEST(ColaRecognizer, RecordedScansOfAnLms5xxAreRecognisedAndKeepTheirFarReturns) {
  for (const Recorded& each : {Recorded{"sick/lms5xx_colaa_scale2_25m.pcap", 241, 1056, 18, 5307984},
                               Recorded{"sick/lms5xx_colaa_100hz.pcap", 181, 1074, 0, 2175570}}) {
    LIDARD_NEED_CAPTURE(path, each.capture);
    Collector out;
    Identifier identifier;
    PcapSource first(path);
    for (Packet packet; first.next(packet);) {
      if (packet.from.port == 2111) identifier.add(packet);
    }
    ASSERT_EQ(identifier.verdict(), find_model("sick_lms5xx")) << each.capture;
    EXPECT_EQ(identifier.remark(), "") << each.capture;
    DriverConfig config;
    config.model = identifier.verdict();
    const auto driver = config.model->make(config);
    PcapSource second(path);
    for (Packet packet; second.next(packet);) {
      if (packet.from.port == 2111) driver->receive(packet, out);
    }
    std::size_t hits = 0, far = 0;
    double sum = 0;
    for (const PlanarScan& scan : out.scans) {
      ASSERT_EQ(scan.beams, each.beams);
      for (std::size_t i = 0; i < scan.beams; ++i) {
        if (scan.statuses[i] != BeamStatus::hit) continue;
        ++hits;
        far += scan.ranges[i] > 50 ? 1U : 0U;
        sum += static_cast<double>(scan.ranges[i]) * 1000;
      }
    }
    EXPECT_EQ(out.scans.size(), 6U);
    EXPECT_EQ(hits, each.hits);
    EXPECT_EQ(far, each.beyond_50_m);
    EXPECT_NEAR(sum, each.sum_mm, 10);
    EXPECT_EQ(driver->counters().rejected_total(), 0U);
  }
}

/// Angles of the headers are those of two TiM551; the distances were made by this rule.
std::uint16_t made_mm(std::size_t beam, std::size_t scan) {
  if ((beam + scan) % 17 == 0) return static_cast<std::uint16_t>((beam + scan) % 3);
  return static_cast<std::uint16_t>(
      2000 + 500 * std::sin(static_cast<double>(beam) / 40 + static_cast<double>(scan) / 10));
}

TEST(ColaRecognizer, TheHeadersOfATim551AreATim5xxWithEveryBeam) {
  for (const char* capture : {"sick/tim551_colaa_header_a.pcap", "sick/tim551_colaa_header_b.pcap"}) {
    LIDARD_NEED_CAPTURE(path, capture);
    Identifier identifier;
    PcapSource source(path);
    for (Packet packet; source.next(packet);) {
      if (packet.from.port == 2112) identifier.add(packet);
    }
    ASSERT_EQ(identifier.verdict(), find_model("sick_tim5xx")) << capture;
    EXPECT_EQ(identifier.remark(), "");
    const Decoded got = decode_capture(path, "sick_tim5xx");
    ASSERT_EQ(got.output.scans.size(), 40U);
    EXPECT_EQ(got.counters.rejected_total(), 0U);
    for (std::size_t k = 0; k < got.output.scans.size(); ++k) {
      const PlanarScan& scan = got.output.scans[k];
      ASSERT_EQ(scan.beams, 271U);
      EXPECT_NEAR(scan.angle_min, -135 * M_PI / 180, 1e-6);
      for (std::size_t i = 0; i < scan.beams; ++i) {
        const std::uint16_t mm = made_mm(i, k);
        if (mm < 16)
          ASSERT_EQ(scan.statuses[i], mm == 0 ? BeamStatus::none : BeamStatus::invalid);
        else
          ASSERT_NEAR(scan.ranges[i], mm * 1e-3, 1e-6) << "scan " << k << " beam " << i;
      }
    }
  }
}

TEST(ColaRecognizer, ASessionOfLmdscandatamonAloneIsDecoded) {
  LIDARD_NEED_CAPTURE(path, "sick/tim781s_lmdscandatamon.pcap");
  Identifier identifier;
  PcapSource source(path);
  for (Packet packet; source.next(packet);) identifier.add(packet);
  ASSERT_EQ(identifier.verdict(), find_model("sick_tim7xx"));
  const Decoded got = decode_capture(path, "sick_tim7xx");
  EXPECT_EQ(got.output.scans.size(), 224U);
  EXPECT_EQ(got.counters.packets, 224U);
  EXPECT_EQ(got.counters.rejected_total(), 0U);
  ASSERT_FALSE(got.output.scans.empty());
  EXPECT_EQ(got.output.scans[0].beams, 811U);
}

/// What is said of scans that were changed by `spoil`, as binary telegrams.
template <class Spoil>
std::string remark_of(Spoil spoil) {
  const auto recognizer = sick::make_cola_recognizer();
  sim::SickScan scan;
  scan.channels = {{"DIST1", 1, 0, -450000, 5000, true, std::vector<std::uint16_t>(541, 3000)}};
  for (int i = 0; i < 10; ++i) spoil(*recognizer, scan);
  EXPECT_EQ(recognizer->verdict(), "");
  return recognizer->remark();
}

TEST(ColaRecognizer, ScansThatCannotBeReadAreNamedWithTheReason) {
  const std::string malformed = remark_of([](Recognizer& recognizer, sim::SickScan& scan) {
    scan.encoders.resize(9);  // four are the most
    show(recognizer, scan.bytes(sim::Cola::binary));
  });
  EXPECT_THAT(malformed, AllOf(HasSubstr("LMDscandata of a SICK scanner (CoLa) begins 10 times"),
                               HasSubstr("10 rejected for field")));
  const std::string endless = remark_of([](Recognizer& recognizer, sim::SickScan& scan) {
    auto bytes = scan.bytes(sim::Cola::text);
    bytes.back() = ' ';
    show(recognizer, bytes);
  });
  EXPECT_THAT(endless, AllOf(HasSubstr("begins"), HasSubstr("no telegram is complete")));
  const std::string holed = remark_of([](Recognizer& recognizer, sim::SickScan& scan) {
    const auto bytes = scan.bytes(sim::Cola::binary);
    Packet packet;
    packet.transport = Transport::tcp;
    packet.missing = bytes.size() - 500;
    packet.payload = {bytes.data(), 500};
    recognizer.add(packet);
  });
  EXPECT_THAT(holed, HasSubstr("bytes of the connection are not in the capture"));
  const std::string strange = remark_of([](Recognizer& recognizer, sim::SickScan& scan) {
    scan.channels[0].start = -1800000;
    show(recognizer, scan.bytes(sim::Cola::binary));
  });
  EXPECT_THAT(strange, HasSubstr("those of no known model"));
}

}  // namespace
}  // namespace lidard::test
