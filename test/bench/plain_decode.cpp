// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// plain_decode MODEL CAPTURE: prints points, seconds of processor time and the peak of memory (MB) of
// decoding alone, for python_speed.py.
#include <sys/resource.h>

#include <cstdio>
#include <ctime>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/registry.h"

struct Count final : lidard::FrameReceiver {
  void scan(lidard::PlanarScan& scan) override { points += scan.beams; }
  void cloud(lidard::Cloud& cloud) override { points += cloud.size(); }
  std::size_t points = 0;
};

int main(int argc, char** argv) {
  lidard::DriverConfig config;
  config.model = argc == 3 ? lidard::find_model(argv[1]) : nullptr;
  if (config.model == nullptr) return 2;
  config.keep_partial = true;
  const std::clock_t begin = std::clock();
  const auto driver = config.model->make(config);
  lidard::PcapSource source(argv[2]);
  Count out;
  for (lidard::Packet packet; source.next(packet);) driver->receive(packet, out);
  driver->finish(out);
  const double took = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  std::printf("%zu %f %f\n", out.points, took, static_cast<double>(used.ru_maxrss) / 1000);
}
