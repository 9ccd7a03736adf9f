// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Streams of scanners that speak CoLa: the first byte chooses the model, the rest is cut into chunks, each
// behind a length (8 bit; 0: a hole), and given to one driver; then the whole input is parsed as one telegram
// of each kind and dialect. A scan that breaks an invariant is a finding.
#include <cstdlib>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_scan.h"
#include "test/sim/servers/output_check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  if (size < 1) return 0;
  const ByteView input(data, size);
  static sick::ColaScan scan;
  sick::ColaFields fields;
  sick::ColaPins pins;
  for (const auto dialect : {sick::ColaDialect::a, sick::ColaDialect::b}) {
    const sick::ColaTelegram telegram{dialect, input};
    static_cast<void>(sick::parse_cola_scan(telegram, scan));
    static_cast<void>(sick::parse_cola_fields(telegram, fields));
    static_cast<void>(sick::parse_cola_outputs(telegram, pins));
    static_cast<void>(sick::parse_cola_inputs(telegram, pins));
  }
  static const Model* const models[] = {find_model("sick_lms1xx"), find_model("sick_mrs1000")};
  DriverConfig config;
  config.model = models[data[0] % 2];
  config.publish_multiecho = (data[0] & 2U) != 0;
  config.keep_origins = (data[0] & 4U) != 0;
  const auto driver = config.model->make(config);
  const auto recognizer = sick::make_cola_recognizer();
  sim::OutputCheck out;
  Packet packet;
  packet.transport = Transport::tcp;
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  driver->connected(packet.arrival, out);
  for (std::size_t at = 1; input.has(at, 1);) {
    const std::size_t length = input.u8(at++);
    packet.missing = length == 0 ? 10 : 0;
    packet.payload = input.sub(at, length < size - at ? length : size - at);
    at += packet.payload.size();
    packet.arrival = packet.arrival + std::chrono::milliseconds(10);
    static_cast<void>(driver->receive(packet, out));
    driver->tick(packet.arrival, out);
    recognizer->add(packet);
  }
  driver->finish(out);
  if (out.violation() != nullptr) std::abort();
  return 0;
}
