// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/output_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstring>
#include <ostream>

#include "daemon/pipeline/report.h"

namespace lidard {

void OutputReport::count(Stamp released) {
  if (messages == 0) first = released;
  last = released;
  ++messages;
}

double OutputReport::rate() const {
  const double span = seconds(last - first);
  return messages < 2 || span <= 0 ? 0 : static_cast<double>(messages - 1) / span;
}

std::string why_no_frame(const Model& model, const Counters& counters, Span span) {
  if (counters.packets > 0 && counters.rejected_total() >= counters.packets)
    return "no packet could be used, rejected " + rejected_text(counters) + "; is it a " +
           std::string(model.product) + "?";
  const std::string data = fmt::format("{} packets in {:.3f} s, a whole one usually takes {} s",
                                       counters.packets, seconds(span), model.frame_period);
  const double part = seconds(span) / model.frame_period;
  if (part < 0.95) return fmt::format("only about {:.1f} of a frame: {}", part, data);
  return fmt::format("no whole frame: {}; {} lost, {} frames cut off by begin, end or loss", data,
                     counters.lost_packets, counters.partial_frames);
}

void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out) {
  std::size_t width = std::strlen(head);
  for (const OutputReport& one : outputs) width = std::max(width, one.name.size());
  out << fmt::format("{:<{}}  {:>8}  {:>7}\n", head, width, "messages", "Hz");
  std::string untold;
  for (const OutputReport& one : outputs) {
    if (!one.promised && one.messages == 0) {
      untold += (untold.empty() ? "" : ", ") + one.name;
      continue;
    }
    const std::string rate = one.rate() > 0 ? fmt::format("{:.1f}", one.rate()) : "-";
    std::string remark = one.remark;
    if (one.messages == 0) remark = "none: " + (remark.empty() ? "nothing of its kind came" : remark);
    out << fmt::format("{:<{}}  {:>8}  {:>7}{}{}\n", one.name, width, one.messages, rate,
                       remark.empty() ? "" : "  ", remark);
  }
  if (!untold.empty()) out << "  not told by the devices: " << untold << '\n';
}

bool all_came(const std::vector<OutputReport>& outputs) {
  return std::all_of(outputs.begin(), outputs.end(),
                     [](const OutputReport& one) { return !one.promised || one.messages > 0; });
}

}  // namespace lidard
