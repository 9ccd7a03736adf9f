// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>

#include "daemon/offline/choice.h"
#include "daemon/python/frame_source.h"

namespace lidard::python {

/// One sensor's driver; its frames go to a FrameSource.
class Decoder;

/// The frames of all chosen sensors in captures, in the order in which they were complete.
class CaptureReader final : public FrameSource {
 public:
  /// The begin of the captures shows which sensors there are. All of them is surveyed where a sender is
  /// unknown there, or comes later. Throws std::runtime_error if there is no sensor to decode.
  CaptureReader(std::vector<std::string> captures, CaptureChoice choice, ClockMode clock);
  ~CaptureReader() override;

 private:
  bool advance() override;
  std::string sensors_json() const override;
  void free() override { capture_.reset(); }
  void add_sensors(const Survey& survey);
  bool is_new(const Packet& packet);

  const std::vector<std::string> captures_;
  const CaptureChoice choice_;
  const ClockMode clock_;
  CalibrationPtr calibration_;
  bool is_complete_ = false;  // all of the captures was surveyed
  std::vector<FoundSensor> sensors_;
  std::vector<std::unique_ptr<Decoder>> decoders_;  // of the sensors
  FlowTable<std::size_t> owners_;                   // indices of the sensors
  std::unique_ptr<MergedCapture> capture_;
};

/// One device, live: bytes in, frames out.
class LiveReader final : public FrameSource {
 public:
  /// Throws UsageError for an unknown model.
  LiveReader(const CaptureChoice& choice, ClockMode clock);
  ~LiveReader() override;
  /// The frames that a datagram (TCP: a chunk of the stream) completes; `port`: where it was sent to, 0: the
  /// model's.
  std::deque<Frame> feed(ByteView bytes, Stamp arrival, std::uint16_t port);
  /// The incomplete frame at the end.
  std::deque<Frame> finish();

 private:
  bool advance() override { return false; }
  std::string sensors_json() const override;
  void free() override {}

  std::unique_ptr<Decoder> decoder_;
  bool is_first_ = true;
};

}  // namespace lidard::python
