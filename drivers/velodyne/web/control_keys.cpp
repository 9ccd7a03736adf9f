// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `control:` of a sensor.
#include <cmath>

#include "drivers/document.h"
#include "drivers/web_control.h"

namespace lidard {
namespace {

// Ranges: VLP-16 user manual 63-9243 Rev D, section 10.2.
constexpr double slowest_rpm = 300;
constexpr double fastest_rpm = 1200;
constexpr double rpm_step = 60;
constexpr double last_port = 65535;

constexpr const char* host_form = "the IPv4 address to send to, a broadcast or a multicast address";

std::optional<Rejection> no_rpm(const KeyValue& value) {
  if (std::fmod(std::get<double>(value), rpm_step) == 0) return std::nullopt;
  return Rejection{"is {}", "a multiple of 60 from 300 to 1200"};
}

std::optional<Rejection> no_host(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (address && !address->v6 && *address != IpAddress::v4(0, 0, 0, 0)) return std::nullopt;
  return Rejection{"is {}", host_form};
}

Keys wanted_keys(VelodyneSettings& wanted) {
  using namespace keys;
  return {{"rpm", wanted.rpm, whole(slowest_rpm, fastest_rpm, no_rpm), "speed of rotation, a multiple of 60"},
          {"returns", wanted.returns,
           word({{"strongest", VelodyneReturns::strongest},
                 {"last", VelodyneReturns::last},
                 {"dual", VelodyneReturns::dual}}),
           "which returns it sends"},
          {"fov_start_deg", wanted.fov_start_deg, whole(0, 359),
           "begin of the sector that it sends, as it counts azimuth"},
          {"fov_end_deg", wanted.fov_end_deg, whole(0, 360), "end of that sector; 0 to 360 is all"},
          {"host_address", wanted.host_address, text(host_form, no_host), "where it sends"},
          {"host_port", wanted.host_port, whole(1, last_port), "the port that it sends its data to"},
          {"host_telemetry_port", wanted.host_telemetry_port, whole(1, last_port),
           "the port that it sends its satellite receiver's sentences to"}};
}

}  // namespace

Keys control_keys(VelodyneControl& control) {
  using namespace keys;
  return join(
      {{{"allow_write", control.allow_write, flag, "settings that differ from those wanted here are written"},
        {"port", control.port, whole(1, last_port), "TCP port of its web interface"}},
       wanted_keys(control.wanted)});
}

void check_control(const Mapping& yaml, const std::optional<IpAddress>& address, VelodyneControl& control,
                   std::vector<std::string>& warnings) {
  const std::optional<int>& start = control.wanted.fov_start_deg;
  const std::optional<int>& end = control.wanted.fov_end_deg;
  if (start.has_value() != end.has_value())
    yaml.where(start ? "fov_start_deg" : "fov_end_deg")
        .fail_at_key("is given alone", "both fov_start_deg and fov_end_deg, or none");
  if (start && start == end)
    yaml.where("fov_end_deg").fail("is fov_start_deg too", "0 and 360 for all, in whole degrees");
  if (control.wanted.host_port && *control.wanted.host_port != control.data_port) {
    const Value& port = yaml.where("host_port");
    warnings.push_back(port.location().to_string() + ": " + port.path() +
                       " makes the sensor send to a port that is not its ip_port, " +
                       std::to_string(control.data_port) + ": its data will not arrive here");
  }
  if (!control.wanted.any()) return;
  for (const auto& [key, value] : yaml.entries()) {
    if (!control.allow_write && key != "allow_write" && key != "port")
      value.fail_at_key("asks to change the sensor, but control.allow_write is not true",
                        "allow_write: true beside it, or no such key");
  }
  if (!address) yaml.self().fail_at_key("needs the sensor's address", "ip_address: of the sensor");
  control.address = *address;
}

}  // namespace lidard
