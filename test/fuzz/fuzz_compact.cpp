// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Telegrams of picoScan100, multiScan100 and LRS4000, Compact and MSGPACK: the input is parsed as one
// telegram of each format; then it is cut into pieces, each behind a length (16 bit), whose checksums are
// made right, and given to drivers of one and of several layers as datagrams; at last all of it as a stream.
// A scan that breaks an invariant is a finding.
#include <cstdlib>
#include <vector>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/compact/compact_telegram.h"
#include "test/sim/devices/checksums.h"
#include "test/sim/servers/output_check.h"

namespace {

using namespace lidard;

void play(const char* model, ByteView input, bool as_stream) {
  DriverConfig config;
  config.model = find_model(model);
  config.publish_multiecho = true;
  const auto driver = config.model->make(config);
  sim::OutputCheck out;
  Packet packet;
  packet.transport = as_stream ? Transport::tcp : Transport::udp;
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  std::size_t at = 0;
  while (input.has(at, 2)) {
    const std::size_t length = input.le16(at);
    at += 2;
    const ByteView piece = input.sub(at, length < input.size() - at ? length : input.size() - at);
    at += piece.size();
    std::vector<std::uint8_t> telegram(piece.begin(), piece.end());
    sim::make_checksums_right(telegram);
    packet.payload = {telegram.data(), telegram.size()};
    packet.arrival = packet.arrival + std::chrono::milliseconds(5);
    static_cast<void>(driver->receive(packet, out));
    driver->tick(packet.arrival, out);
  }
  driver->finish(out);
  if (out.violation() != nullptr) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const ByteView input(data, size);
  static sick::Segment segment;
  static_cast<void>(sick::parse_compact_scan(input, segment));
  static_cast<void>(sick::parse_msgpack(input, segment));
  static_cast<void>(sick::parse_msgpack_payload(input, segment));
  play("sick_picoscan150", input, false);
  play("sick_multiscan136", input, false);
  play("sick_lrs4000", input, true);
  return 0;
}
