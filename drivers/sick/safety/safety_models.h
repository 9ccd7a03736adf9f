// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/driver.h"
#include "drivers/recognizer.h"

namespace lidard {
class SideDialogue;
}

namespace lidard::sick {

/// Protocol properties of one safety scanner.
struct SafetyRow {
  double ahead_deg;  ///< device angle that points straight ahead, deg
};

/// Adds the SICK safety scanners to the table of models.
void append_safety_models(std::vector<Model>& list);

/// Recognizes the family. All products of the family send the same telegrams, and no known field names the
/// product (the type code is a variable of the TCP interface): the verdict is sick_microscan3, and only the
/// configuration can set another one. They differ in range_max and in nothing else.
std::unique_ptr<Recognizer> make_safety_recognizer();

/// True for a datagram of the safety scanners' data output ("MS3 MD").
bool is_ms3(ByteView payload);

/// Driver of the SICK safety scanners; `config.model` must be one of append_safety_models().
///
/// One driver reads one data output channel of one device: the first one received. Other channels are counted
/// in `other_packets` and named in a warning. The number of beams and their angles stay until the device
/// announces others, which gives a warning, too.
std::unique_ptr<Driver> make_safety_driver(const DriverConfig& config);

/// The settings of a safety scanner over TCP.
std::unique_ptr<SideDialogue> make_safety_dialogue(const DriverConfig& config);

}  // namespace lidard::sick
