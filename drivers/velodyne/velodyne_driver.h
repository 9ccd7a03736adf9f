// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "drivers/driver.h"

namespace lidard::velodyne {

/// Driver of the spinning Velodynes; `config.model` must be one of velodyne::append_models().
///
/// Frames are cut per firing sequence: revolutions at `config.cut_angle` or in the sector that the sensor
/// leaves out, or pieces of `config.frame_duration`. A packet that comes one place too late is put back in
/// its place; one that comes twice is used once. The first and the last revolution of a stream are handed on
/// only with `keep_partial`.
std::unique_ptr<Driver> make_driver(const DriverConfig& config);

}  // namespace lidard::velodyne
