// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/collector.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard::test {
bool is_for(const Model& model, const Packet& packet) {
  if (packet.transport != model.transport) return false;
  if (packet.transport == Transport::tcp) return packet.from.port == model.port;
  return packet.to.port == model.port || packet.to.port == model.telemetry_port;
}

void Collector::scan(PlanarScan& scan) {
  EXPECT_EQ(violation(scan), nullptr) << violation(scan);
  scans.push_back(scan);
}

void Collector::message(const DeviceMessage& message) {
  if (const auto* state = std::get_if<DeviceState>(&message)) states.push_back(*state);
  if (const auto* imu = std::get_if<ImuSample>(&message)) imus.push_back(*imu);
}

void Collector::extra_scan(std::string_view topic, PlanarScan& scan) {
  EXPECT_EQ(violation(scan), nullptr) << violation(scan);
  extra_scans[std::string(topic)].push_back(scan);
}

std::string detail_of(const DeviceInfo& info, const std::string& key) {
  for (const auto& [name, value] : info.details) {
    if (name == key) return value;
  }
  return "(missing)";
}

DriverBench::DriverBench(const std::string& name, DriverConfig config) : model(find_model(name)) {
  config.model = model;
  config.frame_id = "laser";
  driver = model->make(config);
}

void DriverBench::scan(PlanarScan& scan) {
  EXPECT_EQ(model->kind, FrameKind::scan);
  Collector::scan(scan);
}

void DriverBench::cloud(Cloud& cloud) {
  EXPECT_EQ(model->kind, FrameKind::cloud);
  Collector::cloud(cloud);
}

Verdict DriverBench::feed(ByteView bytes, bool stream_start, std::uint64_t missing) {
  Packet packet;
  packet.payload = bytes;
  packet.arrival = now;
  packet.transport = Transport::tcp;
  packet.stream_start = stream_start;
  packet.missing = missing;
  return driver->receive(packet, *this);
}

void DriverBench::feed_in_pieces(std::string_view bytes, std::size_t piece, const bool& open) {
  for (std::size_t at = 0; open && at < bytes.size(); at += piece) feed(ByteView(bytes.substr(at, piece)));
}

bool DriverBench::has_warning(const std::string& part) const {
  const auto& all = driver->info().warnings;
  return std::any_of(all.begin(), all.end(),
                     [&](const std::string& each) { return each.find(part) != std::string::npos; });
}

void Collector::cloud(Cloud& cloud) {
  for (std::size_t i = 0; i < cloud.origins.size(); ++i) {
    const ReturnOrigin& o = cloud.origins[i];
    const CloudColumn& c = cloud.columns.at(o.column);
    const CloudPoint p = cloud.points()[i];
    rows.push_back({clouds.size(), c.packet, o.block, o.laser, p.ring, c.echo, o.offset_ns, o.stamp.ns,
                    o.azimuth_deg, o.distance_m, p.x, p.y, p.z, p.intensity, p.time});
  }
  clouds.push_back(cloud);
}

Decoded decode_capture(const std::string& path, const std::string& model, DriverConfig config) {
  Decoded decoded;
  config.model = find_model(model);
  if (config.model == nullptr) {
    ADD_FAILURE() << "no model " << model;
    return decoded;
  }
  try {
    PcapSource source(path);
    const auto driver = config.model->make(config);
    Packet packet;
    while (source.next(packet)) {
      if (is_for(*config.model, packet)) driver->receive(packet, decoded.output);
    }
    driver->finish(decoded.output);
    decoded.counters = driver->counters();
    decoded.info = driver->info();
    decoded.capture_error = source.error();
  } catch (const CaptureError& e) {
    ADD_FAILURE() << e.what();
  }
  return decoded;
}

}  // namespace lidard::test
