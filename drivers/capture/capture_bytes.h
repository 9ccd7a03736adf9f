// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace lidard {

/// Packed bytes on their way through one of the libraries that unpack.
struct PackedBytes {
  const std::uint8_t* in = nullptr;
  std::size_t in_left = 0;
  std::uint8_t* out = nullptr;
  std::size_t out_left = 0;
};

/// One way of packing, through its library.
class Codec {
 public:
  virtual ~Codec() = default;
  /// Unpacks what it can. Returns what is wrong with the bytes, or nullptr.
  virtual const char* run(PackedBytes& bytes) = 0;
  /// True where the packed bytes may end.
  virtual bool complete() const = 0;
  virtual const char* name() const = 0;
};

/// The bytes of a capture file in order; a gzip or zstd file is unpacked while it is read. Needs memory for
/// one window of the packing, not for the file.
class CaptureBytes {
 public:
  /// `fd` must outlive this; its offset is neither used nor changed.
  explicit CaptureBytes(int fd);

  /// Reads up to `size` bytes; 0 at the end, -1 where they cannot be read (error() says why, or errno).
  ssize_t read(std::uint8_t* out, std::size_t size);

  bool is_packed() const { return codec_ != nullptr; }
  /// Bytes of the file that were read.
  std::uint64_t position() const { return position_; }
  /// The fault of the packed file, and where it is; empty: none.
  const std::string& error() const { return error_; }

 private:
  ssize_t read_packed(std::uint8_t* out, std::size_t size);
  ssize_t fail(const std::string& what);

  int fd_;
  std::unique_ptr<Codec> codec_;  // nullptr: not packed
  std::vector<std::uint8_t> buffer_;
  PackedBytes bytes_;
  bool file_ended_ = false;
  std::uint64_t position_ = 0;
  std::string error_;
};

}  // namespace lidard
