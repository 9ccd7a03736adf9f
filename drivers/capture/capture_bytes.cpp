// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/capture_bytes.h"

#include <lzma.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <array>
#include <new>

#include "core/base/bytes.h"

namespace lidard {
namespace {

/// RFC 1952, one member after the other.
class Gzip final : public Codec {
 public:
  Gzip() {
    // 15: the largest window; 16 more: a gzip header and its checksum (zlib.h, inflateInit2).
    if (inflateInit2(&stream_, 15 + 16) != Z_OK) throw std::bad_alloc();
  }
  ~Gzip() override { inflateEnd(&stream_); }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

  const char* run(PackedBytes& b, bool /*last*/) override {
    if (complete_ && b.in_left == 0) return nullptr;
    if (complete_) inflateReset(&stream_);
    stream_.next_in = const_cast<Bytef*>(b.in);  // zlib has no const
    stream_.avail_in = static_cast<uInt>(b.in_left);
    stream_.next_out = b.out;
    stream_.avail_out = static_cast<uInt>(b.out_left);
    const int result = inflate(&stream_, Z_NO_FLUSH);
    b = {stream_.next_in, stream_.avail_in, stream_.next_out, stream_.avail_out};
    complete_ = result == Z_STREAM_END;
    if (complete_ || result == Z_OK || result == Z_BUF_ERROR) return nullptr;
    return stream_.msg != nullptr ? stream_.msg : zError(result);
  }
  bool complete() const override { return complete_; }
  const char* name() const override { return "gzip"; }

 private:
  z_stream stream_{};
  bool complete_ = false;
};

/// RFC 8878, one frame after the other.
class Zstd final : public Codec {
 public:
  Zstd() : stream_(ZSTD_createDStream()) {
    if (stream_ == nullptr) throw std::bad_alloc();
  }
  ~Zstd() override { ZSTD_freeDStream(stream_); }
  Zstd(const Zstd&) = delete;
  Zstd& operator=(const Zstd&) = delete;

  const char* run(PackedBytes& b, bool /*last*/) override {
    if (complete_ && b.in_left == 0) return nullptr;
    ZSTD_inBuffer in{b.in, b.in_left, 0};
    ZSTD_outBuffer out{b.out, b.out_left, 0};
    const std::size_t result = ZSTD_decompressStream(stream_, &out, &in);
    b = {b.in + in.pos, b.in_left - in.pos, b.out + out.pos, b.out_left - out.pos};
    complete_ = result == 0;
    return ZSTD_isError(result) != 0U ? ZSTD_getErrorName(result) : nullptr;
  }
  bool complete() const override { return complete_; }
  const char* name() const override { return "zstd"; }

 private:
  ZSTD_DStream* stream_;
  bool complete_ = false;
};

/// The .xz file format 1.2, one stream after the other.
class Xz final : public Codec {
 public:
  Xz() {
    // What `xz -9` makes needs 65 MiB (xz(1)).
    constexpr std::uint64_t memory = 256U << 20U;
    if (lzma_stream_decoder(&stream_, memory, LZMA_CONCATENATED) != LZMA_OK) throw std::bad_alloc();
  }
  ~Xz() override { lzma_end(&stream_); }
  Xz(const Xz&) = delete;
  Xz& operator=(const Xz&) = delete;

  const char* run(PackedBytes& b, bool last) override {
    stream_.next_in = b.in, stream_.avail_in = b.in_left;
    stream_.next_out = b.out, stream_.avail_out = b.out_left;
    const lzma_ret result = lzma_code(&stream_, last ? LZMA_FINISH : LZMA_RUN);
    b = {stream_.next_in, stream_.avail_in, stream_.next_out, stream_.avail_out};
    complete_ = result == LZMA_STREAM_END;
    if (complete_ || result == LZMA_OK || result == LZMA_BUF_ERROR) return nullptr;
    if (result == LZMA_MEMLIMIT_ERROR) return "needs more than 256 MiB of memory to unpack";
    return result == LZMA_FORMAT_ERROR ? "no xz data" : "invalid data or wrong checksum";
  }
  bool complete() const override { return complete_; }
  const char* name() const override { return "xz"; }

 private:
  lzma_stream stream_ = LZMA_STREAM_INIT;
  bool complete_ = false;
};

std::unique_ptr<Codec> codec_for(ByteView magic) {
  // RFC 1952 section 2.3.1; RFC 8878 sections 3.1.1 and 3.1.2 (skippable frames); xz-file-format 2.1.1.1.
  if (magic.be16(0) == 0x1f8b) return std::make_unique<Gzip>();
  if (magic.le32(0) == 0xfd2fb528U || (magic.le32(0) & 0xfffffff0U) == 0x184d2a50U)
    return std::make_unique<Zstd>();
  if (magic.be32(0) == 0xfd377a58U) return std::make_unique<Xz>();
  return nullptr;
}

}  // namespace

CaptureBytes::CaptureBytes(int fd) : fd_(fd) { rewind(); }

void CaptureBytes::rewind() {
  position_ = taken_ = 0;
  file_ended_ = false;
  bytes_ = {};
  error_.clear();
  codec_ = nullptr;
  std::array<std::uint8_t, 4> magic{};
  if (::pread(fd_, magic.data(), magic.size(), 0) == 4) codec_ = codec_for({magic.data(), magic.size()});
}

ssize_t CaptureBytes::read(char* out, std::size_t size) {
  if (codec_ != nullptr) return read_packed(out, size);
  const ssize_t got = ::pread(fd_, out, size, static_cast<off_t>(position_));
  if (got > 0) taken_ = position_ += static_cast<std::uint64_t>(got);
  return got;
}

ssize_t CaptureBytes::read_packed(char* out, std::size_t size) {
  if (!error_.empty()) return -1;
  bytes_.out = reinterpret_cast<std::uint8_t*>(out);
  bytes_.out_left = size;
  while (bytes_.out_left == size) {
    if (bytes_.in_left == 0 && !file_ended_ && !fill()) return -1;
    const std::size_t before = bytes_.in_left;
    const char* wrong = codec_->run(bytes_, file_ended_);
    if (wrong != nullptr) return fail(std::string("is damaged, ") + wrong);
    if (bytes_.out_left < size) break;
    if (file_ended_) return codec_->complete() ? 0 : fail("was cut off");
    if (before > 0 && bytes_.in_left == before) return fail("is damaged, nothing can be unpacked");
  }
  const std::size_t got = size - bytes_.out_left;
  position_ += got;
  return static_cast<ssize_t>(got);
}

bool CaptureBytes::fill() {
  buffer_.resize(64 * 1024);
  const ssize_t got = ::pread(fd_, buffer_.data(), buffer_.size(), static_cast<off_t>(taken_));
  if (got < 0) return false;
  file_ended_ = got == 0;
  taken_ += static_cast<std::uint64_t>(got);
  bytes_.in = buffer_.data();
  bytes_.in_left = static_cast<std::size_t>(got);
  return true;
}

ssize_t CaptureBytes::fail(const std::string& what) {
  error_ = std::string("the ") + codec_->name() + " file " + what + ", at byte " +
           std::to_string(taken_ - bytes_.in_left);
  return -1;
}

}  // namespace lidard
