// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/frames/scan.h"
#include "drivers/model.h"

namespace lidard {

/// Common part of all drivers.
class DriverBase : public Driver {
 public:
  const Counters& counters() const final { return counters_; }
  const DeviceInfo& info() const final { return info_; }

 protected:
  explicit DriverBase(const DriverConfig& config) : config_(config) {
    info_.set("Vendor Name", config.model->vendor);
    info_.set("Product Name", config.model->product);
  }
  /// Updates the details of the device's clock once per second. The device's clock is never used as the time
  /// of day; `wraps`: overflows of its counter.
  void describe_clock(const DeviceClock& clock, std::uint64_t wraps, Stamp now) {
    if (!clock.ready() || std::chrono::abs(now - clock_described_) < std::chrono::seconds(1)) return;
    clock_described_ = now;
    const auto set = [this](std::string_view key, const char* format, auto value) {
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), format, value);
      info_.set(key, text.data());
    };
    const bool smooth = config_.clock == ClockMode::smooth;
    info_.set("Stamps", !smooth               ? "by each packet's arrival"
                        : clock.knows_drift() ? "by the device's clock, drift measured"
                                              : "by the device's clock, drift not yet measured");
    set("Clock drift (ppm)", "%.1f", 0.0 - clock.drift_ppm());
    set("Clock residual (ms)", "%.3f", seconds(clock.spread()) * 1e3);
    set("Clock restarts", "%llu", static_cast<unsigned long long>(counters_.clock_steps));
    set("Clock overflows", "%llu", static_cast<unsigned long long>(wraps));
  }
  /// Removes all details but vendor and product.
  void clear_details() { info_.details.resize(2); }

  /// Passes a chunk of a stream to its reader and every complete item to `handle`. The reader counts bytes
  /// that belong to no item.
  template <class Item, class Reader, class Handle>
  Verdict read_stream(const Packet& packet, Reader& reader, Handle handle) {
    counters_.bytes += packet.payload.size();
    if (packet.stream_start || packet.missing > 0) reader.interrupt();
    reader.add(packet.payload);
    Verdict all;
    for (Item item; reader.next(item);) include_verdict(handle(item), all);
    return all;
  }
  /// Passes the complete items of a chunk to `note` before read_stream() does, and leaves `reader` and
  /// counters as they are. The first read of a stream may hold several scans that waited for it: the newest
  /// one, with which the clock begins, shows how late they are, so that all keep the device's intervals.
  template <class Item, class Reader, class Note>
  void look_ahead(const Packet& packet, const Reader& reader, Note note) {
    const Counters before = counters_;
    Reader ahead = reader;
    if (packet.stream_start || packet.missing > 0) ahead.interrupt();
    ahead.add(packet.payload);
    for (Item item; ahead.next(item);) note(item);
    counters_ = before;
  }
  /// Counts the verdict on an item and adds it to `all`, the verdict on the bytes that hold it.
  void include_verdict(const Verdict& item, Verdict& all) {
    all.has_data = all.has_data || item.has_data;
    all.device = item.device;
    if (item.reject == Reject::none) return;
    counters_.reject(item.reject);
    all.reject = item.reject;
  }

  /// For Verdict::device, "scanner 17"; without a number (0) nothing.
  std::string_view device_named(const char* kind, std::uint32_t number) {
    if (number == 0) return {};
    if (std::exchange(device_, number) != number) device_name_ = kind + std::to_string(number);
    return device_name_;
  }

  /// True if the bytes equal those of the last call: the network duplicates packets.
  bool is_repeated(ByteView bytes) {
    if (bytes.text() == std::string_view(last_item_)) return true;
    last_item_ = bytes.text();
    return false;
  }
  void forget_repeated() { last_item_.clear(); }

  DriverConfig config_;
  Counters counters_;
  DeviceInfo info_;

 private:
  Stamp clock_described_;
  std::uint32_t device_ = 0;
  std::string device_name_;
  std::string last_item_;
};

/// Stores a sample of an inertial unit; `turned` (w x y z) is used only if it is a rotation.
inline void set_imu(const std::array<double, 3>& acceleration, const std::array<double, 3>& velocity,
                    const std::array<double, 4>& turned, ReusedMessage<ImuSample>& sample) {
  sample->linear_acceleration = {acceleration[0], acceleration[1], acceleration[2]};
  sample->angular_velocity = {velocity[0], velocity[1], velocity[2]};
  const Eigen::Quaterniond quaternion(turned[0], turned[1], turned[2], turned[3]);
  sample->orientation.reset();
  if (std::fabs(quaternion.norm() - 1) < 0.1) sample->orientation = quaternion.normalized();
}

/// Frame and limits of a planar scanner's scans.
inline void prepare_scan(const DriverConfig& config, PlanarScan& scan) {
  scan.frame_id = config.frame_id;
  scan.range_min = static_cast<float>(config.model->range_min);
  scan.range_max = static_cast<float>(config.model->range_max);
}

/// Sets the beams of a scan to those of `beams` beams, from `angle` in steps of `step` (rad), that lie
/// between the configured angles. Returns the window.
inline BeamWindow choose_beams(const DriverConfig& config, double angle, double step, std::size_t beams,
                               PlanarScan& scan) {
  const BeamWindow kept = beams_inside(config.sector(), angle, step, beams);
  scan.beams = kept.count;
  scan.set_angles(static_cast<float>(angle + step * static_cast<double>(kept.first)),
                  static_cast<float>(step));
  return kept;
}

/// `fault`: the device itself is in error, and its data must not be relied on.
enum class Severity : std::uint8_t { warning, fault };

/// The sentences, each with its remedy, for what a device reports of itself, and the worst severity.
struct SelfReport {
  std::string text;
  Severity severity = Severity::warning;

  void add(bool is_so, Severity how_bad, std::string_view sentence) {
    if (!is_so) return;
    text += (text.empty() ? "" : ". ") + std::string(sentence);
    severity = std::max(severity, how_bad);
  }
};

/// One warning per kind of trouble, in DeviceInfo::warnings while the trouble lasts.
template <class Kind>
class WarningBoard {
 public:
  explicit WarningBoard(DeviceInfo& info) : info_(info) {}

  /// An empty text clears the warning.
  void set(Kind kind, std::string text, Severity severity = Severity::warning) {
    std::string& slot = texts_[static_cast<std::size_t>(kind)];
    Severity& level = severities_[static_cast<std::size_t>(kind)];
    if (slot == text && level == severity) return;
    slot = std::move(text);
    level = severity;
    show();
  }
  void show(Kind kind, SelfReport report) { set(kind, std::move(report.text), report.severity); }
  void clear(Kind kind) { set(kind, {}); }
  bool is_set(Kind kind) const { return !texts_[static_cast<std::size_t>(kind)].empty(); }
  /// Sets the warning (from `make_text`) when the trouble begins and clears it when the trouble ends.
  template <class MakeText>
  void update(Kind kind, bool lasts, MakeText&& make_text, Severity severity = Severity::warning) {
    if (lasts != is_set(kind)) set(kind, lasts ? std::string(make_text()) : std::string(), severity);
  }
  /// Warnings from another source, listed first.
  void lead(const std::vector<std::string>& sentences) {
    lead_ = sentences;
    show();
  }

 private:
  void show() {
    info_.warnings = lead_;
    info_.has_fault = false;
    for (std::size_t i = 0; i < texts_.size(); ++i) {
      if (texts_[i].empty()) continue;
      info_.warnings.push_back(texts_[i]);
      info_.has_fault = info_.has_fault || severities_[i] == Severity::fault;
    }
  }

  DeviceInfo& info_;
  std::vector<std::string> lead_;
  std::array<std::string, static_cast<std::size_t>(Kind::count_)> texts_;
  std::array<Severity, static_cast<std::size_t>(Kind::count_)> severities_{};
};

}  // namespace lidard
