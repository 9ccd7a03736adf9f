// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pcap/pcap.h>
#include <poll.h>

#include <chrono>
#include <memory>
#include <ostream>
#include <set>

#include "daemon/commands/commands.h"
#include "daemon/commands/stop_signal.h"
#include "daemon/config/config.h"
#include "drivers/capture/pcap_writer.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// Complete datagrams, since the host reassembles fragments and offloaded segments before recording.
constexpr int snapshot_length = 262144;
/// For delays of the disk.
constexpr int buffer_bytes = 64 * 1024 * 1024;
constexpr int wake_up_ms = 200;

struct CloseCapture {
  void operator()(pcap_t* capture) const { pcap_close(capture); }
};
using Capture = std::unique_ptr<pcap_t, CloseCapture>;

/// Fragments after the first one have no ports, so all of an unknown sender's are recorded.
constexpr const char* fragments = "(ip[6:2] & 0x1fff != 0)";

/// The filter for all supported lidars with factory settings.
std::string usual_filter() {
  std::set<std::string> ports;
  for (const Model& model : models()) {
    for (const Flow& flow : flows_of(model, {}, model.port, model.telemetry_port, 0))
      ports.insert((flow.transport == Transport::udp ? " or udp dst port " : " or tcp port ") +
                   std::to_string(flow.port));
  }
  std::string filter = fragments;
  for (const std::string& port : ports) filter += port;
  return filter;
}

std::string sensor_filter(const SensorConfig& sensor) {
  if (sensor.ip_address) return "host " + sensor.ip_address->to_string();
  std::string filter = fragments;
  for (const Flow& flow : flows_of(sensor)) filter += " or udp dst port " + std::to_string(flow.port);
  return filter;
}

/// Why a capture cannot be made, or empty.
std::string begin(pcap_t* capture, const std::string& interface, const std::string& filter) {
  pcap_set_snaplen(capture, snapshot_length);
  pcap_set_buffer_size(capture, buffer_bytes);
  pcap_set_timeout(capture, wake_up_ms);
  pcap_set_tstamp_precision(capture, PCAP_TSTAMP_PRECISION_NANO);
  const int result = pcap_activate(capture);
  if (result == PCAP_ERROR_PERM_DENIED)
    return "recording from the network needs the capability CAP_NET_RAW; run it as root, or give it to the "
           "program: setcap cap_net_raw+ep /usr/bin/lidard";
  if (result == PCAP_ERROR_NO_SUCH_DEVICE)
    return "there is no network interface " + interface + "; compare with `ip link`";
  if (result < 0) return "cannot record from " + interface + ": " + pcap_geterr(capture);
  char why[PCAP_ERRBUF_SIZE] = "";
  if (pcap_setnonblock(capture, 1, why) != 0) return why;
  bpf_program program{};
  const bool well = pcap_compile(capture, &program, filter.c_str(), 1, PCAP_NETMASK_UNKNOWN) == 0 &&
                    pcap_setfilter(capture, &program) == 0;
  pcap_freecode(&program);
  return well ? std::string() : "cannot filter with '" + filter + "': " + pcap_geterr(capture);
}

/// The callback of libpcap for every frame.
struct Recorder {
  PcapWriter& writer;
  std::int64_t tick;  // ns: of the stamps' second part

  static void record(unsigned char* self, const pcap_pkthdr* header, const unsigned char* bytes) {
    const Recorder& to = *reinterpret_cast<Recorder*>(self);
    const Stamp stamp{header->ts.tv_sec * std::int64_t{1'000'000'000} + header->ts.tv_usec * to.tick};
    to.writer.write_frame(stamp, {bytes, header->caplen}, header->len);
  }
};

/// Records until a signal, the end of the time or a full disk; returns an error of the network, or nothing.
std::string record(pcap_t* capture, PcapWriter& writer, double duration) {
  Recorder recorder{writer, pcap_get_tstamp_precision(capture) == PCAP_TSTAMP_PRECISION_NANO ? 1 : 1000};
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(duration);
  // libpcap's own waiting ignores signals and the end of the time while no packet arrives.
  pollfd source{pcap_get_selectable_fd(capture), POLLIN, 0};
  while (!stopped() && !writer.has_failed() && (duration <= 0 || std::chrono::steady_clock::now() < end)) {
    static_cast<void>(::poll(&source, 1, wake_up_ms));
    if (pcap_dispatch(capture, -1, Recorder::record, reinterpret_cast<unsigned char*>(&recorder)) < 0)
      return std::string("recording ended: ") + pcap_geterr(capture);
  }
  return {};
}

void report(pcap_t* capture, const RecordOptions& options, std::uint64_t packets, std::ostream& err) {
  err << options.output << ": " << packets << " packets";
  pcap_stat counts{};
  if (pcap_stats(capture, &counts) == 0) err << ", " << counts.ps_drop << " lost by the kernel";
  err << '\n';
  if (packets == 0)
    err << "nothing came from the sensors; check addresses, ports and cables, `lidard inspect` on a "
           "recording of everything (tcpdump -w) shows what is there\n";
}

}  // namespace

std::string capture_filter(const Config& config) {
  std::string all;
  for (const SensorConfig& sensor : config.sensors) {
    if (sensor.model == nullptr || !sensor.packet_topic.empty()) continue;
    all += (all.empty() ? "(" : " or (") + sensor_filter(sensor) + ")";
  }
  return all;
}

int run_record(const RecordOptions& options, std::ostream& err) {
  return guarded(err, [&] {
    const std::string filter =
        options.config.empty() ? usual_filter() : capture_filter(load_config(options.config));
    const auto fail = [](const std::string& why) { throw std::runtime_error(why); };
    if (filter.empty()) fail(options.config + " names no sensor that is on the network");
    char why[PCAP_ERRBUF_SIZE] = "";
    const Capture capture(pcap_create(options.interface.c_str(), why));
    if (!capture) fail(why);
    std::string trouble = begin(capture.get(), options.interface, filter);
    if (!trouble.empty()) fail(trouble);
    PcapWriter writer(options.output, pcap_datalink(capture.get()), snapshot_length);
    stop_on_signals();
    err << "recording to " << options.output << ", stop with Ctrl-C\n";
    trouble = record(capture.get(), writer, options.duration);
    report(capture.get(), options, writer.records(), err);
    if (!trouble.empty()) fail(trouble);
    writer.close();
    return exit_ok;
  });
}

}  // namespace lidard
