// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "drivers/driver.h"

namespace lidard::sick {

/// Driver of the devices that send Compact or MSGPACK telegrams: picoScan100, multiScan100, LRS4000.
/// `config.model` must be one of append_compact_models().
std::unique_ptr<Driver> make_compact_driver(const DriverConfig& config);

}  // namespace lidard::sick
