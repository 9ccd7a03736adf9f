// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/number_text.h"
#include "daemon/files/snapshot_chart.h"
#include "daemon/files/snapshot_view.h"

namespace lidard {

// Okabe and Ito's colours, which people with any colour vision can distinguish; roles differ in shape too.
constexpr std::array<Color, 6> input_colors = {{{0.00, 0.45, 0.70},
                                                {0.84, 0.37, 0.00},
                                                {0.80, 0.47, 0.65},
                                                {0.34, 0.71, 0.91},
                                                {0.55, 0.40, 0.10},
                                                {0.35, 0.25, 0.60}}};
constexpr std::array<Color, 3> merged_colors = {{{0, 0, 0}, {0.90, 0.62, 0.00}, {0.50, 0.50, 0.50}}};
constexpr std::array<Color, 4> virtual_colors = {
    {{0.84, 0.00, 0.45}, {0.45, 0.20, 0.55}, {0.75, 0.35, 0.00}, {0.10, 0.35, 0.35}}};
constexpr Color cloud_color{0.35, 0.35, 0.35};
constexpr Color free_color{0.86, 0.95, 0.89};
constexpr Color unobserved_color{0.91, 0.89, 0.87};
constexpr Color ink{0.13, 0.13, 0.13};
constexpr Color pale{0.45, 0.45, 0.45};

inline Color color_of(SnapshotView::Role role, std::size_t number) {
  switch (role) {
    case SnapshotView::Role::input:
      return input_colors[number % input_colors.size()];
    case SnapshotView::Role::merged:
      return merged_colors[number % merged_colors.size()];
    case SnapshotView::Role::virtual_scan:
      return virtual_colors[number % virtual_colors.size()];
    case SnapshotView::Role::cloud:
      return cloud_color;
  }
  return ink;
}

/// The colour of a value between the ends of a scale, 0 ... 1: the map viridis of matplotlib (CC0), whose
/// steps appear equal and differ in brightness for people with any colour vision; without its end, too bright
/// on white.
inline Color scale_color(double share) {
  constexpr std::array<Color, 8> steps = {{{0.267, 0.005, 0.329},
                                           {0.278, 0.173, 0.478},
                                           {0.231, 0.318, 0.545},
                                           {0.173, 0.443, 0.557},
                                           {0.129, 0.565, 0.553},
                                           {0.153, 0.678, 0.506},
                                           {0.361, 0.784, 0.388},
                                           {0.667, 0.863, 0.196}}};
  const double at = std::clamp(share, 0.0, 1.0) * (steps.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), steps.size() - 2);
  const double part = at - static_cast<double>(low);
  const auto mix = [&](double Color::*c) { return steps[low].*c * (1 - part) + steps[low + 1].*c * part; };
  return {mix(&Color::red), mix(&Color::green), mix(&Color::blue)};
}

/// 1, 2 or 5 times a power of ten, such that about `parts` of them make `length`.
inline double round_step(double length, double parts) {
  const double rough = length / parts;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double lead = rough / power;
  return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

inline std::string meters(double length) { return printed("%.6g m", length); }

}  // namespace lidard
