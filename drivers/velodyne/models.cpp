// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/models.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>

#include "drivers/velodyne/model_row.h"
#include "drivers/velodyne/velodyne_driver.h"

namespace lidard::velodyne {
namespace {

using std::chrono::nanoseconds;

// VLP-16 and Puck LITE: user manual 63-9243 Rev D, table 9-1 (elevation, vertical correction).
constexpr std::array<Laser, 16> vlp16_lasers = {{{-15, 0, 11.2},
                                                 {1, 0, -0.7},
                                                 {-13, 0, 9.7},
                                                 {3, 0, -2.2},
                                                 {-11, 0, 8.1},
                                                 {5, 0, -3.7},
                                                 {-9, 0, 6.6},
                                                 {7, 0, -5.1},
                                                 {-7, 0, 5.1},
                                                 {9, 0, -6.6},
                                                 {-5, 0, 3.7},
                                                 {11, 0, -8.1},
                                                 {-3, 0, 2.2},
                                                 {13, 0, -9.7},
                                                 {-1, 0, 0.7},
                                                 {15, 0, -11.2}}};

// Firing times: 63-9243 Rev D, section 9.4; product id: table 9-3.
constexpr ModelRow vlp16 = {"VLP-16",           0x22, 0.002, 16, 1, nanoseconds(2304), nanoseconds(55296),
                            vlp16_lasers.data()};

// 63-9243 Rev D, table 9-3; 0xA1 and 0x63 are both seen for the VLS-128.
constexpr std::array<std::pair<std::uint8_t, const char*>, 8> products = {{{0x21, "HDL-32E"},
                                                                           {0x22, "VLP-16"},
                                                                           {0x23, "VLP-32A/B"},
                                                                           {0x24, "Puck Hi-Res"},
                                                                           {0x28, "VLP-32C"},
                                                                           {0x31, "Velarray"},
                                                                           {0x63, "VLS-128"},
                                                                           {0xA1, "VLS-128"}}};

Model spinning(const char* name, const char* product, const ModelRow& row, double range_max,
               const char* verified) {
  constexpr double default_rpm = 600;
  return {name,
          "Velodyne",
          product,
          "Velodyne data packet",
          FrameKind::cloud,
          Transport::udp,
          2368,
          8308,
          1 / seconds(row.packet_period(2)),
          60 / default_rpm,
          0.4,  // nearer returns come from the housing or the mounting (ros-drivers/velodyne launch files)
          range_max,
          row.lasers,
          verified,
          &row,
          &make_driver};
}

}  // namespace

void append_models(std::vector<Model>& list) {
  list.push_back(spinning("velodyne_vlp16", "VLP-16", vlp16, 100, "real captures: strongest, last, dual"));
  list.push_back(spinning("velodyne_puck_lite", "Puck LITE", vlp16, 100, "same packets as VLP-16"));
}

const std::vector<const ModelRow*>& model_rows() {
  static const std::vector<const ModelRow*> rows = {&vlp16};
  return rows;
}

std::vector<std::uint16_t> rings_by_elevation(const ModelRow& row) {
  std::vector<std::size_t> order(row.lasers);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&row](std::size_t a, std::size_t b) {
    return row.laser[a].elevation_deg < row.laser[b].elevation_deg;
  });
  std::vector<std::uint16_t> rings(row.lasers);
  for (std::size_t ring = 0; ring < order.size(); ++ring)
    rings[order[ring]] = static_cast<std::uint16_t>(ring);
  return rings;
}

std::string product_name(std::uint8_t product_id) {
  for (const auto& [id, name] : products) {
    if (id == product_id) return name;
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "unknown product 0x%02x", static_cast<unsigned>(product_id));
  return text.data();
}

}  // namespace lidard::velodyne
