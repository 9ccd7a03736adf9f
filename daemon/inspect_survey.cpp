// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/inspect_survey.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

namespace lidard {
namespace {

// An address scan or a peer-to-peer program makes a flow per packet; a vehicle has some dozens.
constexpr std::size_t max_flows = 1000;

using FlowKey = std::pair<IpAddress, std::uint16_t>;

struct Watched {
  Flow flow;
  Identifier identifier;
};
using Flows = std::map<FlowKey, Watched>;

class NullOutput : public DriverOutput {
 public:
  void scan(PlanarScan& scan) override { static_cast<void>(scan); }
  void cloud(Cloud& cloud) override { static_cast<void>(cloud); }
};

void add_to(Flow& flow, const Packet& packet) {
  const std::size_t size = packet.payload.size();
  if (flow.packets++ == 0) {
    flow.sender = packet.from.address;
    flow.port = packet.to.port;
    flow.source_port = packet.from.port;
    flow.smallest = size;
    flow.first = flow.last = packet.arrival;
  }
  if (flow.destinations.size() < max_flows) flow.destinations.insert(packet.to.address);
  flow.bytes += size;
  flow.smallest = std::min(flow.smallest, size);
  flow.largest = std::max(flow.largest, size);
  flow.first = std::min(flow.first, packet.arrival);
  flow.last = std::max(flow.last, packet.arrival);
}

/// Calls `take` with every datagram; returns what is to be said of the file.
template <typename Take>
SurveyedCapture read(const std::string& file, Take take) {
  SurveyedCapture capture;
  capture.file = file;
  try {
    PcapSource source(file);
    Packet packet;
    while (source.next(packet)) {
      if (packet.transport != Transport::udp) continue;
      capture.first = std::min(capture.first.value_or(packet.arrival), packet.arrival);
      capture.last = std::max(capture.last.value_or(packet.arrival), packet.arrival);
      take(packet);
    }
    capture.counters = source.counters();
    capture.error = source.error();
  } catch (const CaptureError& error) {
    capture.error = error.what();
  }
  return capture;
}

void watch(const Packet& packet, Flows& flows, std::uint64_t& uncounted) {
  const FlowKey key{packet.from.address, packet.to.port};
  auto found = flows.find(key);
  if (found == flows.end()) {
    if (flows.size() >= max_flows) {
      ++uncounted;
      return;
    }
    found = flows.emplace(key, Watched{}).first;
  }
  add_to(found->second.flow, packet);
  found->second.identifier.add(packet);
}

std::string name_for(const Model& model, const std::vector<FoundSensor>& others) {
  const auto same = std::count_if(others.begin(), others.end(),
                                  [&](const FoundSensor& sensor) { return sensor.model == &model; });
  return std::string(model.name) + (same == 0 ? "" : "_" + std::to_string(same + 1));
}

/// Sorts the flows into sensors, their telemetry and the rest.
void sort_out(Flows& flows, Survey& out) {
  for (auto& [key, watched] : flows) {
    watched.flow.remark = watched.identifier.remark();
    const Model* model = watched.identifier.verdict();
    if (model == nullptr) continue;
    FoundSensor sensor;
    sensor.name = name_for(*model, out.sensors);
    sensor.model = model;
    sensor.data = watched.flow;
    out.sensors.push_back(std::move(sensor));
  }
  for (auto& [key, watched] : flows) {
    if (watched.identifier.verdict() != nullptr) continue;
    const auto owner = std::find_if(out.sensors.begin(), out.sensors.end(), [&](const FoundSensor& sensor) {
      return sensor.data.sender == key.first && sensor.model->telemetry_port == key.second;
    });
    if (owner == out.sensors.end())
      out.unknown.push_back(watched.flow);
    else
      owner->telemetry = watched.flow;
  }
  std::stable_sort(out.unknown.begin(), out.unknown.end(),
                   [](const Flow& a, const Flow& b) { return a.packets > b.packets; });
}

/// Lets the drivers of the sensors see their packets.
void judge(const std::vector<std::string>& captures, std::vector<FoundSensor>& sensors) {
  std::vector<std::unique_ptr<Driver>> drivers;
  std::map<FlowKey, Driver*> receivers;
  for (const FoundSensor& sensor : sensors) {
    DriverConfig config;
    config.model = sensor.model;
    config.frame_id = sensor.name;
    drivers.push_back(sensor.model->make(config));
    receivers[{sensor.data.sender, sensor.data.port}] = drivers.back().get();
    if (sensor.telemetry) receivers[{sensor.data.sender, sensor.telemetry->port}] = drivers.back().get();
  }
  NullOutput output;
  for (const std::string& file : captures) {
    read(file, [&](const Packet& packet) {
      const auto receiver = receivers.find({packet.from.address, packet.to.port});
      if (receiver != receivers.end()) receiver->second->receive(packet, output);
    });
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    drivers[i]->finish(output);
    sensors[i].counters = drivers[i]->counters();
    sensors[i].info = drivers[i]->info();
  }
}

}  // namespace

Survey survey(const std::vector<std::string>& captures) {
  Survey out;
  Flows flows;
  for (const std::string& file : captures) {
    out.captures.push_back(read(file, [&](const Packet& packet) { watch(packet, flows, out.uncounted); }));
  }
  sort_out(flows, out);
  if (!out.sensors.empty()) judge(captures, out.sensors);
  return out;
}

std::string config_of(const Survey& survey) {
  std::string yaml = "sensors:\n";
  for (const FoundSensor& sensor : survey.sensors) {
    yaml += "  " + sensor.name + ":\n";
    yaml += "    model: " + std::string(sensor.model->name) + "\n";
    yaml += "    ip_address: \"" + sensor.data.sender.to_string() + "\"\n";
    yaml += "    ip_port: " + std::to_string(sensor.data.port) + "\n";
    for (const IpAddress& destination : sensor.data.destinations) {
      if (!destination.is_multicast()) continue;
      yaml += "    multicast_group: \"" + destination.to_string() + "\"\n";
      break;
    }
    yaml += "    frame_id: " + sensor.name + "\n";
  }
  return yaml;
}

}  // namespace lidard
