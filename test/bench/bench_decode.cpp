// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Decoding packets to finished PointCloud2 bytes, and copying the same number of bytes with memcpy between
// buffers larger than the cache, in one program: the ratio is what counts, since machines differ. With
// LIDARD_CAPTURES real captures are decoded too.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

struct Recorded {
  std::vector<std::uint8_t> bytes;
  Stamp arrival;
  Endpoint from, to;
};

/// The packets of one model's port in a capture.
std::vector<Recorded> packets_of(const std::string& capture, const Model& model) {
  std::vector<Recorded> packets;
  PcapSource source(capture);
  Packet p;
  while (source.next(p)) {
    if (p.to.port != model.port) continue;
    packets.push_back({{p.payload.begin(), p.payload.end()}, p.arrival, p.from, p.to});
  }
  return packets;
}

void decode(benchmark::State& state, const std::string& name, const std::string& capture) {
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
  test::Counted output;
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
  state.counters["ns_per_packet"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(packets.size()) * 1e-9,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
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

struct Case {
  const char *name, *model, *file;
};
constexpr Case shipped[] = {{"vlp16", "velodyne_vlp16", "demo.pcap"},
                            {"vlp16_dual", "velodyne_vlp16", "vlp16_dual.pcap"},
                            {"microscan3", "sick_microscan3", "demo.pcap"}};
constexpr Case real[] = {{"real/vlp16_strongest", "velodyne_vlp16", "vlp16_strongest_1000.pcap"},
                         {"real/vlp16_last", "velodyne_vlp16", "vlp16_last_1500.pcap"},
                         {"real/vlp16_dual", "velodyne_vlp16", "vlp16_dual_1500.pcap"},
                         {"real/vlp32c", "velodyne_vlp32c", "vlp32c_fov_379.pcap"},
                         {"real/hdl32e", "velodyne_hdl32e", "hdl32e_gprmc_876.pcap"},
                         {"real/vls128", "velodyne_vls128", "vls128_strongest_2193.pcap"}};

void add(const Case& one, const std::string& folder) {
  benchmark::RegisterBenchmark(one.name, [&one, path = folder + one.file](benchmark::State& state) {
    decode(state, one.model, path);
  });
}

}  // namespace
}  // namespace lidard

int main(int argc, char** argv) {
  benchmark::RegisterBenchmark("memcpy", lidard::copy_points);
  for (const auto& one : lidard::shipped) lidard::add(one, LIDARD_SOURCE_DIR "/pcaps/");
  if (const char* folder = std::getenv("LIDARD_CAPTURES")) {
    for (const auto& one : lidard::real) lidard::add(one, std::string(folder) + "/velodyne/");
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
