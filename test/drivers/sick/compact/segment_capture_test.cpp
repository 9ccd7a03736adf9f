// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/compact/compact_telegram.h"
#include "test/drivers/sick/compact/segment_bench.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;
using nlohmann::json;

Decoded play(const std::string& path, bool keep_partial = false) {
  DriverConfig config;
  config.keep_partial = keep_partial;
  Decoded played = decode_capture(path, "sick_multiscan136", config);
  EXPECT_TRUE(played.output.scans.empty()) << "several layers made a scan";
  return played;
}

TEST(SegmentCapture, AllTelegramsOfTheCompactCaptureAreGood) {
  LIDARD_NEED_CAPTURE(path, "sick/multiscan_compact_frag.pcap");
  const Decoded played = play(path);
  EXPECT_EQ(played.counters.packets, 66U);
  EXPECT_EQ(played.counters.other_packets, 28U);
  EXPECT_EQ(played.counters.rejected_total(), 0U);
  EXPECT_EQ(played.counters.lost_packets, 0U);
  EXPECT_EQ(played.counters.clock_steps, 0U);
  EXPECT_EQ(played.output.imus.size(), 28U);
  EXPECT_EQ(played.info.serial, "22280002");
  // Segment 11 of one frame, five whole frames, five segments of a seventh. Of the first whole one the
  // counter proves both ends.
  ASSERT_EQ(played.output.clouds.size(), 5U);
  EXPECT_EQ(played.counters.partial_frames, 2U);
  for (const Cloud& cloud : played.output.clouds) {
    EXPECT_TRUE(cloud.complete);
    EXPECT_EQ(cloud.rings, 16U);
    EXPECT_NEAR(seconds(cloud.end - cloud.stamp), 0.05, 0.001);
  }
  for (std::size_t i = 1; i < played.output.clouds.size(); ++i)
    EXPECT_NEAR(seconds(played.output.clouds[i].stamp - played.output.clouds[i - 1].stamp), 0.05, 0.0005);
}

TEST(SegmentCapture, AllTelegramsOfTheMsgpackCaptureAreGood) {
  LIDARD_NEED_CAPTURE(path, "sick/multiscan_msgpack_3echo_frag.pcap");
  const Decoded played = play(path);
  EXPECT_EQ(played.counters.packets, 25U);
  EXPECT_EQ(played.counters.rejected_total(), 0U);
  EXPECT_EQ(played.counters.lost_packets, 0U);
  ASSERT_GE(played.output.clouds.size(), 1U);
  EXPECT_EQ(played.output.clouds.front().rings, 16U);
}

TEST(SegmentCapture, ElevationIsPositiveUpwards) {
  LIDARD_NEED_CAPTURE(path, "sick/multiscan_compact_frag.pcap");
  const Decoded played = play(path);
  // The device stands upright: its inertial unit feels gravity's counterforce along +z.
  ASSERT_GT(played.output.imus.size(), 10U);
  for (const ImuSample& sample : played.output.imus) {
    EXPECT_NEAR(sample.linear_acceleration.z(), 9.63, 0.1);
    ASSERT_TRUE(sample.orientation);
    // Gravity turned to a frame with z up has no other component.
    const Eigen::Vector3d up = *sample.orientation * sample.linear_acceleration;
    EXPECT_NEAR(up.normalized().z(), 1, 0.001);
  }
  // Where the visibility is free, each of the lower layers ends at the floor, 1.25 to 1.35 m below.
  std::map<int, std::vector<float>> heights;
  for (const Cloud& cloud : played.output.clouds) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const float z = p.z;
      heights[p.ring].push_back(z);
    }
  }
  for (int ring = 0; ring < 6; ++ring) {
    auto& z = heights[ring];
    ASSERT_GT(z.size(), 1000U);
    std::sort(z.begin(), z.end());
    EXPECT_NEAR(z[z.size() / 10], -1.3, 0.08) << ring;
  }
}

/// The next scan telegram of a capture; the packet lives in the source.
bool next_scan(PcapSource& capture, Packet& packet) {
  while (capture.next(packet)) {
    const TelegramHead head = read_head(packet.payload);
    if (head.reject == Reject::none && head.type == TelegramType::scan) return true;
  }
  return false;
}

void expect_beam(const json& row, const SegmentLine& line) {
  const auto beam = row[0].get<std::size_t>();
  EXPECT_NEAR(line.azimuth(beam) / bench_rad, row[2].get<double>(), 1e-4);
  EXPECT_EQ(line.properties[beam], row[3].get<double>());
  for (std::size_t e = 0; e < row[4].size(); ++e) {
    EXPECT_DOUBLE_EQ(line.distance[e][beam] * line.metres * 1000, row[4][e][0].get<double>());
    EXPECT_EQ(line.rssi[e][beam], row[4][e][1].get<double>());
  }
}

TEST(SegmentCapture, CompactTelegramsHoldWhatAnotherDecoderReads) {
  LIDARD_NEED_CAPTURE(path, "sick/multiscan_compact_frag.pcap");
  LIDARD_NEED_CAPTURE(truth_path, "sick/compact_multiscan.jsonl");
  PcapSource capture(path);
  std::ifstream lines(truth_path);
  std::size_t telegrams = 0, beams = 0;
  Packet packet;
  Segment segment;
  for (std::string text; std::getline(lines, text); ++telegrams) {
    const json truth = json::parse(text);
    ASSERT_TRUE(next_scan(capture, packet));
    ASSERT_TRUE(checksum_is_right(packet.payload, TelegramType::scan));
    ASSERT_EQ(parse_compact_scan(packet.payload, segment), Reject::none);
    EXPECT_EQ(segment.counter, truth["counter"]);
    std::size_t first = 0;
    for (const json& module : truth["modules"]) {
      EXPECT_EQ(segment.index, module["seg"]);
      EXPECT_EQ(segment.frame, module["frame"]);
      EXPECT_EQ(segment.sender, module["sender"]);
      const std::size_t count = module["nl"];
      ASSERT_LE(first + count, segment.line_count);
      EXPECT_EQ(segment.lines[first].start_us, module["t0"]);
      EXPECT_EQ(segment.lines[first].stop_us, module["t1"]);
      for (std::size_t l = 0; l < count; ++l) {
        EXPECT_EQ(segment.lines[first + l].beams, module["nb"]);
        EXPECT_NEAR(segment.lines[first + l].elevation / bench_rad, module["phi"][l].get<double>(), 0.006);
      }
      for (const json& row : module["beams"])
        expect_beam(row, segment.lines[first + row[1].get<std::size_t>()]);
      beams += module["beams"].size();
      first += count;
    }
    EXPECT_EQ(first, segment.line_count);
  }
  EXPECT_EQ(telegrams, 6U);
  EXPECT_GT(beams, 6U * 400U);
}

/// The two formats round differently: MSGPACK has distances of 32 bit, Compact whole mm.
void expect_same_line(const SegmentLine& compact, const SegmentLine& msgpack) {
  ASSERT_EQ(compact.beams, msgpack.beams);
  ASSERT_EQ(compact.echoes, msgpack.echoes);
  EXPECT_EQ(compact.start_us, msgpack.start_us);
  EXPECT_EQ(compact.stop_us, msgpack.stop_us);
  EXPECT_DOUBLE_EQ(compact.elevation, msgpack.elevation);
  EXPECT_NEAR(compact.theta_start, msgpack.theta_start, 1e-6);
  EXPECT_NEAR(compact.theta_stop, msgpack.theta_stop, 1e-6);
  EXPECT_EQ(compact.properties.sent(), msgpack.properties.sent());
  for (std::size_t b = 0; b < compact.beams; ++b) {
    EXPECT_NEAR(compact.azimuth(b), msgpack.azimuth(b), 1.0 / 5215);
    if (compact.properties.sent()) {
      EXPECT_EQ(compact.properties[b], msgpack.properties[b]);
    }
    for (std::size_t e = 0; e < compact.echoes; ++e) {
      EXPECT_EQ(compact.distance[e][b], std::floor(msgpack.distance[e][b]));
      EXPECT_EQ(compact.rssi[e][b], msgpack.rssi[e][b]);
    }
  }
}

TEST(SegmentCapture, BothFormatsOfTheSameContentAreEqual) {
  for (const std::string name :
       {"ScanSegmentAPI_synthetic_sample", "ScanSegmentAPI_synthetic_sample_30deg"}) {
    LIDARD_NEED_CAPTURE(compact_path, "sick/" + name + ".compact");
    LIDARD_NEED_CAPTURE(msgpack_path, "sick/" + name + ".msgpack");
    const auto compact_bytes = file_bytes(compact_path), msgpack_bytes = file_bytes(msgpack_path);
    Segment compact, msgpack;
    ASSERT_TRUE(checksum_is_right(view_of(compact_bytes), TelegramType::scan));
    ASSERT_EQ(parse_compact_scan(view_of(compact_bytes), compact), Reject::none);
    ASSERT_EQ(parse_msgpack_payload(view_of(msgpack_bytes), msgpack), Reject::none);
    EXPECT_EQ(compact.counter, msgpack.counter);
    EXPECT_EQ(compact.frame, msgpack.frame);
    EXPECT_EQ(compact.index, msgpack.index);
    EXPECT_EQ(compact.sender, msgpack.sender);
    ASSERT_EQ(compact.line_count, msgpack.line_count);
    for (std::size_t i = 0; i < compact.line_count; ++i) expect_same_line(compact.lines[i], msgpack.lines[i]);
  }
}

struct Sample {
  const char* file;
  std::uint64_t counter, frame, index;
  std::uint32_t sender;
  std::size_t lines, echoes;
  double first_theta_deg;  // of the first line
  double metres;
};

TEST(SegmentCapture, SingleTelegramsHoldTheirDocumentedValues) {
  const Sample samples[] = {
      {"perception_sdk_picoScan150_profile1_scan-frame_0.bin", 243829, 160, 2, 23370016, 1, 3, -78, 0.001},
      {"perception_sdk_picoScan150_profile1_scan-frame_1.bin", 243830, 160, 3, 23370016, 1, 3, -48, 0.001},
      {"perception_sdk_LRS4581_scan-frame_0.bin", 5194, 446178444, 0, 22150040, 1, 1, -180, 0.002},
      {"perception_sdk_multiScan136_scan-frame_1.bin", 31555, 65574, 0, 23210001, 16, 3, -168.906, 0.001},
      {"ScanSegmentAPICSharp_TestData.bin", 3703, 12441, 1, 23350001, 16, 3, -149.277, 0.001},
      {"sick_scan_xd_unittest_v4.bin", 14704, 1225, 10, 22190002, 16, 3, 131.355, 0.001},
      {"sick_scan_xd_multiscan_2layers.bin", 3709205, 632951, 3, 22280002, 2, 1, -88.82, 0.001}};
  for (const Sample& sample : samples) {
    LIDARD_NEED_CAPTURE(path, std::string("sick/") + sample.file);
    const auto bytes = file_bytes(path);
    Segment segment;
    EXPECT_TRUE(checksum_is_right(view_of(bytes), TelegramType::scan)) << sample.file;
    ASSERT_EQ(parse_compact_scan(view_of(bytes), segment), Reject::none) << sample.file;
    EXPECT_EQ(segment.counter, sample.counter);
    EXPECT_EQ(segment.frame, sample.frame);
    EXPECT_EQ(segment.index, sample.index);
    EXPECT_EQ(segment.sender, sample.sender);
    EXPECT_EQ(segment.line_count, sample.lines);
    EXPECT_EQ(segment.lines[0].echoes, sample.echoes);
    EXPECT_NEAR(segment.lines[0].theta_start / bench_rad, sample.first_theta_deg, 1e-3);
    EXPECT_NEAR(segment.lines[0].azimuth(0) / bench_rad, sample.first_theta_deg, 0.012);
    EXPECT_DOUBLE_EQ(segment.lines[0].metres, sample.metres);
    for (std::size_t l = 0; l < segment.line_count; ++l) {
      const SegmentLine& line = segment.lines[l];
      // No echo has no strength; echoes come by distance.
      for (std::size_t b = 0; b < line.beams; ++b) {
        double before = 0;
        for (std::size_t e = 0; e < line.echoes; ++e) {
          const double distance = line.distance[e][b];
          EXPECT_EQ(distance > 0, line.rssi[e][b] > 0) << sample.file;
          EXPECT_TRUE(distance == 0.0 || distance >= before) << sample.file;
          before = distance;
        }
      }
    }
  }
}

TEST(SegmentCapture, InertialUnitsTelegramsHoldTheirDocumentedValues) {
  LIDARD_NEED_CAPTURE(path, "sick/perception_sdk_multiScan136_imu-frame_0.bin");
  SegmentBench bench("sick_multiscan136");
  EXPECT_EQ(bench.send(file_bytes(path), bench.epoch, 7503), Reject::none);
  ASSERT_EQ(bench.imus.size(), 1U);
  const ImuSample& sample = bench.imus[0];
  EXPECT_NEAR(sample.linear_acceleration.x(), -1.29051, 1e-5);
  EXPECT_NEAR(sample.linear_acceleration.z(), 9.51006, 1e-5);
  EXPECT_NEAR(sample.angular_velocity.y(), 0.043677, 1e-6);
  ASSERT_TRUE(sample.orientation);
  EXPECT_NEAR(sample.orientation->w(), 0.95654, 2e-3);
  // The orientation takes gravity's counterforce upwards, tilted as the device is.
  EXPECT_NEAR((*sample.orientation * sample.linear_acceleration).normalized().z(), 1, 0.002);
  EXPECT_EQ(bench.driver->counters().other_packets, 1U);
  EXPECT_EQ(bench.driver->counters().packets, 0U);
}

TEST(SegmentCapture, EncoderTelegramsBecomeAState) {
  LIDARD_NEED_CAPTURE(path, "sick/perception_sdk_picoScan150_encoder-frame_0.bin");
  SegmentBench bench;
  EXPECT_EQ(bench.send(file_bytes(path), bench.epoch), Reject::none);
  ASSERT_EQ(bench.states.size(), 1U);
  EXPECT_EQ(bench.states[0].topic, "encoder");
  EXPECT_EQ(bench.states[0].values[0].value, 252'013);
  EXPECT_EQ(bench.states[0].values[1].value, 0xefe96c);
  EXPECT_EQ(bench.states[0].values[2].value, 1000);
  EXPECT_EQ(bench.states[0].stamp, bench.epoch);
}

/// 40 turns/s and 1440 beams a turn: 25 ms / 1440. Segments that lie in the view as a whole say the same:
/// 4185, 4165, 4167 and 4167 us from start to start, for 240 beams.
TEST(SegmentCapture, TheLastSegmentOfAPicoScanEndsBeyondTheViewAndShortensNoTime) {
  LIDARD_NEED_CAPTURE(path, "sick/picoscan150_compact_frag.pcap");
  for (const bool partial : {false, true}) {
    DriverConfig config;
    config.keep_partial = partial;
    const Decoded got = decode_capture(path, "sick_picoscan150", config);
    EXPECT_EQ(got.counters.packets, 96U);
    EXPECT_EQ(got.counters.rejected_total(), 0U);
    EXPECT_EQ(got.counters.lost_packets, 0U);
    const auto& scans = got.output.scans;
    ASSERT_GE(scans.size(), 18U);
    for (const PlanarScan& scan : scans) {
      EXPECT_NEAR(static_cast<double>(scan.time_increment), 25e-3 / 1440, 0.01e-6);
      EXPECT_NEAR(static_cast<double>(scan.scan_time), 0.025, 0.00001);
    }
    for (std::size_t i = partial ? 2 : 1; i + 1 < scans.size(); ++i)
      EXPECT_NEAR(seconds(scans[i].stamp - scans[i - 1].stamp), 0.025, 0.0002);
    const PlanarScan& whole = scans.at(partial ? 1 : 0);
    EXPECT_EQ(whole.beams, 1200U);
    EXPECT_NEAR(static_cast<double>(whole.angle_min) / bench_rad, -138, 1e-4);
    // The device measures nothing beyond 138 deg and sends zeros there.
    EXPECT_EQ(whole.statuses[1104], BeamStatus::hit);
    for (std::size_t b = 1105; b < whole.beams; ++b) EXPECT_EQ(whole.statuses[b], BeamStatus::invalid) << b;
  }
}

TEST(SegmentCapture, Lrs4000TelegramIsAWholeTurn) {
  SegmentBench bench("sick_lrs4000");
  for (const char* name : {"0", "1", "2"}) {
    LIDARD_NEED_CAPTURE(path, std::string("sick/perception_sdk_LRS4581_scan-frame_") + name + ".bin");
    const auto bytes = file_bytes(path);
    Packet packet;
    packet.payload = view_of(bytes);
    packet.transport = Transport::tcp;
    packet.stream_start = name[0] == '0';
    packet.arrival = bench.epoch + std::chrono::milliseconds(40 * (name[0] - '0'));
    EXPECT_EQ(bench.driver->receive(packet, bench).reject, Reject::none);
  }
  EXPECT_EQ(bench.driver->counters().packets, 3U);
  // Of the first turn the begin is not known to be whole.
  ASSERT_EQ(bench.scans.size(), 2U);
  for (const PlanarScan& scan : bench.scans) {
    EXPECT_EQ(scan.beams, 1500U);
    EXPECT_NEAR(static_cast<double>(scan.angle_min) / bench_rad, -180, 1e-4);
    EXPECT_NEAR(static_cast<double>(scan.angle_max) / bench_rad, 179.76, 1e-3);
    EXPECT_NEAR(static_cast<double>(scan.time_increment), 26.65e-6, 0.02e-6);
    EXPECT_GT(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit), 1000);
    EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::invalid), 0);
  }
  EXPECT_NEAR(static_cast<double>(bench.scans[1].scan_time), 0.04, 1e-4);
  EXPECT_FALSE(bench.has_warning("evenly"));
}

// What a daemon and a replay that began elsewhere make of the same packets.
TEST(SegmentCapture, WhereARecordingOfAPicoScanBeginsChangesNoLaterScan) {
  LIDARD_NEED_CAPTURE(path, "sick/picoscan150_compact_frag.pcap");
  std::vector<PlanarScan> whole;
  for (int left_out = 0; left_out < 12; ++left_out) {
    DriverConfig config;
    config.model = find_model("sick_picoscan150");
    const auto driver = config.model->make(config);
    Collector out;
    PcapSource capture(path);
    int n = 0;
    for (Packet packet; capture.next(packet);) {
      if (n++ >= left_out) driver->receive(packet, out);
    }
    if (left_out == 0) whole = out.scans;
    ASSERT_GE(out.scans.size(), 15U);
    ASSERT_LE(out.scans.size(), whole.size());
    const std::size_t missing = whole.size() - out.scans.size();
    for (std::size_t i = 0; i < out.scans.size(); ++i) {
      const PlanarScan &one = out.scans[i], &other = whole[missing + i];
      EXPECT_LT(std::abs(seconds(one.stamp - other.stamp)), 2e-4);
      EXPECT_EQ(one.angle_min, other.angle_min) << left_out;
      EXPECT_EQ(one.angle_increment, other.angle_increment) << left_out;
      EXPECT_EQ(one.statuses, other.statuses) << left_out << " scan " << i;
      EXPECT_EQ(one.intensities, other.intensities) << left_out;
    }
  }
}

}  // namespace
}  // namespace lidard::sick
