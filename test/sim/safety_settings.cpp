// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/safety_settings.h"

#include "test/sim/wire.h"

namespace lidard::sim {
namespace {

using Bytes = SafetySettings::Bytes;

Bytes text(const std::string& words) {
  Bytes out = {static_cast<std::uint8_t>(words.size()), static_cast<std::uint8_t>(words.size() >> 8U)};
  out.insert(out.end(), words.begin(), words.end());
  return out;
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
  Bytes out = {request.u8(18), request.u8(19)};
  out.insert(out.end(), data.begin(), data.end());
  return out;
}

Bytes field(const std::string& name) {
  Wire wire(88);
  put_version(wire);
  wire.put8(72, 1);
  wire.put8(73, 4);
  wire.put16(82, 1);
  wire.put32(84, name.size());
  Bytes out = wire.bytes();
  out.insert(out.end(), name.begin(), name.end());
  return out;
}

Bytes monitoring_case(std::uint16_t number, const std::vector<std::uint16_t>& fields) {
  Wire wire(200);
  put_version(wire);
  wire.put16(6, number);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    wire.put8(157 + 4 * i, 1);
    wire.put16(158 + 4 * i, fields[i]);
  }
  return wire.bytes();
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
    const Bytes value = variable(index);
    return value.empty() ? telegram(session_, t, 'F', 'A', {3, 0})
                         : telegram(session_, t, 'R', 'A', indexed(t, value));
  }
  heard.push_back("call " + std::to_string(index));
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
  current.features = a.le16(24);
  return 0;
}

Bytes SafetySettings::variable(std::uint16_t index) const {
  switch (index) {
    case 3:
      return text(serial);
    case 4:
      return text(firmware);
    case 13:
      return text(type_code);
    case 16:
      return {static_cast<std::uint8_t>(user_action), static_cast<std::uint8_t>(user_action >> 8U)};
    case 17:
      return text(device_name);
    case 18:
    case 33:
      return text("yard");
    default:
      break;
  }
  Wire wire(60);
  put_version(wire);
  if (index == 23) {
    wire.put32(12, 42);
    return wire.bytes();
  }
  if (index == 177 || index == 178) {
    put_output(wire, index == 177 ? persistent : current);
    return wire.bytes();
  }
  const std::size_t number = index - (index >= 0x2710 ? 0x2710U : 2101U);
  if (index >= 0x2710) return number < fields.size() ? field(fields[number]) : Wire(88).bytes();
  if (index < 2101) return {};
  auto entry = cases.begin();
  if (number >= cases.size()) return Wire(200).bytes();
  std::advance(entry, number);
  return monitoring_case(entry->first, entry->second);
}

}  // namespace lidard::sim
