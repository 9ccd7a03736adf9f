// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/recognizer.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// A row of the family whose blocks the packet has; nullptr if it is no data packet.
const ModelRow* family_of(ByteView payload);

/// Recognises which Velodyne sent a stream: by the order of its blocks, its product byte unless the packet
/// period contradicts it, and, of an HDL-64E, its status bytes.
class VelodyneRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override;
  std::string_view verdict() const override;
  /// Every product of the rows that fit, so that only a person can tell: a Puck LITE has the row of a VLP-16.
  std::vector<std::string_view> others() const override;
  /// Byte and period disagree, or the product is not supported.
  std::string remark() const override;

 private:
  /// nullptr: no Velodyne, or one without a row.
  const ModelRow* row() const;
  /// Rows that the packets fit beside row().
  std::vector<const ModelRow*> other_rows() const;
  const ModelRow* by_product() const;
  bool fits_period(const ModelRow& row) const;
  bool is_byte_right() const;
  /// Whether an HDL-64E with pairs of blocks is of that generation; by the status bytes, else by the period.
  bool is_possible_generation(const ModelRow& row) const;
  void note_status(std::uint8_t type);
  /// The median step between stamps; 0 while fewer than four packets were seen.
  Span median_period() const;

  std::uint64_t packets_ = 0;
  std::uint64_t dual_packets_ = 0;
  std::uint8_t product_ = 0;
  const ModelRow* family_ = nullptr;
  std::uint32_t last_us_ = 0;
  std::array<std::int64_t, 128> steps_{};
  std::size_t step_count_ = 0;
  std::uint8_t last_type_ = 0;  // of the status bytes of an HDL-64E
  std::uint64_t warnings_ = 0;  // cycles of them that have a warning byte
  std::uint64_t quiet_ = 0;     // and that have none
};

}  // namespace lidard::velodyne
