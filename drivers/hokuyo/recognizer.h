// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "drivers/hokuyo/scip_message.h"
#include "drivers/hokuyo/uam_frame.h"
#include "drivers/recognizer.h"

namespace lidard::hokuyo {

/// Finds out whether a TCP stream is a Hokuyo's, and which one's.
class HokuyoRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override;
  /// Name of a model; empty while nothing fits, the generic SCIP model while distances came but no name.
  std::string_view verdict() const override { return name_; }
  /// While the sensor did not say its name: every one that speaks SCIP.
  std::vector<std::string_view> others() const override;

 private:
  void take(const ScipMessage& message);

  Counters ignored_;
  ScipReader scip_{ignored_};
  UamReader uam_{ignored_};
  std::uint64_t useless_bytes_ = 0;
  std::string_view name_;
};

}  // namespace lidard::hokuyo
