// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/random_cloud.h"

#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/motion/frame_motion.h"
#include "core/virtual/virtualizer.h"
#include "test/support/random_bytes.h"

namespace lidard::sim {
namespace {

VirtualSettings read_virtual_settings(Bytes& in) {
  VirtualSettings settings;
  settings.visibility = in.chance(240);
  settings.mode = in.chance(128) ? CutMode::slice : CutMode::band;
  settings.ground.model = static_cast<GroundModel>(in.below(3));
  settings.ground.z = in.between(-3, 1);
  settings.ground.tolerance = in.between(0, 0.5);
  settings.ground.steepest = in.between(0, 1);
  settings.how.noise = in.between(0, 0.1);
  if (in.chance(40)) settings.how.free_required = in.between(0, 100);
  if (in.chance(200)) settings.beams.no_return_free_range = in.between(0, 120);
  settings.beams.early_returns = in.chance(128);
  return settings;
}

/// How the lidar of the next clouds measures.
struct Layout {
  std::size_t rings = 16, columns = 36;
  double lowest = -0.3, ring_step = 0.03, step = 0.17, begin = 0;  // rad
  bool has_columns = true, has_rings = true, by_ring = false, dual = false, shuffled = false;
};

Layout read_layout(Bytes& in) {
  Layout layout;
  layout.rings = 1 + in.below(in.chance(30) ? 128 : 20);
  layout.columns = in.chance(20) ? in.below(4) : in.below(120);
  layout.lowest = in.between(-1.4, 0.3);
  layout.ring_step = in.between(0.0005, 0.1);
  layout.step = in.between(0.0005, 0.4);
  layout.begin = in.between(-4, 10);
  layout.has_columns = in.chance(160);
  layout.has_rings = in.chance(200);
  layout.by_ring = in.chance(60);
  layout.dual = in.chance(60);
  layout.shuffled = in.chance(40);
  return layout;
}

/// A return where a surface may go on; now and then anything else.
CloudPoint read_point(Bytes& in, const Layout& layout, double azimuth, std::size_t ring, double& range) {
  const std::uint8_t what = in.byte();
  if (what < 30) range = in.between(0, 60);
  range += (static_cast<double>(what) - 128) * 2e-3;
  const double elevation = layout.lowest + layout.ring_step * static_cast<double>(ring);
  const double level = range * std::cos(elevation);
  CloudPoint point{
      static_cast<float>(level * std::cos(azimuth)),           static_cast<float>(-level * std::sin(azimuth)),
      static_cast<float>(range * std::sin(elevation)),         static_cast<float>(what),
      static_cast<std::uint16_t>(layout.has_rings ? ring : 0), static_cast<float>(ring) * 1e-5F};
  if (layout.shuffled && in.chance(40)) point.ring = static_cast<std::uint16_t>(in.below(65536));
  if (what == 30) point.x = in.any_float();
  if (what == 31) point.y = in.any_float(), point.z = in.any_float();
  if (what == 32) point.time = in.any_float(), point.intensity = in.any_float();
  if (what == 33) point.x = point.y = point.z = std::numeric_limits<float>::quiet_NaN();
  if (what == 34) point.x = point.y = point.z = 0;
  return point;
}

void append(Cloud& cloud, const CloudPoint& point) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&point);
  cloud.points_bytes.insert(cloud.points_bytes.end(), bytes, bytes + sizeof point);
}

/// The returns of rings [first, last) at one azimuth.
void read_column(Bytes& in, const Layout& layout, std::size_t number, std::size_t first, std::size_t last,
                 Cloud& cloud) {
  double azimuth = layout.begin + layout.step * static_cast<double>(number);
  if (in.chance(8)) azimuth = in.between(-10, 10);
  const Stamp stamp = cloud.stamp + std::chrono::microseconds(50 * number);
  const std::uint8_t echoes = layout.dual ? 2 : 1;
  for (std::uint8_t echo = 0; echo < echoes; ++echo) {
    if (layout.has_columns)
      cloud.columns.push_back({static_cast<std::uint32_t>(cloud.size()), 0, 0, echo,
                               static_cast<float>(azimuth),
                               in.chance(3) ? Stamp{static_cast<std::int64_t>(in.below(65536))} : stamp});
    double range = in.between(0, 60);
    for (std::size_t ring = first; ring < last; ++ring) {
      if (!in.chance(220)) continue;
      append(cloud, read_point(in, layout, azimuth, ring, range));
    }
  }
  if (layout.has_columns && in.chance(10))
    cloud.too_near.push_back({static_cast<std::uint32_t>(in.below(cloud.columns.size() + 2)),
                              static_cast<std::uint16_t>(in.below(layout.rings + 2))});
}

void read_cloud(Bytes& in, const Layout& layout, Stamp stamp, Cloud& cloud) {
  cloud.clear();
  cloud.stamp = stamp;
  cloud.rings = static_cast<std::uint16_t>(layout.has_rings ? layout.rings : in.below(2));
  const std::size_t groups = layout.by_ring ? layout.rings : 1;
  for (std::size_t group = 0; group < groups; ++group) {
    for (std::size_t c = 0; c < layout.columns && !in.empty(); ++c) {
      if (in.chance(12)) continue;  // lost
      read_column(in, layout, c, layout.by_ring ? group : 0, layout.by_ring ? group + 1 : layout.rings,
                  cloud);
    }
  }
  cloud.end =
      stamp + std::chrono::milliseconds(in.below(200)) - std::chrono::milliseconds(in.chance(10) ? 400 : 0);
}

/// What fills one virtual scan after the other.
class Run {
 public:
  using Look = std::function<void(const VirtualScan&, const Virtualizer&)>;

  Run(Bytes& in, const Look& look)
      : in_(in),
        look_(look),
        grid_(read_grid(in)),
        frames_(1 + in.below(3)),
        settings_(read_virtual_settings(in)),
        virtualizer_(grid_, read_band(in), frames_, settings_),
        vehicle_from_cloud_(read_pose(in)) {
    if (in.chance(128)) virtualizer_.set_footprint(read_footprint(in));
    for (std::size_t f = 0; f < frames_; ++f) poses_.push_back(read_pose(in));
  }

  std::size_t all() {
    std::size_t scans = 0;
    Layout layout = read_layout(in_);
    while (!in_.empty()) {
      if (in_.chance(60)) layout = read_layout(in_);
      if (in_.chance(20)) poses_[in_.below(frames_)] = read_pose(in_);
      if (in_.chance(10)) vehicle_from_cloud_ = read_pose(in_);
      if (in_.chance(10)) virtualizer_.set_footprint(read_footprint(in_));
      now_ = now_ + std::chrono::milliseconds(in_.below(300));
      read_cloud(in_, layout, now_, cloud_);
      scans += look();
    }
    return scans;
  }

 private:
  std::size_t look() {
    if (in_.chance(128)) track_.add(now_, read_pose(in_));
    if (in_.chance(128)) track_.add(now_ + std::chrono::milliseconds(100), read_pose(in_));
    const bool moves = in_.chance(160) && motion_.find(cloud_, vehicle_from_cloud_, track_);
    virtualizer_.set_cloud(cloud_, vehicle_from_cloud_, moves ? &motion_ : nullptr);
    std::vector<VirtualScan> outputs = {{Profile::flatten, &scans_[0]}};
    if (settings_.visibility) {
      outputs.push_back({Profile::strict, &scans_[1]});
      outputs.push_back({Profile::safety, &scans_[2]});
    }
    for (std::size_t f = 0; f < frames_; ++f) {
      virtualizer_.project(f, poses_[f], outputs);
      for (const VirtualScan& output : outputs) {
        check(*output.scan, grid_);
        if (look_) look_(output, virtualizer_);
      }
    }
    return frames_ * outputs.size();
  }

  Bytes& in_;
  const Look& look_;
  ScanGrid grid_;
  std::size_t frames_;
  VirtualSettings settings_;
  Virtualizer virtualizer_;
  Pose vehicle_from_cloud_;
  std::vector<Pose> poses_;
  Cloud cloud_;
  CloudMotion motion_;
  PoseTrack track_;
  PlanarScan scans_[3];
  Stamp now_{1'000'000'000'000};
};

}  // namespace

std::size_t virtualize_bytes(const std::uint8_t* data, std::size_t size,
                             const std::function<void(const VirtualScan&, const Virtualizer&)>& look) {
  Bytes in(data, size);
  return Run(in, look).all();
}

}  // namespace lidard::sim
