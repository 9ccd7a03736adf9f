// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any bytes as what the web server of a Velodyne answers, in any pieces: the dialogue goes on.
// Each connection gets some of the input; -max_len=8192.
#include <cstdlib>

#include "drivers/velodyne/web/web_dialogue.h"
#include "test/sim/servers/output_check.h"
#include "test/support/random_bytes.h"

namespace {

using namespace lidard;

class Requests final : public FrameReceiver {
 public:
  void scan(PlanarScan&) override {}
  void cloud(Cloud&) override {}
  void connect() override { asked = true; }
  bool asked = false;
};

VelodyneControl wanted() {
  VelodyneControl control;
  control.allow_write = true;
  control.wanted.rpm = 600;
  control.wanted.returns = VelodyneReturns::dual;
  return control;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sim::Bytes in(data, size);
  velodyne::WebDialogue dialogue(wanted());
  Requests out;
  Stamp now{1'000'000'000};
  while (!in.empty()) {
    now = now + std::chrono::seconds(1 + in.below(70));
    out.asked = false;
    dialogue.tick(now, in.chance(128) ? std::optional<Stamp>(now) : std::nullopt, out);
    if (!out.asked) continue;
    dialogue.connected(now, out);
    for (std::size_t pieces = in.below(4); pieces > 0; --pieces) {
      std::vector<std::uint8_t> piece(in.below(600));
      for (std::uint8_t& byte : piece) byte = in.byte();
      dialogue.receive({{piece.data(), piece.size()}, now, {}, {}, Transport::tcp}, out);
    }
    dialogue.disconnected();
  }
  return 0;
}
