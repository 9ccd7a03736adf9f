// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <charconv>
#include <cmath>

#include "core/base/number_text.h"
#include "daemon/config/config_parts.h"

namespace lidard {
namespace {

// Ranges: VLP-16 user manual 63-9243 Rev D, section 10.2.
constexpr long slowest_rpm = 300;
constexpr long fastest_rpm = 1200;
constexpr long rpm_step = 60;
constexpr double shortest_period_s = 3;  // one round is three requests, one per second
constexpr double longest_period_s = 3600;

constexpr std::array<const char*, 3> return_words = {"strongest", "last", "dual"};

int read_rpm(const Value& value) {
  const long rpm = value.integer(slowest_rpm, fastest_rpm);
  if (rpm % rpm_step != 0) value.fail("is " + std::to_string(rpm), "a multiple of 60 from 300 to 1200");
  return static_cast<int>(rpm);
}

VelodyneReturns read_returns(const Value& value) {
  const std::string expected = "strongest, last or dual";
  const std::string word = value.text(expected);
  for (std::size_t i = 0; i < return_words.size(); ++i) {
    if (word == return_words.at(i)) return static_cast<VelodyneReturns>(i);
  }
  value.fail("is " + value.quoted(), expected);
}

void read_fov(const Value& value, VelodyneSettings& wanted) {
  Mapping fov(value, {"start_deg", "end_deg"});
  const std::string expected = "{start_deg: 0, end_deg: 360}, whole degrees";
  wanted.fov_start_deg = static_cast<int>(fov.require("start_deg", expected).integer(0, 359));
  wanted.fov_end_deg = static_cast<int>(fov.require("end_deg", expected).integer(0, 360));
  if (wanted.fov_start_deg == wanted.fov_end_deg) fov.where("end_deg").fail("is start_deg too", expected);
}

std::uint16_t read_port(const Value& value) { return static_cast<std::uint16_t>(value.integer(1, 65535)); }

IpAddress read_host_address(const Value& value) {
  const std::string expected = "the IPv4 address to send to, a broadcast or a multicast address";
  const auto address = IpAddress::parse(value.text(expected));
  if (!address || address->v6 || *address == IpAddress::v4(0, 0, 0, 0))
    value.fail("is " + value.quoted(), expected);
  return *address;
}

void read_host(const Value& value, const SensorConfig& sensor, VelodyneSettings& wanted, Config& config) {
  Mapping host(value, {"address", "port", "telemetry_port"});
  if (const auto address = host.find("address")) wanted.host_address = read_host_address(*address);
  if (const auto port = host.find("port")) {
    wanted.host_port = read_port(*port);
    if (*wanted.host_port != sensor.ip_port)
      warn(config, port->place(),
           port->path() + " makes the sensor send to a port that is not its ip_port, " +
               std::to_string(sensor.ip_port) + ": its data will not arrive here");
  }
  if (const auto port = host.find("telemetry_port")) wanted.host_telemetry_port = read_port(*port);
}

void read_phase_lock(const Value& value, VelodyneSettings& wanted) {
  Mapping lock(value, {"enabled", "offset_deg"});
  wanted.phase_lock = lock.require("enabled", "{enabled: true, offset_deg: 0}").boolean();
  const auto offset = lock.find("offset_deg");
  if (!offset) return;
  const double hundredths = offset->number(0, 360, "degrees") * 100;
  if (std::abs(hundredths - std::round(hundredths)) > 1e-6)
    offset->fail("is " + offset->quoted(), "a multiple of 0.01 degrees");
  wanted.phase_lock_offset = static_cast<int>(std::lround(hundredths));
}

void read_wanted(Mapping& yaml, const SensorConfig& sensor, VelodyneSettings& wanted, Config& config) {
  if (const auto rpm = yaml.find("rpm")) wanted.rpm = read_rpm(*rpm);
  if (const auto returns = yaml.find("returns")) wanted.returns = read_returns(*returns);
  if (const auto laser = yaml.find("laser")) wanted.laser = laser->boolean();
  if (const auto fov = yaml.find("fov")) read_fov(*fov, wanted);
  if (const auto lock = yaml.find("phase_lock")) read_phase_lock(*lock, wanted);
  if (const auto host = yaml.find("host")) read_host(*host, sensor, wanted, config);
}

/// Refuses what would be ignored: a wish without permission, a permission to save nothing.
void check_permissions(const Mapping& yaml, const VelodyneControl& control) {
  if (!control.allow_write) {
    for (const char* key : {"rpm", "returns", "laser", "fov", "phase_lock", "host", "save"}) {
      if (yaml.has(key) && (control.wanted.any() || control.save))
        yaml.where(key).fail_at_key("asks to change the sensor, but control.allow_write is not true",
                                    "allow_write: true beside it, or no such key");
    }
  }
  if (control.save && !control.wanted.any())
    yaml.where("save").fail_at_key("is given, but no setting to save", "rpm, returns, fov, host … beside it");
  if (control.wanted.any() && !control.read)
    yaml.where("read").fail("is false, so nobody could tell whether a setting differs",
                            "true, or no wanted settings");
}

void number(YAML::Emitter& yaml, const char* key, long value) {
  yaml << YAML::Key << key << YAML::Value << value;
}
void text(YAML::Emitter& yaml, const char* key, const std::string& value) {
  yaml << YAML::Key << key << YAML::Value << value;
}
void flag(YAML::Emitter& yaml, const char* key, bool value) { text(yaml, key, value ? "true" : "false"); }

void write_phase_lock(YAML::Emitter& yaml, const VelodyneSettings& wanted) {
  if (!wanted.phase_lock) return;
  yaml << YAML::Key << "phase_lock" << YAML::Value << YAML::BeginMap;
  flag(yaml, "enabled", *wanted.phase_lock);
  if (wanted.phase_lock_offset) text(yaml, "offset_deg", number_text(*wanted.phase_lock_offset / 100.0));
  yaml << YAML::EndMap;
}

void write_host(YAML::Emitter& yaml, const VelodyneSettings& wanted) {
  if (!wanted.host_address && !wanted.host_port && !wanted.host_telemetry_port) return;
  yaml << YAML::Key << "host" << YAML::Value << YAML::BeginMap;
  if (wanted.host_address) text(yaml, "address", wanted.host_address->to_string());
  if (wanted.host_port) number(yaml, "port", *wanted.host_port);
  if (wanted.host_telemetry_port) number(yaml, "telemetry_port", *wanted.host_telemetry_port);
  yaml << YAML::EndMap;
}

void write_wanted(YAML::Emitter& yaml, const VelodyneSettings& wanted) {
  if (wanted.rpm) number(yaml, "rpm", *wanted.rpm);
  if (wanted.returns) text(yaml, "returns", return_words.at(static_cast<std::size_t>(*wanted.returns)));
  if (wanted.laser) flag(yaml, "laser", *wanted.laser);
  if (wanted.fov_start_deg && wanted.fov_end_deg) {
    yaml << YAML::Key << "fov" << YAML::Value << YAML::BeginMap;
    number(yaml, "start_deg", *wanted.fov_start_deg);
    number(yaml, "end_deg", *wanted.fov_end_deg);
    yaml << YAML::EndMap;
  }
  write_phase_lock(yaml, wanted);
  write_host(yaml, wanted);
}

}  // namespace

VelodyneControl read_control(const Value& value, const SensorConfig& sensor, Config& config) {
  Mapping yaml(value, {"read", "allow_write", "port", "rpm", "returns", "laser", "fov", "phase_lock", "host",
                       "save", "period"});
  VelodyneControl control;
  if (const auto write = yaml.find("allow_write")) control.allow_write = write->boolean();
  if (const auto port = yaml.find("port")) control.port = read_port(*port);
  read_wanted(yaml, sensor, control.wanted, config);
  control.read = control.wanted.any();
  if (const auto read = yaml.find("read")) control.read = read->boolean();
  if (const auto save = yaml.find("save")) control.save = save->boolean();
  if (const auto period = yaml.find("period"))
    control.period = period->duration(shortest_period_s, longest_period_s);
  check_permissions(yaml, control);
  if (control.read && !sensor.ip_address)
    value.fail_at_key("needs the sensor's address", "ip_address: of the sensor");
  return control;
}

void write_control(YAML::Emitter& yaml, const VelodyneControl& control) {
  yaml << YAML::Flow << YAML::BeginMap;
  flag(yaml, "read", control.read);
  flag(yaml, "allow_write", control.allow_write);
  number(yaml, "port", control.port);
  write_wanted(yaml, control.wanted);
  flag(yaml, "save", control.save);
  text(yaml, "period", number_text(static_cast<double>(control.period.count()) / 1e9));
  yaml << YAML::EndMap;
}

}  // namespace lidard
