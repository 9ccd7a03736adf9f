// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/models.h"
#include "drivers/hokuyo/scip_message.h"

namespace lidard::hokuyo {
namespace {

std::string question(std::uint32_t /*key*/, const IpAddress& /*own*/, const IpAddress& /*mask*/) {
  return "VV\n";
}

std::optional<FoundDevice> read_answer(ByteView stream, const IpAddress& sender) {
  Counters ignored;
  ScipReader reader(ignored);
  reader.add(stream);
  for (ScipMessage message; reader.next(message);) {
    if (message.echo != "VV" || message.status != "00") continue;
    FoundDevice device;
    device.address = sender;
    for_each_entry(message.body, [&](std::string_view key, std::string_view value, bool) {
      if (key == "PROD") device.product = value;
      if (key == "FIRM") device.firmware = value;
      if (key == "SERI") device.serial = value;
    });
    device.model = scip_name_of(device.product);
    return device;
  }
  return std::nullopt;
}

}  // namespace

const Discovery& discovery() {
  static const Discovery hokuyo{"hokuyo",       "Hokuyo", Transport::tcp, 10940,
                                "192.168.0.10", question, read_answer};
  return hokuyo;
}

}  // namespace lidard::hokuyo
