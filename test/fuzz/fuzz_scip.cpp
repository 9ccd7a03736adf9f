// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a SCIP sensor sends: the first byte chooses model and wishes and whether a connection stands; the rest
// is cut into chunks, each behind a length (16 bit) whose highest bit means a hole before it. A scan that
// breaks an invariant, or a number of beams that changes without a warning, is a finding.
#include <cstdlib>

#include "drivers/hokuyo/models.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace {

class Checker final : public lidard::FrameReceiver {
 public:
  void scan(lidard::PlanarScan& scan) override {
    if (lidard::violation(scan) != nullptr) std::abort();
    if (beams != 0 && scan.beams != beams) changed = true;
    beams = scan.beams;
  }
  void cloud(lidard::Cloud&) override { std::abort(); }

  std::size_t beams = 0;
  bool changed = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  if (size == 0) return 0;
  static const Model* const all[] = {find_model("hokuyo_ust_10lx"), find_model("hokuyo_utm_30lx_ew"),
                                     find_model("hokuyo_scip"), find_model("hokuyo_uxm_30lx_ew")};
  const ByteView input(data, size);
  const unsigned wishes = input.u8(0);
  DriverConfig config;
  config.model = all[wishes & 3U];
  config.publish_multiecho = (wishes & 4U) != 0;
  config.publish_intensity = (wishes & 8U) != 0;
  if ((wishes & 16U) != 0) config.angle_min = -0.5;
  const auto driver = config.model->make(config);
  Checker out;
  Packet packet;
  packet.transport = Transport::tcp;
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  if ((wishes & 32U) != 0) driver->connected(packet.arrival, out);
  const auto recognizer = hokuyo::make_recognizer();
  std::size_t at = 1;
  while (input.has(at, 2)) {
    const std::size_t length = input.le16(at) & 0x7fffU;
    packet.missing = (input.le16(at) & 0x8000U) != 0 ? 1 : 0;
    at += 2;
    packet.payload = input.sub(at, length < size - at ? length : size - at);
    at += packet.payload.size();
    packet.arrival = packet.arrival + std::chrono::milliseconds(25);
    recognizer->add(packet);
    static_cast<void>(driver->receive(packet, out));
    driver->tick(packet.arrival, out);
  }
  if (out.changed && driver->info().warnings.empty()) std::abort();
  return 0;
}
