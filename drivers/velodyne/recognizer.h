// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/bytes.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// Recognises which Velodyne sent a stream: by its product byte, unless the packet period contradicts it.
class Recognizer {
 public:
  void add(ByteView payload);
  /// nullptr: no Velodyne, or one without a row.
  const ModelRow* verdict() const;
  /// A sentence when byte and period disagree or the product is not supported; else empty.
  std::string remark() const;

 private:
  const ModelRow* by_product() const;
  /// The median step between stamps; 0 while fewer than four packets were seen.
  Span median_period() const;

  std::uint64_t packets_ = 0;
  std::uint64_t dual_packets_ = 0;
  std::uint8_t product_ = 0;
  std::size_t banks_ = 1;
  std::uint32_t last_us_ = 0;
  std::array<std::int64_t, 128> steps_{};
  std::size_t step_count_ = 0;
};

}  // namespace lidard::velodyne
