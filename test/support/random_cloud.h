// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "core/virtual/virtualizer.h"

namespace lidard::sim {

/// Reads virtual frames, settings, clouds of changing layouts and poses out of bytes and makes virtual scans
/// of them. Returns the number of scans; 0 also if the bytes are too few. Aborts if a scan breaks an
/// invariant. `look` is shown each of them, with the profile.
std::size_t virtualize_bytes(const std::uint8_t* data, std::size_t size,
                             const std::function<void(const VirtualScan&, const Virtualizer&)>& look = {});

}  // namespace lidard::sim
