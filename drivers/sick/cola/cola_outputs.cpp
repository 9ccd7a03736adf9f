// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_outputs.h"

namespace lidard::sick {
namespace {

void append_change(std::string& text, const char* what, const std::string& before, const std::string& now) {
  if (before == now) return;
  text += (text.empty() ? "" : ", ") + std::string(what) + " " + before + " -> " + now;
}

}  // namespace

bool operator==(const ColaOutputs& a, const ColaOutputs& b) {
  return a.channels == b.channels && a.rssi == b.rssi && a.wide_rssi == b.wide_rssi && a.unit == b.unit &&
         a.encoders == b.encoders && a.position == b.position && a.name == b.name && a.comment == b.comment &&
         a.time == b.time && a.interval == b.interval;
}

std::string echoes_of(const ColaOutputs& s) {
  std::string text;
  for (unsigned bit = 0; bit < 5; ++bit) {
    if ((s.channels[0] >> bit & 1U) != 0) text += (text.empty() ? "" : "+") + std::to_string(bit + 1);
  }
  return text.empty() ? "none" : text;
}

std::string changes(const ColaOutputs& before, const ColaOutputs& now) {
  std::string text;
  const auto on_off = [](bool on) { return std::string(on ? "on" : "off"); };
  append_change(text, "echoes", echoes_of(before), echoes_of(now));
  append_change(text, "intensity", on_off(before.rssi != 0), on_off(now.rssi != 0));
  append_change(text, "output interval", std::to_string(before.interval), std::to_string(now.interval));
  return text;
}

}  // namespace lidard::sick
