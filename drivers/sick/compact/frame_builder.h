// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/base/counters.h"
#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "drivers/driver.h"
#include "drivers/driver_base.h"
#include "drivers/sick/compact/compact_telegram.h"

namespace lidard::sick {

/// Assigns segments to frames and decides when a frame is complete.
///
/// A device omits the segments that its angle filter hides, so the frame's size is learned from frames that
/// are complete by the telegram counter. Two frames can be open at a time, so that telegrams may be
/// reordered.
class OpenFrames {
 public:
  static constexpr std::size_t most = 2;

  struct Frame {
    bool open = false;
    std::uint64_t number = 0;
    std::uint64_t segments = 0;  ///< bit n: segment n was received
    std::uint64_t first_counter = 0, last_counter = 0;
    std::size_t telegrams = 0;
    bool proven = false;  ///< when released: no telegram is missing before, inside or after the frame

    bool is_gapless() const { return last_counter - first_counter + 1 == telegrams; }
  };

  /// The slot of the frame that `segment` belongs to. Before, `release(slot)` is called for frames that must
  /// make room, oldest first.
  template <class Release>
  Reject assign(const Segment& segment, std::size_t& slot, Release&& release) {
    if (segment.index >= max_segments) return Reject::field;
    if (released_any_ && segment.frame <= released_number_) {
      note_late(segment);
      return Reject::stale;
    }
    if (!find_slot(segment.frame, slot)) {
      if (open_count() == most) {
        if (segment.frame < frames_[oldest()].number) return Reject::stale;
        release_oldest(release);
      }
      slot = frames_[0].open ? 1 : 0;
      frames_[slot] = Frame{};
      frames_[slot].open = true;
      frames_[slot].number = segment.frame;
      frames_[slot].first_counter = frames_[slot].last_counter = segment.counter;
    }
    Frame& frame = frames_[slot];
    const std::uint64_t bit = std::uint64_t{1} << segment.index;
    if ((frame.segments & bit) != 0) return Reject::duplicate;
    frame.segments |= bit;
    ++frame.telegrams;
    if (segment.counter < frame.first_counter) frame.first_counter = segment.counter;
    if (segment.counter > frame.last_counter) frame.last_counter = segment.counter;
    return Reject::none;
  }

  /// Call after the segment was used; calls `release(slot)` for the frames that it finishes.
  template <class Release>
  void settle(Release&& release) {
    while (open_count() == 2 && is_overtaken(frames_[oldest()], frames_[newest()])) release_oldest(release);
    while (open_count() > 0 && is_complete(frames_[newest()])) release_oldest(release);
    while (open_count() > 0 && is_complete(frames_[oldest()])) release_oldest(release);
  }

  /// Closes the oldest open frame, complete or not; false if none is open.
  template <class Release>
  bool release_oldest(Release&& release) {
    if (open_count() == 0) return false;
    const std::size_t slot = oldest();
    close(slot);
    release(slot);
    return true;
  }

  /// True if the segment is too old to be late: the device counts its frames anew.
  bool counts_anew(const Segment& segment) const {
    constexpr std::uint64_t latest = 64;
    return released_any_ && segment.frame + latest < released_number_;
  }

  const Frame& frame(std::size_t slot) const { return frames_[slot]; }
  /// Bit n: segment n belongs to a frame; 0: not yet known.
  std::uint64_t expected() const { return expected_; }
  /// Resets the stream and the learned size.
  void reset() {
    restart();
    expected_ = 0;
  }

  /// Resets the stream.
  void restart() {
    frames_ = {};
    released_any_ = false;
    unproven_ = 0;
    seen_ = 0;
  }

 private:
  /// After this number of frames the segments so far count as complete, without a proof by the telegram
  /// counter.
  static constexpr int patience = 8;

  bool find_slot(std::uint64_t number, std::size_t& slot) const {
    for (std::size_t i = 0; i < most; ++i) {
      if (frames_[i].open && frames_[i].number == number) {
        slot = i;
        return true;
      }
    }
    return false;
  }

  std::size_t oldest() const {
    if (open_count() < 2) return frames_[0].open ? 0 : 1;
    return frames_[0].number < frames_[1].number ? 0 : 1;
  }

  std::size_t newest() const { return open_count() < 2 ? oldest() : 1 - oldest(); }

  std::size_t open_count() const { return (frames_[0].open ? 1U : 0U) + (frames_[1].open ? 1U : 0U); }

  bool is_complete(const Frame& frame) const {
    return expected_ != 0 && (frame.segments & expected_) == expected_;
  }

  /// True if the old frame can get no more segments: the new frame follows without a gap or has progressed
  /// further.
  bool is_overtaken(const Frame& old_frame, const Frame& new_frame) const {
    if (new_frame.telegrams > 1) return true;
    return old_frame.is_gapless() && new_frame.first_counter == old_frame.last_counter + 1 && released_any_ &&
           old_frame.first_counter == released_counter_ + 1;
  }

  void close(std::size_t slot) {
    Frame& frame = frames_[slot];
    frame.open = false;
    const bool head_is_there = released_any_ && frame.first_counter == released_counter_ + 1;
    const Frame& other = frames_[1 - slot];
    const bool tail_is_there = other.open && other.first_counter == frame.last_counter + 1;
    frame.proven = frame.is_gapless() && head_is_there && tail_is_there;
    learn(frame);
    released_any_ = true;
    released_number_ = frame.number;
    released_counter_ = frame.last_counter;
  }

  void learn(const Frame& frame) {
    // Complete frames count too: the device may now send more segments.
    const bool is_whole = frame.proven || is_complete(frame);
    if (!is_whole) seen_ |= frame.segments;
    if (!is_whole && ++unproven_ < patience) return;
    expected_ = is_whole ? frame.segments : seen_;
    unproven_ = 0;
    seen_ = 0;
  }

  /// Learns from a late segment of a complete frame that frames have more segments.
  void note_late(const Segment& segment) {
    if (expected_ != 0 && segment.frame == released_number_ && segment.counter > released_counter_)
      expected_ |= std::uint64_t{1} << segment.index;
  }

  std::array<Frame, most> frames_{};
  std::uint64_t expected_ = 0;
  std::uint64_t seen_ = 0;
  int unproven_ = 0;
  bool released_any_ = false;
  std::uint64_t released_number_ = 0;
  std::uint64_t released_counter_ = 0;  // the last counter of the last frame released
};

/// Follows a counter of telegrams: finds missing, repeated and late ones.
class TelegramOrder {
 public:
  enum class Verdict { next, late, duplicate, restart };

  /// Adds the next telegram; `counters` gets lost and late ones.
  Verdict add(std::uint64_t counter, Counters& counters) {
    const bool ahead = counter > newest_;
    const std::uint64_t distance = ahead ? counter - newest_ : newest_ - counter;
    if (!started_ || (ahead ? distance > longest_gap : distance >= window)) {
      const bool restart = started_;
      started_ = true;
      newest_ = counter;
      seen_ = 1;
      return restart ? Verdict::restart : Verdict::next;
    }
    if (ahead) {
      counters.lost_packets += distance - 1;
      seen_ = distance < window ? seen_ << distance : 0;
      seen_ |= 1;
      newest_ = counter;
      return Verdict::next;
    }
    const std::uint64_t bit = std::uint64_t{1} << distance;
    if ((seen_ & bit) != 0) return Verdict::duplicate;
    seen_ |= bit;
    ++counters.reordered;
    // It was counted as lost, unless it was sent before the first received telegram.
    if (counters.lost_packets > 0) --counters.lost_packets;
    return Verdict::late;
  }
  void reset() { started_ = false; }

 private:
  /// Number of remembered telegrams; an older one belongs to another count.
  static constexpr std::uint64_t window = 64;
  /// A larger step ahead also starts another count; equals some minutes of the fastest device.
  static constexpr std::uint64_t longest_gap = 100'000;

  bool started_ = false;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit n: newest_ - n was received
};

/// Device time; `us` is limited by is_plausible().
inline Span device_span(std::uint64_t us) { return std::chrono::microseconds(static_cast<std::int64_t>(us)); }

/// Faults of a stream of segments.
enum class SegmentTrouble : std::uint8_t { geometry, layers, uneven, no_beams, other_device, count_ };
using SegmentWarnings = WarningBoard<SegmentTrouble>;

/// How a frame ends.
struct FrameEnd {
  bool torn = false;           ///< cut off by the begin or end of the data
  std::uint64_t segments = 0;  ///< bit n: segment n was received
  std::uint64_t expected = 0;  ///< as OpenFrames::expected()
  bool complete() const { return expected != 0 && (segments & expected) == expected; }
};

/// Common interface of the builders of scans and clouds, which fill the frames of OpenFrames.
class FrameBuilder {
 public:
  virtual ~FrameBuilder() = default;
  /// Reject::none, or why such segments cannot form a frame of the model.
  virtual Reject check(const Segment& segment) = 0;
  /// False if the segment has another layout, so that the frames must restart.
  virtual bool continues(const Segment& segment) const = 0;
  virtual void adopt(const Segment& segment) = 0;
  virtual void begin(std::size_t slot) = 0;
  virtual void add(std::size_t slot, const Segment& segment, std::uint32_t packet) = 0;
  /// Publishes the frame; false: it was too incomplete.
  virtual bool end(std::size_t slot, const FrameEnd& how, FrameReceiver& out) = 0;
  /// The stream starts again.
  virtual void restart() = 0;
};

/// Scans of a single-plane device, of constant geometry.
std::unique_ptr<FrameBuilder> make_scan_builder(const DriverConfig& config, const DeviceClock& clock,
                                                SegmentWarnings& warnings);
/// Clouds of a device with several layers.
std::unique_ptr<FrameBuilder> make_cloud_builder(const DriverConfig& config, const DeviceClock& clock);

}  // namespace lidard::sick
