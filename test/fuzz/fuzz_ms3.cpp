// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Datagrams of safety scanners: the input is cut into datagrams, each behind a length (16 bit), and given to
// one driver; then the whole input is parsed as one telegram. A scan that breaks an invariant is a finding.
#include <cstdlib>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/safety/ms3_telegram.h"
#include "test/sim/servers/output_check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  const ByteView input(data, size);
  sick::Ms3Telegram telegram;
  static_cast<void>(sick::parse_ms3_telegram(input, telegram));
  static const Model* const model = find_model("sick_microscan3");
  DriverConfig config;
  config.model = model;
  const auto driver = model->make(config);
  sim::OutputCheck out;
  Packet packet;
  packet.from = {IpAddress::v4(192, 168, 0, 21), 50000};
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  std::size_t at = 0;
  while (input.has(at, 2)) {
    const std::size_t length = input.le16(at);
    at += 2;
    packet.payload = input.sub(at, length < size - at ? length : size - at);
    at += packet.payload.size();
    packet.arrival = packet.arrival + std::chrono::milliseconds(10);
    static_cast<void>(driver->receive(packet, out));
  }
  driver->finish(out);
  if (out.violation() != nullptr) std::abort();
  return 0;
}
