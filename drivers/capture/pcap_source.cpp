// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>

namespace lidard {
namespace {

std::string why_not() { return std::strerror(errno); }

/// Copies a pipe to a temporary file without a name. Stops early if the bytes are no capture: a pipe may
/// never end.
FileDescriptor spool(int pipe, const std::string& name) {
  const auto fail = [&](const char* what) -> void {
    throw CaptureError(name + ": " + what + ": " + why_not() + "; save the capture to a file first");
  };
  const char* folder = std::getenv("TMPDIR");
  FileDescriptor file(::open(folder != nullptr ? folder : "/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  if (!file.valid()) fail("its copy cannot be made");
  std::vector<char> buffer(262'144);
  bool checked = false;
  for (std::uint64_t size = 0;;) {
    const ssize_t got = ::read(pipe, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("cannot be read");
    if (got == 0) return file;
    for (ssize_t put = 0; put < got;) {
      const ssize_t n = ::write(file.get(), buffer.data() + put, static_cast<std::size_t>(got - put));
      if (n < 0) fail("its copy in the temporary folder cannot be written");
      put += n;
    }
    size += static_cast<std::uint64_t>(got);
    if (checked || size < 65'536) continue;
    checked = true;
    try {
      CaptureReader(file.get(), name);
    } catch (const CaptureError&) {
      return file;  // a further open finds the same
    }
  }
}

/// Opens a seekable file: a file by name, or the copy of a pipe ("-": standard input). The copy is made once,
/// since the writer of a pipe is gone when it is opened again.
FileDescriptor open_file(const std::string& path, const std::string& name) {
  static std::map<std::string, FileDescriptor> copies;
  const auto duplicate = [](int fd) { return FileDescriptor(::fcntl(fd, F_DUPFD_CLOEXEC, 0)); };
  const auto copy = copies.find(path);
  if (copy != copies.end()) return duplicate(copy->second.get());
  FileDescriptor file =
      path == "-" ? duplicate(STDIN_FILENO) : FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid())
    throw CaptureError(name + ": cannot be opened: " + why_not() + "; check the path and its rights");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw CaptureError(name + ": cannot be read: " + why_not());
  if (S_ISREG(status.st_mode)) return file;
  if (S_ISDIR(status.st_mode)) throw CaptureError(name + ": is a directory; name the capture files in it");
  if (!S_ISFIFO(status.st_mode) && !S_ISSOCK(status.st_mode))
    throw CaptureError(name + ": is neither a file nor a pipe; name a capture, or give one with `< FILE`");
  return duplicate(copies.emplace(path, spool(file.get(), name)).first->second.get());
}

}  // namespace

PcapSource::PcapSource(const std::string& path)
    : name_(path == "-" ? "standard input" : path), file_(open_file(path, name_)) {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) throw CaptureError(name_ + ": cannot be read: " + why_not());
  size_ = static_cast<std::uint64_t>(status.st_size);
  reader_ = std::make_unique<CaptureReader>(file_.get(), name_);
}

bool PcapSource::next(Packet& packet) {
  CaptureRecord record;
  while (!tcp_.next(packet)) {
    if (ended_) return false;
    if (!reader_->next(record)) {
      end();
      continue;
    }
    ++counters_.frames;
    ++records_;
    tcp_.expire(record.stamp);
    if (decode(record, packet)) {
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

/// Counts a frame that is not handed on. Bytes end too early through the snapshot length, or are malformed.
bool PcapSource::count(HeaderResult result, bool snapped) {
  if (result == HeaderResult::not_ip)
    ++counters_.not_ip;
  else if (result == HeaderResult::unsupported)
    ++counters_.unsupported_link;
  else
    ++(result == HeaderResult::cut && snapped ? counters_.truncated : counters_.malformed);
  return false;
}

bool PcapSource::decode(const CaptureRecord& record, Packet& packet) {
  const bool snapped = record.bytes.size() < record.length;
  LinkPayload link;
  IpPacket ip;
  HeaderResult result = find_ip(record.link_type, record.bytes, link);
  if (result == HeaderResult::ok) result = parse_ip(link.bytes, link.v6, ip);
  if (result != HeaderResult::ok) return count(result, snapped);
  // Records without a time: beams lie before the arrival, and ROS has no time before 1970.
  packet.arrival = record.stamp == Stamp{} ? Stamp{} + std::chrono::seconds(1) : record.stamp;
  return ip.fragment.is_fragment ? add_fragment(ip, snapped, packet) : decode_transport(ip, snapped, packet);
}

bool PcapSource::add_fragment(IpPacket& ip, bool snapped, Packet& packet) {
  if (ip.shorter_than_declared) return count(HeaderResult::cut, snapped);
  const DefragResult defragmented = defragmenter_.add(ip, packet.arrival);
  counters_.fragments_dropped = defragmenter_.dropped();
  if (defragmented == DefragResult::malformed) return count(HeaderResult::malformed, false);
  ++counters_.fragments;
  if (defragmented == DefragResult::waiting) return false;
  ++counters_.reassembled;
  const HeaderResult result = skip_reassembled_extensions(ip);
  return result == HeaderResult::ok ? decode_transport(ip, false, packet) : count(result, false);
}

bool PcapSource::decode_transport(const IpPacket& ip, bool snapped, Packet& packet) {
  if (ip.protocol == static_cast<std::uint8_t>(IpProtocol::tcp)) {
    add_segment(ip, snapped, packet.arrival);
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

void PcapSource::add_segment(const IpPacket& ip, bool snapped, Stamp stamp) {
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
  records_ = 0;
  reader_ = std::make_unique<CaptureReader>(file_.get(), name_);
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
