// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/capture/ip_defrag.h"
#include "drivers/capture/ip_packet.h"
#include "drivers/capture/link_layer.h"
#include "drivers/capture/pcap_reader.h"

namespace lidard {
namespace {

std::string why_not() { return std::strerror(errno); }

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

struct PcapSource::Impl {
  explicit Impl(const std::string& path);

  bool next(Packet& packet);
  bool take(const CaptureRecord& record, Packet& packet);
  bool take_fragment(IpPacket& ip, bool snapped, Packet& packet);
  bool take_transport(const IpPacket& ip, bool snapped, Packet& packet);
  void take_segment(const IpPacket& ip, bool snapped, Stamp stamp);
  bool count(HeaderResult result, bool snapped);
  void end();

  std::string name;
  Descriptor file;  // kept, so that a rewind finds the same file even where its name is gone
  std::uint64_t size = 0;
  std::unique_ptr<CaptureReader> reader;
  IpDefragmenter defragmenter;
  TcpReassembler tcp;
  CaptureCounters counters;
  std::uint64_t records = 0;  // since the last rewind
  bool ended = false;
  bool ends_in_last_record = false;
  std::string error;
};

PcapSource::Impl::Impl(const std::string& path)
    : name(path), file(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file.get() < 0)
    throw CaptureError(name + ": cannot be opened: " + why_not() + "; check the path and its rights");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw CaptureError(name + ": cannot be read: " + why_not());
  if (S_ISDIR(status.st_mode)) throw CaptureError(name + ": is a directory; name the capture files in it");
  if (!S_ISREG(status.st_mode))
    throw CaptureError(name + ": is not a regular file; save the capture to a file first");
  size = static_cast<std::uint64_t>(status.st_size);
  reader = open_capture(file.get(), name, size);
}

bool PcapSource::Impl::next(Packet& packet) {
  CaptureRecord record;
  while (!tcp.next(packet)) {
    if (ended) return false;
    const std::uint64_t begin = reader->position();
    if (!reader->next(record)) {
      // More bytes than a record has are more than a last one.
      constexpr std::uint64_t longest_record = 65536 + 64;
      ends_in_last_record = records > 0 && reader->ran_out() && size - begin <= longest_record;
      end();
      continue;
    }
    ++counters.frames;
    ++records;
    tcp.expire(record.stamp);
    if (take(record, packet)) {
      ++counters.datagrams;
      return true;
    }
  }
  return true;
}

void PcapSource::Impl::end() {
  if (ended) return;
  ended = true;
  defragmenter.flush();
  counters.fragments_dropped = defragmenter.dropped();
  tcp.flush();
  if (!reader->error().empty()) {
    error = name + ": " + reader->error() + "; " +
            (records == 0 ? "there is nothing before it, record again" : "what came before it was used");
  } else if (records == 0) {
    error = name + ": holds no packet; check interface and filter and record again";
  }
}

/// Counts what is not handed on. Bytes that end too early are the snapshot length's fault, or a lie.
bool PcapSource::Impl::count(HeaderResult result, bool snapped) {
  switch (result) {
    case HeaderResult::ok:
      break;
    case HeaderResult::not_ip:
      ++counters.not_ip;
      break;
    case HeaderResult::unsupported:
      ++counters.unsupported_link;
      break;
    case HeaderResult::cut:
      ++(snapped ? counters.truncated : counters.malformed);
      break;
    case HeaderResult::malformed:
      ++counters.malformed;
      break;
  }
  return false;
}

bool PcapSource::Impl::take(const CaptureRecord& record, Packet& packet) {
  const bool snapped = record.bytes.size() < record.length;
  LinkPayload link;
  IpPacket ip;
  HeaderResult result = find_ip(record.link_type, record.bytes, link);
  if (result == HeaderResult::ok) result = parse_ip(link.bytes, link.v6, ip);
  if (result != HeaderResult::ok) return count(result, snapped);
  packet.arrival = record.stamp;
  return ip.fragment.is_fragment ? take_fragment(ip, snapped, packet) : take_transport(ip, snapped, packet);
}

bool PcapSource::Impl::take_fragment(IpPacket& ip, bool snapped, Packet& packet) {
  if (ip.shorter_than_declared) return count(HeaderResult::cut, snapped);
  const DefragResult defragmented = defragmenter.add(ip, packet.arrival);
  counters.fragments_dropped = defragmenter.dropped();
  if (defragmented == DefragResult::malformed) return count(HeaderResult::malformed, false);
  ++counters.fragments;
  if (defragmented == DefragResult::waiting) return false;
  ++counters.reassembled;
  const HeaderResult result = skip_reassembled_extensions(ip);
  return result == HeaderResult::ok ? take_transport(ip, false, packet) : count(result, false);
}

bool PcapSource::Impl::take_transport(const IpPacket& ip, bool snapped, Packet& packet) {
  if (ip.protocol == static_cast<std::uint8_t>(IpProtocol::tcp)) {
    take_segment(ip, snapped, packet.arrival);
    return false;
  }
  if (ip.protocol != static_cast<std::uint8_t>(IpProtocol::udp)) {
    ++counters.other_ip;
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

void PcapSource::Impl::take_segment(const IpPacket& ip, bool snapped, Stamp stamp) {
  TcpSegment segment;
  HeaderResult result = parse_tcp(ip, segment);
  if (result == HeaderResult::ok && ip.shorter_than_declared && !snapped) result = HeaderResult::malformed;
  if (result != HeaderResult::ok) {
    count(result, snapped);
    return;
  }
  ++(ip.shorter_than_declared ? counters.truncated : counters.tcp_segments);
  tcp.add(segment, ip.from, ip.to, stamp);
}

PcapSource::PcapSource(const std::string& path) : impl_(std::make_unique<Impl>(path)) {}
PcapSource::~PcapSource() = default;
PcapSource::PcapSource(PcapSource&&) noexcept = default;
PcapSource& PcapSource::operator=(PcapSource&&) noexcept = default;

bool PcapSource::next(Packet& packet) { return impl_->next(packet); }
const std::string& PcapSource::error() const { return impl_->error; }
bool PcapSource::is_damaged() const { return !impl_->error.empty() && !impl_->ends_in_last_record; }
const CaptureCounters& PcapSource::counters() const {
  impl_->counters.tcp = impl_->tcp.counters();
  return impl_->counters;
}
std::uint64_t PcapSource::position() const { return impl_->reader->position(); }
std::uint64_t PcapSource::size() const { return impl_->size; }

void PcapSource::rewind() {
  impl_->defragmenter.flush();
  impl_->counters.fragments_dropped = impl_->defragmenter.dropped();
  impl_->tcp.restart();
  impl_->error.clear();
  impl_->ends_in_last_record = false;
  impl_->records = 0;
  impl_->reader = open_capture(impl_->file.get(), impl_->name, impl_->size);
  impl_->ended = false;
}

}  // namespace lidard
