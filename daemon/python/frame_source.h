// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/frames/cloud.h"
#include "core/frames/scan.h"

namespace lidard::python {

/// The memory behind the arrays of a cloud.
struct CloudMemory {
  PointBytes points;
  std::vector<CloudColumn> columns;
};
/// Memory goes back to a few free ones when Python drops the arrays: the system would have to zero what the
/// heap gives back to it, which takes twice as long as decoding.
struct FreeMemory {
  void operator()(CloudMemory* memory) const;
};
using CloudMemoryPtr = std::unique_ptr<CloudMemory, FreeMemory>;

/// A cloud or merged cloud.
struct CloudFrame {
  std::string frame_id;
  Stamp stamp;
  bool complete = true;
  bool has_sensors = false;  ///< the points are MergedPoints
  std::uint32_t height = 0;  ///< as Cloud::height
  CloudMemoryPtr memory;
};

/// A frame on its way to Python.
struct Frame {
  std::string sensor;  ///< empty: made of several
  std::string topic;   ///< of a replay
  std::variant<std::unique_ptr<PlanarScan>, CloudFrame> data;
};

/// Gives frames one after the other. Threads wait for each other.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next frame; none at the end, or if many packets gave none: call again unless ended().
  std::optional<Frame> next();
  bool ended() const;
  /// Sentences on the capture since the last call.
  std::vector<std::string> new_warnings();
  /// Why not all frames came, once; empty: all did.
  std::string new_error();
  /// JSON: what came from each sensor so far.
  std::string sensors() const;
  /// Ends the iteration, and frees what it needs.
  void close();

 protected:
  /// Reads on; false at the end, once everything that is complete was added.
  virtual bool advance() = 0;
  virtual std::string sensors_json() const = 0;
  virtual void free() = 0;

  void add(const std::string& sensor, const PlanarScan& scan, const std::string& topic = {});
  /// `columns` may be swapped away, as the points are.
  void add(const std::string& sensor, Cloud& cloud, std::vector<CloudColumn>& columns,
           const std::string& topic = {});
  void add(MergedCloud& cloud, const std::string& topic);
  std::deque<Frame>& frames() { return frames_; }

  mutable std::mutex mutex_;
  std::vector<std::string> warnings_;
  std::string error_;

 private:
  std::deque<Frame> frames_;
  bool ended_ = false;
};

}  // namespace lidard::python
