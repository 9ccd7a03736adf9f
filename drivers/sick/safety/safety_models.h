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

/// What the protocol needs to know of one safety scanner.
struct SafetyRow {
  double ahead_deg;  ///< device angle that points straight ahead, deg
};

/// Adds the SICK safety scanners to the table of models.
void append_safety_models(std::vector<Model>& list);

/// Recognizes the family. All products of the family send the same telegrams, and none of the fields known to
/// us names the product (the type code is a variable of the TCP interface): a verdict is sick_microscan3, and
/// only the configuration can say that it is another one. They differ in range_max and in nothing else.
std::unique_ptr<Recognizer> make_safety_recognizer();

/// True for a datagram of the safety scanners' data output ("MS3 MD").
bool looks_like_ms3(ByteView payload);

/// Driver of the SICK safety scanners; `config.model` must be one of append_safety_models().
///
/// One driver serves one data output channel of one device: the first it hears. Other channels are counted
/// in `other_packets` and named in a warning. The number of beams and their angles stay as they are until the
/// device announces other ones; that is a warning, too.
std::unique_ptr<Driver> make_safety_driver(const DriverConfig& config);

/// The settings of a safety scanner over TCP.
std::unique_ptr<SideDialogue> make_safety_dialogue(const DriverConfig& config);

}  // namespace lidard::sick
