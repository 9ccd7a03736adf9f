// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/capture.h"

#include <boost/crc.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

#include "drivers/capture/pcap_writer.h"
#include "test/sim/servers/simulate.h"
#include "test/sim/servers/truth.h"

namespace lidard::sim {
namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be opened; name an existing file");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_file(const std::string& path, const char* data, std::size_t size) {
  std::ofstream file(path, std::ios::binary);
  file.write(data, static_cast<std::streamsize>(size));
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written; name a folder that exists and has room");
}

std::string digest_line(const std::string& path) {
  char crc[16];
  std::snprintf(crc, sizeof crc, "%08x", file_crc32(path));
  return std::filesystem::path(path).filename().string() + " crc32 " + crc + " bytes " +
         std::to_string(std::filesystem::file_size(path)) + "\n";
}

void write_digest(const std::string& prefix, bool with_truth) {
  std::string text;
  std::string others;
  text += digest_line(prefix + ".pcap");
  if (with_truth) text += digest_line(prefix + ".truth");
  std::ifstream old(prefix + ".digest");
  const std::string stem = std::filesystem::path(prefix).filename().string();
  for (std::string line; std::getline(old, line);) {
    const std::string subject = line.substr(0, line.find(' '));
    if (subject != stem + ".pcap" && subject != stem + ".truth") others += line + "\n";
  }
  old.close();
  text += others;
  write_file(prefix + ".digest", text.data(), text.size());
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

std::uint32_t file_crc32(const std::string& path) {
  const std::string content = read_file(path);
  boost::crc_32_type crc;
  crc.process_bytes(content.data(), content.size());
  return crc.checksum();
}

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
  write_digest(prefix, with_truth);
  return summary;
}

}  // namespace lidard::sim
