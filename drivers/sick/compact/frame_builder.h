// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "drivers/driver.h"
#include "drivers/driver_base.h"
#include "drivers/sick/compact/open_frames.h"
#include "drivers/sick/compact/segment.h"

namespace lidard::sick {

/// Device time as the clock counts it. `us` is at most what is_plausible() lets pass.
inline Span device_span(std::uint64_t us) { return std::chrono::microseconds(static_cast<std::int64_t>(us)); }

/// What may be wrong with a stream of segments.
enum class SegmentTrouble : std::uint8_t {
  geometry,
  layers,
  uneven,
  no_beams,
  other_device,
  far,
  dialogue,
  count_
};
using SegmentWarnings = WarningBoard<SegmentTrouble>;

/// Why and how whole a frame ends.
struct FrameEnd {
  bool torn = false;           ///< cut off by the begin or end of the data
  std::uint64_t segments = 0;  ///< bit n: segment n is there
  std::uint64_t expected = 0;  ///< as OpenFrames::expected()
  bool complete() const { return expected != 0 && (segments & expected) == expected; }
};

/// What is common to the makers of scans and clouds. They write segments into as many frames as
/// OpenFrames keeps open.
class FrameBuilder {
 public:
  virtual ~FrameBuilder() = default;
  /// Reject::none, or why segments like this one make no frame of the model.
  virtual Reject check(const Segment& segment) = 0;
  /// True if the segment continues the frames so far; false: begin anew.
  virtual bool continues(const Segment& segment) const = 0;
  virtual void adopt(const Segment& segment) = 0;
  virtual void begin(std::size_t slot) = 0;
  virtual void add(std::size_t slot, const Segment& segment, std::uint32_t packet) = 0;
  /// Hands the frame on; false: it was not whole enough.
  virtual bool end(std::size_t slot, const FrameEnd& how, DriverOutput& out) = 0;
  /// The stream starts again.
  virtual void restart() = 0;
};

/// Scans of a single-plane device, of constant geometry.
std::unique_ptr<FrameBuilder> make_scan_builder(const DriverConfig& config, const DeviceClock& clock,
                                                SegmentWarnings& warnings);
/// Clouds of a device with several layers.
std::unique_ptr<FrameBuilder> make_cloud_builder(const DriverConfig& config, const DeviceClock& clock);

}  // namespace lidard::sick
