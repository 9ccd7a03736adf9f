// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/survey.h"

#include <algorithm>
#include <map>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <utility>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/identifier.h"

namespace lidard {
namespace {

// Limit for address scans and peer-to-peer programs, which make a flow per packet; a vehicle has some dozens.
constexpr std::size_t max_flows = 1000;

struct Watched {
  SeenFlow flow;
  Identifier identifier;
  ConnectionPicker connection;
};
using Flows = std::map<Flow, Watched>;

/// Records the stamps of a sensor's frames.
class FrameTimes final : public FrameReceiver {
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

void add_to(SeenFlow& flow, const Packet& packet) {
  const std::size_t size = packet.payload.size();
  if (flow.packets++ == 0) {
    static_cast<Flow&>(flow) = flow_of(packet);
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

/// Calls `use` with datagrams and chunks of the first `part` until it returns false; returns the properties
/// of the file.
template <typename Use>
SurveyedCapture read(const std::string& file, Span part, Use use) {
  SurveyedCapture capture;
  capture.file = file;
  try {
    PcapSource source(file);
    Packet packet;
    while (source.next(packet)) {
      capture.first = std::min(capture.first.value_or(packet.arrival), packet.arrival);
      capture.last = std::max(capture.last.value_or(packet.arrival), packet.arrival);
      if (!use(packet) || *capture.last - *capture.first > part) break;
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

void watch(Packet packet, const SurveyOptions& options, Flows& flows, std::uint64_t& uncounted) {
  if (options.is_wanted && !options.is_wanted(packet)) return;
  const Flow key = flow_of(packet);
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

/// The model of a flow; a wanted one is assumed of all flows of its transport. No device has the address of a
/// group (RFC 1122, 3.2.1.3): the capture is damaged.
const Model* verdict_on(const Watched& watched, const Model* wanted) {
  if (watched.flow.address.is_multicast()) return nullptr;
  if (wanted == nullptr) return watched.identifier.verdict();
  return wanted->transport == watched.flow.transport ? wanted : nullptr;
}

/// True if the driver of an assumed model could use packets. Requests to a device may look like packets, but
/// never make frames.
bool is_proven(const FoundSensor& sensor) {
  const Counters& c = sensor.counters;
  return sensor.data.transport == Transport::tcp ? c.frames > 0 : c.packets > c.rejected_total();
}

/// Sorts the flows into sensors, their telemetry and the rest.
void sort_out(Flows& flows, const Model* wanted, Survey& out) {
  for (auto& [key, watched] : flows) {
    watched.flow.remark = watched.identifier.remark();
    const Model* model = verdict_on(watched, wanted);
    if (model == nullptr) continue;
    FoundSensor sensor;
    sensor.name = name_for(*model, out.sensors);
    sensor.model = model;
    sensor.others = watched.identifier.others();
    sensor.data = watched.flow;
    out.sensors.push_back(std::move(sensor));
  }
  const FlowTable<std::size_t> owners = owners_of(out.sensors);
  for (auto& [flow, watched] : flows) {
    if (verdict_on(watched, wanted) != nullptr) continue;
    const std::size_t* owner = owners.find(flow);
    const Endpoint& peer = watched.flow.peer;
    // The client's side of a connection is ignored.
    if (owner == nullptr && flow.transport == Transport::tcp)
      owner = owners.find({Transport::tcp, peer.address, peer.port});
    if (owner == nullptr)
      out.unknown.push_back(watched.flow);
    else if (flow.transport == Transport::udp)
      out.sensors[*owner].telemetry = watched.flow;
  }
  std::stable_sort(out.unknown.begin(), out.unknown.end(),
                   [](const SeenFlow& a, const SeenFlow& b) { return a.packets > b.packets; });
}

/// Runs the drivers of the sensors; with `first_frames` until each has given a frame.
void judge(const std::vector<std::string>& captures, const SurveyOptions& options,
           std::vector<FoundSensor>& sensors) {
  struct Receiver {
    std::unique_ptr<Driver> driver;
    FrameTimes times;
    ConnectionPicker connection{};
  };
  std::vector<Receiver> receivers;
  for (FoundSensor& sensor : sensors) {
    DriverConfig config;
    config.model = sensor.model;
    config.frame_id = sensor.name;
    receivers.push_back({sensor.model->make(config), FrameTimes(sensor)});
  }
  const FlowTable<std::size_t> owners = owners_of(sensors);
  for (const std::string& file : captures) {
    read(file, options.part, [&](Packet packet) {
      const std::size_t* owner = owners.find(packet);
      if (owner == nullptr) return true;
      Receiver& receiver = receivers[*owner];
      if (packet.transport == Transport::udp || receiver.connection.pick(packet))
        receiver.driver->receive(packet, receiver.times);
      // Where the capture has no arrival times the device's clock shows how long it lasts.
      const DeviceClock* const clock = receiver.driver->clock();
      SeenFlow& data = sensors[*owner].data;
      if (clock != nullptr && clock->lacks_now()) data.last = std::max(data.last, clock->newest());
      return !options.first_frames ||
             std::any_of(sensors.begin(), sensors.end(),
                         [](const FoundSensor& sensor) { return sensor.frames == 0; });
    });
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    receivers[i].driver->finish(receivers[i].times);
    sensors[i].counters = receivers[i].driver->counters();
    sensors[i].info = info_of(*receivers[i].driver);
  }
}

/// The models to choose from, as comments.
std::string others_in_yaml(const FoundSensor& sensor) {
  if (sensor.others.empty()) return {};
  std::string yaml =
      "    # The packets do not distinguish these models from it; set the one that you have:\n";
  for (const Model* other : sensor.others) {
    const bool alike = other->row == sensor.model->row;
    yaml += "    # model: " + std::string(other->name) + (alike ? "  # decoded alike" : "") + "\n";
  }
  return yaml;
}

/// The message for captures without packets of a lidar.
std::string nothing_found(const Survey& found, const Model* wanted) {
  std::string all;
  for (const SeenFlow& flow : found.unknown) {
    if (flow.remark.empty()) continue;
    const std::string file = found.captures.size() == 1 ? found.captures[0].file + ": " : "";
    all += (all.empty() ? "" : "\n") + file + flow.to_string() + ": " + flow.remark;
  }
  if (!all.empty()) return all;
  for (const SurveyedCapture& capture : found.captures) {
    if (!all.empty()) all += '\n';
    all += !capture.error.empty() && capture.counters.datagrams == 0
               ? capture.error
               : capture.file + ": no packets of " +
                     (wanted == nullptr ? "a supported lidar" : std::string(wanted->name)) +
                     " found; `lidard inspect` shows what is in it, `lidard models` what is supported";
  }
  return all;
}

}  // namespace

std::string name_for(const Model& model, const std::vector<FoundSensor>& others) {
  const auto same = std::count_if(others.begin(), others.end(),
                                  [&](const FoundSensor& sensor) { return sensor.model == &model; });
  return std::string(model.name) + (same == 0 ? "" : "_" + std::to_string(same + 1));
}

FlowTable<std::size_t> owners_of(const std::vector<FoundSensor>& sensors) {
  FlowTable<std::size_t> owners;
  for (std::size_t i = 0; i < sensors.size(); ++i) owners.add(sensors[i].data, i);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const Model& model = *sensors[i].model;
    const Flow& data = sensors[i].data;
    for (const Flow& flow : flows_of(model, data.address, data.port)) owners.add(flow, i);
  }
  return owners;
}

Survey survey_of_sensors(const std::vector<std::string>& captures, std::ostream& err,
                         const SurveyOptions& options) {
  Survey found = survey(captures, options);
  if (found.sensors.empty()) throw std::runtime_error(nothing_found(found, options.model));
  for (const SurveyedCapture& capture : found.captures) {
    if (!capture.error.empty()) err << capture.error << '\n';
  }
  return found;
}

Survey survey(const std::vector<std::string>& captures, const SurveyOptions& options) {
  Survey out;
  Flows flows;
  for (const std::string& file : captures) {
    out.captures.push_back(read(file, options.part, [&](const Packet& packet) {
      watch(packet, options, flows, out.uncounted);
      return true;
    }));
  }
  sort_out(flows, options.model, out);
  if (!out.sensors.empty()) judge(captures, options, out.sensors);
  if (options.model == nullptr) return out;
  const auto unproven = std::stable_partition(out.sensors.begin(), out.sensors.end(), is_proven);
  for (auto sensor = unproven; sensor != out.sensors.end(); ++sensor) out.unknown.push_back(sensor->data);
  out.sensors.erase(unproven, out.sensors.end());
  return out;
}

std::string config_of(const Survey& survey) {
  std::string yaml = "sensors:\n";
  for (const FoundSensor& sensor : survey.sensors) {
    yaml += "  " + sensor.name + ":\n";
    yaml += "    model: " + std::string(sensor.model->name) + "\n";
    yaml += others_in_yaml(sensor);
    if (!sensor.data.address.v6)  // the daemon receives only IPv4
      yaml += "    ip_address: \"" + sensor.data.address.to_string() + "\"\n";
    yaml += "    ip_port: " + std::to_string(sensor.data.port) + "\n";
    for (const IpAddress& destination : sensor.data.destinations) {
      // The daemon receives only IPv4; a connection to a group is a damaged capture.
      if (sensor.data.transport != Transport::udp || destination.v6 || !destination.is_multicast()) continue;
      yaml += "    multicast_group: \"" + destination.to_string() + "\"\n";
      break;
    }
    yaml += "    frame_id: " + sensor.name + "\n";
    yaml += "    pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}  # edit: where it is mounted, m in base_link\n";
  }
  return yaml;
}

}  // namespace lidard
