// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_parameters.h"

#include <array>
#include <charconv>

#include "core/base/angle.h"
#include "drivers/hokuyo/scip_message.h"

namespace lidard::hokuyo {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

bool is_plausible(const ScipParameters& p) {
  // Four digits hold a step in a request, three characters a distance.
  return p.range_min_mm >= 0 && p.range_max_mm > p.range_min_mm && p.range_max_mm < 1 << 18 &&
         p.steps_per_turn > 0 && p.steps_per_turn <= 100'000 && p.first_step >= 0 &&
         p.last_step > p.first_step && p.last_step <= 9999 && p.front_step >= 0 && p.front_step <= 9999 &&
         p.rpm > 0 && p.rpm <= 100'000;
}

}  // namespace

BeamStatus status_of_code(CodeTable table, std::uint32_t code) {
  if (table == CodeTable::urg) {
    // 0: possibly at 22 m; 6: "others", in practice beyond the range (as hokuyo_node takes both).
    return code == 0 || code == 6 ? BeamStatus::none : BeamStatus::invalid;
  }
  if (code == 1) return BeamStatus::none;
  // 2: too near (internal error); 4: out of range at the near end.
  return code == 2 || code == 4 ? BeamStatus::near : BeamStatus::invalid;
}

CodeTable code_table_of(std::string_view product) {
  for (const std::string_view family : {"URG", "UBG", "UHG"}) {
    if (product.substr(0, family.size()) == family) return CodeTable::urg;
  }
  return CodeTable::utm;
}

double ScipParameters::rad_per_step() const { return two_pi / steps_per_turn; }

bool operator==(const ScipParameters& a, const ScipParameters& b) {
  return a.range_min_mm == b.range_min_mm && a.range_max_mm == b.range_max_mm &&
         a.steps_per_turn == b.steps_per_turn && a.first_step == b.first_step && a.last_step == b.last_step &&
         a.front_step == b.front_step && a.rpm == b.rpm;
}

bool split_entry(std::string_view line, std::string_view& key, std::string_view& value, bool& sound) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.size() < colon + 3) return false;
  const std::string_view counted = line.substr(0, line.size() - 1);
  std::string_view bare = counted;
  if (bare.back() == ';') bare.remove_suffix(1);
  sound = line.back() == scip_checksum(bare) || line.back() == scip_checksum(counted);
  key = line.substr(0, colon);
  value = trimmed(bare.substr(colon + 1));
  return true;
}

bool parse_parameters(std::string_view body, ScipParameters& parameters, std::string& product) {
  struct Field {
    std::string_view key;
    int ScipParameters::*value;
  };
  constexpr std::array<Field, 7> fields = {{{"DMIN", &ScipParameters::range_min_mm},
                                            {"DMAX", &ScipParameters::range_max_mm},
                                            {"ARES", &ScipParameters::steps_per_turn},
                                            {"AMIN", &ScipParameters::first_step},
                                            {"AMAX", &ScipParameters::last_step},
                                            {"AFRT", &ScipParameters::front_step},
                                            {"SCAN", &ScipParameters::rpm}}};
  ScipParameters read;
  std::size_t found = 0;
  bool all_sound = true;
  std::string_view name;
  for_each_entry(body, [&](std::string_view key, std::string_view value, bool sound) {
    all_sound = all_sound && sound;
    if (key == "MODL") name = value.substr(0, value.find('('));
    for (const Field& field : fields) {
      if (field.key != key) continue;
      const auto result = std::from_chars(value.data(), value.data() + value.size(), read.*field.value);
      if (result.ec == std::errc() && result.ptr == value.data() + value.size()) ++found;
    }
  });
  if (!all_sound || found != fields.size() || !is_plausible(read)) return false;
  parameters = read;
  product = trimmed(name);
  return true;
}

}  // namespace lidard::hokuyo
