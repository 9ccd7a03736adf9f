// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "drivers/driver.h"
#include "drivers/recognizer.h"

namespace lidard {
class SideDialogue;
}

namespace lidard::sick {

/// Adds picoScan100, multiScan100 and LRS4000 to the table of models.
void append_compact_models(std::vector<Model>& list);

/// Recognizes the family. The telegrams do not name the product: one layer is recognized as picoScan150 (over
/// TCP as LRS4000), several as multiScan136. Only the configuration can select a related model with another
/// range.
std::unique_ptr<Recognizer> make_compact_recognizer();

/// Driver of the devices that send Compact or MSGPACK telegrams: picoScan100, multiScan100, LRS4000.
/// `config.model` must be one of append_compact_models().
std::unique_ptr<Driver> make_compact_driver(const DriverConfig& config);

/// The settings of a picoScan100 or multiScan100 over TCP.
std::unique_ptr<SideDialogue> make_sopas_dialogue(const DriverConfig& config);

}  // namespace lidard::sick
