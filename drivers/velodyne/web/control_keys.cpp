// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/control_keys.h"

#include <cmath>

namespace lidard {
namespace {

using namespace keys;
using S = VelodyneSettings;

// Ranges: VLP-16 user manual 63-9243 Rev D, section 10.2.
constexpr double slowest_rpm = 300;
constexpr double fastest_rpm = 1200;
constexpr double rpm_step = 60;
constexpr double shortest_period_s = 3;  // one round is three requests, one per second
constexpr double longest_period_s = 3600;
constexpr double last_port = 65535;

constexpr const char* fov_form = "{start_deg: 0, end_deg: 360}, whole degrees";
constexpr const char* host_form = "the IPv4 address to send to, a broadcast or a multicast address";

std::optional<Misfit> no_rpm(const KeyValue& value) {
  if (std::fmod(std::get<double>(value), rpm_step) == 0) return std::nullopt;
  return Misfit{"is {}", "a multiple of 60 from 300 to 1200"};
}

std::optional<Misfit> no_hundredths(const KeyValue& value) {
  const double hundredths = std::get<double>(value) * 100;
  if (std::abs(hundredths - std::round(hundredths)) <= 1e-6) return std::nullopt;
  return Misfit{"is {}", "a multiple of 0.01 degrees"};
}

std::optional<Misfit> no_host(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (address && !address->v6 && *address != IpAddress::v4(0, 0, 0, 0)) return std::nullopt;
  return Misfit{"is {}", host_form};
}

Keys<S> fov_keys() {
  return {
      whole("start_deg", &S::fov_start_deg, 0, 359, "as the sensor counts azimuth")
          .of_form(fov_form)
          .needed(),
      whole("end_deg", &S::fov_end_deg, 0, 360, "as the sensor counts azimuth").of_form(fov_form).needed()};
}

Keys<S> phase_lock_keys() {
  auto offset = number("offset_deg", &S::phase_lock_offset, 0, 360, "degrees",
                       "where the lasers fire at the top of the second")
                    .checked(no_hundredths);
  offset.get = [](const S& wanted) {
    return wanted.phase_lock_offset ? key_value(*wanted.phase_lock_offset / 100.0) : KeyValue();
  };
  offset.set = [](S& wanted, const KeyValue& value) {
    wanted.phase_lock_offset = static_cast<int>(std::lround(std::get<double>(value) * 100));
  };
  return {flag("enabled", &S::phase_lock, "the rotation is locked to the top of the second")
              .of_form("{enabled: true, offset_deg: 0}")
              .needed(),
          offset};
}

Keys<S> wanted_keys() {
  const Words<std::optional<VelodyneReturns>> returns{{"strongest", VelodyneReturns::strongest},
                                                      {"last", VelodyneReturns::last},
                                                      {"dual", VelodyneReturns::dual}};
  return {
      whole("rpm", &S::rpm, slowest_rpm, fastest_rpm, "speed of rotation, a multiple of 60").checked(no_rpm),
      word("returns", &S::returns, returns, "which returns it sends"),
      flag("laser", &S::laser, "the lasers fire"),
      section("fov", fov_keys(), "the sector that it sends"),
      section("phase_lock", phase_lock_keys(), "where it looks at the top of the second"),
      section<S>("host",
                 {text("address", &S::host_address, host_form, "where it sends").checked(no_host),
                  whole("port", &S::host_port, 1, last_port, "of its data"),
                  whole("telemetry_port", &S::host_telemetry_port, 1, last_port,
                        "of its satellite receiver's sentences")},
                 "where it sends")};
}

}  // namespace

Keys<VelodyneControl> control_keys() {
  using C = VelodyneControl;
  Keys<C> rows{
      flag("read", &C::read, "asks the sensor for its settings").by_default("true if a setting is wanted"),
      flag("allow_write", &C::allow_write, "settings that differ from those wanted here are written"),
      whole("port", &C::port, 1, last_port, "TCP port of its web interface")};
  const Keys<C> wanted = within(&C::wanted, wanted_keys());
  rows.insert(rows.end(), wanted.begin(), wanted.end());
  rows.push_back(flag("save", &C::save, "keeps what was written in the sensor's flash memory"));
  rows.push_back(number("period", &C::period, shortest_period_s, longest_period_s, "s",
                        "between two rounds of requests"));
  return rows;
}

}  // namespace lidard
