// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_source.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "drivers/capture/link_layer.h"

namespace lidard {
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

}  // namespace lidard
