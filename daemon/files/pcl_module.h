// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "core/frames/cloud.h"

/// Writes a PCD file (binary_compressed, fields x y z intensity ring time); false if that failed. Not linked,
/// but found by name in the module.
extern "C" bool lidard_write_pcd(const char* path, const lidard::CloudPoint* points, std::size_t count);
