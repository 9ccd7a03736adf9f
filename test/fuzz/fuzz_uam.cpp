// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a UAM-05LP sends: the first byte chooses the model and whether a connection stands, the rest is cut
// into chunks, each behind a length (16 bit). With its highest bit the chunk is put into a frame with the
// right length and checksum, so that what is inside of frames is reached.
#include <cstdlib>
#include <string>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/sim/devices/uam_device.h"

namespace {

class Checker final : public lidard::FrameReceiver {
 public:
  void scan(lidard::PlanarScan& scan) override {
    if (lidard::violation(scan) != nullptr) std::abort();
    if (beams != 0 && scan.beams != beams) std::abort();
    beams = scan.beams;
  }
  void cloud(lidard::Cloud&) override { std::abort(); }
  std::size_t beams = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  if (size == 0) return 0;
  static const Model* const all[] = {find_model("hokuyo_uam_05lp"), find_model("hokuyo_uam_05lp_intensity"),
                                     find_model("hokuyo_uam_05lp_fine")};
  const ByteView input(data, size);
  DriverConfig config;
  config.model = all[input.u8(0) % 3U];
  const auto driver = config.model->make(config);
  Checker out;
  Packet packet;
  packet.transport = Transport::tcp;
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  if ((input.u8(0) & 128U) != 0) driver->connected(packet.arrival, out);
  std::size_t at = 1;
  while (input.has(at, 2)) {
    const std::size_t length = input.le16(at) & 0x7fffU;
    const bool framed = (input.le16(at) & 0x8000U) != 0;
    at += 2;
    const ByteView chunk = input.sub(at, length < size - at ? length : size - at);
    at += chunk.size();
    std::string text(chunk.text());
    if (framed) text = sim::uam_frame(text);
    packet.payload = ByteView(text);
    packet.arrival = packet.arrival + std::chrono::milliseconds(30);
    static_cast<void>(driver->receive(packet, out));
    driver->tick(packet.arrival, out);
  }
  return 0;
}
