// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/velodyne_wire.h"

#include <algorithm>

namespace lidard::test {
namespace {

constexpr Stamp start{1'767'226'643'500'000'000};

const sim::VelodyneTiming& timing_of(const ModelMode& which) {
  return sim::velodyne_timing(which.table(), which.timing);
}

}  // namespace

std::string ModelMode::name() const {
  const char* names[] = {"strongest", "last", "dual", "dual with confidence"};
  return model + " " + names[static_cast<std::size_t>(mode)] + (timing.empty() ? "" : " " + timing);
}

std::size_t ModelMode::sequences() const {
  const std::size_t lasers = table().lasers_per_sequence();
  const std::size_t echoes = is_dual() ? 2 : 1;
  return lasers == 128 && is_dual() ? 1 : 384 / lasers / echoes;
}

std::size_t ModelMode::groups() const {
  const std::size_t banks = std::max<std::size_t>(1, table().lasers_per_sequence() / 32);
  return 12 / banks / (is_dual() ? 2 : 1);
}

double ModelMode::turn_deg() const { return timing_of(*this).turn_deg; }

Span ModelMode::turn_time() const {
  return span_from_seconds(360 / turn_deg() * 1e-9 * static_cast<double>(timing_of(*this).period_ns()));
}

const std::vector<ModelMode>& model_modes() {
  static const std::vector<ModelMode> all = [] {
    std::vector<ModelMode> list;
    for (const sim::VelodyneTable& table : sim::velodyne_tables()) {
      const std::string model = table.name;
      if (model == "velodyne_puck_lite" || model == "velodyne_alpha_prime") continue;
      for (const sim::VelodyneTiming& timing : table.timings) {
        list.push_back({model, sim::ReturnMode::strongest, timing.name});
        if (table.has_dual) list.push_back({model, sim::ReturnMode::dual, timing.name});
        if (table.has_confidence()) list.push_back({model, sim::ReturnMode::dual_confidence, timing.name});
      }
      list.push_back({model, sim::ReturnMode::last, table.timings.front().name});
    }
    return list;
  }();
  return all;
}

std::vector<WirePacket> spin(const ModelMode& which, double turns, sim::VelodyneOptions options) {
  options.mode = which.mode;
  options.timing = which.timing;
  const sim::SensorEntry entry;
  const auto sensor = sim::make_velodyne(which.table(), options)(entry, start);
  const double turn_deg = options.turn_deg.value_or(which.turn_deg());
  const Stamp end =
      start + span_from_seconds(seconds(which.turn_time()) * which.turn_deg() / turn_deg * turns);
  std::vector<WirePacket> packets;
  std::vector<sim::Answer> answers;
  std::vector<sim::Datagram> datagrams;
  std::vector<sim::SlotTruth> slots;
  while (true) {
    const std::vector<sim::Beam>& beams = sensor->next();
    if (beams.back().time >= end) return packets;
    sim::Answer answer;
    answer.echoes = {{{8, 8, 0.5}, {12, 12, 0.5}}};
    answer.count = 2;
    answers.assign(beams.size(), answer);
    datagrams.clear();
    slots.clear();
    sensor->encode(answers, {}, datagrams, slots);
    packets.push_back({std::move(datagrams.back().payload), datagrams.back().ready + entry.latency});
  }
}

Reject give(Driver& driver, const WirePacket& packet, FrameReceiver& out) {
  const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
  const ByteView bytes(packet.bytes.data(), packet.bytes.size());
  return driver.receive({bytes, packet.arrival, sensor, {{}, 2368}}, out).reject;
}

}  // namespace lidard::test
