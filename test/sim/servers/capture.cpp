// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/capture.h"

#include <cstdio>
#include <fstream>
#include <set>
#include <stdexcept>

#include "drivers/capture/pcap_writer.h"
#include "test/sim/servers/simulate.h"
#include "test/sim/servers/truth.h"

namespace lidard::sim {
namespace {

void write_file(const std::string& path, const char* data, std::size_t size) {
  std::ofstream file(path, std::ios::binary);
  file.write(data, static_cast<std::streamsize>(size));
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written; name a folder that exists and has room");
}

/// For `--motion` of lidard.
void write_odometry(const Scene& scene, const std::string& path) {
  std::string text = "stamp,x,y,yaw\n";
  for (const auto& [stamp, place] : odometry_of(scene)) {
    char line[128];
    std::snprintf(line, sizeof line, "%lld.%09lld,%.6f,%.6f,%.8f\n",
                  static_cast<long long>(stamp.ns / 1'000'000'000),
                  static_cast<long long>(stamp.ns % 1'000'000'000), place.x, place.y, place.yaw);
    text += line;
  }
  write_file(path, text.data(), text.size());
}

}  // namespace

CaptureSummary make_capture(const Scene& scene, const std::string& prefix, bool with_truth) {
  PcapWriter pcap(prefix + ".pcap");
  TruthWriter truth(scene);
  CaptureSummary summary;
  std::set<std::size_t> opened;
  simulate(scene, [&](const SimPacket& packet) {
    if (packet.tcp) {
      // A capture that begins with a request begins with the connection.
      if (packet.to_device && opened.insert(packet.sensor).second)
        pcap.open_tcp(packet.time - Span(300'000), packet.from, packet.to);
      constexpr Span per_byte(80);  // of a 100 Mbit/s line
      pcap.write_tcp(packet.time, packet.from, packet.to, packet.payload, per_byte);
    } else {
      pcap.write(packet.time, packet.from, packet.to, packet.payload);
    }
    if (packet.measurement != nullptr) {
      truth.add(*packet.measurement, static_cast<std::uint32_t>(pcap.records()) - 1);
      ++summary.measurements;
    }
    ++summary.packets;
    return true;
  });
  pcap.close();
  if (scene.odometry) write_odometry(scene, prefix + ".odometry.csv");
  if (with_truth) {
    const auto bytes = truth.bytes();
    write_file(prefix + ".truth", reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return summary;
}

}  // namespace lidard::sim
