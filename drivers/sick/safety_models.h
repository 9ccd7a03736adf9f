// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "drivers/model.h"

namespace lidard::sick {

/// Adds the SICK safety scanners to the table of models.
void append_safety_models(std::vector<Model>& list);

}  // namespace lidard::sick
