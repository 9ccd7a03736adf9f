// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config_parts.h"

namespace lidard {
namespace {

IpAddress read_receiver(const Value& value) {
  const std::string expected = "an IPv4 address of this host (or a multicast group) like 192.168.0.100";
  const auto address = IpAddress::parse(value.text(expected));
  if (!address || address->v6) value.fail("is " + value.quoted() + ", which is no IPv4 address", expected);
  return *address;
}

std::string read_level(const Value& value) { return std::to_string(value.integer(1, 9)); }

std::string read_hash(const Value& value) {
  const std::string expected = "the hash of the password, 8 hexadecimal digits like F4724744";
  std::string text = value.text(expected);
  if (text.size() != 8 || text.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
    value.fail("is not 8 hexadecimal digits", expected);
  return text;
}

}  // namespace

void read_requests(Mapping& yaml, SensorConfig& sensor) {
  const Model& model = *sensor.model;
  if (!model.has(Trait::settings_writable)) return;
  DeviceRequests& requests = sensor.driver.requests;
  if (const auto write = yaml.find("allow_write")) requests.allow_write = write->boolean();
  if (model.has(Trait::receiver_settable)) {
    const auto listen = yaml.find("listen_only");
    if (listen) requests.listen_only = listen->boolean();
    if (const auto receiver = yaml.find("udp_receiver_ip")) {
      requests.host_address = read_receiver(*receiver);
      requests.host_port = sensor.ip_port;
      if (!sensor.ip_address)
        receiver->fail_at_key(
            "is given without ip_address",
            "both: the device is told over TCP where to send, so its address must be known");
    }
    if (requests.listen_only && requests.allow_write)
      listen->fail_at_key("contradicts allow_write", "one of them");
  }
  if (!model.has(Trait::logins)) return;
  const auto level = yaml.find("user_level");
  const auto password = yaml.find("user_level_password");
  if (level) requests.user_level = read_level(*level);
  if (password) requests.password_hash = read_hash(*password);
  if (level.has_value() != password.has_value())
    (level ? level : password)
        ->fail_at_key("is given alone", "both user_level and user_level_password, or none");
}

std::vector<std::pair<std::string, std::string>> requests_text(const SensorConfig& sensor) {
  std::vector<std::pair<std::string, std::string>> text;
  const Model& model = *sensor.model;
  if (!model.has(Trait::settings_writable)) return text;
  const DeviceRequests& requests = sensor.driver.requests;
  const auto flag = [](bool value) { return std::string(value ? "true" : "false"); };
  text.emplace_back("allow_write", flag(requests.allow_write));
  if (model.has(Trait::receiver_settable)) {
    text.emplace_back("listen_only", flag(requests.listen_only));
    if (requests.host_address) text.emplace_back("udp_receiver_ip", requests.host_address->to_string());
  }
  if (!requests.user_level.empty()) {
    text.emplace_back("user_level", requests.user_level);
    text.emplace_back("user_level_password", requests.password_hash);
  }
  return text;
}

}  // namespace lidard
