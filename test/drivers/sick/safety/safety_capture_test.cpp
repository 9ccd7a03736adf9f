// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A recorded microScan3: 398 datagrams, 129 whole scans, with real losses. All figures are those that
// test/support/sick_figures.py reads from the capture.
#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <cmath>
#include <map>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/safety/ms3_telegram.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

constexpr const char* capture = "sick/microscan3_398.pcap";
constexpr std::size_t scans = 129, beams = 715;
const std::map<int, std::size_t> beams_by_flags = {{0x01, 74518}, {0x03, 7095}, {0x41, 2721}, {0x43, 325},
                                                   {0x81, 2214},  {0xc1, 5120}, {0xc3, 242}};

TEST(SafetyCapture, EveryBeamOfEveryWholeScanIsRead) {
  LIDARD_NEED_CAPTURE(path, capture);
  Counters counters;
  sick::Ms3Reassembler reassembler(counters);
  sick::Ms3Reassembler::Instance instance;
  sick::Ms3Telegram telegram;
  boost::crc_32_type crc;
  std::size_t telegrams = 0;
  PcapSource source(path);
  for (Packet packet; source.next(packet);) {
    ASSERT_EQ(reassembler.add(packet, instance), Reject::none);
    if (instance.bytes.empty()) continue;
    ASSERT_EQ(parse_ms3_telegram(instance.bytes, telegram), Reject::none);
    ASSERT_EQ(telegram.beams(), beams);
    ++telegrams;
    for (std::size_t i = 0; i < beams; ++i) {
      const sick::Ms3Beam beam = telegram.beam(i);
      crc.process_byte(static_cast<unsigned char>(beam.distance & 0xffU));
      crc.process_byte(static_cast<unsigned char>(beam.distance >> 8U));
      crc.process_byte(beam.reflectivity);
      crc.process_byte(beam.status);
    }
  }
  EXPECT_EQ(telegrams, scans);
  EXPECT_EQ(crc.checksum(), 0x8e8c3ee1U);
}

TEST(SafetyCapture, RangesReflectivitiesAndFlagsComeOut) {
  LIDARD_NEED_CAPTURE(path, capture);
  DriverConfig config;
  config.model = find_model("sick_microscan3");
  const auto driver = config.model->make(config);
  Collector out;
  PcapSource source(path);
  for (Packet packet; source.next(packet);) driver->receive(packet, out);
  driver->finish(out);
  ASSERT_EQ(out.scans.size(), scans);
  ASSERT_EQ(out.extra_scans["beam_status"].size(), scans);
  std::size_t hits = 0, none = 0;
  double range_mm = 0, reflectivity = 0;
  std::map<int, std::size_t> by_flags;
  for (std::size_t s = 0; s < scans; ++s) {
    const PlanarScan& scan = out.scans[s];
    ASSERT_EQ(scan.beams, beams);
    EXPECT_EQ(out.extra_scans["beam_status"][s].stamp, scan.stamp);
    for (std::size_t i = 0; i < beams; ++i) {
      const int flags = static_cast<int>(out.extra_scans["beam_status"][s].intensities[i]);
      ++by_flags[flags];
      reflectivity += static_cast<double>(scan.intensities[i]);
      none += scan.statuses[i] == BeamStatus::none ? 1U : 0U;
      EXPECT_EQ(scan.statuses[i] == BeamStatus::none, (flags & 2) != 0);
      if (scan.statuses[i] != BeamStatus::hit) continue;
      ++hits;
      range_mm += std::round(static_cast<double>(scan.ranges[i]) * 1000);
    }
  }
  EXPECT_EQ(by_flags, beams_by_flags);
  EXPECT_EQ(hits, 82775U) << "the others are nearer than 0.1 m";
  EXPECT_EQ(none, 7095U + 325U + 242U);
  EXPECT_EQ(range_mm, 973683349.0);
  EXPECT_EQ(reflectivity, 4478456.0);
  EXPECT_EQ(driver->counters().lost_packets, 4208U);
  EXPECT_EQ(driver->counters().incomplete, 7U) << "two of them where the recording begins and ends";
  EXPECT_EQ(driver->counters().rejected_total(), 0U);
  EXPECT_EQ(driver->info().serial, "23430548");
}

}  // namespace
}  // namespace lidard::test
