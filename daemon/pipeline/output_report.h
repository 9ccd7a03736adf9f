// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "drivers/model.h"

namespace lidard {

/// What came out on one topic, or into one file.
struct OutputReport {
  std::string name;
  std::uint64_t messages = 0;
  Stamp first{}, last{};  ///< when the first and the last one were released
  bool promised = true;   ///< false: it depends on what the device has to tell
  std::string remark;     ///< why there is none, or what was missing

  void count(Stamp released);
  /// Messages per second; 0: fewer than two.
  double rate() const;
};

/// Why a driver that got packets over a time of `span` gave no whole frame: "only about 0.4 of a frame: …".
std::string why_no_frame(const Model& model, const Counters& counters, Span span);
/// The table of outputs: a row for each that was promised or came, and one line for the others.
void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out);
/// False if an output that was promised never came.
bool all_came(const std::vector<OutputReport>& outputs);

}  // namespace lidard
