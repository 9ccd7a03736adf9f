// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/models.h"

namespace lidard::velodyne {
void append_models(std::vector<Model>& list) { static_cast<void>(list); }
}  // namespace lidard::velodyne
