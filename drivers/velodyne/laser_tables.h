// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "drivers/velodyne/models.h"

namespace lidard::velodyne {

// Elevation (deg), rot_correction (deg), z offset (mm) of each laser in the order of the packet. The sign of
// rot_correction is that of the calibration files: it is subtracted from the azimuth.
extern const std::array<Laser, 16> vlp16_lasers;
extern const std::array<Laser, 16> hires_lasers;
extern const std::array<Laser, 32> vlp32a_lasers;
extern const std::array<Laser, 32> vlp32c_lasers;
extern const std::array<Laser, 32> hdl32e_lasers;
extern const std::array<Laser, 64> hdl64e_s1_lasers;
extern const std::array<Laser, 64> hdl64e_s21_lasers;
extern const std::array<Laser, 64> hdl64e_s3_lasers;
extern const std::array<Laser, 128> vls128_lasers;

}  // namespace lidard::velodyne
