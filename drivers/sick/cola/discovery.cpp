// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <tinyxml2.h>

#include <algorithm>

#include "drivers/sick/cola/cola_models.h"

namespace lidard::sick {
namespace {

std::string question(std::uint32_t key, const IpAddress& own, const IpAddress& mask) {
  std::string bytes("\x10\0\0\x08\xff\xff\xff\xff\xff\xff", 10);
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(key >> shift & 0xffU);
  bytes += "\x01\x02";
  for (const IpAddress& address : {own, mask}) {
    for (std::size_t i = 0; i < 4; ++i) bytes += static_cast<char>(address.bytes[i]);
  }
  return bytes;
}

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

std::optional<FoundDevice> read_answer(ByteView datagram, const IpAddress& sender) {
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
  device.product = value_of(*root, "DeviceType");
  device.serial = value_of(*root, "SerialNumber");
  device.firmware = value_of(*root, "FirmwareVersion");
  // A device in another subnet also answers; its own address counts, not the router's.
  device.address = IpAddress::parse(value_of(*root, "IPAddress")).value_or(sender);
  device.model = cola_model_named(device.product);
  return device;
}

}  // namespace

const Discovery& discovery() {
  static const Discovery sick{"sick", "SICK", Transport::udp, 30718, "", question, read_answer};
  return sick;
}

}  // namespace lidard::sick
