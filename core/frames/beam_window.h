// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

namespace lidard {

/// Neighbouring beams of a scan.
struct BeamWindow {
  std::size_t first = 0;
  std::size_t count = 0;
};

/// Which of `beams` beams, the first at `angle` and each `step` further (rad), lie between two limits. Limits
/// are rounded where they come from: a beam on one of them is inside.
BeamWindow beams_between(double angle, double step, std::size_t beams, std::optional<double> lowest,
                         std::optional<double> highest);

}  // namespace lidard
