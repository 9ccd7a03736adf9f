// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

using velodyne::DataPacket;

constexpr const char* capture_name = "velodyne/vlp32c_fov_379.pcap";
constexpr double block_us = 55.296;
/// The packets of the recording that hold blocks from before and after the silence.
constexpr std::size_t straddling[] = {75, 151, 227, 302, 378};

struct Recording {
  std::vector<std::vector<std::uint8_t>> payloads;
  test::Decoded decoded;

  explicit Recording(const std::string& path, DriverConfig config = {}) {
    PcapSource source(path);
    Packet packet;
    while (source.next(packet)) {
      if (packet.payload.size() == velodyne::packet_size)
        payloads.emplace_back(packet.payload.begin(), packet.payload.end());
    }
    config.clock = ClockMode::arrival;
    config.keep_partial = config.keep_origins = true;
    decoded = test::decode_capture(path, "velodyne_vlp32c", config);
  }
  DataPacket packet(std::size_t i) const { return DataPacket({payloads[i].data(), payloads[i].size()}); }
};

int step_of(const DataPacket& packet, std::size_t block) {
  return (packet.azimuth(block) - packet.azimuth(block - 1) + 36000) % 36000;
}

/// The first block after the silence; 0: none.
std::size_t block_after_silence(const DataPacket& packet) {
  for (std::size_t b = 1; b < 12; ++b) {
    if (step_of(packet, b) > 1000) return b;
  }
  return 0;
}

/// 1/100 deg from block to block, the mean of those that are no silence.
double mean_step(const DataPacket& packet) {
  const std::size_t silence = block_after_silence(packet);
  double sum = 0;
  for (std::size_t b = 1; b < 12; ++b) sum += b == silence ? 0 : step_of(packet, b);
  return sum / (silence == 0 ? 11 : 10);
}

/// When each block began after the packet's stamp, us: those after the silence by counting back from the next
/// packet's stamp; of the last packet, by the rotation from the begin of the silence before to that of this
/// one.
std::array<double, 12> block_times(const Recording& recording, std::size_t i) {
  const DataPacket packet = recording.packet(i);
  const std::size_t silence = block_after_silence(packet);
  double late = 0;
  if (i + 1 < recording.payloads.size()) {
    late = recording.packet(i + 1).stamp_us() - packet.stamp_us() - 12 * block_us;
  } else {
    const DataPacket before = recording.packet(302);
    const std::size_t edge = block_after_silence(before);
    const double elapsed = packet.stamp_us() - before.stamp_us() +
                           block_us * (static_cast<double>(silence) - static_cast<double>(edge));
    const double turned = 36000.0 + packet.azimuth(silence - 1) - before.azimuth(edge - 1);
    late = step_of(packet, silence) / (turned / elapsed) - block_us;
  }
  std::array<double, 12> times{};
  for (std::size_t b = 0; b < 12; ++b)
    times[b] = block_us * static_cast<double>(b) + (b < silence ? 0 : late);
  return times;
}

TEST(VelodyneGap, PointsAcrossTheSilenceAreWhereAndWhenCountingBackPutsThem) {
  LIDARD_NEED_CAPTURE(path, capture_name);
  const Recording recording(path);
  const auto& row = *static_cast<const velodyne::ModelRow*>(find_model("velodyne_vlp32c")->row);
  std::map<std::size_t, std::array<double, 12>> times;
  for (const std::size_t i : straddling) {
    ASSERT_GT(block_after_silence(recording.packet(i)), 0U) << i;
    times[i] = block_times(recording, i);
    const std::size_t silence = block_after_silence(recording.packet(i));
    EXPECT_NEAR(times[i][silence] - times[i][silence - 1], 49767, 10) << i;
  }
  std::size_t straddlers = 0;
  for (std::size_t i = 0; i < recording.payloads.size(); ++i)
    straddlers += block_after_silence(recording.packet(i)) > 0 ? 1U : 0U;
  EXPECT_EQ(straddlers, std::size(straddling));
  double worst_us = 0;
  double worst_deg = 0;
  std::size_t compared = 0;
  for (const test::Row& r : recording.decoded.output.rows) {
    const auto found = times.find(r.packet);
    if (found == times.end()) continue;
    ++compared;
    const DataPacket packet = recording.packet(r.packet);
    const auto block = static_cast<std::size_t>(r.block);
    const double in_block_us = 2.304 * (r.laser / 2);  // pairs fire together
    const double time_off = static_cast<double>(r.offset_ns) * 1e-3 - found->second[block] - in_block_us;
    worst_us = std::max(worst_us, std::fabs(time_off));
    const double azimuth = 0.01 * (packet.azimuth(block) + mean_step(packet) / block_us * in_block_us) -
                           row.laser[static_cast<std::size_t>(r.laser)].rot_correction_deg;
    worst_deg = std::max(worst_deg, std::fabs(std::remainder(r.azimuth_deg - azimuth, 360)));
  }
  std::printf("%zu points across the silence: off by at most %.1f us and %.4f deg\n", compared, worst_us,
              worst_deg);
  EXPECT_GT(compared, 1000U);
  EXPECT_LE(worst_us, 20);
  EXPECT_LE(worst_deg, 0.01);
  EXPECT_EQ(recording.decoded.counters.lost_packets, 0U);
}

TEST(VelodyneGap, NoPointOfOneRevolutionIsInAnother) {
  LIDARD_NEED_CAPTURE(path, capture_name);
  DriverConfig config;
  config.cut_angle = M_PI;  // hidden
  const Recording recording(path, config);
  const auto& frames = recording.decoded.output.clouds;
  ASSERT_EQ(frames.size(), 6U);
  for (const Cloud& frame : frames) {
    double last = -1;
    for (const CloudColumn& column : frame.columns) {
      const double since_cut = std::fmod(column.azimuth * 180 / M_PI - 180 + 360, 360);
      ASSERT_GT(since_cut, last);
      last = since_cut;
    }
    EXPECT_LE(frame.columns.size(), 910U);
    EXPECT_LT(seconds(frame.end - frame.stamp), 0.0505);
  }
  EXPECT_EQ(recording.decoded.counters.lost_packets, 0U);
  EXPECT_EQ(recording.decoded.counters.rejected_total(), 0U);
}

}  // namespace
}  // namespace lidard
