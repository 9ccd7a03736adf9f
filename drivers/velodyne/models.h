// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "drivers/recognizer.h"

namespace lidard::velodyne {

/// Adds the Velodyne rows to the table of models.
void append_models(std::vector<Model>& list);
std::unique_ptr<Recognizer> make_recognizer();

}  // namespace lidard::velodyne
