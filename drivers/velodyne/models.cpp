// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/models.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "drivers/velodyne/calibration.h"

namespace lidard::velodyne {
namespace {

/// Lasers whose beams all cross one point so far ahead of the axis: each leaves the axis at another height.
template <std::size_t count>
std::array<Laser, count> crossing_at(double ahead_mm, std::array<Laser, count> lasers) {
  for (Laser& laser : lasers) laser.z_offset_mm = ahead_mm * std::tan(-laser.elevation_deg * rad_per_deg);
  return lasers;
}

// Elevation (deg), rot_correction (deg), z offset (mm) of each laser in the order of the packet. The sign of
// rot_correction is that of the calibration files: it is subtracted from the azimuth.
//
// VLP-16 and Puck LITE: user manual 63-9243 Rev D, table 9-1 (elevation, vertical correction).
// clang-format off
const std::array<Laser, 16> vlp16_lasers = {{
    {-15, 0, 11.2}, {1, 0, -0.7},   {-13, 0, 9.7},  {3, 0, -2.2},
    {-11, 0, 8.1},  {5, 0, -3.7},   {-9, 0, 6.6},   {7, 0, -5.1},
    {-7, 0, 5.1},   {9, 0, -6.6},   {-5, 0, 3.7},   {11, 0, -8.1},
    {-3, 0, 2.2},   {13, 0, -9.7},  {-1, 0, 0.7},   {15, 0, -11.2}}};
// clang-format on

// Puck Hi-Res: drawing 86-0129 (elevation, vertical correction).
// clang-format off
const std::array<Laser, 16> hires_lasers = {{
    {-10, 0, 7.4},    {0.667, 0, -0.9}, {-8.667, 0, 6.5}, {2, 0, -1.8},
    {-7.333, 0, 5.5}, {3.333, 0, -2.7}, {-6, 0, 4.6},     {4.667, 0, -3.7},
    {-4.667, 0, 3.7}, {6, 0, -4.6},     {-3.333, 0, 2.7}, {7.333, 0, -5.5},
    {-2, 0, 1.8},     {8.667, 0, -6.5}, {-0.667, 0, 0.9}, {10, 0, -7.4}}};
// clang-format on

// VLP-32C and 32B: user manual 63-9325 Rev B; z offsets 42.4 mm * tan(-elevation) (valgur/velodyne_decoder).
// The flat floor of a recording (nebula's, rings at 0.7 to 10 m) asks for 1.05 +- 0.02 of them: a plane
// through it is off by 3.1 mm with them, by 5.1 mm without. A range bias of -45 mm would do the same, but the
// product is specified to 30 mm.
const std::array<Laser, 32> vlp32c_lasers = {
    {{-25, -1.4, 19.771},   {-1, 4.2, 0.740},     {-1.667, -1.4, 1.234},  {-15.639, 1.4, 11.869},
     {-11.31, -1.4, 8.480}, {0, 1.4, -0.000},     {-0.667, -4.2, 0.494},  {-8.843, 1.4, 6.596},
     {-7.254, -1.4, 5.397}, {0.333, 4.2, -0.246}, {-0.333, -1.4, 0.246},  {-6.148, 1.4, 4.567},
     {-5.333, -4.2, 3.958}, {1.333, 1.4, -0.987}, {0.667, -4.2, -0.494},  {-4, 1.4, 2.965},
     {-4.667, -1.4, 3.461}, {1.667, 4.2, -1.234}, {1, -1.4, -0.740},      {-3.667, 4.2, 2.717},
     {-3.333, -4.2, 2.469}, {3.333, 1.4, -2.469}, {2.333, -1.4, -1.727},  {-2.667, 1.4, 1.975},
     {-3, -1.4, 2.222},     {7, 1.4, -5.206},     {4.667, -1.4, -3.461},  {-2.333, 4.2, 1.727},
     {-2, -4.2, 1.481},     {15, 1.4, -11.361},   {10.333, -1.4, -7.731}, {-1.333, 1.4, 0.987}}};

// VLP-32A: VeloView VLP-32a.xml; z offsets as VLP-32C, unverified.
const std::array<Laser, 32> vlp32a_lasers = {
    {{-14.3, -1.2, 10.808}, {0.8337, 1.2, -0.617}, {12.5, -1.2, -9.400},  {-0.5, 1.2, 0.370},
     {-10.7, -1.2, 8.012},  {2.167, 1.2, -1.604},  {8.9, -1.2, -6.640},   {-1.834, 1.2, 1.358},
     {-7, -1.2, 5.206},     {1.167, 3.6, -0.864},  {6, -1.2, -4.456},     {-0.167, 3.6, 0.124},
     {-4.9, -1.2, 3.635},   {2.5, 3.6, -1.851},    {3.8, -1.2, -2.816},   {-1.5, 3.6, 1.110},
     {-2.167, -1.2, 1.604}, {10.7, 1.2, -8.012},   {1.834, -1.2, -1.358}, {-8.9, 1.2, 6.640},
     {-2.5, -3.6, 1.851},   {4.9, 1.2, -3.635},    {1.5, -3.6, -1.110},   {-3.8, 1.2, 2.816},
     {-0.834, -1.2, 0.617}, {14.3, 1.2, -10.808},  {0.5, -1.2, -0.370},   {-12.5, 1.2, 9.400},
     {-1.167, -3.6, 0.864}, {7, 1.2, -5.206},      {0.167, -3.6, -0.124}, {-6, 1.2, 4.456}}};

// HDL-32E: drawing 86-0106 (elevation, vertical correction).
const std::array<Laser, 32> hdl32e_lasers = {
    {{-30.67, 0, 17.17}, {-9.33, 0, 4.76},   {-29.33, 0, 16.27}, {-8, 0, 4.07},      {-28, 0, 15.4},
     {-6.67, 0, 3.38},   {-26.67, 0, 14.54}, {-5.33, 0, 2.7},    {-25.33, 0, 13.71}, {-4, 0, 2.02},
     {-24, 0, 12.89},    {-2.67, 0, 1.35},   {-22.67, 0, 12.09}, {-1.33, 0, 0.67},   {-21.33, 0, 11.31},
     {0, 0, 0},          {-20, 0, 10.54},    {1.33, 0, -0.67},   {-18.67, 0, 9.78},  {2.67, 0, -1.35},
     {-17.33, 0, 9.04},  {4, 0, -2.02},      {-16, 0, 8.3},      {5.33, 0, -2.7},    {-14.67, 0, 7.58},
     {6.67, 0, -3.38},   {-13.33, 0, 6.86},  {8, 0, -4.07},      {-12, 0, 6.15},     {9.33, 0, -4.76},
     {-10.67, 0, 5.45},  {10.67, 0, -5.45}}};

// HDL-64E S1 and S2: one unit's calibration (ros-drivers/velodyne 64e_utexas.yaml); every unit differs.
const std::array<Laser, 64> hdl64e_s1_lasers = {
    {{-7.16, -4.00, 0},  {-6.82, -2.25, 0},  {0.32, 4.00, 0},    {0.66, 6.00, 0},    {-6.48, 0.80, 0},
     {-6.14, 2.25, 0},   {-8.52, 0.00, 0},   {-8.18, 1.30, 0},   {-5.80, 4.70, 0},   {-5.46, 6.50, 0},
     {-7.84, 4.00, 0},   {-7.50, 6.00, 0},   {-3.08, -3.90, 0},  {-2.74, -2.00, 0},  {-5.12, -4.80, 0},
     {-4.78, -2.75, 0},  {-2.40, 0.50, 0},   {-2.06, 2.25, 0},   {-4.44, 0.00, 0},   {-4.10, 1.75, 0},
     {-1.72, 4.90, 0},   {-1.38, 6.25, 0},   {-3.76, 4.00, 0},   {-3.42, 6.00, 0},   {1.00, -3.50, 0},
     {1.34, -2.00, 0},   {-1.04, -4.50, 0},  {-0.70, -2.70, 0},  {1.68, 0.60, 0},    {2.02, 2.00, 0},
     {-0.36, -0.25, 0},  {-0.02, 1.70, 0},   {-22.74, -7.00, 0}, {-22.23, -3.50, 0}, {-11.51, 5.50, 0},
     {-11.00, 8.50, 0},  {-21.71, -0.50, 0}, {-21.20, 3.50, 0},  {-24.71, -1.00, 0}, {-24.28, 2.00, 0},
     {-20.69, 7.00, 0},  {-20.18, 10.00, 0}, {-23.76, 6.00, 0},  {-23.25, 9.50, 0},  {-16.62, -6.50, 0},
     {-16.11, -3.25, 0}, {-19.67, -8.00, 0}, {-19.16, -5.00, 0}, {-15.60, 0.00, 0},  {-15.09, 3.20, 0},
     {-18.56, -1.00, 0}, {-18.14, 2.00, 0},  {-14.58, 7.00, 0},  {-14.07, 9.50, 0},  {-17.63, 6.00, 0},
     {-17.12, 9.00, 0},  {-10.49, -6.00, 0}, {-9.98, -3.50, 0},  {-13.56, -8.00, 0}, {-13.05, -4.50, 0},
     {-9.46, 0.00, 0},   {-8.95, 2.50, 0},   {-12.54, -1.00, 0}, {-12.03, 1.80, 0}}};

// HDL-64E S2.1: one unit's calibration (64e_s2.1-sztaki.yaml); every unit differs.
const std::array<Laser, 64> hdl64e_s21_lasers = {
    {{-8.77, -7.16, 0},  {-8.36, -3.97, 0},  {2.49, 4.72, 0},    {2.98, 7.90, 0},    {-7.78, -0.64, 0},
     {-7.26, 2.62, 0},   {-10.86, -1.81, 0}, {-10.36, 1.34, 0},  {-6.86, 5.77, 0},   {-6.26, 9.17, 0},
     {-9.82, 4.76, 0},   {-9.34, 7.94, 0},   {-2.59, -7.20, 0},  {-2.06, -3.85, 0},  {-5.67, -8.35, 0},
     {-5.19, -5.10, 0},  {-1.59, -0.75, 0},  {-1.15, 2.63, 0},   {-4.70, -1.85, 0},  {-4.17, 1.39, 0},
     {-0.57, 5.75, 0},   {-0.22, 9.09, 0},   {-3.71, 4.61, 0},   {-3.19, 7.95, 0},   {3.50, -7.17, 0},
     {4.00, -3.90, 0},   {0.51, -8.33, 0},   {0.98, -5.10, 0},   {4.49, -0.69, 0},   {4.97, 2.51, 0},
     {1.45, -1.89, 0},   {1.97, 1.46, 0},    {-22.73, -7.63, 0}, {-22.36, -4.15, 0}, {-11.52, 4.75, 0},
     {-10.95, 8.03, 0},  {-21.89, -0.69, 0}, {-21.31, 2.77, 0},  {-24.85, -2.05, 0}, {-24.42, 1.54, 0},
     {-20.86, 6.17, 0},  {-20.12, 9.62, 0},  {-23.85, 4.93, 0},  {-23.18, 8.61, 0},  {-16.55, -7.45, 0},
     {-16.11, -4.02, 0}, {-19.57, -8.79, 0}, {-19.18, -5.32, 0}, {-15.69, -0.69, 0}, {-15.18, 2.72, 0},
     {-18.72, -1.94, 0}, {-18.22, 1.45, 0},  {-14.60, 6.01, 0},  {-14.08, 9.35, 0},  {-17.76, 4.80, 0},
     {-17.11, 8.24, 0},  {-10.54, -7.30, 0}, {-9.99, -3.93, 0},  {-13.41, -8.58, 0}, {-12.97, -5.14, 0},
     {-9.62, -0.67, 0},  {-9.07, 2.57, 0},   {-12.42, -1.95, 0}, {-12.07, 1.42, 0}}};

// HDL-64E S3: one unit's calibration (64e_s3-xiesc.yaml); every unit differs.
const std::array<Laser, 64> hdl64e_s3_lasers = {
    {{-7.23, -4.38, 0},  {-6.85, -2.25, 0},  {0.20, 3.44, 0},    {0.59, 5.68, 0},    {-6.56, -0.05, 0},
     {-6.19, 2.19, 0},   {-8.56, -0.88, 0},  {-8.22, 1.39, 0},   {-5.89, 4.21, 0},   {-5.48, 6.48, 0},
     {-7.94, 3.41, 0},   {-7.55, 5.68, 0},   {-3.12, -4.34, 0},  {-2.79, -2.12, 0},  {-5.13, -5.13, 0},
     {-4.81, -2.91, 0},  {-2.49, -0.11, 0},  {-2.09, 2.15, 0},   {-4.53, -0.87, 0},  {-4.16, 1.37, 0},
     {-1.81, 4.16, 0},   {-1.46, 6.38, 0},   {-3.82, 3.40, 0},   {-3.47, 5.61, 0},   {0.89, -4.39, 0},
     {1.29, -2.17, 0},   {-1.14, -5.18, 0},  {-0.76, -2.94, 0},  {1.56, -0.11, 0},   {1.96, 2.11, 0},
     {-0.45, -0.89, 0},  {-0.09, 1.33, 0},   {-22.36, -7.33, 0}, {-21.98, -3.81, 0}, {-11.30, 5.07, 0},
     {-10.75, 8.34, 0},  {-21.49, -0.29, 0}, {-21.06, 3.11, 0},  {-24.56, -1.61, 0}, {-24.15, 1.82, 0},
     {-20.43, 6.54, 0},  {-19.89, 9.94, 0},  {-23.55, 5.48, 0},  {-22.97, 8.90, 0},  {-16.27, -7.11, 0},
     {-15.91, -3.67, 0}, {-19.25, -8.52, 0}, {-18.92, -4.99, 0}, {-15.38, -0.39, 0}, {-14.93, 3.00, 0},
     {-18.43, -1.63, 0}, {-17.96, 1.82, 0},  {-14.29, 6.28, 0},  {-13.81, 9.67, 0},  {-17.37, 5.18, 0},
     {-16.80, 8.52, 0},  {-10.18, -6.93, 0}, {-9.74, -3.69, 0},  {-13.16, -8.30, 0}, {-12.83, -4.88, 0},
     {-9.30, -0.34, 0},  {-8.77, 2.90, 0},   {-12.29, -1.57, 0}, {-11.91, 1.66, 0}}};

// VLS-128: ros-drivers/velodyne, valgur/velodyne_decoder and nebula agree in the angles. Only
// velodyne_decoder states that beams cross 58.63 mm ahead of the axis. In nebula's recording the road does
// not determine the heights, but edges at 3 to 8 m, seen by lasers up to 12.7 deg apart, are shifted sideways
// as if beams crossed 60 mm ahead (+- 1.3 mm; 38 to 116 mm for other distances or scaled angles; no fit gives
// 0). A lens has one such point for both directions, and the offsets that Velodyne prints for the VLP-16,
// Puck Hi-Res and HDL-32E have this form. So 58.63 mm are used as the most likely value, not as a measured
// one.
constexpr double vls128_elevations_deg[128] = {
    -11.742, -1.99, 3.4,     -5.29, -0.78,   4.61,   -4.08,   1.31,  -6.5,  -1.11,   4.28,  -4.41,  0.1,
    6.48,    -3.2,  2.19,    -3.86, 1.53,    -9.244, -1.77,   2.74,  -5.95, -0.56,   4.83,  -2.98,  2.41,
    -6.28,   -0.89, 3.62,    -5.07, 0.32,    7.58,   -0.34,   5.18,  -3.64, 1.75,    -25,   -2.43,  2.96,
    -5.73,   0.54,  9.7,     -2.76, 2.63,    -7.65,  -1.55,   3.84,  -4.85, 3.18,    -5.51, -0.12,  5.73,
    -4.3,    1.09,  -16.042, -2.21, 4.06,    -4.63,  0.76,    15,    -3.42, 1.97,    -6.85, -1.33,  -5.62,
    -0.23,   5.43,  -3.53,   0.98,  -19.582, -2.32,  3.07,    -4.74, 0.65,  11.75,   -2.65, 1.86,   -7.15,
    -1.44,   3.95,  -2.1,    3.29,  -5.4,    -0.01,  4.5,     -4.19, 1.2,   -13.565, -1.22, 4.17,   -4.52,
    0.87,    6.08,  -3.31,   2.08,  -6.65,   1.42,   -10.346, -1.88, 3.51,  -6.06,   -0.67, 4.72,   -3.97,
    2.3,     -6.39, -1,      4.39,  -5.18,   0.21,   6.98,    -3.09, 4.98,  -3.75,   1.64,  -8.352, -2.54,
    2.85,    -5.84, -0.45,   8.43,  -2.87,   2.52,   -6.17,   -1.66, 3.73,  -4.96,   0.43};
const std::array<Laser, 128> vls128_lasers = [] {
  constexpr double rot_corrections_deg[8] = {-6.354, -4.548, -2.732, -0.911, 0.911, 2.732, 4.548, 6.354};
  std::array<Laser, 128> lasers{};
  for (std::size_t k = 0; k < lasers.size(); ++k)
    lasers[k] = {vls128_elevations_deg[k], rot_corrections_deg[k % 8], 0};
  return crossing_at(58.63, lasers);
}();

using std::chrono::nanoseconds;

/// A sensor with equal firing steps of `together` lasers.
Timing even(int sequence_ns, int step_ns, std::size_t together) {
  Timing timing{};
  timing.sequence = nanoseconds(sequence_ns);
  timing.step = nanoseconds(step_ns);
  timing.together = together;
  return timing;
}

/// VLS-128: eight lasers at each step, a pause after 64, the stamp some time after the first firing.
Timing vls128(int sequence_ns, int step_ns, int pause_steps, int before_ns) {
  Timing timing = even(sequence_ns, step_ns, 8);
  timing.pause_after = 64;
  timing.pause = nanoseconds(step_ns * pause_steps);
  timing.before = nanoseconds(before_ns);
  return timing;
}

/// HDL-64E: four lasers of each bank within a step; both banks together.
Timing hdl64e(int sequence_ns, int step_ns, std::array<nanoseconds, 4> within) {
  Timing timing = even(sequence_ns, step_ns, 4);
  timing.within = {within[0], within[1], within[2], within[3]};
  return timing;
}

// Firing times of the Pucks: 63-9243 Rev D, section 9.4; 63-9325 Rev B, section 9.4. 32A and 32B: assumed
// equal to 32C (unverified).
const Timing puck16 = even(55296, 2304, 1);
const Timing puck32 = even(55296, 2304, 2);
// HDL-32E: application note 63-9277. Old firmware (before 2.2.20.0) stamps the end of the packet: HDL-32E
// manual (Acoustics edition) p. 27. Unverified: the missing factory bytes mark old firmware.
const Timing hdl32e_new = even(46080, 1152, 1);
const Timing hdl32e_old = [] {
  Timing timing = hdl32e_new;
  timing.before = nanoseconds(542592);
  return timing;
}();
// HDL-64E S2 manual p. 38 and S3 manual, as in valgur/velodyne_decoder; unverified, no recording is public.
const Timing hdl64e_48us =
    hdl64e(48000, 6000, {nanoseconds(0), nanoseconds(1260), nanoseconds(2460), nanoseconds(3660)});
const Timing hdl64e_57us =
    hdl64e(57600, 7200, {nanoseconds(0), nanoseconds(1300), nanoseconds(2500), nanoseconds(3700)});
// S1: measured on a capture (chalmers-revere/opendlv.core, "atwall"): 384.05 us from packet to packet by a
// line through the arrivals of 306 packets, with equal steps of the azimuth between its 12 blocks and between
// packets, so 32.0 us per block. ros-drivers/velodyne has 2600 packets/s, the data sheet a million points/s
// (384 us). Unverified: the 32 lasers of a block fire in order and evenly.
const Timing hdl64e_s1 = even(32000, 1000, 1);
// VLS-128: Rev 3 (firmware 5.1.7.1) pauses for a random time after each sequence, mean 1.941 us; Rev A (draft
// manual 63-9483); Rev 4 (firmware from 5.2.3). UniBwTAS/velodyne, valgur/velodyne_decoder,
// ros-drivers/velodyne.
const Timing vls128_rev3 = vls128(55277, 2665, 2, 7000);
const Timing vls128_rev_a = vls128(53300, 2665, 1, 8700);
const Timing vls128_rev4 = vls128(57800, 2890, 2, 7000);

// Product ids: 63-9243 Rev D, table 9-3; the VLS-128's is 0xA1 on the wire, the table prints 0x63.
const ModelRow vlp16 = {"VLP-16", {0x22, 0}, 0.002, 16, 1, false, {puck16}, nullptr, vlp16_lasers.data()};
const ModelRow hires = {"Puck Hi-Res", {0x24, 0},          0.002, 16, 1, false, {puck16},
                        nullptr,       hires_lasers.data()};
const ModelRow vlp32a = {"VLP-32A", {0x23, 0}, 0.004, 32, 1, false, {puck32}, nullptr, vlp32a_lasers.data()};
const ModelRow vlp32b = {"VLP-32B", {0x23, 0}, 0.004, 32, 1, false, {puck32}, nullptr, vlp32c_lasers.data()};
const ModelRow vlp32c = {"VLP-32C", {0x28, 0}, 0.004, 32, 1, false, {puck32}, nullptr, vlp32c_lasers.data()};
const ModelRow hdl32e = {"HDL-32E",   {0x21, 0},           0.002, 32, 1, false, {hdl32e_new},
                         &hdl32e_old, hdl32e_lasers.data()};
const ModelRow hdl64e_s1_row = {
    "HDL-64E S1", {0, 0}, 0.002, 64, 2, false, {hdl64e_s1}, nullptr, hdl64e_s1_lasers.data(), true};
const ModelRow hdl64e_s2_row = {
    "HDL-64E S2", {0, 0}, 0.002, 64, 2, false, {hdl64e_48us, hdl64e_57us}, nullptr, hdl64e_s1_lasers.data()};
const ModelRow hdl64e_s21_row = {
    "HDL-64E S2.1",          {0, 0}, 0.002, 64, 2, false, {hdl64e_48us, hdl64e_57us}, nullptr,
    hdl64e_s21_lasers.data()};
const ModelRow hdl64e_s3_row = {
    "HDL-64E S3", {0, 0}, 0.002, 64, 2, false, {hdl64e_57us, hdl64e_48us}, nullptr, hdl64e_s3_lasers.data(),
    false,        true};
const ModelRow vls128_row = {
    "VLS-128", {0xA1, 0x63},        0.004, 128, 4, true, {vls128_rev3, vls128_rev_a, vls128_rev4},
    nullptr,   vls128_lasers.data()};

constexpr std::array<std::pair<std::uint8_t, const char*>, 8> products = {{{0x21, "HDL-32E"},
                                                                           {0x22, "VLP-16"},
                                                                           {0x23, "VLP-32A/B"},
                                                                           {0x24, "Puck Hi-Res"},
                                                                           {0x28, "VLP-32C"},
                                                                           {0x31, "Velarray"},
                                                                           {0x63, "VLS-128"},
                                                                           {0xA1, "VLS-128"}}};

/// The upper one of two equally near rings, as velodyne_laserscan for a VLP-16.
std::uint16_t level_ring(const DriverConfig& config) {
  const auto& row = *static_cast<const ModelRow*>(config.model->row);
  const Calibration calibration = config.calibration != nullptr ? *own_calibration(config) : table_of(row);
  const auto rings = rings_by_elevation(calibration);
  std::uint16_t best_ring = 0;
  double best = 1e9;
  for (std::size_t k = 0; k < rings.size(); ++k) {
    const double elevation_deg = calibration.lasers[k].vert_correction * deg_per_rad;
    constexpr double equal_deg = 1e-6;
    const double off = std::fabs(elevation_deg);
    if (off > best + equal_deg || (off > best - equal_deg && rings[k] < best_ring)) continue;
    best = off;
    best_ring = rings[k];
  }
  return best_ring;
}

Model spinning(const char* name, const char* product, const ModelRow& row, double range_max,
               const char* verified) {
  constexpr double default_rpm = 600;
  const std::size_t most_echoes = row.banks == 2 ? 1 : 2;
  Model model{name, "Velodyne", product, "Velodyne data packet", verified, FrameKind::cloud};
  model.port = usual_data_port;
  model.packets_per_s = 1 / seconds(row.packet_period(row.timings.front(), most_echoes));
  model.frame_period = 60 / default_rpm;
  model.range_min = 0.4;  // nearer returns are from the housing or the mounting (launch files of ros-drivers)
  model.range_max = range_max;
  model.beams = row.lasers;
  // HDL-64E: 50 m for pavement (reflectivity 0.10), 120 m for cars and foliage (0.80), its data sheet as
  // others quote it. The data sheets of the others give the range of bright targets alone.
  if (row.banks == 2) model.dark_range = 50;
  model.field.beams = static_cast<std::size_t>(model.frame_period / seconds(row.timings.front().sequence));
  model.field.step_deg = 360.0 / static_cast<double>(model.field.beams);
  for (std::size_t k = 0; k < row.lasers; ++k)
    model.field.elevations_deg.push_back(row.laser[k].elevation_deg);
  std::sort(model.field.elevations_deg.begin(), model.field.elevations_deg.end());
  model.traits = {Trait::revolutions, Trait::calibration, Trait::packet_messages};
  // Of an HDL-64E S1 a column does not show which beams were fired.
  if (!row.bank_by_bank) model.traits.add({Trait::silent_beams_are_free});
  model.level_ring = &level_ring;
  model.row = &row;
  model.make = &make_driver;
  return model;
}

/// Sensors with telemetry packets and a web interface (63-9243 Rev D, section 10.2). The HDL-64E has neither;
/// it is set through a serial line (user manual 63-HDL64ES3).
Model connected(const char* name, const char* product, const ModelRow& row, double range_max,
                const char* verified) {
  Model model = spinning(name, product, row, range_max, verified);
  model.telemetry_port = usual_telemetry_port;
  model.dialogue_port = 80;
  model.traits.add({Trait::gnss, Trait::web_control});
  model.messages = {message_topic<GnssFix>(), message_topic<TimeReference>()};
  return model;
}

}  // namespace

void append_models(std::vector<Model>& list) {
  // Ranges: data sheets, unverified.
  const char* simulated = "our simulator; no public capture";
  const auto add = [&list](Model model) { list.push_back(std::move(model)); };
  add(connected("velodyne_vlp16", "VLP-16", vlp16, 100, "real captures: strongest, last, dual"));
  add(connected("velodyne_puck_lite", "Puck LITE", vlp16, 100, "same packets as VLP-16"));
  add(connected("velodyne_puck_hires", "Puck Hi-Res", hires, 100, simulated));
  add(connected("velodyne_vlp32a", "VLP-32A", vlp32a, 200, simulated));
  add(connected("velodyne_vlp32b", "VLP-32B", vlp32b, 200, simulated));
  add(connected("velodyne_vlp32c", "VLP-32C", vlp32c, 200, "real capture: strongest, field of view"));
  add(connected("velodyne_hdl32e", "HDL-32E", hdl32e, 100, "real captures: strongest"));
  list.back().messages.push_back(message_topic<ImuSample>());
  add(spinning("velodyne_hdl64e_s1", "HDL-64E S1", hdl64e_s1_row, 120, "real capture with its calibration"));
  add(spinning("velodyne_hdl64e_s2", "HDL-64E S2", hdl64e_s2_row, 120, simulated));
  add(spinning("velodyne_hdl64e_s21", "HDL-64E S2.1", hdl64e_s21_row, 120, simulated));
  add(spinning("velodyne_hdl64e_s3", "HDL-64E S3", hdl64e_s3_row, 120, simulated));
  add(connected("velodyne_vls128", "VLS-128", vls128_row, 300, "real capture: strongest"));
  add(connected("velodyne_alpha_prime", "Alpha Prime", vls128_row, 300, "same packets as VLS-128"));
}

const std::vector<const ModelRow*>& model_rows() {
  static const std::vector<const ModelRow*> rows = {
      &vlp16,      &hires,         &vlp32c,         &vlp32a,        &vlp32b,       &hdl32e,
      &vls128_row, &hdl64e_s2_row, &hdl64e_s21_row, &hdl64e_s3_row, &hdl64e_s1_row};
  return rows;
}

Span ModelRow::firing_time(const Timing& timing, std::size_t index) const {
  const std::size_t k = banks == 2 ? index % 32 : index;
  Span time = timing.step * static_cast<int>(k / timing.together) - timing.before;
  if (timing.pause_after != 0 && k >= timing.pause_after) time += timing.pause;
  if (banks == 2) time += timing.within[k % timing.within.size()];
  return time;
}

bool is_product(std::uint8_t product_id) {
  return std::any_of(products.begin(), products.end(),
                     [product_id](const auto& p) { return p.first == product_id; });
}

std::string product_name(std::uint8_t product_id) {
  for (const auto& [id, name] : products) {
    if (id == product_id) return name;
  }
  return printed("unknown product 0x%02x", static_cast<unsigned>(product_id));
}

}  // namespace lidard::velodyne
