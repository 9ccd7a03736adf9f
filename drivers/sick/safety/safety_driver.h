// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "drivers/driver.h"

namespace lidard::sick {

/// Driver of the SICK safety scanners; `config.model` must be one of append_safety_models().
///
/// One driver serves one data output channel of one device: the first it hears. Other channels are counted
/// in `other_packets` and named in a warning. The number of beams and their angles stay as they are until the
/// device announces other ones; that is a warning, too.
std::unique_ptr<Driver> make_safety_driver(const DriverConfig& config);

}  // namespace lidard::sick
