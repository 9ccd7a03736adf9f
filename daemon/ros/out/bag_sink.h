// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/health/diagnostics.h"
#include "daemon/ros/out/message_rows.h"

namespace lidard {

class BagFile;

/// A bag that cannot be written: "cannot write bag 'out.bag': No space left on device; …".
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes the messages for ROS into a bag; needs no master. The time of a message in the bag is the frame's
/// `released`. The same calls give the same file, byte by byte.
class BagSink : public DiagnosticSink {
 public:
  /// Creates or overwrites the file; throws BagError.
  explicit BagSink(const std::string& path);
  ~BagSink() override;

  void publish(const OutputTopic& topic, const Frame& frame, Stamp released) override;
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override;
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override;
  /// The outline of the vehicle, if it has one.
  void outline(const VehicleConfig& vehicle, Stamp released);

  /// Messages written so far.
  std::size_t messages() const { return messages_; }
  /// The first error of writing; empty: none. After an error nothing more is written.
  const std::string& error() const { return error_; }
  /// Writes the index and closes the file; throws BagError if the bag is not complete on disk. The destructor
  /// closes too, and ignores errors.
  void close();

 private:
  void give_up(const std::exception& problem, int error_number);
  /// Calls step(), which may fail; false if it did.
  template <class Step>
  bool attempt(const Step& step);
  void write(const std::string& topic, Stamp released, const RawMessage& message, bool latched = false);

  const std::string path_;
  const ClockStep clock_;                                        // a replay has one time scale
  std::map<std::string, std::unique_ptr<MessageMaker>> makers_;  // by topic
  std::unique_ptr<BagFile> bag_;                                 // nullptr: closed, or given up
  std::size_t messages_ = 0;
  std::string error_;
};

}  // namespace lidard
