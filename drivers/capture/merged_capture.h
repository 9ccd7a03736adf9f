// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"

namespace lidard {

/// Several captures read as one, in the order of their stamps: one file per sensor, or one recording in
/// pieces.
class MergedCapture {
 public:
  /// Throws CaptureError.
  explicit MergedCapture(const std::vector<std::string>& paths);

  /// The next datagram of all files; its payload stays valid until the next call.
  bool next(Packet& packet);
  void rewind();
  /// Messages of files that ended early.
  std::vector<std::string> errors() const;
  /// True if one of them is damaged: more is missing than an unfinished last record.
  bool is_damaged() const;
  /// Sum over the files.
  CaptureCounters counters() const;
  /// Part of the bytes read, 0 ... 1.
  double progress() const;

 private:
  struct File {
    PcapSource source;
    Packet packet;
    bool ready = false;
  };
  void fill(File& file) { file.ready = file.source.next(file.packet); }

  std::vector<File> files_;
  File* given_ = nullptr;  // whose packet the caller holds
};

}  // namespace lidard
