// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"

namespace lidard {

/// The host's time: the scale of the stamps of what arrives.
inline Stamp wall_clock() {
  return {std::chrono::duration_cast<Span>(std::chrono::system_clock::now().time_since_epoch()).count()};
}

}  // namespace lidard
