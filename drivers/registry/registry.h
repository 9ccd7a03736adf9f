// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <string_view>
#include <vector>

#include "drivers/recognizer.h"

namespace lidard {

/// Every family that is known.
const std::vector<Family>& families();
/// All supported models, in the order of the documentation. A model keeps its address.
const std::deque<Model>& models();
/// The model of that name, or nullptr.
const Model* find_model(std::string_view name);
/// Appends a family of an external driver. Every command knows its models from then on. Call it before other
/// threads start. Throws std::invalid_argument, and changes nothing, if a name is in use or a model has no
/// driver.
void register_family(const Family& family);

}  // namespace lidard
