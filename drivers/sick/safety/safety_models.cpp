// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/safety_models.h"

#include "core/base/angle.h"
#include "drivers/sick/safety/ms3_telegram.h"
#include "drivers/sick/safety/safety_status.h"

namespace lidard::sick {
namespace {

// 0 deg is right of the device, counter-clockwise (SICK 8022708 p. 15).
constexpr SafetyRow safety_row = {90};

Model scanner(const char* name, const char* product, double frame_period, double range_max,
              const char* verified) {
  Model model{name, "SICK", product, "MS3 MD", verified};
  // The port is chosen in Safety Designer; 6060 is what most examples for these devices use.
  model.port = 6060;
  model.dialogue_port = 2122;  // CoLa 2 (SICK 8022708 p. 28)
  // 2751 beams (275 deg in steps of 0.1 deg) with all blocks are 14 datagrams, each 40 ms. Unverified.
  model.packets_per_s = 350;
  model.frame_period = frame_period;
  model.range_min = 0.1;  // as sick_safetyscanners has it; unverified
  model.range_max = range_max;
  // 275 deg (data sheets of the three products); the step is that of a cycle of 30 ms, unverified.
  model.field = {-137.5, 0.39, 706};
  // CoLa 2 needs no login for what concerns the data output.
  model.traits = {Trait::settings_writable, Trait::receiver_settable, Trait::states_on_request,
                  Trait::output_paths};
  model.messages = {message_topic<DeviceState>(safety_topic::system_state),
                    message_topic<DeviceState>(output_paths_topic)};
  model.extra_scans = {safety_topic::intrusion, beam_status_scan};
  model.row = &safety_row;
  model.make = make_safety_driver;
  return model;
}

class SafetyRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override {
    found_ = found_ || (packet.transport == Transport::udp && is_ms3(packet.payload));
  }
  std::string_view verdict() const override { return found_ ? "sick_microscan3" : ""; }
  std::vector<std::string_view> others() const override {
    return names_of(append_safety_models, [](const Model&) { return true; });
  }

 private:
  bool found_ = false;
};

}  // namespace

// Ranges by type code, as sick_safetyscanners_base derives them: ..30.., ..40.., ..55.. are 40 m, ..90.. is
// 64 m. Scan cycle times: microScan3 30 or 40 ms, the others unverified.
void append_safety_models(std::vector<Model>& list) {
  const char* recorded =
      "1 capture and the telegrams printed in SICK 8022708; two flags of its beams are unknown";
  const char* printed = "no capture of a device; sends what a microScan3 sends";
  list.push_back(scanner("sick_microscan3", "microScan3", 0.03, 40, recorded));
  list.push_back(scanner("sick_microscan3_9m", "microScan3 9.0 m", 0.04, 64, printed));
  list.push_back(scanner("sick_nanoscan3", "nanoScan3", 0.03, 40, printed));
  list.push_back(scanner("sick_outdoorscan3", "outdoorScan3", 0.04, 40, printed));
}

std::unique_ptr<Recognizer> make_safety_recognizer() { return std::make_unique<SafetyRecognizer>(); }

bool is_ms3(ByteView payload) {
  Ms3Datagram datagram;
  return read_ms3_datagram(payload, datagram) == Reject::none;
}

}  // namespace lidard::sick
