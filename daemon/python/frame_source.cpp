// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/python/frame_source.h"

#include <utility>

namespace lidard::python {
namespace {

/// Clouds that nobody holds any more.
class FreeList {
 public:
  CloudMemoryPtr get() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return CloudMemoryPtr(new CloudMemory);
    CloudMemoryPtr memory(free_.back().release());
    free_.pop_back();
    return memory;
  }
  void keep(std::unique_ptr<CloudMemory> memory) {
    constexpr std::size_t most = 4;
    const std::lock_guard lock(mutex_);
    if (free_.size() < most) free_.push_back(std::move(memory));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<CloudMemory>> free_;
};

/// Arrays may be dropped while the process ends.
FreeList& free_list() {
  static auto* const list = new FreeList;
  return *list;
}

}  // namespace

void FreeMemory::operator()(CloudMemory* memory) const {
  free_list().keep(std::unique_ptr<CloudMemory>(memory));
}

std::optional<Frame> FrameSource::next() {
  // So many packets take about a tenth of a second.
  constexpr int most_packets = 50'000;
  const std::lock_guard lock(mutex_);
  for (int i = 0; frames_.empty() && !ended_ && i < most_packets; ++i) ended_ = !advance();
  if (frames_.empty()) return std::nullopt;
  std::optional<Frame> frame(std::move(frames_.front()));
  frames_.pop_front();
  return frame;
}

bool FrameSource::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_ && frames_.empty();
}

std::vector<std::string> FrameSource::new_warnings() {
  const std::lock_guard lock(mutex_);
  return std::exchange(warnings_, {});
}

std::string FrameSource::new_error() {
  const std::lock_guard lock(mutex_);
  return std::exchange(error_, {});
}

std::string FrameSource::sensors() const {
  const std::lock_guard lock(mutex_);
  return sensors_json();
}

void FrameSource::close() {
  const std::lock_guard lock(mutex_);
  frames_.clear();
  error_.clear();
  if (!std::exchange(ended_, true)) free();
}

void FrameSource::add(const std::string& sensor, const PlanarScan& scan, const std::string& topic) {
  auto held = std::make_unique<PlanarScan>(scan);
  encode_ranges(scan, held->ranges.data());
  frames_.push_back({sensor, topic, std::move(held)});
}

void FrameSource::add(const std::string& sensor, Cloud& cloud, std::vector<CloudColumn>& columns,
                      const std::string& topic) {
  CloudFrame frame{cloud.frame_id, cloud.stamp, cloud.complete, false, cloud.height, free_list().get()};
  frame.memory->points.swap(cloud.points_bytes);
  frame.memory->columns.swap(columns);
  // The points of a cloud in rows are not in the order of its columns.
  if (cloud.height > 0) frame.memory->columns.clear();
  columns.clear();
  frames_.push_back({sensor, topic, std::move(frame)});
}

void FrameSource::add(MergedCloud& cloud, const std::string& topic) {
  CloudFrame frame{cloud.frame_id, cloud.stamp, true, true, cloud.height, free_list().get()};
  frame.memory->points.swap(cloud.points_bytes);
  frame.memory->columns.clear();
  frames_.push_back({{}, topic, std::move(frame)});
}

}  // namespace lidard::python
