// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace lidard {

/// A view of bytes that another object owns; valid as long as that object.
///
/// Offsets count from the start of the view. Check lengths from the wire with `has()` first: a read outside
/// the view is a bug and ends the process.
class ByteView {
 public:
  constexpr ByteView() = default;
  constexpr ByteView(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  explicit ByteView(std::string_view text)
      : data_(reinterpret_cast<const std::uint8_t*>(text.data())), size_(text.size()) {}

  constexpr const std::uint8_t* data() const { return data_; }
  constexpr std::size_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr const std::uint8_t* begin() const { return data_; }
  constexpr const std::uint8_t* end() const { return data_ + size_; }

  /// True if `length` bytes from `offset` on lie inside the view (safe against overflow).
  constexpr bool has(std::size_t offset, std::size_t length) const {
    return offset <= size_ && length <= size_ - offset;
  }
  /// `length` bytes from `offset` on.
  ByteView sub(std::size_t offset, std::size_t length) const {
    require(offset, length);
    return {data_ + offset, length};
  }
  /// All bytes from `offset` on.
  ByteView from(std::size_t offset) const { return sub(offset, size_ - (offset <= size_ ? offset : size_)); }
  std::string_view text() const { return {reinterpret_cast<const char*>(data_), size_}; }

  std::uint8_t u8(std::size_t o) const { return static_cast<std::uint8_t>(little(o, 1)); }
  std::uint16_t le16(std::size_t o) const { return static_cast<std::uint16_t>(little(o, 2)); }
  std::uint32_t le32(std::size_t o) const { return static_cast<std::uint32_t>(little(o, 4)); }
  std::uint64_t le64(std::size_t o) const { return little(o, 8); }
  std::uint16_t be16(std::size_t o) const { return static_cast<std::uint16_t>(big(o, 2)); }
  std::uint32_t be32(std::size_t o) const { return static_cast<std::uint32_t>(big(o, 4)); }
  std::int32_t le32s(std::size_t o) const { return static_cast<std::int32_t>(le32(o)); }

 private:
  void require(std::size_t offset, std::size_t length) const {
    if (!has(offset, length)) std::abort();
  }
  std::uint64_t little(std::size_t o, std::size_t n) const {
    require(o, n);
    std::uint64_t value = 0;
    for (std::size_t i = n; i-- > 0;) value = value << 8U | data_[o + i];
    return value;
  }
  std::uint64_t big(std::size_t o, std::size_t n) const {
    require(o, n);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n; ++i) value = value << 8U | data_[o + i];
    return value;
  }

  const std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Resizes lists, with some room for more: the number of a lidar's columns varies a little from turn to turn.
template <class... Lists>
void resize_amply(std::size_t size, Lists&... lists) {
  const auto resize = [size](auto& list) {
    if (list.capacity() < size) list.reserve(size + size / 16);
    list.resize(size);
  };
  (resize(lists), ...);
}

/// Calls `use` with the index of each of `count` bytes that is not 0; fast where few are.
template <class Use>
void each_set(const std::uint8_t* bytes, std::size_t count, Use use) {
  constexpr std::size_t width = sizeof(std::uint64_t);
  std::size_t i = 0;
  for (; i + width <= count; i += width) {
    std::uint64_t all = 0;
    std::memcpy(&all, bytes + i, width);
    if (all == 0) continue;
    for (std::size_t k = i; k < i + width; ++k) {
      if (bytes[k] != 0) use(k);
    }
  }
  for (; i < count; ++i) {
    if (bytes[i] != 0) use(i);
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
