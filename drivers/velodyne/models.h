// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "drivers/model.h"

namespace lidard::velodyne {

/// Adds the Velodyne rows to the table of models.
void append_models(std::vector<Model>& list);

}  // namespace lidard::velodyne
