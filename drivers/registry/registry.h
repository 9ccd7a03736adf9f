// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "drivers/recognizer.h"

namespace lidard {

/// Every family that is known.
const std::vector<Family>& families();
/// All supported models, in the order of the documentation.
const std::vector<Model>& models();
/// The model of that name, or nullptr.
const Model* find_model(std::string_view name);

}  // namespace lidard
