// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/inspect_survey.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "drivers/capture/connection_picker.h"
#include "drivers/registry/identifier.h"

namespace lidard {
namespace {

// An address scan or a peer-to-peer program makes a flow per packet; a vehicle has some dozens.
constexpr std::size_t max_flows = 1000;

/// Sender's address, and the destination port or, of a connection, its own.
using FlowKey = std::pair<Transport, Endpoint>;

FlowKey key_of(const Packet& packet) {
  const bool tcp = packet.transport == Transport::tcp;
  return {packet.transport, {packet.from.address, tcp ? packet.from.port : packet.to.port}};
}

struct Watched {
  Flow flow;
  Identifier identifier;
  ConnectionPicker connection;
};
using Flows = std::map<FlowKey, Watched>;

/// Notes when the frames of a sensor were measured.
class FrameTimes final : public DriverOutput {
 public:
  explicit FrameTimes(FoundSensor& sensor) : sensor_(&sensor) {}
  void scan(PlanarScan& scan) override { note_frame(scan.stamp); }
  void cloud(Cloud& cloud) override { note_frame(cloud.stamp); }

 private:
  void note_frame(Stamp stamp) {
    if (sensor_->frames++ == 0) sensor_->first_frame = stamp;
    sensor_->last_frame = stamp;
  }
  FoundSensor* sensor_;
};

void add_to(Flow& flow, const Packet& packet) {
  const std::size_t size = packet.payload.size();
  if (flow.packets++ == 0) {
    flow.sender = packet.from.address;
    flow.transport = packet.transport;
    flow.port = key_of(packet).second.port;
    flow.source_port = packet.from.port;
    flow.peer = packet.to;
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

/// Calls `take` with every datagram and chunk; returns what is to be said of the file.
template <typename Take>
SurveyedCapture read(const std::string& file, Take take) {
  SurveyedCapture capture;
  capture.file = file;
  try {
    PcapSource source(file);
    Packet packet;
    while (source.next(packet)) {
      capture.first = std::min(capture.first.value_or(packet.arrival), packet.arrival);
      capture.last = std::max(capture.last.value_or(packet.arrival), packet.arrival);
      take(packet);
    }
    capture.counters = source.counters();
    capture.error = source.error();
    capture.damaged = source.is_damaged();
  } catch (const CaptureError& error) {
    capture.error = error.what();
    capture.damaged = true;
  }
  return capture;
}

void watch(Packet packet, Flows& flows, std::uint64_t& uncounted) {
  const FlowKey key = key_of(packet);
  auto found = flows.find(key);
  if (found == flows.end()) {
    if (flows.size() >= max_flows) {
      ++uncounted;
      return;
    }
    found = flows.emplace(key, Watched{}).first;
  }
  add_to(found->second.flow, packet);
  if (packet.transport == Transport::udp || found->second.connection.pick(packet))
    found->second.identifier.add(packet);
}

std::string name_for(const Model& model, const std::vector<FoundSensor>& others) {
  const auto same = std::count_if(others.begin(), others.end(),
                                  [&](const FoundSensor& sensor) { return sensor.model == &model; });
  return std::string(model.name) + (same == 0 ? "" : "_" + std::to_string(same + 1));
}

/// The sensor whose telemetry or dialogue this flow is, or whose client's side of the conversation.
FoundSensor* owner_of(const Flow& flow, std::vector<FoundSensor>& sensors) {
  for (FoundSensor& sensor : sensors) {
    const bool tcp = sensor.data.transport == Transport::tcp;
    const Endpoint device{sensor.data.sender, tcp ? sensor.data.port : sensor.model->dialogue_port};
    if (flow.transport == Transport::tcp) {
      if (flow.peer == device || device == Endpoint{flow.sender, flow.port}) return &sensor;
    } else if (!tcp && flow.sender == sensor.data.sender && flow.port == sensor.model->telemetry_port) {
      return &sensor;
    }
  }
  return nullptr;
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
    sensor.others = watched.identifier.others();
    sensor.data = watched.flow;
    out.sensors.push_back(std::move(sensor));
  }
  for (auto& [key, watched] : flows) {
    if (watched.identifier.verdict() != nullptr) continue;
    FoundSensor* owner = owner_of(watched.flow, out.sensors);
    if (owner == nullptr)
      out.unknown.push_back(watched.flow);
    else if (watched.flow.transport == Transport::udp)
      owner->telemetry = watched.flow;
  }
  std::stable_sort(out.unknown.begin(), out.unknown.end(),
                   [](const Flow& a, const Flow& b) { return a.packets > b.packets; });
}

/// Lets the drivers of the sensors see their packets.
void judge(const std::vector<std::string>& captures, std::vector<FoundSensor>& sensors) {
  struct Receiver {
    Driver* driver;
    FrameTimes* times;
    ConnectionPicker connection{};
  };
  std::vector<std::unique_ptr<Driver>> drivers;
  std::vector<FrameTimes> times(sensors.begin(), sensors.end());
  std::map<FlowKey, Receiver> receivers;
  for (const FoundSensor& sensor : sensors) {
    DriverConfig config;
    config.model = sensor.model;
    config.frame_id = sensor.name;
    drivers.push_back(sensor.model->make(config));
    const auto listen = [&](Transport transport, std::uint16_t port) {
      receivers[{transport, {sensor.data.sender, port}}] = {drivers.back().get(), &times[drivers.size() - 1]};
    };
    listen(sensor.data.transport, sensor.data.port);
    if (sensor.telemetry) listen(Transport::udp, sensor.telemetry->port);
    if (sensor.model->dialogue_port != 0) listen(Transport::tcp, sensor.model->dialogue_port);
  }
  for (const std::string& file : captures) {
    read(file, [&](Packet packet) {
      const auto found = receivers.find(key_of(packet));
      if (found == receivers.end()) return;
      Receiver& receiver = found->second;
      if (packet.transport == Transport::udp || receiver.connection.pick(packet))
        receiver.driver->receive(packet, *receiver.times);
    });
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    drivers[i]->finish(times[i]);
    sensors[i].counters = drivers[i]->counters();
    sensors[i].info = drivers[i]->info();
  }
}

/// The models to choose from, as comments.
std::string others_in_yaml(const FoundSensor& sensor) {
  if (sensor.others.empty()) return {};
  std::string yaml = "    # Nothing in the packets tells these apart from it; set the one that you have:\n";
  for (const Model* other : sensor.others) {
    const bool alike = other->row == sensor.model->row;
    yaml += "    # model: " + std::string(other->name) + (alike ? "  # decoded alike" : "") + "\n";
  }
  return yaml;
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
    yaml += others_in_yaml(sensor);
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
