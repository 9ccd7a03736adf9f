// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/offline/survey.h"
#include "drivers/calibration.h"

namespace lidard {

/// Which sensors of captures are decoded, and as what.
struct CaptureChoice {
  std::string model;                ///< empty: from the packets
  std::optional<IpAddress> source;  ///< only packets from this sender
  std::uint16_t source_port = 0;    ///< 0: any
  std::uint16_t port = 0;           ///< destination port; 0: any
  std::string calibration;          ///< file; empty: that of the model or the device
  std::string calibration_model;    ///< ros_drivers, exact or veloview; empty: the file's default

  /// True if the packet is of the requested sender and port; the port of a connection is the device's.
  bool is_wanted(const Packet& packet) const;
  /// Sets sender and port from "IP" or "IP:PORT". False: the text is neither.
  bool parse_source(const std::string& text);
};

/// A mistake in an option. Exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The requested model; nullptr: none is. Throws UsageError for an unknown name.
const Model* model_of(const CaptureChoice& choice);
/// Surveys the chosen sensors until each has given a frame, by what came within `part` of the begin of each
/// capture. Throws std::runtime_error if there is none. Prints why a capture was not read to its end.
Survey survey_of_choice(const std::vector<std::string>& captures, const CaptureChoice& choice,
                        std::ostream& err, Span part = Span::max());
/// Throws std::runtime_error, with the sensors to choose from, if there are several.
void check_single(const std::vector<std::string>& captures, const std::vector<FoundSensor>& sensors);
/// "velodyne_vlp16 192.168.1.201 -> port 2368".
std::string text_of(const FoundSensor& sensor);

/// Reads a calibration file as parse_calibration() does.
Calibration load_calibration(const std::string& path, std::vector<std::string>& warnings);
using CalibrationPtr = std::shared_ptr<const Calibration>;
/// The requested file, with its notes in `err`; nullptr: none is requested. Throws ConfigError.
CalibrationPtr read_calibration(const CaptureChoice& choice, std::ostream& err);
/// What a model is decoded with: the file (nullptr: none) with the requested or default equations, or the
/// model's table with those requested; nullptr: the driver's default. Throws ConfigError if it does not fit.
CalibrationPtr calibration_for(const CaptureChoice& choice, const CalibrationPtr& file, const Model& model,
                               std::ostream& err);

}  // namespace lidard
