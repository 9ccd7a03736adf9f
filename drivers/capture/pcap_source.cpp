// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_source.h"

#include <fcntl.h>
#include <pcap/pcap.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>

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

  static ssize_t read(void* self, char* out, std::size_t size) {
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

  static int seek(void* self, off64_t* offset, int whence) {
    auto& view = *static_cast<FileView*>(self);
    if (whence == SEEK_END) return -1;
    const off64_t target = whence == SEEK_CUR ? view.position + *offset : *offset;
    if (target < 0) return -1;
    *offset = view.position = target;
    return 0;
  }

  static int close(void* self) {
    delete static_cast<FileView*>(self);
    return 0;
  }
};

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

namespace {

std::string why_not() { return std::strerror(errno); }

}  // namespace

PcapSource::PcapSource(const std::string& path)
    : name_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_.get() < 0)
    throw CaptureError(name_ + ": cannot be opened: " + why_not() + "; check the path and its rights");
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) throw CaptureError(name_ + ": cannot be read: " + why_not());
  if (S_ISDIR(status.st_mode)) throw CaptureError(name_ + ": is a directory; name the capture files in it");
  if (!S_ISREG(status.st_mode))
    throw CaptureError(name_ + ": is not a regular file; save the capture to a file first");
  size_ = static_cast<std::uint64_t>(status.st_size);
  reader_ = open_capture(file_.get(), name_, size_);
}

bool PcapSource::next(Packet& packet) {
  CaptureRecord record;
  while (!tcp_.next(packet)) {
    if (ended_) return false;
    const std::uint64_t begin = reader_->position();
    if (!reader_->next(record)) {
      // More bytes than a record has are more than a last one.
      constexpr std::uint64_t longest_record = 65536 + 64;
      ends_in_last_record_ = records_ > 0 && reader_->ran_out() && size_ - begin <= longest_record;
      end();
      continue;
    }
    ++counters_.frames;
    ++records_;
    tcp_.expire(record.stamp);
    if (take(record, packet)) {
      ++counters_.datagrams;
      return true;
    }
  }
  return true;
}

void PcapSource::end() {
  if (ended_) return;
  ended_ = true;
  defragmenter_.flush();
  counters_.fragments_dropped = defragmenter_.dropped();
  tcp_.flush();
  if (!reader_->error().empty()) {
    error_ = name_ + ": " + reader_->error() + "; " +
             (records_ == 0 ? "there is nothing before it, record again" : "what came before it was used");
  } else if (records_ == 0) {
    error_ = name_ + ": holds no packet; check interface and filter and record again";
  }
}

/// Counts what is not handed on. Bytes that end too early are the snapshot length's fault, or a lie.
bool PcapSource::count(HeaderResult result, bool snapped) {
  if (result == HeaderResult::not_ip)
    ++counters_.not_ip;
  else if (result == HeaderResult::unsupported)
    ++counters_.unsupported_link;
  else
    ++(result == HeaderResult::cut && snapped ? counters_.truncated : counters_.malformed);
  return false;
}

bool PcapSource::take(const CaptureRecord& record, Packet& packet) {
  const bool snapped = record.bytes.size() < record.length;
  LinkPayload link;
  IpPacket ip;
  HeaderResult result = find_ip(record.link_type, record.bytes, link);
  if (result == HeaderResult::ok) result = parse_ip(link.bytes, link.v6, ip);
  if (result != HeaderResult::ok) return count(result, snapped);
  packet.arrival = record.stamp;
  return ip.fragment.is_fragment ? take_fragment(ip, snapped, packet) : take_transport(ip, snapped, packet);
}

bool PcapSource::take_fragment(IpPacket& ip, bool snapped, Packet& packet) {
  if (ip.shorter_than_declared) return count(HeaderResult::cut, snapped);
  const DefragResult defragmented = defragmenter_.add(ip, packet.arrival);
  counters_.fragments_dropped = defragmenter_.dropped();
  if (defragmented == DefragResult::malformed) return count(HeaderResult::malformed, false);
  ++counters_.fragments;
  if (defragmented == DefragResult::waiting) return false;
  ++counters_.reassembled;
  const HeaderResult result = skip_reassembled_extensions(ip);
  return result == HeaderResult::ok ? take_transport(ip, false, packet) : count(result, false);
}

bool PcapSource::take_transport(const IpPacket& ip, bool snapped, Packet& packet) {
  if (ip.protocol == static_cast<std::uint8_t>(IpProtocol::tcp)) {
    take_segment(ip, snapped, packet.arrival);
    return false;
  }
  if (ip.protocol != static_cast<std::uint8_t>(IpProtocol::udp)) {
    ++counters_.other_ip;
    return false;
  }
  UdpDatagram udp;
  const HeaderResult result = parse_udp(ip.captured, udp);
  if (result != HeaderResult::ok) return count(result, snapped);
  packet.payload = udp.payload;
  packet.from = {ip.from, udp.from_port};
  packet.to = {ip.to, udp.to_port};
  packet.transport = Transport::udp;
  packet.stream_start = false;
  packet.missing = 0;
  return true;
}

void PcapSource::take_segment(const IpPacket& ip, bool snapped, Stamp stamp) {
  TcpSegment segment;
  HeaderResult result = parse_tcp(ip, segment);
  if (result == HeaderResult::ok && ip.shorter_than_declared && !snapped) result = HeaderResult::malformed;
  if (result != HeaderResult::ok) {
    count(result, snapped);
    return;
  }
  ++(ip.shorter_than_declared ? counters_.truncated : counters_.tcp_segments);
  tcp_.add(segment, ip.from, ip.to, stamp);
}

void PcapSource::rewind() {
  defragmenter_.flush();
  counters_.fragments_dropped = defragmenter_.dropped();
  tcp_.restart();
  error_.clear();
  ends_in_last_record_ = false;
  records_ = 0;
  reader_ = open_capture(file_.get(), name_, size_);
  ended_ = false;
}

MergedCapture::MergedCapture(const std::vector<std::string>& paths) {
  files_.reserve(paths.size());
  for (const auto& path : paths) files_.push_back({PcapSource(path), {}, false});
  for (File& file : files_) fill(file);
}

bool MergedCapture::next(Packet& packet) {
  if (given_ != nullptr) fill(*given_);
  given_ = nullptr;
  for (File& file : files_) {
    if (file.ready && (given_ == nullptr || file.packet.arrival < given_->packet.arrival)) given_ = &file;
  }
  if (given_ == nullptr) return false;
  packet = given_->packet;
  return true;
}

void MergedCapture::rewind() {
  given_ = nullptr;
  for (File& file : files_) {
    file.source.rewind();
    fill(file);
  }
}

std::vector<std::string> MergedCapture::errors() const {
  std::vector<std::string> all;
  for (const File& file : files_) {
    if (!file.source.error().empty()) all.push_back(file.source.error());
  }
  return all;
}

bool MergedCapture::is_damaged() const {
  return std::any_of(files_.begin(), files_.end(), [](const File& file) { return file.source.is_damaged(); });
}

CaptureCounters MergedCapture::counters() const {
  CaptureCounters sum;
  const auto add = [](const auto& list, const auto& counters, auto& to) {
    for (const auto& counter : list) to.*counter.value += counters.*counter.value;
  };
  for (const File& file : files_) {
    const CaptureCounters& c = file.source.counters();
    add(capture_counts, c, sum);
    add(capture_losses, c, sum);
    add(tcp_counts, c.tcp, sum.tcp);
    add(tcp_losses, c.tcp, sum.tcp);
  }
  return sum;
}

double MergedCapture::progress() const {
  double read = 0;
  double all = 0;
  for (const File& file : files_) {
    read += static_cast<double>(file.source.position());
    all += static_cast<double>(file.source.size());
  }
  return all > 0 ? read / all : 1;
}

}  // namespace lidard
