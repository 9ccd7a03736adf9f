// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/safety/safety_models.h"
#include "test/drivers/sick/safety/safety_bench.h"
#include "test/support/allocations.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

constexpr double rad = 3.14159265358979323846 / 180;

TEST(SafetyModels, AreFoundByNameAndMakeDrivers) {
  for (const char* name : {"sick_microscan3", "sick_nanoscan3", "sick_outdoorscan3", "sick_microscan3_9m"}) {
    const Model* model = find_model(name);
    ASSERT_NE(model, nullptr) << name;
    EXPECT_EQ(model->port, 6060);
    EXPECT_EQ(model->kind, FrameKind::scan);
    DriverConfig config;
    config.model = model;
    SafetyBench bench(config);
    bench.send_next();
    ASSERT_EQ(bench.scans.size(), 1U);
    EXPECT_FLOAT_EQ(bench.scans[0].range_max, std::string(name) == "sick_microscan3_9m" ? 64.0F : 40.0F);
  }
}

TEST(SafetyModels, RecogniseTheirDatagramsOnly) {
  const auto looks = [](const Bytes& b) { return is_ms3(ByteView(b.data(), b.size())); };
  EXPECT_TRUE(looks(ms3_datagrams(Ms3Sample().instance(), 1)[0]));
  EXPECT_FALSE(looks(Bytes(1206, 0xff)));
  EXPECT_FALSE(looks({}));
  EXPECT_FALSE(looks(ms3_datagram(10, 1, 5, Bytes(6, 0))));
}

TEST(SafetyModels, AreIdentifiedAsMicroScan3) {
  Identifier identifier;
  const Bytes foreign(1206, 0xff), datagram = ms3_datagrams(Ms3Sample().instance(), 1)[0];
  identifier.add(packet_of(foreign));
  EXPECT_EQ(identifier.verdict(), nullptr);
  identifier.add(packet_of(datagram));
  EXPECT_EQ(identifier.verdict(), find_model("sick_microscan3"));
}

TEST(SafetyDriver, TurnsTheManualsTelegramIntoAScan) {
  SafetyBench bench;
  bench.sample.beams[1] = {1411, 26, 1};
  ASSERT_EQ(bench.send_next(), Reject::none);
  ASSERT_EQ(bench.scans.size(), 1U);
  const PlanarScan& scan = bench.scans[0];
  EXPECT_EQ(scan.frame_id, "laser");
  EXPECT_EQ(scan.beams, 48U);
  EXPECT_NEAR(scan.angle_min, (-10.5597 - 90) * rad, 1e-6);
  EXPECT_NEAR(scan.angle_increment, 0.51306 * rad, 1e-7);
  EXPECT_NEAR(scan.angle_max, (-10.5597 - 90 + 47 * 0.51306) * rad, 1e-5);
  EXPECT_FLOAT_EQ(scan.scan_time, 0.03F);
  EXPECT_NEAR(scan.time_increment, 42.755e-6, 1e-9);
  EXPECT_FLOAT_EQ(scan.ranges[0], 1.408F);
  EXPECT_FLOAT_EQ(scan.ranges[1], 1.411F);
  EXPECT_FLOAT_EQ(scan.intensities[0], 26.0F);
  EXPECT_EQ(scan.stamp, bench.now - 47 * beam_period);
  EXPECT_EQ(bench.driver->info().serial, "17479021");
  EXPECT_EQ(bench.driver->counters().frames, 1U);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(SafetyDriver, MapsEveryCombinationOfStatusBits) {
  SafetyBench bench;
  bench.sample.beams.assign(64, {2000, 5, 0});
  for (std::size_t i = 0; i < 64; ++i) bench.sample.beams[i].status = static_cast<std::uint8_t>(i);
  bench.send_next();
  for (std::size_t i = 0; i < 64; ++i) {
    const bool valid = i & 1U, infinite = i & 2U, glare = i & 4U;
    const BeamStatus expected = glare      ? BeamStatus::invalid
                                : infinite ? BeamStatus::none
                                : valid    ? BeamStatus::hit
                                           : BeamStatus::invalid;
    EXPECT_EQ(bench.scans[0].statuses[i], expected) << i;
  }
}

TEST(SafetyDriver, KeepsEveryFiniteRangeInsideTheLimits) {
  SafetyBench bench;
  bench.sample.beams.resize(6);
  const std::array<std::uint16_t, 6> millimetres{{0, 99, 100, 40000, 40001, 65535}};
  for (std::size_t i = 0; i < 6; ++i) bench.sample.beams[i].distance = millimetres[i];
  bench.send_next();
  const auto& status = bench.scans[0].statuses;
  EXPECT_EQ(status[0], BeamStatus::near);
  EXPECT_EQ(status[1], BeamStatus::near);
  EXPECT_EQ(status[2], BeamStatus::hit);
  EXPECT_EQ(status[3], BeamStatus::hit);
  EXPECT_EQ(status[4], BeamStatus::none);
  EXPECT_EQ(status[5], BeamStatus::none);
  EXPECT_TRUE(bench.has_warning("65.535"));
}

TEST(SafetyDriver, AppliesTheDistanceFactor) {
  SafetyBench bench;
  bench.send_next();
  bench.sample.factor = 2;
  bench.send_next();
  EXPECT_FLOAT_EQ(bench.scans[1].ranges[0], 2.816F);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(SafetyDriver, LeavesIntensitiesOutOnRequest) {
  DriverConfig config;
  config.publish_intensity = false;
  SafetyBench bench(config);
  bench.send_next();
  EXPECT_TRUE(bench.scans[0].intensities.empty());
}

TEST(SafetyDriver, SaysWhenTheConfiguredAnglesLeaveNothing) {
  DriverConfig config;
  config.angle_min = 2.9;
  SafetyBench bench(config);
  bench.send_next();
  EXPECT_TRUE(bench.scans.empty());
  EXPECT_TRUE(bench.has_warning("angle_min"));
  EXPECT_EQ(bench.driver->counters().other_packets, 1U);
}

TEST(SafetyDriver, ChangedGeometryIsAnnouncedOnceAndStays) {
  SafetyBench bench;
  for (int i = 0; i < 3; ++i) bench.send_next();
  bench.sample.beams.resize(40);
  for (int i = 0; i < 3; ++i) bench.send_next();
  ASSERT_EQ(bench.scans.size(), 6U);
  EXPECT_EQ(bench.scans[2].beams, 48U);
  EXPECT_EQ(bench.scans[3].beams, 40U);
  EXPECT_EQ(bench.scans[5].beams, 40U);
  EXPECT_TRUE(bench.has_warning("48 beams"));
  EXPECT_TRUE(bench.has_warning("40 beams"));
  for (int i = 0; i < 50; ++i) {
    bench.sample.beams.resize(i % 2 == 0 ? 48 : 40);
    bench.send_next();
  }
  EXPECT_EQ(bench.driver->info().warnings.size(), 1U);
}

TEST(SafetyDriver, TellsTheStateOfTheScanner) {
  SafetyBench bench;
  bench.sample.state_flags = 0x01 | 0x04 | 0x10;
  bench.sample.cases = {{7, 2, 0, 0}};
  bench.sample.intrusion[4] = {0, 1, 0, 0, 0, 0};
  bench.send_next();
  EXPECT_EQ(bench.detail("Monitoring Cases"), "7 2 0 0");
  EXPECT_EQ(bench.detail("Contamination"), "warning");
  EXPECT_EQ(bench.detail("Safe Cut-off Paths ON"), "1 3 5 7");
  EXPECT_EQ(bench.detail("Non-safe Cut-off Paths ON"), "1 2 3 4 5 6 7 8");
  EXPECT_EQ(bench.detail("Cut-off Paths with Interrupted Beams"), "5");
  EXPECT_EQ(bench.detail("Reference Contour Violated"), "yes");
  EXPECT_EQ(bench.detail("Vendor Name"), "SICK");
  const std::size_t details = bench.driver->info().details.size();
  bench.sample.state_flags = 0x09;
  bench.sample.intrusion[4] = Bytes(6, 0);
  bench.send_next();
  EXPECT_EQ(bench.detail("Contamination"), "error");
  EXPECT_EQ(bench.detail("Cut-off Paths with Interrupted Beams"), "none");
  EXPECT_EQ(bench.driver->info().details.size(), details);
}

TEST(SafetyDriver, MissingBlocksAreExplained) {
  SafetyBench bench;
  bench.sample.with_derived = false;
  EXPECT_EQ(bench.send_next(), Reject::field);
  EXPECT_TRUE(bench.has_warning("derived values"));
  bench.sample.with_measurement = false;
  EXPECT_EQ(bench.send_next(), Reject::none);
  EXPECT_TRUE(bench.has_warning("no measurement data"));
  bench.sample.with_derived = bench.sample.with_measurement = true;
  bench.send_next();
  EXPECT_EQ(bench.scans.size(), 1U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  bench.sample.major = 3;
  EXPECT_EQ(bench.send_next(), Reject::version);
  EXPECT_TRUE(bench.has_warning("version 3"));
}

TEST(SafetyDriver, OtherChannelIsLeftOutAndNamed) {
  SafetyBench bench;
  Ms3Sample other = bench.sample;
  other.channel = 1;
  other.beams.resize(10);
  for (int i = 0; i < 5; ++i) {
    bench.send_next();
    ++other.sequence;
    ++other.scan;
    bench.send(other, bench.now + std::chrono::milliseconds(3));
  }
  EXPECT_EQ(bench.scans.size(), 5U);
  EXPECT_EQ(bench.driver->counters().other_packets, 5U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_TRUE(bench.has_warning("channel 1 of scanner"));
}

TEST(SafetyDriver, ReplacedScannerTakesOver) {
  SafetyBench bench;
  for (int i = 0; i < 5; ++i) bench.send_next();
  bench.now = bench.now + std::chrono::seconds(60);
  bench.sample.serial = 22220001;
  bench.sample.sequence = 5000;
  bench.send_next();
  EXPECT_EQ(bench.scans.size(), 6U);
  EXPECT_EQ(bench.driver->info().serial, "22220001");
  EXPECT_TRUE(bench.has_warning("was replaced"));
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
}

TEST(SafetyDriver, ForeignDatagramsAreCountedByReason) {
  SafetyBench bench;
  EXPECT_EQ(bench.driver->receive(packet_of(Bytes(1206, 0xff)), bench).reject, Reject::magic);
  EXPECT_EQ(bench.driver->receive(packet_of({}), bench).reject, Reject::size);
  EXPECT_EQ(bench.driver->counters().packets, 2U);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 2U);
}

// The bits: SICK 8022708 p. 18-19.
TEST(SafetyDriver, WhatTheScannerReportsOfItselfIsSaidWhileItLasts) {
  struct Case {
    std::uint8_t flags, errors;
    const char* words;
    bool is_fault;
  };
  SafetyBench bench;
  for (int incident = 0; incident < 2; ++incident) {
    for (const Case& each :
         {Case{0x05, 0, "warns of contamination", false}, Case{0x0d, 0, "contamination error", true},
          Case{0x11, 0, "reference contour", false}, Case{0x21, 0, "manipulation", true},
          Case{1, 1, "application error", true}, Case{1, 2, "device error", true}}) {
      bench.sample.state_flags = each.flags;
      bench.sample.errors = each.errors;
      bench.send_next();
      ASSERT_EQ(bench.driver->info().warnings.size(), 1U) << each.words;
      EXPECT_TRUE(bench.has_warning(each.words)) << each.words;
      EXPECT_EQ(bench.driver->info().has_fault, each.is_fault) << each.words;
      bench.sample.state_flags = 1;
      bench.sample.errors = 0;
      bench.send_next();
      EXPECT_TRUE(bench.driver->info().warnings.empty()) << each.words;
      EXPECT_FALSE(bench.driver->info().has_fault);
    }
  }
  bench.sample.state_flags = 0x25;
  bench.sample.errors = 2;
  bench.send_next();
  EXPECT_TRUE(bench.has_warning("contamination") && bench.has_warning("manipulation") &&
              bench.has_warning("device error"));
}

TEST(SafetyDriver, ContaminatedBeamsAreNamedWhereTheScannersStateIsNotSent) {
  SafetyBench bench;
  bench.sample.with_state = false;
  bench.sample.beams[7].status = 0x11;
  bench.send_next();
  EXPECT_TRUE(bench.has_warning("contaminated"));
  bench.sample.beams[7].status = 1;
  bench.send_next();
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(SafetyDriver, AllocatesNothingPerScanAfterWarmUp) {
  DriverConfig config;
  config.model = find_model("sick_nanoscan3");
  const auto driver = config.model->make(config);
  Ms3Sample sample;
  sample.beams.resize(1651);
  sample.step = 713032;
  sample.period_us = 14;
  sample.intrusion[3] = Bytes(207, 0x5a);
  std::vector<std::vector<Bytes>> scans;
  for (std::uint32_t i = 0; i < 200; ++i) {
    ++sample.sequence;
    ++sample.scan;
    scans.push_back(ms3_datagrams(sample.instance(), i));
  }
  Counted out;
  std::uint64_t before = 0;
  Stamp now = ms3_epoch;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i == 20) before = allocations();
    for (const Bytes& part : scans[i]) driver->receive(packet_of(part, now), out);
    now = now + std::chrono::milliseconds(30);
  }
  EXPECT_EQ(allocations() - before, 0U);
  EXPECT_EQ(out.points, 200U * 1651U);
  EXPECT_GT(allocations(), 0U);
}

}  // namespace
}  // namespace lidard::sick
