// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// A bag that cannot be written: "cannot write bag 'out.bag': No space left on device; …".
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes the messages that ROS would have got into a bag; needs no master. The time of a message in the bag
/// is the frame's `released`. The same calls give the same file, byte by byte.
class BagSink : public FrameSink {
 public:
  /// Creates or overwrites the file; throws BagError.
  explicit BagSink(const std::string& path);
  ~BagSink() override;

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override;
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override;
  void message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) override;
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override;
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override;

  /// Messages written so far.
  std::size_t messages() const;
  /// What went wrong while writing; empty if nothing did. After an error nothing more is written.
  const std::string& error() const;
  /// Writes the index and closes the file; throws BagError if the bag is not complete on disk. The destructor
  /// closes too, and keeps errors to itself.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidard
