// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <ostream>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "daemon/files/text_table.h"
#include "daemon/offline/forecast.h"
#include "daemon/offline/remarks.h"

namespace lidard {
namespace {

/// True if the daemon connects to the device: it streams over TCP, or its driver has a dialogue.
bool connects(const SensorConfig& sensor) {
  struct Listener final : FrameReceiver {
    void scan(PlanarScan& /*scan*/) override {}
    void cloud(Cloud& /*cloud*/) override {}
    void connect() override { asked = true; }
    bool asked = false;
  } listener;
  if (sensor.model->transport == Transport::tcp) return !sensor.driver.requests.listen_only;
  const auto driver = sensor.model->make(sensor.driver);
  for (std::int64_t second = 1; second < 10 && !listener.asked; ++second)
    driver->tick(Stamp{second * 1'000'000'000}, listener);
  return listener.asked;
}

/// Ports that the daemon listens on and devices that it connects to, with their sensors.
TextTable sockets_of(const Config& config) {
  std::map<std::pair<std::string, std::string>, std::string> sensors;
  const auto add = [&](const char* does, const std::string& socket, const SensorConfig& sensor) {
    std::string& names = sensors[{does, socket}];
    names += (names.empty() ? "" : ", ") + sensor.name;
  };
  for (const SensorConfig& sensor : config.sensors) {
    for (const Flow& flow : flows_of(sensor)) {
      if (flow.transport == Transport::udp) add("listens", "udp " + std::to_string(flow.port), sensor);
    }
    if (sensor.device_port() == 0 || !connects(sensor)) continue;
    const std::string port = std::to_string(sensor.device_port());
    add("connects",
        sensor.ip_address ? "tcp " + sensor.ip_address->to_string() + ":" + port
                          : "tcp, port " + port + " of the sender",
        sensor);
  }
  TextTable table{{"DOES", "SOCKET", "FOR"}};
  for (const auto& [socket, names] : sensors) table.push_back({socket.first, socket.second, names});
  // roscpp: topics and calls over TCP; it always opens the port of UDPROS. The kernel chooses the ports.
  table.push_back({"listens", "tcp, two free ports", "ROS"});
  table.push_back({"listens", "udp, one free port", "ROS"});
  table.push_back({"connects", "tcp, the ROS master's port", "ROS"});
  return table;
}

}  // namespace

int run_check_ports(const std::string& file, std::ostream& out, std::ostream& err) {
  return guarded(err, [&] {
    print_columns(sockets_of(load_config(file)), out);
    return exit_ok;
  });
}

int run_check(const std::string& file, std::ostream& out, std::ostream& err) {
  return guarded(err, [&] {
    const Config config = load_config(file);
    const EmptyField field(config);
    const std::vector<FieldSight> sights = sights_of(config, field);
    for (const auto& list : {remarks_on(config), host_remarks_on(config), forecast(config, sights)}) {
      for (const std::string& sentence : list) err << sentence << '\n';
    }
    out << to_yaml(config) << comments_of(sights, field);
    return exit_ok;
  });
}

}  // namespace lidard
