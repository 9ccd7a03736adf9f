// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Recorded connections of SICK scanners. The expected values stand in JSON files beside the captures, made by
// a program that shares nothing with this one.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_scan.h"
#include "drivers/sick/cola/cola_stream.h"
#include "test/sim/world/rng.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

struct Recorded {
  const char* capture;
  const char* truth;
  const char* model;
  std::size_t scans;
  std::size_t beams;
  std::size_t repeated = 0;  ///< of the scans: the same bytes again, 2 to 3 ms later
};
constexpr Recorded lms111 = {
    "sick/lms111_colab_20210302.pcap", "sick/colab_lms111_20210302.jsonl", "sick_lms1xx", 175, 541, 3};
constexpr Recorded lms511 = {"sick/lms511_colab_20210301.pcap", "sick/colab_lms511_20210301.jsonl",
                             "sick_lms5xx", 136, 1141};
constexpr Recorded tim781s = {"sick/tim781s_colab_20210125.pcap", "sick/colab_tim781s_20210125.jsonl",
                              "sick_tim7xxs", 140, 811};
constexpr Recorded mrs1104 = {"sick/mrs1104_colab_20210722.pcap", "sick/colab_mrs1104.jsonl", "sick_mrs1000",
                              96, 1101};

class ColaCapture : public ::testing::TestWithParam<Recorded> {};
INSTANTIATE_TEST_SUITE_P(Recorded, ColaCapture, ::testing::Values(lms111, lms511, tim781s, mrs1104),
                         [](const auto& each) { return std::string(each.param.model); });

/// What the device sent.
std::string device_stream(const std::string& path) {
  std::string stream;
  PcapSource source(path);
  for (Packet packet; source.next(packet);) {
    if (packet.transport == Transport::tcp && packet.from.port == 2112) stream += packet.payload.text();
  }
  return stream;
}

std::vector<nlohmann::json> read_truth(const std::string& path) {
  std::vector<nlohmann::json> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

TEST_P(ColaCapture, GivesEveryScanWithoutAnyError) {
  LIDARD_NEED_CAPTURE(path, GetParam().capture);
  const Decoded got = decode_capture(path, GetParam().model);
  const bool layered = !got.output.clouds.empty();
  EXPECT_EQ(layered ? got.output.clouds.size() * 4 : got.output.scans.size(),
            GetParam().scans - GetParam().repeated);
  EXPECT_EQ(got.counters.packets, GetParam().scans);
  EXPECT_EQ(got.counters.rejected[static_cast<std::size_t>(Reject::duplicate)], GetParam().repeated);
  EXPECT_EQ(got.counters.rejected_total(), GetParam().repeated);
  EXPECT_EQ(got.counters.lost_packets, 0U);
  EXPECT_EQ(got.counters.incomplete, 0U);
  EXPECT_EQ(got.counters.partial_frames, 0U);
  EXPECT_EQ(got.counters.clock_steps, 0U);
  for (const PlanarScan& scan : got.output.scans) {
    ASSERT_EQ(violation(scan), nullptr) << violation(scan);
    EXPECT_EQ(scan.beams, GetParam().beams);
    EXPECT_EQ(scan.angle_min, got.output.scans[0].angle_min);
    EXPECT_EQ(scan.angle_increment, got.output.scans[0].angle_increment);
  }
}

TEST_P(ColaCapture, TelegramsHoldWhatTheTruthSays) {
  LIDARD_NEED_CAPTURE(path, GetParam().capture);
  LIDARD_NEED_CAPTURE(truth_path, GetParam().truth);
  const std::string stream = device_stream(path);
  Counters counters;
  sick::ColaStream telegrams(counters);
  telegrams.add(ByteView(stream));
  sick::ColaTelegram telegram;
  sick::ColaScan scan;
  const auto truths = read_truth(truth_path);
  ASSERT_GE(truths.size(), 10U);
  for (const auto& truth : truths) {
    do {
      ASSERT_TRUE(telegrams.next(telegram));
    } while (telegram.kind() != "sSN" || telegram.name() != "LMDscandata");
    ASSERT_EQ(parse_cola_scan(telegram, scan), Reject::none);
    EXPECT_EQ(scan.serial, truth["serial"]);
    EXPECT_EQ(scan.telegram_counter, truth["telegram"]);
    EXPECT_EQ(scan.scan_counter, truth["scan"]);
    EXPECT_EQ(scan.start_us, truth["up_us"]);
    EXPECT_EQ(scan.transmit_us, truth["tx_us"]);
    EXPECT_EQ(scan.layer, truth["layer_centideg"]);
    std::size_t at = 0;
    for (const char* width : {"ch16", "ch8"}) {
      if (!truth.contains(width)) continue;
      for (const auto& expected : truth[width]) {
        const sick::ColaChannel& channel = scan.channels.at(at++);
        EXPECT_EQ(channel.name(), expected["name"].get<std::string>());
        EXPECT_NEAR(channel.start_deg, expected["start_deg"], 1e-9);
        EXPECT_NEAR(channel.step_deg, expected["step_deg"], 1e-9);
        EXPECT_EQ(channel.values, expected["data"].get<std::vector<std::uint16_t>>());
      }
    }
    EXPECT_EQ(scan.channel_count, at);
    EXPECT_GT(at, 0U);
  }
}

TEST_P(ColaCapture, PublishedRangesAreTheTruthsDistances) {
  LIDARD_NEED_CAPTURE(path, GetParam().capture);
  LIDARD_NEED_CAPTURE(truth_path, GetParam().truth);
  DriverConfig config;
  config.keep_origins = true;
  const Decoded got = decode_capture(path, GetParam().model, config);
  const std::vector<nlohmann::json> truth = read_truth(truth_path);
  ASSERT_GE(truth.size(), 12U);
  std::size_t row = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto& raw = truth[i]["ch16"][0]["data"];
    for (std::size_t beam = 0; beam < raw.size(); ++beam) {
      const int mm = raw[beam];
      if (got.output.clouds.empty()) {
        const float range = got.output.scans.at(i).ranges.at(beam);
        if (mm >= 50) {
          EXPECT_FLOAT_EQ(range, static_cast<float>(mm * 1e-3));
        } else {
          EXPECT_FALSE(std::isfinite(range));
        }
      } else if (mm >= 50) {
        const Row& point = got.output.rows.at(row++);
        EXPECT_EQ(point.packet, i);
        EXPECT_NEAR(point.distance_m, mm * 1e-3, 1e-6);
        EXPECT_NEAR(point.azimuth_deg, -47.5 + 0.25 * static_cast<double>(beam), 1e-9);
        EXPECT_EQ(point.ring, 1 - truth[i]["layer_centideg"].get<int>() / 250);
        EXPECT_NEAR(std::hypot(point.x, point.y, point.z), mm * 1e-3, 1e-4);
      }
    }
  }
}

TEST(ColaCaptures, ForeignTelegramsAreSetAsideAndCounted) {
  LIDARD_NEED_CAPTURE(mixed, "sick/tim7xx_sopas_et_field_test.pcap");
  const Decoded monitored = decode_capture(mixed, "sick_tim7xxs");
  EXPECT_EQ(monitored.output.scans.size(), 139U);
  EXPECT_EQ(monitored.counters.other_packets, 138U);
  EXPECT_EQ(monitored.counters.rejected_total(), 0U);
  LIDARD_NEED_CAPTURE(radar, "sick/rms1xxx_colaa_radar.pcap");
  DriverConfig config;
  const Decoded foreign = decode_capture(radar, "sick_lms1xx", config);
  EXPECT_TRUE(foreign.output.scans.empty());
  EXPECT_EQ(foreign.counters.rejected_total(), 0U);
  EXPECT_GT(foreign.counters.other_packets, 700U);
}

TEST(ColaCaptures, FieldsAndOutputsOfAnLms511GoOut) {
  LIDARD_NEED_CAPTURE(path, "sick/lms511_colab_20210301.pcap");
  DriverConfig config;
  config.model = find_model("sick_lms5xx");
  const auto driver = config.model->make(config);
  struct States final : FrameReceiver {
    void scan(PlanarScan&) override {}
    void cloud(Cloud&) override {}
    void message(const DeviceMessage& message) override {
      last = std::get<DeviceState>(message);
      ++count[std::string(last.topic)];
    }
    std::map<std::string, int> count;
    DeviceState last;
  } out;
  PcapSource source(path);
  for (Packet packet; source.next(packet);) {
    if (packet.from.port == 2112) driver->receive(packet, out);
    if (out.last.topic == "lferec") {
      EXPECT_EQ(out.last.values.size(), 4U);
      EXPECT_EQ(out.last.values.at(1).name, "field_2");
      EXPECT_EQ(out.last.values.at(1).value, 2) << "infringed";
      EXPECT_EQ(out.last.values.at(0).value, 1) << "free";
      EXPECT_LT(std::abs(seconds(packet.arrival - out.last.stamp)), 1.0);
      out.last.topic = "";
    }
  }
  EXPECT_EQ(out.count["lferec"], 3);
  EXPECT_EQ(out.count["lidoutputstate"], 4);
  EXPECT_EQ(out.count["lidinputstate"], 1);
}

}  // namespace
}  // namespace lidard::test
