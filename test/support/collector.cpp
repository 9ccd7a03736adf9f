// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/collector.h"

#include <gtest/gtest.h>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard::test {
bool is_for(const Model& model, const Packet& packet) {
  if (packet.transport != model.transport) return false;
  if (packet.transport == Transport::tcp) return packet.from.port == model.port;
  return packet.to.port == model.port || packet.to.port == model.telemetry_port;
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
