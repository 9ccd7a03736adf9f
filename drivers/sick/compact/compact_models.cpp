// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/compact_models.h"

#include "drivers/sick/compact/compact_driver.h"
#include "drivers/sick/compact/compact_telegram.h"
#include "drivers/sick/compact/msgpack_telegram.h"

namespace lidard::sick {
namespace {

// Ports of the launch files of SICKAG/sick_scan_xd (sick_picoscan.launch): scans, inertial unit, settings.
constexpr std::uint16_t scan_port = 2115, imu_port = 7503, sopas_port = 2111;

struct Product {
  const char* name;
  const char* product;
  FrameKind kind;
  double packets_per_s, frame_period;
  double range_min, range_max;
  std::size_t layers;
  const char* verified;
};

Model udp_model(const Product& p) {
  Model model{p.name,    "SICK",     p.product,       "Compact or MSGPACK", p.kind,      Transport::udp,
              scan_port, imu_port,   p.packets_per_s, p.frame_period,       p.range_min, p.range_max,
              p.layers,  p.verified, nullptr,         make_compact_driver};
  model.messages = {message_topic<ImuSample>()};
  model.telemetry_is_imu = true;
  model.has_echoes = p.kind == FrameKind::scan;
  model.dialogue_port = sopas_port;
  if (p.kind == FrameKind::scan) {
    model.messages.push_back(message_topic<DeviceState>("encoder"));
    model.extra_scans = {"reflectors"};
  }
  return model;
}

Model lrs4000() {
  Model model{"sick_lrs4000",
              "SICK",
              "LRS4000",
              "Compact over TCP",
              FrameKind::scan,
              Transport::tcp,
              scan_port,
              0,
              50,
              0.04,
              0.05,
              130,
              1,
              "three telegrams of an LRS4581; no capture of a connection",
              nullptr,
              make_compact_driver};
  model.extra_scans = {"reflectors"};
  return model;
}

}  // namespace

// Largest ranges: sick_scan_xd's table of devices for the LRS4000; those of the others and all smallest ones
// are unverified and generous, since a limit too near would make a wall look like nothing. Rates: 20 turns/s
// of 12 segments (multiScan100); up to 50 turns/s of 5, or 25 of 10 (picoScan100); inertial unit 100 Hz.
void append_compact_models(std::vector<Model>& list) {
  const char* pico = "1 capture and three telegrams of a device, Compact 4; the simulator";
  list.push_back(
      udp_model({"sick_picoscan150", "picoScan150", FrameKind::scan, 400, 0.05, 0.05, 120, 1, pico}));
  list.push_back(udp_model({"sick_picoscan120", "picoScan120", FrameKind::scan, 400, 0.05, 0.05, 120, 1,
                            "the simulator; sends what a picoScan150 sends"}));
  list.push_back(udp_model({"sick_multiscan136", "multiScan136", FrameKind::cloud, 400, 0.05, 0.05, 120, 16,
                            "captures of a device, Compact and MSGPACK, with inertial unit"}));
  list.push_back(udp_model({"sick_multiscan165", "multiScan165", FrameKind::cloud, 400, 0.05, 0.05, 120, 16,
                            "no capture of a device; sends what a multiScan136 sends"}));
  list.push_back(udp_model({"sick_multiscan166", "multiScan166", FrameKind::cloud, 400, 0.05, 0.05, 120, 16,
                            "no capture of a device; sends what a multiScan136 sends"}));
  list.push_back(lrs4000());
}

void CompactRecognizer::judge(ByteView telegram, TelegramType type, Transport transport) {
  auto segment = std::make_unique<Segment>();
  Reject reason = Reject::magic;
  if (type == TelegramType::msgpack) reason = parse_msgpack(telegram, *segment);
  if (type == TelegramType::scan) reason = parse_compact_scan(telegram, *segment);
  if (reason != Reject::none) return;
  if (transport == Transport::tcp)
    verdict_ = "sick_lrs4000";
  else
    verdict_ = segment->line_count > 1 ? "sick_multiscan136" : "sick_picoscan150";
}

void CompactRecognizer::add(const Packet& packet) {
  if (!verdict_.empty()) return;
  if (packet.transport == Transport::tcp) {
    if (packet.stream_start || packet.missing > 0) stream_.cut(counters_);
    static_cast<void>(stream_.feed(packet.payload, counters_, [&](ByteView telegram, TelegramType type) {
      judge(telegram, type, packet.transport);
    }));
    return;
  }
  const TelegramHead head = read_head(packet.payload);
  if (head.reject != Reject::none || head.length == 0 || head.length > packet.payload.size()) return;
  const ByteView telegram = packet.payload.sub(0, head.length);
  if (checksum_is_right(telegram, head.type)) judge(telegram, head.type, packet.transport);
}

}  // namespace lidard::sick
