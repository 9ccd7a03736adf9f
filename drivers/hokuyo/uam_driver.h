// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "drivers/driver.h"

namespace lidard::hokuyo {

/// Adds the UAM-05LP safety scanners, read by their AR protocol: scan and state come in the same frame.
void append_uam_models(std::vector<Model>& list);

/// Driver of those; `config.model` must be one of append_uam_models().
std::unique_ptr<Driver> make_uam_driver(const DriverConfig& config);

}  // namespace lidard::hokuyo
