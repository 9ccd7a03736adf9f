// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "drivers/driver.h"

namespace lidard::hokuyo {

/// Driver of the sensors that speak SCIP 2; `config.model` must be one of append_scip_models().
///
/// With a connection it asks for name, parameters and state, compares the clocks and starts an endless
/// stream; without one (a capture) it takes what passes by, from anywhere in the stream on.
std::unique_ptr<Driver> make_scip_driver(const DriverConfig& config);

}  // namespace lidard::hokuyo
