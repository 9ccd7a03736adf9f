// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Decoding packets to finished PointCloud2 bytes, and copying the same number of bytes with memcpy between
// buffers larger than the cache, in one program: the ratio is what counts, since machines differ.
#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

struct Recorded {
  std::vector<std::uint8_t> bytes;
  Stamp arrival;
  Endpoint from, to;
};

/// The packets of one model's port in a capture of the project.
std::vector<Recorded> packets_of(const char* capture, const Model& model) {
  std::vector<Recorded> packets;
  PcapSource source(std::string(LIDARD_SOURCE_DIR "/pcaps/") + capture);
  Packet p;
  while (source.next(p)) {
    if (p.to.port != model.port) continue;
    packets.push_back({{p.payload.begin(), p.payload.end()}, p.arrival, p.from, p.to});
  }
  return packets;
}

class CountingOutput final : public DriverOutput {
 public:
  void scan(PlanarScan& scan) override { points += scan.beams; }
  void cloud(Cloud& cloud) override { points += cloud.size(); }
  std::uint64_t points = 0;
};

void decode(benchmark::State& state, const char* name, const char* capture) {
  const Model& model = *find_model(name);
  const auto packets = packets_of(capture, model);
  if (packets.empty()) {
    state.SkipWithError("no packets of this model in the capture");
    return;
  }
  DriverConfig config;
  config.model = &model;
  config.keep_partial = true;
  const auto driver = model.make(config);
  CountingOutput output;
  const auto play = [&] {
    for (const auto& p : packets) {
      driver->receive({{p.bytes.data(), p.bytes.size()}, p.arrival, p.from, p.to}, output);
    }
    driver->finish(output);
    driver->restart();
  };
  play();
  output.points = 0;
  for (auto _ : state) play();
  state.SetItemsProcessed(static_cast<std::int64_t>(output.points));
  state.SetBytesProcessed(static_cast<std::int64_t>(output.points * sizeof(CloudPoint)));
  state.counters["ns_per_point"] = benchmark::Counter(
      static_cast<double>(output.points) * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// The yardstick: as many bytes as a revolution of 28 800 points, from and to 64 MiB.
void copy_points(benchmark::State& state) {
  constexpr std::size_t points = 28'800;
  constexpr std::size_t frame = points * sizeof(CloudPoint);
  constexpr std::size_t frames = (64U << 20U) / frame;
  const std::vector<std::uint8_t> from(frames * frame, 1);
  std::vector<std::uint8_t> to(frames * frame);
  std::size_t at = 0;
  for (auto _ : state) {
    std::memcpy(to.data() + at * frame, from.data() + at * frame, frame);
    benchmark::ClobberMemory();
    at = (at + 1) % frames;
  }
  const auto copied = static_cast<double>(state.iterations()) * static_cast<double>(points);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(frame));
  state.counters["ns_per_point"] =
      benchmark::Counter(copied * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(copy_points)->Name("memcpy");
BENCHMARK_CAPTURE(decode, vlp16, "velodyne_vlp16", "demo.pcap");
BENCHMARK_CAPTURE(decode, vlp16_dual, "velodyne_vlp16", "vlp16_dual.pcap");
BENCHMARK_CAPTURE(decode, microscan3, "sick_microscan3", "demo.pcap");

}  // namespace
}  // namespace lidard

BENCHMARK_MAIN();
