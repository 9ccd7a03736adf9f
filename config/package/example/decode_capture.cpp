// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Prints the scans and clouds of one lidar in a capture: decode_capture velodyne_vlp16 drive.pcap
#include <lidard/drivers/capture/pcap_source.h>
#include <lidard/drivers/registry/registry.h>

#include <cstdio>
#include <exception>

struct Print final : lidard::FrameReceiver {
  void scan(lidard::PlanarScan& scan) override {
    std::printf("%.9f scan, %zu beams\n", lidard::seconds(scan.stamp - lidard::Stamp{}), scan.beams);
  }
  void cloud(lidard::Cloud& cloud) override {
    std::printf("%.9f cloud, %zu points\n", lidard::seconds(cloud.stamp - lidard::Stamp{}), cloud.size());
  }
};

int main(int argc, char** argv) try {
  lidard::DriverConfig config;
  config.model = argc == 3 ? lidard::find_model(argv[1]) : nullptr;  // names: lidard models
  if (config.model == nullptr) return std::fprintf(stderr, "usage: decode_capture MODEL CAPTURE\n"), 2;
  const auto driver = config.model->make(config);
  lidard::PcapSource source(argv[2]);
  Print out;
  for (lidard::Packet packet; source.next(packet);) driver->receive(packet, out);
  driver->finish(out);
  std::printf("%llu packets\n", static_cast<unsigned long long>(driver->counters().packets));
} catch (const std::exception& why) {
  return std::fprintf(stderr, "%s\n", why.what()), 1;
}
