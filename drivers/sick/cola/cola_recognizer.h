// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "drivers/recognizer.h"
#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {

/// The model of a device that calls itself `identity` (DeviceIdent); empty if no known name is in it.
std::string_view cola_model_named(std::string_view identity);

/// What the scans of a sender say of it, beside its name.
struct ColaEvidence {
  double start_deg = 0, end_deg = 0, step_deg = 0;  ///< as the device counts
  double hz = 0;                                    ///< scans per second
  double scale_mm = 1;                              ///< of one step of a distance
  double farthest_m = 0;                            ///< of all scans so far
};

/// Recognises scanners that speak CoLa in the bytes of one sender. The model follows from what the device
/// calls itself (DeviceIdent), else from angles, rates and distances of its scans; where they fit several
/// families, others() names those that were not chosen.
class ColaRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override;
  std::string_view verdict() const override { return verdict_; }
  std::vector<std::string_view> others() const override { return others_; }

 private:
  void look_at(const ColaTelegram& telegram);
  void note_identity(std::string_view identity);
  void choose();

  Counters counters_;
  ColaStream stream_{counters_};
  ColaScan scan_;
  ColaEvidence seen_;
  std::string_view verdict_;
  std::vector<std::string_view> others_;
  bool named_ = false;    // by the device itself
  bool layered_ = false;  // planes other than the horizontal one came
};

}  // namespace lidard::sick
