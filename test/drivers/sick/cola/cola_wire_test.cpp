// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The same connection, cut, shuffled, doubled and fragmented by the network in many ways: the same scans.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/drivers/capture/pcap_testing.h"
#include "test/sim/world/rng.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

/// What the device of this port sent in a capture.
Bytes stream_of(const std::string& path, std::uint16_t port) {
  Bytes bytes;
  PcapSource source(path);
  for (Packet packet; source.next(packet);) {
    if (packet.transport == Transport::tcp && packet.from.port == port)
      bytes.insert(bytes.end(), packet.payload.begin(), packet.payload.end());
  }
  return bytes;
}

/// The capture of a connection that this network made of the stream.
class Network {
 public:
  Network(Bytes stream, std::uint64_t seed) : stream_(std::move(stream)), random_(seed) {}

  Bytes carry() {
    cut();
    // A segment may come up to three places later than it left, or twice.
    for (std::size_t i = 0; i + 1 < segments_.size(); ++i) {
      if (one_in(4))
        std::swap(segments_[i], segments_[std::min(i + 1 + random_.bits() % 3, segments_.size() - 1)]);
      if (one_in(5)) segments_.push_back(segments_[i]);
    }
    PcapBytes out;
    out.add(ethernet(ipv4(tcp({}, first_ - 1, 2112, 40000, tcp_syn), of_tcp())), 1);
    double time = 1.001;
    for (const auto& [begin, end] : segments_) {
      const Bytes payload(stream_.begin() + static_cast<std::ptrdiff_t>(begin),
                          stream_.begin() + static_cast<std::ptrdiff_t>(end));
      put(tcp(payload, first_ + static_cast<std::uint32_t>(begin)), time, out);
      time += 0.0005;
    }
    return out.bytes;
  }

 private:
  bool one_in(std::uint64_t n) { return random_.bits() % n == 0; }
  /// Segments of all sizes, some of which repeat the end of the one before.
  void cut() {
    for (std::size_t at = 0; at < stream_.size();) {
      const std::size_t size = 1 + random_.bits() % (one_in(3) ? 60 : 1448);
      const std::size_t again = one_in(6) ? std::min<std::size_t>(at, random_.bits() % 100) : 0;
      const std::size_t end = std::min(stream_.size(), at + size);
      segments_.emplace_back(at - again, end);
      at = end;
    }
  }
  /// Some packets are fragmented, the second half first.
  void put(const Bytes& segment, double time, PcapBytes& out) {
    if (segment.size() < 100 || !one_in(8)) {
      out.add(ethernet(ipv4(segment, of_tcp())), time);
      return;
    }
    V4 first = of_tcp(), second = of_tcp();
    first.id = second.id = ++id_;
    first.more = true;
    second.offset = segment.size() / 2 / 8 * 8;
    const auto middle = segment.begin() + static_cast<std::ptrdiff_t>(second.offset);
    out.add(ethernet(ipv4({middle, segment.end()}, second)), time);
    out.add(ethernet(ipv4({segment.begin(), middle}, first)), time);
  }

  Bytes stream_;
  sim::Rng random_;
  std::uint32_t first_ = 0xffffe000;  // the sequence wraps on the way
  std::uint16_t id_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> segments_;
};

/// Everything but the stamps, which follow the arrivals; -1 for what is no number.
std::vector<std::vector<float>> values_of(const Collector& got) {
  std::vector<std::vector<float>> values;
  for (const PlanarScan& scan : got.scans) {
    values.push_back(scan.ranges);
    for (float& range : values.back()) range = std::isnan(range) ? -1 : range;
  }
  for (const Cloud& cloud : got.clouds) {
    values.emplace_back();
    for (std::size_t i = 0; i < cloud.size(); ++i) values.back().push_back(cloud.points()[i].x);
  }
  return values;
}

void expect_same_scans(const std::string& path, const char* model, std::size_t most_bytes, int trials) {
  const std::uint16_t port = find_model(model)->port;
  Bytes stream = stream_of(path, port);
  stream.resize(std::min(stream.size(), most_bytes));
  const auto whole = values_of(decode_capture(path, model).output);
  for (int seed = 0; seed < trials; ++seed) {
    const MemoryFile file(Network(stream, static_cast<std::uint64_t>(seed)).carry());
    const Decoded got = decode_capture(file.path(), model);
    const auto values = values_of(got.output);
    ASSERT_GE(values.size(), 3U);
    ASSERT_LE(values.size(), whole.size());
    EXPECT_TRUE(std::equal(values.begin(), values.end(), whole.begin())) << model << ", seed " << seed;
    if (stream.size() < most_bytes) {
      EXPECT_EQ(values.size(), whole.size());
    }
    EXPECT_EQ(got.counters.rejected_total(), 0U);
    EXPECT_EQ(got.counters.lost_packets, 0U);
  }
}

TEST(ColaWire, WhateverTheNetworkDoesTheScansAreTheSame) {
  expect_same_scans(project_file("pcaps/sick_lms111.pcap"), "sick_lms1xx", 1'000'000, 20);
  expect_same_scans(project_file("pcaps/sick_tim571_text.pcap"), "sick_tim5xx", 1'000'000, 20);
  expect_same_scans(project_file("pcaps/sick_mrs1104.pcap"), "sick_mrs1000", 1'000'000, 20);
}

TEST(ColaWire, SoItIsWithRecordedConnections) {
  LIDARD_NEED_CAPTURE(lms, "sick/lms511_colab_20210301.pcap");
  expect_same_scans(lms, "sick_lms5xx", 60000, 10);
  LIDARD_NEED_CAPTURE(tim, "sick/tim781s_colab_20210125.pcap");
  expect_same_scans(tim, "sick_tim7xxs", 60000, 10);
}

}  // namespace
}  // namespace lidard::test
