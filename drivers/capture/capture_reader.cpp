// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// pcap as in draft-ietf-opsawg-pcap, pcapng as in draft-ietf-opsawg-pcapng.
#include "drivers/capture/capture_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

namespace lidard {
namespace {

constexpr const char* remedy = "; give a pcap or pcapng file, e.g. from `tcpdump -w FILE.pcap`";

constexpr std::size_t file_header = 24, record_header = 16;
/// libpcap's limits for what one packet of a network and one block may hold; other lengths are wrong.
constexpr std::uint32_t max_record = 262144, max_block = 16U << 20U;
/// More bytes than this are more than one last record.
constexpr std::size_t longest_record = 65536 + 64;

// Block types of pcapng, section 11.1.
constexpr std::uint32_t section_header = 0x0a0d0d0a, interface_description = 1, obsolete_packet = 2,
                        simple_packet = 3, enhanced_packet = 6;
constexpr std::uint32_t byte_order_magic = 0x1a2b3c4d;

constexpr std::int64_t second = 1'000'000'000;  // ns
// Half of what 64 bits hold, so that the difference of any two stamps does not overflow.
constexpr std::int64_t max_seconds = std::numeric_limits<std::int64_t>::max() / 2 / second - 1;

__extension__ typedef unsigned __int128 Wide;

/// Packed formats that are not supported: their first bytes, and the program that unpacks them.
struct OtherPacking {
  std::uint32_t first_bytes, mask;
  const char *name, *command;
};
constexpr OtherPacking other_packings[] = {{0xfd377a58, 0xffffffff, "xz", "xz -d"},
                                           {0x425a6800, 0xffffff00, "bzip2", "bunzip2"},
                                           {0x04224d18, 0xffffffff, "lz4", "lz4 -d"},
                                           {0x504b0304, 0xffffffff, "zip", "unzip"}};

std::string why_no_capture(ByteView head) {
  for (const OtherPacking& packing : other_packings) {
    if ((head.be32(0) & packing.mask) == packing.first_bytes)
      return std::string("is packed with ") + packing.name + "; only gzip and zstd are unpacked here: use `" +
             packing.command + "` first";
  }
  if (head.size() >= 7 && head.sub(0, 7).text() == "#ROSBAG")
    return "is a bag; `lidard replay`, `inspect` and `calibrate` read one whose name ends with .bag";
  return std::string("unknown file format") + remedy;
}

}  // namespace

/// if_tsresol (section 4.2) is a power of 10, or of 2 where its highest bit is set.
Stamp CaptureReader::Interface::stamp(std::uint64_t ticks) const {
  const unsigned base = (resolution & 0x80U) != 0 ? 2 : 10;
  Wide per_second = 1;
  // Beyond 100 bits all ticks together are less than a nanosecond.
  for (unsigned n = resolution & 0x7fU; n > 0 && per_second >> 100U == 0; --n) per_second *= base;
  const Wide ns = std::min<Wide>(Wide{ticks} * second / per_second, Wide{max_seconds} * second);
  const std::int64_t offset = std::clamp(offset_s, -max_seconds, max_seconds) * second;
  return {std::clamp(static_cast<std::int64_t>(ns) + offset, -max_seconds * second, max_seconds * second)};
}

CaptureReader::CaptureReader(int fd, const std::string& name) : bytes_(fd) {
  const ByteView head = peek(file_header);
  const auto refuse = [&](const std::string& why) { throw CaptureError(name + ": " + why); };
  if (!error_.empty()) refuse(error_ + "; copy or record it again");
  if (head.empty() && !bytes_.is_packed()) refuse("the file is empty (0 bytes); record it again");
  if (head.size() < 4) refuse(std::string("too short to be a capture") + remedy);
  if (!read_file_header(head)) refuse(why_no_capture(head));
}

/// Draft-ietf-opsawg-pcap section 4; a section header of pcapng is read as the first block.
bool CaptureReader::read_file_header(ByteView head) {
  if (head.size() < file_header) return false;
  is_pcapng_ = head.be32(0) == section_header &&
               (head.be32(8) == byte_order_magic || head.le32(8) == byte_order_magic);
  if (is_pcapng_) return true;
  for (big_ = false;; big_ = true) {
    const std::uint32_t magic = u32(head, 0);
    if ((magic == 0xa1b2c3d4U || magic == 0xa1b23c4dU) && u16(head, 4) == 2) {
      interfaces_.push_back(
          {u32(head, 20) & 0xffffU, 0, static_cast<std::uint8_t>(magic == 0xa1b2c3d4U ? 6 : 9), 0});
      skip(file_header);
      return true;
    }
    if (big_) return false;
  }
}

bool CaptureReader::next(CaptureRecord& record) {
  while (error_.empty() && !peek(1).empty()) {
    block_ = position_;
    if (is_pcapng_ ? read_block(record) : read_record(record)) return true;
  }
  return false;
}

/// The next `size` bytes, fewer where the file ends or cannot be read; valid until the next call.
ByteView CaptureReader::peek(std::size_t size) {
  if (end_ - begin_ < size) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    if (buffer_.size() < size) buffer_.resize(std::max<std::size_t>(size, 65'536));
  }
  while (end_ - begin_ < size) {
    const ssize_t got = bytes_.read(buffer_.data() + end_, buffer_.size() - end_);
    if (got < 0)
      error_ =
          bytes_.error().empty() ? std::string("cannot be read: ") + std::strerror(errno) : bytes_.error();
    if (got <= 0) break;
    end_ += static_cast<std::size_t>(got);
  }
  return {buffer_.data() + begin_, std::min(size, end_ - begin_)};
}

void CaptureReader::skip(std::size_t size) {
  begin_ += size;
  position_ += size;
}

bool CaptureReader::fail(const std::string& what) {
  error_ = what + " at byte " + std::to_string(block_);
  return false;
}

/// The file ends here, or cannot be read on.
bool CaptureReader::run_out() {
  if (!error_.empty()) return false;
  ends_in_record_ = end_ - begin_ <= longest_record;
  return fail(std::string(is_pcapng_ ? "block" : "record") + " cut by the end of the file");
}

/// Draft-ietf-opsawg-pcap section 5. The stamp's seconds are unsigned: they last until 2106.
bool CaptureReader::read_record(CaptureRecord& record) {
  const ByteView header = peek(record_header);
  if (header.size() < record_header) return run_out();
  const std::uint64_t seconds = u32(header, 0), fraction = u32(header, 4);
  const std::uint32_t captured = u32(header, 8), length = u32(header, 12);
  if (captured > max_record) return fail("record of the impossible length " + std::to_string(captured));
  const ByteView all = peek(record_header + captured);
  if (all.size() < record_header + captured) return run_out();
  const Interface& file = interfaces_.front();
  const std::uint64_t per_second = file.resolution == 6 ? 1'000'000 : 1'000'000'000;
  record = {file.stamp(seconds * per_second + fraction), all.from(record_header), length, file.link_type};
  skip(all.size());
  return true;
}

/// True if the block was a packet.
bool CaptureReader::read_block(CaptureRecord& record) {
  const ByteView head = peek(12);
  if (head.size() < 12) return run_out();
  const bool is_section = head.be32(0) == section_header;
  if (is_section) {
    big_ = head.be32(8) == byte_order_magic;
    if (!big_ && head.le32(8) != byte_order_magic) return fail("section without a byte-order magic");
  }
  const std::uint32_t type = u32(head, 0), length = u32(head, 4);
  if (length < 12 || length % 4 != 0 || length > max_block)
    return fail("block of the impossible length " + std::to_string(length));
  const ByteView block = peek(length);
  if (block.size() < length) return run_out();
  if (u32(block, length - 4) != length)
    return fail("block whose two lengths differ (" + std::to_string(length) + " and " +
                std::to_string(u32(block, length - 4)) + ")");
  skip(length);
  const ByteView body = block.sub(8, length - 12);
  if (is_section) {
    if (!body.has(0, 16) || u16(body, 4) != 1) return fail("section of an unknown version");
    interfaces_.clear();
  }
  if (type == interface_description) return read_interface(body);
  const bool is_packet = type == enhanced_packet || type == simple_packet || type == obsolete_packet;
  return is_packet && read_packet(type, body, record);
}

/// Section 4.2, options as in section 3.5. Always false: no packet.
bool CaptureReader::read_interface(ByteView body) {
  constexpr std::uint16_t end = 0, if_tsresol = 9, if_tsoffset = 14;
  if (!body.has(0, 8)) return fail("interface description too short");
  Interface& interface = interfaces_.emplace_back();
  interface.link_type = u16(body, 0);
  interface.snapshot_length = u32(body, 4);
  for (std::size_t at = 8; body.has(at, 4);) {
    const std::uint16_t code = u16(body, at);
    const std::size_t length = u16(body, at + 2);
    if (code == end || !body.has(at + 4, length)) return false;
    if (code == if_tsresol && length == 1) interface.resolution = body.u8(at + 4);
    if (code == if_tsoffset && length == 8) {
      const std::uint64_t first = u32(body, at + 4), second_half = u32(body, at + 8);
      interface.offset_s =
          static_cast<std::int64_t>(big_ ? first << 32U | second_half : second_half << 32U | first);
    }
    at += 4 + (length + 3) / 4 * 4;
  }
  return false;
}

/// Sections 4.3 and 4.4 and appendix A: interface (16 bits in the obsolete block), stamp (high, low),
/// captured and original length. A simple block has the last alone: it is of the first interface, gets the
/// stamp of the packet before, and was captured up to the snapshot length.
bool CaptureReader::read_packet(std::uint32_t type, ByteView body, CaptureRecord& record) {
  const bool simple = type == simple_packet;
  const std::size_t header = simple ? 4 : 20;
  if (!body.has(0, header)) return fail("packet block too short");
  const std::uint32_t number = simple ? 0 : type == obsolete_packet ? u16(body, 0) : u32(body, 0);
  if (number >= interfaces_.size()) return fail("packet of undescribed interface " + std::to_string(number));
  const Interface& interface = interfaces_[number];
  const std::uint32_t length = u32(body, header - 4);
  std::uint32_t captured = length;
  if (!simple) {
    captured = u32(body, 12);
    last_stamp_ = interface.stamp(std::uint64_t{u32(body, 4)} << 32U | u32(body, 8));
  } else if (interface.snapshot_length > 0) {
    captured = std::min(length, interface.snapshot_length);
  }
  if (!body.has(header, captured))
    return fail("packet of " + std::to_string(captured) + " bytes in a block that holds " +
                std::to_string(body.size() - header));
  record = {last_stamp_, body.sub(header, captured), length, interface.link_type};
  return true;
}

}  // namespace lidard
