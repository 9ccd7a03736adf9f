// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "core/base/bytes.h"
#include "core/base/time.h"

namespace lidard {

/// One record of a capture file.
struct CaptureRecord {
  Stamp stamp;
  ByteView bytes;               ///< as captured; valid until the next record is read
  std::uint32_t length = 0;     ///< on the wire; more than `bytes` where the snapshot length cut it
  std::uint32_t link_type = 0;  ///< LINKTYPE_ number
};

/// Reads the records of a capture file one after the other.
class CaptureReader {
 public:
  CaptureReader() = default;
  CaptureReader(const CaptureReader&) = delete;
  CaptureReader& operator=(const CaptureReader&) = delete;
  virtual ~CaptureReader() = default;

  /// False at the end, be it good or bad.
  virtual bool next(CaptureRecord& record) = 0;
  /// What ended the capture early, "what at byte N"; empty if nothing did.
  virtual const std::string& error() const = 0;
  /// True if the file ended inside a record, or inside what its length says to be one.
  virtual bool ran_out() const = 0;
  /// Bytes read.
  virtual std::uint64_t position() const = 0;
};

/// Closes a FILE.
struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, FileCloser>;

/// A classic pcap file, through libpcap. Throws CaptureError, whose message begins with `name`.
std::unique_ptr<CaptureReader> open_pcap(FileHandle file, const std::string& name);

/// A pcapng file of `size` bytes (draft-ietf-opsawg-pcapng): any number of sections, interfaces and link
/// types. Throws CaptureError.
std::unique_ptr<CaptureReader> open_pcapng(FileHandle file, const std::string& name, std::uint64_t size);

/// Whichever of the two the open file `fd` of `size` bytes is, from its beginning; throws CaptureError where
/// it is neither. The descriptor must outlive the reader; its offset is neither used nor changed.
std::unique_ptr<CaptureReader> open_capture(int fd, const std::string& name, std::uint64_t size);

}  // namespace lidard
