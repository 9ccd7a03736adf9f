// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "drivers/recognizer.h"

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

}  // namespace lidard::sick
