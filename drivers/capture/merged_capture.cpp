// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/merged_capture.h"

#include <algorithm>

namespace lidard {

MergedCapture::MergedCapture(const std::vector<std::string>& paths) {
  files_.reserve(paths.size());
  for (const auto& path : paths) files_.push_back({PcapSource(path), {}, false});
  for (File& file : files_) fill(file);
}

bool MergedCapture::next(Packet& packet) {
  if (given_ != nullptr) fill(*given_);
  given_ = nullptr;
  for (File& file : files_) {
    if (file.ready && (given_ == nullptr || file.packet.arrival < given_->packet.arrival)) given_ = &file;
  }
  if (given_ == nullptr) return false;
  packet = given_->packet;
  return true;
}

void MergedCapture::rewind() {
  given_ = nullptr;
  for (File& file : files_) {
    file.source.rewind();
    fill(file);
  }
}

std::vector<std::string> MergedCapture::errors() const {
  std::vector<std::string> all;
  for (const File& file : files_) {
    if (!file.source.error().empty()) all.push_back(file.source.error());
  }
  return all;
}

bool MergedCapture::is_damaged() const {
  return std::any_of(files_.begin(), files_.end(), [](const File& file) { return file.source.is_damaged(); });
}

CaptureCounters MergedCapture::counters() const {
  CaptureCounters sum;
  const auto add = [](const auto& list, const auto& counters, auto& to) {
    for (const auto& counter : list) to.*counter.value += counters.*counter.value;
  };
  for (const File& file : files_) {
    const CaptureCounters& c = file.source.counters();
    add(capture_counts, c, sum);
    add(capture_losses, c, sum);
    add(tcp_counts, c.tcp, sum.tcp);
    add(tcp_losses, c.tcp, sum.tcp);
  }
  return sum;
}

double MergedCapture::progress() const {
  double read = 0;
  double all = 0;
  for (const File& file : files_) {
    read += static_cast<double>(file.source.position());
    all += static_cast<double>(file.source.size());
  }
  return all > 0 ? read / all : 1;
}

}  // namespace lidard
