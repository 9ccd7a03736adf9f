// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <tinyxml2.h>

#include <algorithm>

#include "daemon/commands/discover.h"
#include "drivers/hokuyo/scip_message.h"
#include "drivers/hokuyo/scip_models.h"

namespace lidard {
namespace {

/// The value of `key` in an answer: <Item key="K" value="V"/>, <K>V</K> or an attribute of the root.
std::string value_of(const tinyxml2::XMLElement& root, const char* key) {
  for (const auto* item = root.FirstChildElement(); item != nullptr; item = item->NextSiblingElement()) {
    const char* name = item->Attribute("key");
    const char* value = item->Attribute("value");
    if (name != nullptr && value != nullptr && std::string_view(name) == key) return value;
    if (std::string_view(item->Name()) == key && item->GetText() != nullptr) return item->GetText();
  }
  const char* attribute = root.Attribute(key);
  return attribute == nullptr ? "" : attribute;
}

}  // namespace

std::array<std::uint8_t, 24> sick_search(std::uint32_t key, const IpAddress& own, const IpAddress& mask) {
  std::array<std::uint8_t, 24> bytes{0x10, 0, 0, 0x08, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[10 + i] = static_cast<std::uint8_t>(key >> (24 - 8 * i) & 0xffU);
    bytes[16 + i] = own.bytes[i];
    bytes[20 + i] = mask.bytes[i];
  }
  bytes[14] = 0x01;
  bytes[15] = 0x02;
  return bytes;
}

std::optional<FoundDevice> read_sick_answer(ByteView datagram, const IpAddress& sender) {
  const std::string_view text = datagram.text();
  const std::size_t begin = std::min(text.find("<?xml"), text.find("<NetScanResult"));
  if (begin == std::string_view::npos) return std::nullopt;
  const std::size_t end = text.rfind('>');
  if (end == std::string_view::npos || end < begin) return std::nullopt;
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data() + begin, end - begin + 1) != tinyxml2::XML_SUCCESS) return std::nullopt;
  const auto* root = document.FirstChildElement("NetScanResult");
  if (root == nullptr) return std::nullopt;
  FoundDevice device;
  device.vendor = "SICK";
  device.product = value_of(*root, "DeviceType");
  device.serial = value_of(*root, "SerialNumber");
  device.firmware = value_of(*root, "FirmwareVersion");
  // A device in another subnet answers, too: its own address counts, not the router's.
  device.address = IpAddress::parse(value_of(*root, "IPAddress")).value_or(sender);
  return device;
}

std::optional<FoundDevice> read_hokuyo_answer(ByteView stream, const IpAddress& sender) {
  Counters ignored;
  hokuyo::ScipReader reader(ignored);
  reader.add(stream);
  for (hokuyo::ScipMessage message; reader.next(message);) {
    if (message.echo != "VV" || message.status != "00") continue;
    FoundDevice device;
    device.vendor = "Hokuyo";
    device.address = sender;
    hokuyo::for_each_entry(message.body, [&](std::string_view key, std::string_view value, bool) {
      if (key == "PROD") device.product = value;
      if (key == "FIRM") device.firmware = value;
      if (key == "SERI") device.serial = value;
    });
    device.model = hokuyo::scip_name_of(device.product);
    return device;
  }
  return std::nullopt;
}

}  // namespace lidard
