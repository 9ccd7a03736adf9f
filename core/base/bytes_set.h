// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace lidard {

/// Resizes lists, with some room for more: the number of a lidar's columns varies a little from turn to turn.
template <class... Lists>
void resize_amply(std::size_t size, Lists&... lists) {
  const auto resize = [size](auto& list) {
    if (list.capacity() < size) list.reserve(size + size / 16);
    list.resize(size);
  };
  (resize(lists), ...);
}

/// Calls `take` with the index of each of `count` bytes that is not 0; made for few of them.
template <class Take>
void each_set(const std::uint8_t* bytes, std::size_t count, Take take) {
  constexpr std::size_t width = sizeof(std::uint64_t);
  std::size_t i = 0;
  for (; i + width <= count; i += width) {
    std::uint64_t all = 0;
    std::memcpy(&all, bytes + i, width);
    if (all == 0) continue;
    for (std::size_t k = i; k < i + width; ++k) {
      if (bytes[k] != 0) take(k);
    }
  }
  for (; i < count; ++i) {
    if (bytes[i] != 0) take(i);
  }
}

/// True if one of `count` bytes is `value`.
inline bool holds(const void* bytes, std::size_t count, std::uint8_t value) {
  constexpr std::uint64_t ones = 0x0101010101010101U;
  const auto* const all = static_cast<const std::uint8_t*>(bytes);
  std::size_t i = 0;
  for (; i + sizeof(ones) <= count; i += sizeof(ones)) {
    std::uint64_t word = 0;
    std::memcpy(&word, all + i, sizeof(word));
    word ^= ones * value;
    // A byte that is 0 now borrows from its highest bit.
    if (((word - ones) & ~word & (ones << 7U)) != 0) return true;
  }
  for (; i < count; ++i) {
    if (all[i] == value) return true;
  }
  return false;
}

}  // namespace lidard
