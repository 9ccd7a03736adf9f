// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/safety_settings.h"

#include <iterator>

#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

using Bytes = SafetySettings::Bytes;

Bytes text(const std::string& words) {
  Wire wire(2);
  wire.put16(0, words.size());
  wire.copy(2, words.data(), words.size());
  return wire.take();
}

void put_version(Wire& wire) {
  wire.put8(0, 'R');
  wire.put8(1, 1);
}

void put_output(Wire& wire, const SafetySettings::Output& output) {
  wire.put8(4, output.enabled ? 1 : 0);
  wire.put8(5, output.interface);
  for (std::size_t i = 0; i < 4; ++i) wire.put8(8 + i, output.host.bytes[3 - i]);
  wire.put16(12, output.port);
  wire.put16(14, output.every);
  wire.put32(16, static_cast<std::uint32_t>(output.start));
  wire.put32(20, static_cast<std::uint32_t>(output.end));
  wire.put16(24, output.features);
}

Bytes telegram(std::uint32_t session, ByteView request, char type, char mode, const Bytes& data) {
  const auto length = static_cast<std::uint32_t>(10 + data.size());
  Bytes out = {2, 2, 2, 2};
  for (unsigned shift = 32; shift > 0;) out.push_back(static_cast<std::uint8_t>(length >> (shift -= 8)));
  out.push_back(0);
  out.push_back(0x80);  // the answer's mark
  for (unsigned shift = 32; shift > 0;) out.push_back(static_cast<std::uint8_t>(session >> (shift -= 8)));
  out.push_back(request.u8(14));
  out.push_back(request.u8(15));
  out.push_back(static_cast<std::uint8_t>(type));
  out.push_back(static_cast<std::uint8_t>(mode));
  out.insert(out.end(), data.begin(), data.end());
  return out;
}

Bytes indexed(ByteView request, const Bytes& data) {
  Wire wire(2);
  wire.put16(0, request.le16(18));
  wire.copy(2, data.data(), data.size());
  return wire.take();
}

/// ParseApplicationNameData.cpp, ParseUserNameData.cpp: a version, a length of four bytes, the text.
Bytes versioned_text(const std::string& words) {
  Wire wire(8);
  put_version(wire);
  wire.put32(4, words.size());
  wire.copy(8, words.data(), words.size());
  return wire.take();
}

/// ParseFieldHeaderData.cpp.
Bytes field(const std::string& name) {
  constexpr std::uint8_t protective = 4;
  Wire wire(88);
  put_version(wire);
  wire.put8(72, 1);
  wire.put8(73, protective);
  wire.put16(74, 2);   // scans until it counts
  wire.put16(78, 70);  // mm, resolution
  wire.put16(82, 1);
  wire.put32(84, name.size());
  wire.copy(88, name.data(), name.size());
  return wire.take();
}

/// ParseFieldGeometryData.cpp: a distance for each beam, here all the same.
Bytes geometry(std::size_t beams) {
  constexpr std::uint16_t distance_mm = 2500;
  Wire wire(8 + 2 * beams);
  put_version(wire);
  wire.put32(4, beams);
  for (std::size_t i = 0; i < beams; ++i) wire.put16(8 + 2 * i, distance_mm);
  return wire.take();
}

/// ParseFieldSetsData.cpp: a list of names with room for 32 characters each, 104 bytes apart.
Bytes field_sets(const std::string& name) {
  Wire wire(8 + 104);
  put_version(wire);
  wire.put32(4, 1);
  wire.put32(8, name.size());
  wire.copy(12, name.data(), name.size());
  wire.put8(44, 1);
  return wire.take();
}

/// ParseMonitoringCaseData.cpp.
Bytes monitoring_case(std::uint16_t number, const std::vector<std::uint16_t>& fields) {
  Wire wire(200);
  put_version(wire);
  wire.put16(6, number);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    wire.put8(157 + 4 * i, 1);
    wire.put16(158 + 4 * i, fields[i]);
  }
  return wire.take();
}

/// ParseConfigMetadata.cpp; days count from 1972-01-01, times are ms of the day.
Bytes metadata() {
  Wire wire(84);
  put_version(wire);
  wire.put16(4, 18'000);
  wire.put32(8, 36'000'000);
  wire.put16(12, 18'001);
  wire.put32(16, 36'060'000);
  wire.put32(36, 0x11223344);
  wire.put32(52, 0x55667788);
  for (std::size_t i = 0; i < 4; ++i) wire.put32(68 + 4 * i, 0x01010101U * (i + 1));
  return wire.take();
}

/// ParseStatusOverview.cpp.
Bytes status_overview(std::uint32_t power_cycles) {
  Wire wire(60);
  put_version(wire);
  wire.put32(12, power_cycles);
  wire.put32(16, 43'200'000);
  wire.put16(20, 18'002);
  return wire.take();
}

/// ParseMeasurementPersistentConfigData.cpp.
Bytes output_variable(const SafetySettings::Output& output) {
  Wire wire(60);
  put_version(wire);
  put_output(wire, output);
  return wire.take();
}

/// ParseMeasurementCurrentConfigData.cpp: the same and what follows from it.
Bytes current_variable(const SafetySettings::Output& output, const SafetySettings::Derived& derived) {
  Wire wire(60);
  put_version(wire);
  put_output(wire, output);
  wire.put16(28, 1);
  wire.put16(30, derived.beams);
  wire.put16(32, derived.scan_time_ms);
  wire.put32(36, static_cast<std::uint32_t>(derived.start));
  wire.put32(40, static_cast<std::uint32_t>(derived.step));
  wire.put32(44, derived.beam_period_us);
  return wire.take();
}

}  // namespace

void SafetySettings::power_cycle() {
  current = persistent;
  pending_.clear();
  session_ += 7;
}

Bytes SafetySettings::answer(ByteView chunk) {
  pending_.insert(pending_.end(), chunk.begin(), chunk.end());
  Bytes out;
  for (;;) {
    const ByteView view(pending_.data(), pending_.size());
    if (!view.has(0, 18) || !view.has(8, view.be32(4))) return out;
    const std::size_t length = 8 + view.be32(4);
    const Bytes one = answer_one(view.sub(0, length));
    if (!mute) out.insert(out.end(), one.begin(), one.end());
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(length));
  }
}

Bytes SafetySettings::answer_one(ByteView t) {
  const std::string command = std::string(t.text().substr(16, 2));
  if (command == "OX") {
    heard.emplace_back("open");
    return refuse_session ? telegram(0, t, 'F', 'A', {3, 0}) : telegram(session_, t, 'O', 'A', {});
  }
  if (t.be32(10) != session_) return telegram(session_, t, 'F', 'A', {1, 0});
  if (command == "CX") {
    heard.emplace_back("close");
    return telegram(session_, t, 'C', 'A', {});
  }
  const std::uint16_t index = t.le16(18);
  if (command == "RI") {
    heard.push_back("read " + std::to_string(index));
    constexpr std::uint16_t current_output = 178;
    const Bytes value = hides_output && index == current_output ? Bytes() : variable(index);
    return value.empty() ? telegram(session_, t, 'F', 'A', {3, 0})
                         : telegram(session_, t, 'R', 'A', indexed(t, value));
  }
  heard.push_back("call " + std::to_string(index));
  constexpr std::uint16_t find_me = 14;
  if (command == "MI" && index == find_me) return telegram(session_, t, 'A', 'I', indexed(t, {0}));
  if (command != "MI" || index != 176) return telegram(session_, t, 'F', 'A', {2, 0});
  return telegram(session_, t, 'A', 'I', indexed(t, {change(t.from(20))}));
}

std::uint8_t SafetySettings::change(ByteView a) {
  if (refuse_with != 0) return refuse_with;
  if (a.size() != 28 || (a.le16(24) & ~0x1fU) != 0) return 6;
  if (ignore_changes) return 0;
  current.enabled = a.u8(4) != 0;
  current.interface = a.u8(5);
  current.host = IpAddress::v4(a.u8(11), a.u8(10), a.u8(9), a.u8(8));
  current.port = a.le16(12);
  current.every = a.le16(14);
  current.start = a.le32s(16);
  current.end = a.le32s(20);
  current.features = a.le16(24);
  return 0;
}

Bytes SafetySettings::variable(std::uint16_t index) const {
  // What lies before a first field is reserved for contour data, and empty here.
  constexpr std::uint16_t first_case = 2101, contour = 0x2710, first_field = 0x2711, first_geometry = 0x2811;
  const auto number_from = [index](std::uint16_t first) { return static_cast<std::size_t>(index - first); };
  if (index >= first_geometry)
    return geometry(number_from(first_geometry) < fields.size() ? derived.beams : 0U);
  if (index >= first_field) {
    const std::size_t number = number_from(first_field);
    return number < fields.size() ? field(fields[number]) : Bytes(88);
  }
  if (index == contour) return Bytes(88);
  if (index >= first_case) {
    const std::size_t number = number_from(first_case);
    if (number >= cases.size()) return Bytes(200);
    const auto entry = std::next(cases.begin(), static_cast<std::ptrdiff_t>(number));
    return monitoring_case(entry->first, entry->second);
  }
  return fixed_variable(index);
}

Bytes SafetySettings::fixed_variable(std::uint16_t index) const {
  switch (index) {
    case 3:
      return text(serial);
    case 4:
      return text(firmware);
    case 13:
      return text(type_code);
    case 14:
      return text(order_number);
    case 15:
      return {device_status};
    case 16:
      return {static_cast<std::uint8_t>(user_action), static_cast<std::uint8_t>(user_action >> 8U)};
    case 17:
      return text(device_name);
    case 18:
      return text(project_name);
    case 23:
      return status_overview(power_cycles);
    case 28:
      return metadata();
    case 33:
      return versioned_text(application_name);
    case 35:
      return versioned_text(user_name);
    case 177:
      return output_variable(persistent);
    case 178:
      return current_variable(current, derived);
    case 179:
      return latest;
    case 1003:
      return field_sets("Set 1");
    case 2100:
      return Bytes(88);  // a header of the table of cases that the vendor's client does not read
    default:
      return {};
  }
}

}  // namespace lidard::sim
