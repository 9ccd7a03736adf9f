// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_reader.h"

#include <pcap/pcap.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>

#include "drivers/capture/pcap_source.h"

namespace lidard {
namespace {

constexpr const char* remedy = "; give a pcap or pcapng file, e.g. from `tcpdump -w FILE.pcap`";

struct PcapCloser {
  void operator()(pcap_t* pcap) const { pcap_close(pcap); }
};

Stamp stamp_of(const timeval& time) {
  // The file has 32 bits of seconds, which libpcap reads as signed: unsigned they last until 2106. With
  // nanosecond precision tv_usec holds nanoseconds (man pcap_open_offline).
  return {static_cast<std::int64_t>(static_cast<std::uint32_t>(time.tv_sec)) * 1'000'000'000 + time.tv_usec};
}

class LibpcapReader : public CaptureReader {
 public:
  explicit LibpcapReader(std::unique_ptr<pcap_t, PcapCloser> pcap)
      : pcap_(std::move(pcap)), link_type_(static_cast<std::uint32_t>(pcap_datalink(pcap_.get()))) {}

  bool next(CaptureRecord& record) override {
    const std::uint64_t begin = position();
    pcap_pkthdr* header = nullptr;
    const u_char* bytes = nullptr;
    const int result = pcap_next_ex(pcap_.get(), &header, &bytes);
    if (result == 1) {
      record = {stamp_of(header->ts), ByteView(bytes, header->caplen), header->len, link_type_};
      return true;
    }
    if (result == PCAP_ERROR)
      error_ = std::string(pcap_geterr(pcap_.get())) + " at byte " + std::to_string(begin);
    return false;
  }
  const std::string& error() const override { return error_; }
  bool ran_out() const override { return !error_.empty() && std::feof(pcap_file(pcap_.get())) != 0; }
  std::uint64_t position() const override {
    return static_cast<std::uint64_t>(ftello(pcap_file(pcap_.get())));
  }

 private:
  std::unique_ptr<pcap_t, PcapCloser> pcap_;
  std::uint32_t link_type_;
  std::string error_;
};

/// A stream over somebody else's descriptor, with a position of its own.
struct FileView {
  int fd;
  bool hide_snapshot_length;
  off_t position = 0;

  static ssize_t read(void* self, char* out, std::size_t size);
  static int seek(void* self, off64_t* offset, int whence);
  static int close(void* self) {
    delete static_cast<FileView*>(self);
    return 0;
  }
};

ssize_t FileView::read(void* self, char* out, std::size_t size) {
  auto& view = *static_cast<FileView*>(self);
  const ssize_t got = ::pread(view.fd, out, size, view.position);
  if (got < 0) return got;
  // libpcap cuts records at the snapshot length of the file header, even where it lies and the bytes are
  // there. Zero means no limit of the file's own (pcap-savefile(5): bytes 16 to 19).
  for (off_t i = std::max<off_t>(16, view.position); view.hide_snapshot_length && i < 20; ++i) {
    if (i < view.position + got) out[i - view.position] = 0;
  }
  view.position += got;
  return got;
}

int FileView::seek(void* self, off64_t* offset, int whence) {
  auto& view = *static_cast<FileView*>(self);
  if (whence == SEEK_END) return -1;
  const off64_t target = whence == SEEK_CUR ? view.position + *offset : *offset;
  if (target < 0) return -1;
  *offset = view.position = target;
  return 0;
}

FileHandle open_stream(int fd, bool hide_snapshot_length) {
  cookie_io_functions_t functions{};
  functions.read = FileView::read;
  functions.seek = FileView::seek;
  functions.close = FileView::close;
  auto view = std::make_unique<FileView>(FileView{fd, hide_snapshot_length});
  FileHandle file(::fopencookie(view.get(), "rb", functions));
  if (!file) throw std::bad_alloc();
  static_cast<void>(view.release());  // close() deletes it
  return file;
}

bool is_compressed(ByteView magic) {
  // RFC 1952; RFC 8878; xz-file-format 1.2.
  return magic.be16(0) == 0x1f8b || magic.le32(0) == 0xfd2fb528U || magic.be32(0) == 0xfd377a58U;
}

}  // namespace

std::unique_ptr<CaptureReader> open_pcap(FileHandle file, const std::string& name) {
  std::array<char, PCAP_ERRBUF_SIZE> why{};
  std::unique_ptr<pcap_t, PcapCloser> pcap(
      pcap_fopen_offline_with_tstamp_precision(file.get(), PCAP_TSTAMP_PRECISION_NANO, why.data()));
  if (!pcap) throw CaptureError(name + ": " + why.data() + remedy);
  static_cast<void>(file.release());  // pcap_close() closes it
  return std::make_unique<LibpcapReader>(std::move(pcap));
}

std::unique_ptr<CaptureReader> open_capture(int fd, const std::string& name, std::uint64_t size) {
  std::array<std::uint8_t, 4> bytes{};
  const ByteView magic(bytes.data(), bytes.size());
  if (size == 0) throw CaptureError(name + ": the file is empty (0 bytes); record it again");
  const ssize_t got = ::pread(fd, bytes.data(), bytes.size(), 0);
  if (got < 0) throw CaptureError(name + ": cannot be read: " + std::strerror(errno) + "; check the disk");
  if (got < 4) throw CaptureError(name + ": too short to be a capture" + remedy);
  if (is_compressed(magic))
    throw CaptureError(name + ": is compressed; unpack it first (gunzip, unzstd, unxz)");
  // Section Header Block, draft-ietf-opsawg-pcapng section 4.1.
  const bool is_pcapng = magic.be32(0) == 0x0a0d0d0aU;
  FileHandle file = open_stream(fd, !is_pcapng);
  return is_pcapng ? open_pcapng(std::move(file), name, size) : open_pcap(std::move(file), name);
}

}  // namespace lidard
