// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// pcapng as in draft-ietf-opsawg-pcapng. libpcap 1.10 refuses files whose interfaces differ in link type or
// snapshot length, and sections whose byte order differs; sensors on several interfaces make such files.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "drivers/capture/pcap_source.h"

namespace lidard {
namespace {

// Block types, section 11.1.
constexpr std::uint32_t section_header = 0x0a0d0d0a, interface_description = 1, obsolete_packet = 2,
                        simple_packet = 3, enhanced_packet = 6;
constexpr std::uint32_t byte_order_magic = 0x1a2b3c4d, byte_order_magic_swapped = 0x4d3c2b1a;
// A block that we read (not skip) never needs more: libpcap's limit for a pcapng block too.
constexpr std::uint32_t max_block = 16U << 20U;
// Half of what 64 bits hold, so that the difference of any two stamps does not overflow.
constexpr std::int64_t max_seconds = std::numeric_limits<std::int64_t>::max() / 2 / 1'000'000'000 - 1;

__extension__ typedef unsigned __int128 Wide;

/// Fields of a block in the byte order of its section.
struct Fields {
  ByteView bytes;
  bool big = false;

  std::uint16_t u16(std::size_t o) const { return big ? bytes.be16(o) : bytes.le16(o); }
  std::uint32_t u32(std::size_t o) const { return big ? bytes.be32(o) : bytes.le32(o); }
  std::int64_t i64(std::size_t o) const {
    const std::uint64_t first = u32(o), second = u32(o + 4);
    return static_cast<std::int64_t>(big ? first << 32U | second : second << 32U | first);
  }
};

/// One Interface Description Block.
struct Interface {
  std::uint32_t link_type = 0;
  std::uint32_t snapshot_length = 0;     // 0: no limit
  std::uint64_t per_second = 1'000'000;  // if_tsresol; ticks in a second after division by `finer`
  std::uint64_t finer = 1;
  std::int64_t offset_s = 0;  // if_tsoffset

  /// Powers of 10, or of 2 where the highest bit is set. A resolution beyond 64 bits only holds fractions of
  /// a second.
  void set_resolution(std::uint8_t resolution) {
    const std::uint64_t base = (resolution & 0x80U) != 0 ? 2 : 10;
    const std::uint64_t limit = std::numeric_limits<std::uint64_t>::max() / base;
    per_second = finer = 1;
    for (unsigned exponent = resolution & 0x7fU; exponent > 0; --exponent) {
      if (per_second <= limit)
        per_second *= base;
      else if (finer <= limit)
        finer *= base;
    }
  }

  Stamp stamp(std::uint64_t ticks) const {
    ticks /= finer;
    const auto fraction =
        static_cast<std::int64_t>(static_cast<Wide>(ticks % per_second) * 1'000'000'000U / per_second);
    const auto whole = static_cast<std::int64_t>(std::min<std::uint64_t>(ticks / per_second, max_seconds));
    const std::int64_t offset = std::clamp(offset_s, -max_seconds, max_seconds);
    return {std::clamp(whole + offset, -max_seconds, max_seconds) * 1'000'000'000 + fraction};
  }
};

/// Options of an Interface Description Block, sections 3.5 and 4.2. An option that runs out of the block ends
/// the list.
void read_options(const Fields& body, std::size_t o, Interface& out) {
  constexpr std::uint16_t end = 0, if_tsresol = 9, if_tsoffset = 14;
  while (body.bytes.has(o, 4)) {
    const std::uint16_t code = body.u16(o);
    const std::size_t length = body.u16(o + 2);
    if (code == end || !body.bytes.has(o + 4, length)) return;
    if (code == if_tsresol && length == 1) out.set_resolution(body.bytes.u8(o + 4));
    if (code == if_tsoffset && length == 8) out.offset_s = body.i64(o + 4);
    o += 4 + (length + 3) / 4 * 4;
  }
}

class PcapngReader : public CaptureReader {
 public:
  PcapngReader(FileHandle file, std::uint64_t size) : file_(std::move(file)), size_(size) {}

  bool next(CaptureRecord& record) override {
    while (error_.empty() && !at_end()) {
      if (read_block(record)) return true;
    }
    return false;
  }
  const std::string& error() const override { return error_; }
  bool ran_out() const override { return ran_out_; }
  std::uint64_t position() const override { return position_; }

 private:
  bool at_end() {
    if (position_ >= size_) return true;
    const int next = std::getc(file_.get());
    return next == EOF || std::ungetc(next, file_.get()) == EOF;
  }
  /// True if the block was a packet.
  bool read_block(CaptureRecord& record) {
    std::uint32_t type = 0;
    std::uint32_t length = 0;
    if (!read_block_header(type, length)) return false;
    const bool is_packet = type == obsolete_packet || type == enhanced_packet;
    const bool wanted =
        is_packet || type == simple_packet || type == section_header || type == interface_description;
    if (!wanted) return skip_body(length);
    if (!read_body(length, type == section_header ? 4 : 0)) return false;
    const Fields body{ByteView(buffer_.data(), buffer_.size() - 4), big_};
    if (type == section_header) return take_section(body);
    if (type == interface_description) return take_interface(body);
    return is_packet ? take_packet(body, type == obsolete_packet, record) : take_simple(body, record);
  }

  bool read_block_header(std::uint32_t& type, std::uint32_t& length) {
    block_ = position_;
    if (size_ - position_ < 12) return run_out("block cut by the end of the file");
    std::array<std::uint8_t, 8> bytes{};
    if (!read(bytes.data(), bytes.size())) return false;
    type = Fields{ByteView(bytes.data(), 8), big_}.u32(0);
    if (type == section_header && !read_section_magic()) return false;
    length = Fields{ByteView(bytes.data(), 8), big_}.u32(4);
    if (length < 12 || length % 4 != 0)
      return fail("block with the impossible length " + std::to_string(length));
    if (length > size_ - block_) {
      return run_out("block of " + std::to_string(length) + " bytes, but the file has only " +
                     std::to_string(size_ - block_) + " left");
    }
    return true;
  }

  /// The section's byte order stands behind its length, which must be known before the length is understood.
  bool read_section_magic() {
    buffer_.resize(4);
    if (!read(buffer_.data(), buffer_.size())) return false;
    const ByteView magic(buffer_.data(), buffer_.size());
    big_ = magic.be32(0) == byte_order_magic;
    return big_ || magic.le32(0) == byte_order_magic || fail("section without a byte-order magic");
  }

  /// `known` bytes stand in the buffer.
  bool read_body(std::uint32_t length, std::size_t known) {
    if (length > max_block) return fail("packet block with the impossible length " + std::to_string(length));
    buffer_.resize(length - 8U);
    if (!read(buffer_.data() + known, buffer_.size() - known)) return false;
    return check_trailer(length,
                         Fields{ByteView(buffer_.data(), buffer_.size()), big_}.u32(buffer_.size() - 4));
  }

  /// Always false: a block that is skipped is no packet.
  bool skip_body(std::uint32_t length) {
    std::array<std::uint8_t, 4096> unread;
    for (std::size_t left = length - 12U; left > 0;) {
      const std::size_t n = std::min(left, unread.size());
      if (!read(unread.data(), n)) return false;
      left -= n;
    }
    std::array<std::uint8_t, 4> trailer{};
    if (read(trailer.data(), trailer.size()))
      check_trailer(length, Fields{ByteView(trailer.data(), 4), big_}.u32(0));
    return false;
  }

  bool check_trailer(std::uint32_t length, std::uint32_t trailer) {
    if (trailer == length) return true;
    return fail("block whose two lengths differ (" + std::to_string(length) + " and " +
                std::to_string(trailer) + ")");
  }

  /// Section 4.1. Always false: no packet.
  bool take_section(const Fields& body) {
    if (!body.bytes.has(0, 16)) return fail("section header too short");
    const std::uint16_t major = body.u16(4);
    if (major != 1) return fail("section of the unknown pcapng version " + std::to_string(major));
    interfaces_.clear();
    return false;
  }

  /// Section 4.2. Always false: no packet.
  bool take_interface(const Fields& body) {
    if (!body.bytes.has(0, 8)) return fail("interface description too short");
    Interface interface;
    interface.link_type = body.u16(0);
    interface.snapshot_length = body.u32(4);
    read_options(body, 8, interface);
    interfaces_.push_back(interface);
    return false;
  }

  /// Section 4.4: of the first interface, without a stamp (it gets that of the packet before) and without a
  /// captured length, which is the shortest of what limits it.
  bool take_simple(const Fields& body, CaptureRecord& record) {
    if (!body.bytes.has(0, 4)) return fail("packet block too short");
    if (interfaces_.empty()) return fail("packet of undescribed interface 0");
    const std::uint32_t length = body.u32(0);
    const std::uint32_t limit = interfaces_[0].snapshot_length;
    const std::size_t captured = limit == 0 ? length : std::min(length, limit);
    if (!body.bytes.has(4, captured)) {
      return fail("packet of " + std::to_string(captured) + " bytes in a block that holds " +
                  std::to_string(body.bytes.size() - 4));
    }
    record = {last_stamp_, body.bytes.sub(4, captured), length, interfaces_[0].link_type};
    return true;
  }

  /// Section 4.3, and appendix A for the obsolete block, whose interface has 16 bits: 20 bytes, of which the
  /// last 16 are stamp (high, low), captured and original length; then the data.
  bool take_packet(const Fields& body, bool obsolete, CaptureRecord& record) {
    constexpr std::size_t header = 20;
    if (!body.bytes.has(0, header)) return fail("packet block too short");
    const std::uint32_t interface = obsolete ? body.u16(0) : body.u32(0);
    const std::uint64_t ticks =
        static_cast<std::uint64_t>(body.u32(header - 16)) << 32U | body.u32(header - 12);
    const std::uint32_t captured = body.u32(header - 8);
    if (interface >= interfaces_.size())
      return fail("packet of undescribed interface " + std::to_string(interface));
    if (!body.bytes.has(header, captured)) {
      return fail("packet of " + std::to_string(captured) + " bytes in a block that holds " +
                  std::to_string(body.bytes.size() - header));
    }
    last_stamp_ = interfaces_[interface].stamp(ticks);
    record = {last_stamp_, body.bytes.sub(header, captured), body.u32(header - 4),
              interfaces_[interface].link_type};
    return true;
  }

  bool fail(const std::string& what) {
    error_ = what + " at byte " + std::to_string(block_);
    return false;
  }
  bool run_out(const std::string& what) {
    ran_out_ = true;
    return fail(what);
  }
  bool read(std::uint8_t* out, std::size_t n) {
    position_ += n;
    if (std::fread(out, 1, n, file_.get()) == n) return true;
    return std::feof(file_.get()) != 0 ? run_out("block cut by the end of the file")
                                       : fail("block cannot be read");
  }

  FileHandle file_;
  std::uint64_t size_;
  std::uint64_t position_ = 0;
  std::uint64_t block_ = 0;  // where the current block begins
  bool big_ = false;
  std::vector<Interface> interfaces_;
  std::vector<std::uint8_t> buffer_;
  Stamp last_stamp_;
  std::string error_;
  bool ran_out_ = false;
};

}  // namespace

std::unique_ptr<CaptureReader> open_pcapng(FileHandle file, std::uint64_t size) {
  return std::make_unique<PcapngReader>(std::move(file), size);
}

}  // namespace lidard
