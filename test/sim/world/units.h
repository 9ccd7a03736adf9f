// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "core/base/angle.h"
#include "core/base/time.h"

/// What tests count with.
namespace lidard {

constexpr double degree = rad_per_deg;  ///< rad
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr Stamp t0{1'767'225'600'000'000'000};  ///< 2026-01-01 00:00 UTC
constexpr Span ms(double count) { return span_from_seconds(count / 1000); }

}  // namespace lidard
