// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/stream_finder.h"

#include <map>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/identifier.h"

namespace lidard {
namespace {

/// So many datagrams are enough once a sensor was found; a sensor that starts later is counted as another
/// sender.
constexpr std::uint64_t enough_datagrams = 5000;
/// An address scan or a peer-to-peer program makes a flow per packet; a vehicle has some dozens.
constexpr std::size_t max_candidates = 1000;

class NoOutput final : public DriverOutput {
 public:
  void scan(PlanarScan& /*scan*/) override {}
  void cloud(Cloud& /*cloud*/) override {}
};

/// What speaks for a stream being a sensor's.
struct Candidate {
  Identifier identifier;
  std::unique_ptr<Driver> probe;
  ConnectionPicker connection;

  void add(Packet packet, const Model* model);
  const Model* verdict(const Model* model) const {
    if (model == nullptr) return identifier.verdict();
    if (!probe) return nullptr;
    const Counters& c = probe->counters();
    // Requests to a device may pass for packets, but never for frames.
    const bool some = model->transport == Transport::tcp ? c.frames > 0 : c.packets > c.rejected_total();
    return some ? model : nullptr;
  }
};

void Candidate::add(Packet packet, const Model* model) {
  if (packet.transport == Transport::tcp && !connection.pick(packet)) return;
  identifier.add(packet);
  if (model == nullptr || model->transport != packet.transport) return;
  if (!probe) {
    DriverConfig config;
    config.model = model;
    probe = model->make(config);
  }
  NoOutput nowhere;
  probe->receive(packet, nowhere);
}

}  // namespace

FlowTable<const Model*> SensorStream::flows() const {
  FlowTable<const Model*> all;
  for (const Flow& flow : flows_of(*model, data.address, data.port)) all.add(flow, model);
  return all;
}

bool is_wanted(const Packet& packet, const DecodeOptions& options) {
  if (options.source && packet.from.address != *options.source) return false;
  if (options.source_port != 0 && packet.from.port != options.source_port) return false;
  return options.port == 0 || flow_of(packet).port == options.port;
}

std::vector<SensorStream> find_streams(const DecodeOptions& options, const Model* model) {
  PcapSource source(options.capture);
  std::map<Flow, Candidate> candidates;
  bool found = false;
  Packet packet;
  for (std::uint64_t n = 0; (n < enough_datagrams || !found) && source.next(packet); ++n) {
    if (!is_wanted(packet, options)) continue;
    const Flow flow = flow_of(packet);
    if (candidates.size() >= max_candidates && candidates.find(flow) == candidates.end()) continue;
    Candidate& candidate = candidates[flow];
    candidate.add(packet, model);
    found = found || candidate.verdict(model) != nullptr;
  }
  std::vector<SensorStream> streams;
  for (const auto& [flow, candidate] : candidates) {
    const Model* verdict = candidate.verdict(model);
    if (verdict != nullptr) streams.push_back({flow, verdict, candidate.identifier.remark()});
  }
  return streams;
}

}  // namespace lidard
