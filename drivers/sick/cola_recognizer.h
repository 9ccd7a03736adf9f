// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "drivers/driver.h"
#include "drivers/sick/cola_scan.h"

namespace lidard::sick {

/// The model of a device that calls itself `identity` (DeviceIdent); empty if no known name is in it.
std::string_view cola_model_named(std::string_view identity);

/// Recognises scanners that speak CoLa in the bytes of one sender. The model follows from what the device
/// calls itself (DeviceIdent), else from the shape of its scans, which families share: remark() then says so.
class ColaRecognizer {
 public:
  void add(const Packet& packet);
  /// Name of the model; empty while nothing fits.
  std::string_view verdict() const { return verdict_; }
  std::string remark() const;

 private:
  void look_at(const ColaTelegram& telegram);
  void note_identity(std::string_view identity);

  Counters counters_;
  ColaStream stream_{counters_};
  ColaScan scan_;
  std::string_view verdict_;
  bool named_ = false;    // by the device itself
  bool layered_ = false;  // planes other than the horizontal one came
};

}  // namespace lidard::sick
