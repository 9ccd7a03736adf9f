// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "drivers/driver.h"

namespace lidard::sick {

/// The driver of every scanner that speaks CoLa A or B; config.model->row is a ColaRow.
std::unique_ptr<Driver> make_cola_driver(const DriverConfig& config);

}  // namespace lidard::sick
