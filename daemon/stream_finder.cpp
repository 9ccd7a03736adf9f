// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/stream_finder.h"

#include <map>

#include "drivers/pcap_source.h"

namespace lidard {
namespace {

/// So many datagrams are enough once a sensor was found; a sensor that starts later is counted as another
/// sender.
constexpr std::uint64_t enough_datagrams = 5000;

class NoOutput final : public DriverOutput {
 public:
  void scan(PlanarScan& /*scan*/) override {}
  void cloud(Cloud& /*cloud*/) override {}
};

/// What speaks for a stream being a sensor's.
struct Candidate {
  Identifier identifier;
  std::unique_ptr<Driver> probe;

  const Model* verdict(const Model* model) const {
    if (model == nullptr) return identifier.verdict();
    const Counters& c = probe->counters();
    return c.packets > c.rejected_total() ? model : nullptr;
  }
};

}  // namespace

bool SensorStream::owns(const Packet& packet) const {
  if (packet.transport != Transport::udp || packet.from.address != sender) return false;
  return packet.to.port == port || (model->telemetry_port != 0 && packet.to.port == model->telemetry_port);
}

std::string SensorStream::to_string() const {
  return std::string(model->name) + " " + sender.to_string() + " -> port " + std::to_string(port);
}

bool is_wanted(const Packet& packet, const DecodeOptions& options) {
  if (packet.transport != Transport::udp) return false;
  if (options.source && packet.from.address != *options.source) return false;
  if (options.source_port != 0 && packet.from.port != options.source_port) return false;
  return options.port == 0 || packet.to.port == options.port;
}

std::vector<SensorStream> find_streams(const DecodeOptions& options, const Model* model) {
  PcapSource source(options.capture);
  std::map<Endpoint, Candidate> candidates;  // sender's address, destination port
  NoOutput nowhere;
  bool found = false;
  Packet packet;
  for (std::uint64_t n = 0; (n < enough_datagrams || !found) && source.next(packet); ++n) {
    if (!is_wanted(packet, options)) continue;
    Candidate& candidate = candidates[Endpoint{packet.from.address, packet.to.port}];
    candidate.identifier.add(packet);
    if (model != nullptr) {
      if (!candidate.probe) {
        DriverConfig config;
        config.model = model;
        candidate.probe = model->make(config);
      }
      candidate.probe->receive(packet, nowhere);
    }
    found = found || candidate.verdict(model) != nullptr;
  }
  std::vector<SensorStream> streams;
  for (const auto& [key, candidate] : candidates) {
    const Model* verdict = candidate.verdict(model);
    if (verdict != nullptr)
      streams.push_back({key.address, key.port, verdict, candidate.identifier.remark()});
  }
  return streams;
}

}  // namespace lidard
