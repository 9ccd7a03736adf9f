// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "drivers/capture/capture_bytes.h"

namespace lidard {

/// A capture that cannot be opened, or ends in a broken record: "file: what, at byte N; remedy".
class CaptureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One record of a capture file.
struct CaptureRecord {
  Stamp stamp;
  ByteView bytes;               ///< as captured; valid until the next record is read
  std::uint32_t length = 0;     ///< on the wire; more than `bytes` where the snapshot length cut it
  std::uint32_t link_type = 0;  ///< LINKTYPE_ number
};

/// Reads the records of a capture file one after the other: pcap of either byte order in us or ns, and pcapng
/// with any number of sections, interfaces and link types. libpcap 1.10 refuses pcapng files whose interfaces
/// differ in link type or snapshot length, as those of all interfaces of a computer do.
class CaptureReader {
 public:
  /// `fd` must outlive this. Throws CaptureError, whose message begins with `name`, where the file is no
  /// capture.
  CaptureReader(int fd, const std::string& name);

  /// False at the end, be it good or bad.
  bool next(CaptureRecord& record);
  /// Why the capture ended early, "what at byte N"; empty if it did not.
  const std::string& error() const { return error_; }
  /// True if the file ends inside its last record, as when a recording is stopped.
  bool ends_in_record() const { return ends_in_record_; }
  /// Bytes of the file that were read.
  std::uint64_t position() const { return bytes_.is_packed() ? bytes_.position() : position_; }

 private:
  /// One Interface Description Block, or the file header of a pcap file.
  struct Interface {
    std::uint32_t link_type = 0;
    std::uint32_t snapshot_length = 0;  // 0: no limit
    std::uint8_t resolution = 6;        // if_tsresol: a tick is 10^-6 s
    std::int64_t offset_s = 0;          // if_tsoffset

    Stamp stamp(std::uint64_t ticks) const;
  };

  ByteView peek(std::size_t size);
  void skip(std::size_t size);
  bool fail(const std::string& what);
  bool run_out();
  std::uint16_t u16(ByteView bytes, std::size_t at) const { return big_ ? bytes.be16(at) : bytes.le16(at); }
  std::uint32_t u32(ByteView bytes, std::size_t at) const { return big_ ? bytes.be32(at) : bytes.le32(at); }

  bool read_file_header(ByteView head);
  bool read_record(CaptureRecord& record);
  bool read_block(CaptureRecord& record);
  bool read_interface(ByteView body);
  bool read_packet(std::uint32_t type, ByteView body, CaptureRecord& record);

  CaptureBytes bytes_;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what of the buffer is not used yet
  std::uint64_t position_ = 0;       // of `begin_` in the capture
  std::uint64_t block_ = 0;          // where the current record or block begins
  bool is_pcapng_ = false;
  bool big_ = false;  // byte order of the file or section
  std::vector<Interface> interfaces_;
  Stamp last_stamp_;
  std::string error_;
  bool ends_in_record_ = false;
};

}  // namespace lidard
