// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety_models.h"

namespace lidard::sick {
void append_safety_models(std::vector<Model>& list) { static_cast<void>(list); }
}  // namespace lidard::sick
