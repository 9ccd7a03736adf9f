// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace lidard::sim {

/// Bytes that grow as a packet is written, little-endian.
class Wire {
 public:
  explicit Wire(std::size_t size = 0) : bytes_(size) {}

  void put8(std::size_t at, std::uint64_t value) { put(at, value, 1); }
  void put16(std::size_t at, std::uint64_t value) { put(at, value, 2); }
  void put32(std::size_t at, std::uint64_t value) { put(at, value, 4); }
  void put64(std::size_t at, std::uint64_t value) { put(at, value, 8); }
  void copy(std::size_t at, const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    for (std::size_t i = 0; i < size; ++i) put8(at + i, bytes[i]);
  }
  std::size_t size() const { return bytes_.size(); }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  void put(std::size_t at, std::uint64_t value, std::size_t count) {
    if (bytes_.size() < at + count) bytes_.resize(at + count);
    for (std::size_t i = 0; i < count; ++i)
      bytes_[at + i] = static_cast<std::uint8_t>(value >> 8U * i & 0xffU);
  }
  std::vector<std::uint8_t> bytes_;
};

}  // namespace lidard::sim
