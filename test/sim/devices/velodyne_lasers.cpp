// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "test/sim/devices/velodyne_tables.h"
#include "test/sim/world/motion.h"

// Angles and heights of a VLP-16, Puck Hi-Res and HDL-32E follow from the steps and the lens of the product.
// The other angles follow no rule: they are the numbers of the same sources that drivers/velodyne/models.cpp
// names, so a mistake of a source is in both.
namespace lidard::sim {
namespace {

/// Never -0.
double rounded(double value, double steps) { return std::round(value * steps) / steps + 0.0; }

/// Even lasers rise from `lowest_deg` and odd ones from `middle_deg` by the same steps.
VelodyneLasers two_rows(std::size_t count, double lowest_deg, double middle_deg, double step_deg) {
  VelodyneLasers lasers(count);
  for (std::size_t i = 0; i < count; ++i)
    lasers[i].elevation_deg = (i % 2 == 0 ? lowest_deg : middle_deg) + step_deg * static_cast<double>(i / 2);
  return lasers;
}

/// Beams that cross one point `focal_mm` ahead of the axis leave the axis at these heights.
void raise(VelodyneLasers& lasers, double focal_mm, double steps) {
  for (VelodyneLaser& laser : lasers)
    laser.z_offset_mm = rounded(focal_mm * std::tan(-laser.elevation_deg * rad_per_deg), steps);
}

void round_elevations(VelodyneLasers& lasers, double steps) {
  for (VelodyneLaser& laser : lasers) laser.elevation_deg = rounded(laser.elevation_deg, steps);
}

}  // namespace

// Velodyne 63-9243 (VLP-16 User Manual) table 9-1.
VelodyneLasers vlp16_lasers() {
  VelodyneLasers lasers = two_rows(16, -15, 1, 2);
  raise(lasers, 41.9, 10);
  return lasers;
}

// Velodyne drawing 86-0129, as VeloView and velodyne_decoder list it.
VelodyneLasers puck_hires_lasers() {
  constexpr double heights_mm[] = {7.4, 6.5, 5.5, 4.6, 3.7, 2.7, 1.8, 0.9};
  VelodyneLasers lasers = two_rows(16, -10, 2.0 / 3, 4.0 / 3);
  round_elevations(lasers, 1000);
  for (std::size_t i = 0; i < 8; ++i) {
    lasers[2 * i].z_offset_mm = heights_mm[i];
    lasers[15 - 2 * i].z_offset_mm = -heights_mm[i];
  }
  return lasers;
}

// Velodyne drawing 86-0106, as velodyne_decoder lists it.
VelodyneLasers hdl32e_lasers() {
  VelodyneLasers lasers = two_rows(32, -92.0 / 3, -28.0 / 3, 4.0 / 3);
  raise(lasers, 28.955, 100);
  round_elevations(lasers, 100);
  return lasers;
}

// clang-format off
// VeloView VLP-32a.xml; no manual at hand (unverified).
VelodyneLasers vlp32a_lasers() {
  return {
      {-14.3, -1.2}, {0.8337, 1.2}, {12.5, -1.2}, {-0.5, 1.2}, {-10.7, -1.2}, {2.167, 1.2}, {8.9, -1.2},
      {-1.834, 1.2}, {-7, -1.2}, {1.167, 3.6}, {6, -1.2}, {-0.167, 3.6}, {-4.9, -1.2}, {2.5, 3.6},
      {3.8, -1.2}, {-1.5, 3.6}, {-2.167, -1.2}, {10.7, 1.2}, {1.834, -1.2}, {-8.9, 1.2}, {-2.5, -3.6},
      {4.9, 1.2}, {1.5, -3.6}, {-3.8, 1.2}, {-0.834, -1.2}, {14.3, 1.2}, {0.5, -1.2}, {-12.5, 1.2},
      {-1.167, -3.6}, {7, 1.2}, {0.167, -3.6}, {-6, 1.2}};
}

// Velodyne 63-9325 (VLP-32C User Manual) ch. 9, signs of the corrections as in the calibration files.
VelodyneLasers vlp32c_lasers() {
  return {
      {-25, -1.4}, {-1, 4.2}, {-1.667, -1.4}, {-15.639, 1.4}, {-11.31, -1.4}, {0, 1.4}, {-0.667, -4.2},
      {-8.843, 1.4}, {-7.254, -1.4}, {0.333, 4.2}, {-0.333, -1.4}, {-6.148, 1.4}, {-5.333, -4.2},
      {1.333, 1.4}, {0.667, -4.2}, {-4, 1.4}, {-4.667, -1.4}, {1.667, 4.2}, {1, -1.4}, {-3.667, 4.2},
      {-3.333, -4.2}, {3.333, 1.4}, {2.333, -1.4}, {-2.667, 1.4}, {-3, -1.4}, {7, 1.4}, {4.667, -1.4},
      {-2.333, 4.2}, {-2, -4.2}, {15, 1.4}, {10.333, -1.4}, {-1.333, 1.4}};
}

// The calibration of an HDL-64E is per unit: these are example units of ros-drivers/velodyne,
// velodyne_pointcloud/params. 64e_utexas.yaml.
VelodyneLasers hdl64e_utexas_lasers() {
  return {
      {-7.16, -4}, {-6.82, -2.25}, {0.32, 4}, {0.66, 6}, {-6.48, 0.8}, {-6.14, 2.25}, {-8.52, 0},
      {-8.18, 1.3}, {-5.8, 4.7}, {-5.46, 6.5}, {-7.84, 4}, {-7.5, 6}, {-3.08, -3.9}, {-2.74, -2},
      {-5.12, -4.8}, {-4.78, -2.75}, {-2.4, 0.5}, {-2.06, 2.25}, {-4.44, 0}, {-4.1, 1.75}, {-1.72, 4.9},
      {-1.38, 6.25}, {-3.76, 4}, {-3.42, 6}, {1, -3.5}, {1.34, -2}, {-1.04, -4.5}, {-0.7, -2.7}, {1.68, 0.6},
      {2.02, 2}, {-0.36, -0.25}, {-0.02, 1.7}, {-22.74, -7}, {-22.23, -3.5}, {-11.51, 5.5}, {-11, 8.5},
      {-21.71, -0.5}, {-21.2, 3.5}, {-24.71, -1}, {-24.28, 2}, {-20.69, 7}, {-20.18, 10}, {-23.76, 6},
      {-23.25, 9.5}, {-16.62, -6.5}, {-16.11, -3.25}, {-19.67, -8}, {-19.16, -5}, {-15.6, 0}, {-15.09, 3.2},
      {-18.56, -1}, {-18.14, 2}, {-14.58, 7}, {-14.07, 9.5}, {-17.63, 6}, {-17.12, 9}, {-10.49, -6},
      {-9.98, -3.5}, {-13.56, -8}, {-13.05, -4.5}, {-9.46, 0}, {-8.95, 2.5}, {-12.54, -1}, {-12.03, 1.8}};
}

// 64e_s2.1-sztaki.yaml.
VelodyneLasers hdl64e_sztaki_lasers() {
  return {
      {-8.77, -7.16}, {-8.36, -3.97}, {2.49, 4.72}, {2.98, 7.9}, {-7.78, -0.64}, {-7.26, 2.62},
      {-10.86, -1.81}, {-10.36, 1.34}, {-6.86, 5.77}, {-6.26, 9.17}, {-9.82, 4.76}, {-9.34, 7.94},
      {-2.59, -7.2}, {-2.06, -3.85}, {-5.67, -8.35}, {-5.19, -5.1}, {-1.59, -0.75}, {-1.15, 2.63},
      {-4.7, -1.85}, {-4.17, 1.39}, {-0.57, 5.75}, {-0.22, 9.09}, {-3.71, 4.61}, {-3.19, 7.95}, {3.5, -7.17},
      {4, -3.9}, {0.51, -8.33}, {0.98, -5.1}, {4.49, -0.69}, {4.97, 2.51}, {1.45, -1.89}, {1.97, 1.46},
      {-22.73, -7.63}, {-22.36, -4.15}, {-11.52, 4.75}, {-10.95, 8.03}, {-21.89, -0.69}, {-21.31, 2.77},
      {-24.85, -2.05}, {-24.42, 1.54}, {-20.86, 6.17}, {-20.12, 9.62}, {-23.85, 4.93}, {-23.18, 8.61},
      {-16.55, -7.45}, {-16.11, -4.02}, {-19.57, -8.79}, {-19.18, -5.32}, {-15.69, -0.69}, {-15.18, 2.72},
      {-18.72, -1.94}, {-18.22, 1.45}, {-14.6, 6.01}, {-14.08, 9.35}, {-17.76, 4.8}, {-17.11, 8.24},
      {-10.54, -7.3}, {-9.99, -3.93}, {-13.41, -8.58}, {-12.97, -5.14}, {-9.62, -0.67}, {-9.07, 2.57},
      {-12.42, -1.95}, {-12.07, 1.42}};
}

// 64e_s3-xiesc.yaml.
VelodyneLasers hdl64e_xiesc_lasers() {
  return {
      {-7.23, -4.38}, {-6.85, -2.25}, {0.2, 3.44}, {0.59, 5.68}, {-6.56, -0.05}, {-6.19, 2.19},
      {-8.56, -0.88}, {-8.22, 1.39}, {-5.89, 4.21}, {-5.48, 6.48}, {-7.94, 3.41}, {-7.55, 5.68},
      {-3.12, -4.34}, {-2.79, -2.12}, {-5.13, -5.13}, {-4.81, -2.91}, {-2.49, -0.11}, {-2.09, 2.15},
      {-4.53, -0.87}, {-4.16, 1.37}, {-1.81, 4.16}, {-1.46, 6.38}, {-3.82, 3.4}, {-3.47, 5.61}, {0.89, -4.39},
      {1.29, -2.17}, {-1.14, -5.18}, {-0.76, -2.94}, {1.56, -0.11}, {1.96, 2.11}, {-0.45, -0.89},
      {-0.09, 1.33}, {-22.36, -7.33}, {-21.98, -3.81}, {-11.3, 5.07}, {-10.75, 8.34}, {-21.49, -0.29},
      {-21.06, 3.11}, {-24.56, -1.61}, {-24.15, 1.82}, {-20.43, 6.54}, {-19.89, 9.94}, {-23.55, 5.48},
      {-22.97, 8.9}, {-16.27, -7.11}, {-15.91, -3.67}, {-19.25, -8.52}, {-18.92, -4.99}, {-15.38, -0.39},
      {-14.93, 3}, {-18.43, -1.63}, {-17.96, 1.82}, {-14.29, 6.28}, {-13.81, 9.67}, {-17.37, 5.18},
      {-16.8, 8.52}, {-10.18, -6.93}, {-9.74, -3.69}, {-13.16, -8.3}, {-12.83, -4.88}, {-9.3, -0.34},
      {-8.77, 2.9}, {-12.29, -1.57}, {-11.91, 1.66}};
}

// ros-drivers/velodyne VLS128.yaml, equal to the tables of velodyne_decoder and Nebula.
VelodyneLasers vls128_lasers() {
  constexpr double elevations_deg[] = {
      -11.742, -1.99, 3.4, -5.29, -0.78, 4.61, -4.08, 1.31, -6.5, -1.11, 4.28, -4.41, 0.1, 6.48, -3.2, 2.19,
      -3.86, 1.53, -9.244, -1.77, 2.74, -5.95, -0.56, 4.83, -2.98, 2.41, -6.28, -0.89, 3.62, -5.07, 0.32,
      7.58, -0.34, 5.18, -3.64, 1.75, -25, -2.43, 2.96, -5.73, 0.54, 9.7, -2.76, 2.63, -7.65, -1.55, 3.84,
      -4.85, 3.18, -5.51, -0.12, 5.73, -4.3, 1.09, -16.042, -2.21, 4.06, -4.63, 0.76, 15, -3.42, 1.97, -6.85,
      -1.33, -5.62, -0.23, 5.43, -3.53, 0.98, -19.582, -2.32, 3.07, -4.74, 0.65, 11.75, -2.65, 1.86, -7.15,
      -1.44, 3.95, -2.1, 3.29, -5.4, -0.01, 4.5, -4.19, 1.2, -13.565, -1.22, 4.17, -4.52, 0.87, 6.08, -3.31,
      2.08, -6.65, 1.42, -10.346, -1.88, 3.51, -6.06, -0.67, 4.72, -3.97, 2.3, -6.39, -1, 4.39, -5.18, 0.21,
      6.98, -3.09, 4.98, -3.75, 1.64, -8.352, -2.54, 2.85, -5.84, -0.45, 8.43, -2.87, 2.52, -6.17, -1.66,
      3.73, -4.96, 0.43};
  constexpr double rot_corrections_deg[] = {-6.354, -4.548, -2.732, -0.911, 0.911, 2.732, 4.548, 6.354};
  VelodyneLasers lasers;
  for (const double elevation : elevations_deg)
    lasers.push_back({elevation, rot_corrections_deg[lasers.size() % 8]});
  return lasers;
}
// clang-format on

}  // namespace lidard::sim
