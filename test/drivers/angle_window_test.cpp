// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// angle_min and angle_max of every planar model: the scans without them are the truth.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

struct Window {
  std::optional<double> first, last;
};

/// Walls ahead, beside and behind, and gaps between them.
constexpr const char* objects =
    "objects:\n  - wall: {from: [6, -2], to: [6, 4], z: [-1, 2]}\n"
    "  - wall: {from: [3, 4], to: [-5, 4], z: [-1, 2]}\n"
    "  - wall: {from: [-5, 3], to: [-5, -3], z: [-1, 2]}\n"
    "  - wall: {from: [-4, -3], to: [5, -5], z: [-1, 2]}\n";

struct Sent {
  sim::SimPacket packet;
  std::vector<std::uint8_t> bytes;
};

/// As many echoes and intensities as the device can send.
std::string options_of(const Model& model) {
  if (model.protocol == "CoLa A/B") return "echoes: 2, rssi: true";
  return model.vendor == "SICK" && model.port == 2115 ? "echoes: 3" : "";
}

/// What a device sends.
std::vector<Sent> packets_of(const Model& model) {
  const std::string port = std::to_string(model.port);
  const bool tcp = model.transport == Transport::tcp;
  const sim::Scene scene = sim::parse_scene(
      "start: 2026-01-01T00:17:23.5Z\nduration: 0.7\nsensors:\n  it: {model: " + std::string(model.name) +
          ", divergence_mrad: 5, options: {" + options_of(model) + "}, from: '10.0.0.1:" + port +
          "', to: '10.0.0.2:" + (tcp ? "40124" : port) + "'}\n" + objects,
      "scene");
  std::vector<Sent> packets;
  sim::simulate(scene, [&](const sim::SimPacket& sent) {
    if (!sent.to_device) packets.push_back({sent, {sent.payload.begin(), sent.payload.end()}});
    return true;
  });
  return packets;
}

std::vector<PlanarScan> scans_of(const Model& model, const std::vector<Sent>& packets, const Window& window) {
  DriverConfig config;
  config.model = &model;
  config.angle_min = window.first, config.angle_max = window.last;
  config.publish_multiecho = true;
  const auto driver = model.make(config);
  test::Collector out;
  for (const Sent& sent : packets) {
    Packet packet;
    packet.payload = {sent.bytes.data(), sent.bytes.size()};
    packet.arrival = sent.packet.time;
    packet.from = sent.packet.from;
    packet.to = sent.packet.to;
    packet.transport = model.transport;
    packet.stream_start = &sent == &packets.front();
    driver->receive(packet, out);
  }
  driver->finish(out);
  return std::move(out.scans);
}

/// A beam is inside if (b - first) mod 2 pi <= last - first; a limit alone leaves out what lies beyond it.
bool is_inside(double angle, const Window& window) {
  if (!window.first) return angle <= window.last.value_or(angle);
  if (!window.last) return angle >= *window.first;
  const double first = window.first.value_or(-pi_d), last = window.last.value_or(pi_d);
  if (last - first >= two_pi - 1e-9) return true;
  const auto turned = [](double a) { return std::fmod(std::fmod(a, two_pi) + two_pi, two_pi); };
  return turned(angle - first) <= turned(last - first);
}
bool is_on_limit(double angle, const Window& window, double step) {
  const auto near = [&](double limit) {
    return std::abs(std::remainder(angle - limit, two_pi)) < 0.05 * std::abs(step);
  };
  return (window.first && near(*window.first)) || (window.last && near(*window.last));
}

Stamp time_of(const PlanarScan& scan, std::size_t beam) {
  return scan.stamp + span_from_seconds(static_cast<double>(scan.time_increment) * static_cast<double>(beam));
}

/// Compares a scan with the part of the whole one that is inside. Returns the number of beams inside.
std::size_t compare(const PlanarScan& all, const PlanarScan& part, const Window& window) {
  const auto step = static_cast<double>(all.angle_increment);
  std::size_t inside = 0, observed = 0;
  EXPECT_EQ(part.echoes, all.echoes);
  for (std::size_t beam = 0; beam < part.beams; ++beam)
    observed += part.statuses[beam] == BeamStatus::invalid ? 0U : 1U;
  for (std::size_t beam = 0; beam < all.beams; ++beam) {
    const auto angle = static_cast<double>(all.angle(beam));
    const long at = std::lround((angle - static_cast<double>(part.angle_min)) / step);
    const bool is_there = at >= 0 && at < static_cast<long>(part.beams);
    if (is_on_limit(angle, window, step)) {
      if (is_there && part.statuses[static_cast<std::size_t>(at)] != BeamStatus::invalid) --observed;
      continue;
    }
    if (!is_inside(angle, window)) {
      if (is_there) {
        EXPECT_EQ(part.statuses[static_cast<std::size_t>(at)], BeamStatus::invalid) << angle;
      }
      continue;
    }
    ++inside;
    EXPECT_TRUE(is_there) << angle;
    if (!is_there) continue;
    const auto here = static_cast<std::size_t>(at);
    EXPECT_NEAR(static_cast<double>(part.angle(here)), angle, 1e-4);
    for (std::size_t echo = 0; echo < all.echoes; ++echo) {
      const std::size_t is = part.index(here, echo), should = all.index(beam, echo);
      EXPECT_EQ(part.statuses[is], all.statuses[should]) << angle;
      if (all.statuses[should] != BeamStatus::hit) continue;
      EXPECT_EQ(part.ranges[is], all.ranges[should]) << angle;
      if (all.intensities.empty()) continue;
      EXPECT_EQ(part.intensities[is], all.intensities[should]) << angle;
    }
    EXPECT_NEAR(seconds(time_of(part, here) - time_of(all, beam)), 0, 5e-5) << angle;
    observed -= part.statuses[here] == BeamStatus::invalid ? 0U : 1U;
  }
  EXPECT_EQ(observed, 0U);
  return inside;
}

TEST(AngleWindow, IsASectorOfTheCircleForEveryPlanarModel) {
  const std::vector<Window> windows = {
      {0.0, two_pi}, {0.0, 4.71},   {2.5, 3.78}, {2.5, -2.5}, {pi_d / 2, 3 * pi_d / 2},
      {-4.0, -2.0},  {-6.28, 6.28}, {-0.5, 0.7}, {6.0, 6.6},  {1.0, {}},
      {{}, -1.0},    {{}, {}}};
  std::size_t tried = 0;
  for (const Model& model : models()) {
    // The simulator has no 9 m type, no unnamed Hokuyo and no LRS4000.
    const bool is_simulated =
        model.name != "sick_microscan3_9m" && model.name != "hokuyo_scip" && model.name != "sick_lrs4000";
    if (model.kind != FrameKind::scan || !is_simulated) continue;
    SCOPED_TRACE(std::string(model.name));
    const std::vector<Sent> packets = packets_of(model);
    const std::vector<PlanarScan> whole = scans_of(model, packets, {});
    ASSERT_GE(whole.size(), 2U);
    for (const Window& window : windows) {
      SCOPED_TRACE(::testing::Message() << window.first.value_or(-99) << " to " << window.last.value_or(99));
      const std::vector<PlanarScan> part = scans_of(model, packets, window);
      if (part.empty()) {
        for (std::size_t beam = 0; beam < whole[0].beams; ++beam) {
          const auto angle = static_cast<double>(whole[0].angle(beam));
          EXPECT_FALSE(is_inside(angle, window)) << angle;
        }
        continue;
      }
      ASSERT_EQ(part.size(), whole.size());
      EXPECT_GT(compare(whole.back(), part.back(), window), 0U);
      ++tried;
    }
  }
  EXPECT_GE(tried, 150U);
}

}  // namespace
}  // namespace lidard
