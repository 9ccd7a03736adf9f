// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/models.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/laser_tables.h"

namespace lidard::velodyne {
namespace {

using ns = std::chrono::nanoseconds;

/// A sensor whose lasers fire evenly: `together` at each step.
Timing even(int sequence_ns, int step_ns, std::size_t together) {
  Timing timing{};
  timing.sequence = ns(sequence_ns);
  timing.step = ns(step_ns);
  timing.together = together;
  return timing;
}

/// VLS-128: eight lasers at each step, a pause after 64, the stamp some time after the first firing.
Timing vls128(int sequence_ns, int step_ns, int pause_steps, int before_ns) {
  Timing timing = even(sequence_ns, step_ns, 8);
  timing.pause_after = 64;
  timing.pause = ns(step_ns * pause_steps);
  timing.before = ns(before_ns);
  return timing;
}

/// HDL-64E: four lasers of each bank within a step; both banks together.
Timing hdl64e(int sequence_ns, int step_ns, std::array<ns, 4> within) {
  Timing timing = even(sequence_ns, step_ns, 4);
  timing.within = {within[0], within[1], within[2], within[3]};
  return timing;
}

// Firing times of the Pucks: 63-9243 Rev D, section 9.4; 63-9325 Rev B, section 9.4. 32A and 32B: assumed
// equal to 32C, unverified.
const Timing puck16 = even(55296, 2304, 1);
const Timing puck32 = even(55296, 2304, 2);
// HDL-32E: application note 63-9277. Old firmware (before 2.2.20.0) stamps the end of the packet: HDL-32E
// manual (Acoustics edition) p. 27; that the missing factory bytes mark it is unverified.
const Timing hdl32e_new = even(46080, 1152, 1);
const Timing hdl32e_old = [] {
  Timing timing = hdl32e_new;
  timing.before = ns(542592);
  return timing;
}();
// HDL-64E S2 manual p. 38 and the S3's, as valgur/velodyne_decoder reads them; unverified, no recording is
// public.
const Timing hdl64e_48us = hdl64e(48000, 6000, {ns(0), ns(1260), ns(2460), ns(3660)});
const Timing hdl64e_57us = hdl64e(57600, 7200, {ns(0), ns(1300), ns(2500), ns(3700)});
// S1: measured on the capture of one (chalmers-revere/opendlv.core, "atwall"): 384.05 us from packet to
// packet as a line through the arrivals of 306 packets has it, 12 blocks at the same step of the azimuth
// within a packet and from packet to packet, so 32.0 us for each; ros-drivers/velodyne counts 2600 packets/s,
// the data sheet a million points/s, which is 384 us. That the 32 lasers of a block fire one after another
// and evenly is unverified.
const Timing hdl64e_s1 = even(32000, 1000, 1);
// VLS-128: Rev 3 (firmware 5.1.7.1) rests a random time after each sequence, mean 1.941 us; Rev A (draft
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

/// Of two equally near to the horizontal the upper one, as velodyne_laserscan chooses on a VLP-16.
std::uint16_t level_ring(const DriverConfig& config) {
  const auto& row = *static_cast<const ModelRow*>(config.model->row);
  const Calibration calibration = config.calibration != nullptr ? *config.calibration : table_of(row);
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
  model.port = 2368;
  model.packets_per_s = 1 / seconds(row.packet_period(row.timings.front(), most_echoes));
  model.frame_period = 60 / default_rpm;
  model.range_min =
      0.4;  // nearer returns come from the housing or the mounting (launch files of ros-drivers)
  model.range_max = range_max;
  model.beams = row.lasers;
  model.traits = {Trait::revolutions, Trait::calibration, Trait::silent_beams_are_free,
                  Trait::packet_messages};
  model.level_ring = &level_ring;
  model.row = &row;
  model.make = &make_driver;
  return model;
}

/// Sensors with telemetry packets and a web interface (63-9243 Rev D, section 10.2), which the HDL-64E has
/// not: it is set through its serial line (user manual 63-HDL64ES3).
Model connected(const char* name, const char* product, const ModelRow& row, double range_max,
                const char* verified, std::initializer_list<Trait> more = {}) {
  Model model = spinning(name, product, row, range_max, verified);
  model.telemetry_port = 8308;
  model.dialogue_port = 80;
  model.traits.add({Trait::gnss, Trait::web_control});
  model.messages = {message_topic<GnssFix>(), message_topic<TimeReference>()};
  model.traits.add(more);
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
  // Confidence: return mode 0x3B.
  add(connected("velodyne_vls128", "VLS-128", vls128_row, 300, "real capture: strongest",
                {Trait::confidence}));
  add(connected("velodyne_alpha_prime", "Alpha Prime", vls128_row, 300, "same packets as VLS-128",
                {Trait::confidence}));
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
