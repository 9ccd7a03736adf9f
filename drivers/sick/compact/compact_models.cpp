// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/compact_models.h"

#include "core/base/angle.h"
#include "drivers/sick/compact/compact_telegram.h"

namespace lidard::sick {
namespace {

Model compact_model(const char* name, const char* product, const char* protocol, const char* verified) {
  Model model{name, "SICK", product, protocol, verified};
  model.port = 2115;
  model.frame_period = 0.05;
  model.range_min = 0.05;
  model.range_max = 120;
  model.beams = 1;
  model.make = make_compact_driver;
  return model;
}

/// Ports of the launch files of SICKAG/sick_scan_xd (sick_picoscan.launch): scans, inertial unit, settings.
Model udp_model(const char* name, const char* product, const char* verified) {
  Model model = compact_model(name, product, "Compact or MSGPACK", verified);
  model.telemetry_port = 7503;
  model.dialogue_port = 2111;
  model.packets_per_s = 400;
  model.messages = {message_topic<ImuSample>()};
  model.traits = {Trait::settings_writable, Trait::receiver_settable, Trait::logins};
  return model;
}

Model picoscan(const char* name, const char* product, const char* verified) {
  Model model = udp_model(name, product, verified);
  model.field = {-138, 0.5, 553};  // 276 deg (SICK's developer guide)
  model.traits.add(Trait::echoes);
  model.messages.push_back(message_topic<DeviceState>("encoder"));
  model.extra_scans = {"reflectors"};
  return model;
}

Model multiscan(const char* name, const char* product, const char* verified) {
  Model model = udp_model(name, product, verified);
  model.kind = FrameKind::cloud;
  model.beams = 16;
  // The elevations of a recorded multiScan136; two of its layers have eight times as many beams.
  model.field = {-180,
                 1,
                 360,
                 {-42.93, -37.34, -35.04, -32.24, -27.3, -22.54, -17.9, -13.6, -6.87, -2.07, 0.05, 2.53, 7.52,
                  12.32, 17.27, 22.31}};
  model.fragments_per_packet = 17;  // a telegram of a multiScan136 is one datagram of up to 24 kB
  return model;
}

Model lrs4000() {
  Model model = compact_model("sick_lrs4000", "LRS4000", "Compact over TCP",
                              "three telegrams of an LRS4581; no capture of a connection");
  model.transport = Transport::tcp;
  model.packets_per_s = 50;
  model.frame_period = 0.04;
  model.range_max = 130;
  model.field = {-180, 0.05, 7200};  // sick_scan_xd's table of devices
  model.extra_scans = {"reflectors"};
  return model;
}

}  // namespace

// Largest ranges: sick_scan_xd's table of devices for the LRS4000; all other limits are unverified and
// generous, since a limit that is too small would hide a wall. Rates: 20 turns/s of 12 segments
// (multiScan100); up to 50 turns/s of 5, or 25 of 10 (picoScan100); inertial unit 100 Hz.
void append_compact_models(std::vector<Model>& list) {
  const char* sister = "no capture of a device; same telegrams as multiScan136";
  list.push_back(picoscan("sick_picoscan150", "picoScan150",
                          "1 capture and three telegrams of a device, Compact 4; the simulator"));
  // PICS150-01000 Pro-1, as others quote SICK; those of the other versions and models are not known.
  list.back().dark_range = 40;
  list.push_back(picoscan("sick_picoscan120", "picoScan120", "the simulator; same telegrams as picoScan150"));
  list.push_back(multiscan("sick_multiscan136", "multiScan136",
                           "captures of a device, Compact and MSGPACK, with inertial unit"));
  list.push_back(multiscan("sick_multiscan165", "multiScan165", sister));
  list.push_back(multiscan("sick_multiscan166", "multiScan166", sister));
  list.push_back(lrs4000());
}

namespace {

class CompactRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override {
    if (!verdict_.empty()) return;
    if (packet.transport == Transport::tcp) {
      if (packet.stream_start || packet.missing > 0) stream_.interrupt();
      stream_.add(packet.payload);
      for (Telegram telegram; stream_.next(telegram);) judge(telegram, packet.transport);
      return;
    }
    const TelegramHead head = read_head(packet.payload);
    if (head.reject != Reject::none || head.length == 0 || head.length > packet.payload.size()) return;
    const ByteView telegram = packet.payload.sub(0, head.length);
    if (checksum_is_right(telegram, head.type)) judge({telegram, head.type}, packet.transport);
  }

  std::string_view verdict() const override { return verdict_; }
  std::vector<std::string_view> others() const override {
    return names_of(append_compact_models, [this](const Model& model) {
      return model.kind == kind_ && model.transport == transport_;
    });
  }

 private:
  void judge(const Telegram& telegram, Transport transport) {
    auto segment = std::make_unique<Segment>();
    if (parse_scan(telegram, *segment) != Reject::none) return;
    transport_ = transport;
    kind_ = transport == Transport::udp && segment->line_count > 1 ? FrameKind::cloud : FrameKind::scan;
    verdict_ = transport == Transport::tcp ? "sick_lrs4000"
               : kind_ == FrameKind::cloud ? "sick_multiscan136"
                                           : "sick_picoscan150";
  }

  Counters counters_;
  TelegramStream stream_{counters_};
  std::string_view verdict_;
  FrameKind kind_ = FrameKind::scan;
  Transport transport_ = Transport::udp;
};

}  // namespace

std::unique_ptr<Recognizer> make_compact_recognizer() { return std::make_unique<CompactRecognizer>(); }

}  // namespace lidard::sick
