// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "drivers/capture/pcap_source.h"

namespace lidard::sim {

/// The datagrams of a capture in memory, to be sent again and again as one stream without an end: the times
/// go on, and so do the stamps inside Velodyne's data packets. Those of other devices begin anew.
class Repeater {
 public:
  /// Reads the whole capture.
  explicit Repeater(PcapSource& capture);

  /// All datagrams, `times` times.
  void play(std::uint64_t times, const std::function<void(const Packet&)>& use);
  std::size_t packets() const { return packets_.size(); }
  /// From one turn to the next: the time of the flow with most packets and one more mean step, in whole
  /// microseconds.
  Span period() const { return period_; }

 private:
  struct Recorded {
    std::vector<std::uint8_t> payload;
    Stamp arrival;
    Endpoint from, to;
  };
  std::vector<Recorded> packets_;
  Span period_{0};
};

}  // namespace lidard::sim
