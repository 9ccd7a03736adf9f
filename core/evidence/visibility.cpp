// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility.h"

#include <cmath>
#include <limits>

namespace lidard {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr std::size_t many = VisibilityTable::stretch_steps;
}  // namespace

Visibility::Visibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources)
    : settings_(settings),
      raster_(grid),
      table_(raster_),
      rays_(sources),
      maps_(sources),
      layers_(sources),
      observing_(sources),
      rows_(sources),
      row_of_(sources),
      range_max_(static_cast<float>(grid.range_max)),
      approach_(static_cast<float>(std::max(settings.approach, 5 * settings.noise))),
      ways_(grid.beams),
      end_x_(grid.beams),
      end_y_(grid.beams),
      way_ends_(sources, std::vector<FreeSpaceMap::Place>(grid.beams)),
      body_ends_(way_ends_),
      parts_(sources),
      begin_(grid.beams, 0),
      pieces_(grid.beams + 1, 0),
      states_(grid.beams, BeamState::unobserved),
      open_to_(grid.beams / VisibilityTable::wedge_beams + 1),
      covered_(grid.beams, 0),
      body_at_(grid.beams, infinite),
      blind_to_(grid.beams, 0) {
  const double asked = settings_.free_required > 0 ? settings_.free_required : grid.range_max;
  open_ = std::min(static_cast<float>(asked), range_max_);
  set_places(sources, sources);
  nearest_.clear(grid.beams);
  mixed_pixels_.clear(grid.beams);
}

void Visibility::set_footprint(const Footprint& footprint) {
  body_ = footprint.padded(Footprint::margin_m);
  inside_.clear();
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    const double angle = raster_.grid().angle(beam);
    const auto crossings = body_.crossings({0, 0}, {std::cos(angle), std::sin(angle)});
    const bool begins_inside = !crossings.empty() && crossings.front().in <= 0;
    begin_[beam] = begins_inside ? static_cast<float>(crossings.front().out) : 0.0F;
    pieces_[beam] = inside_.size();
    for (const auto& [in, out] : crossings) {
      const auto end = static_cast<float>(out);
      // The step that holds the border belongs to the body: no source sees into it.
      const std::size_t from = table_.step_at(static_cast<float>(in)), to = table_.step_at(end);
      if (inside_.size() > pieces_[beam] && from <= inside_.back().to)
        inside_.back().to = to, inside_.back().end = end;
      else
        inside_.push_back({from, to, end});
    }
  }
  pieces_[beams()] = inside_.size();
  for (std::size_t row = 0; row < rows_; ++row) find_ways(row);
}

void Visibility::find_ways(std::size_t row) {
  if (maps_[row].size() == 0) return;
  table_.set(row, rows_, raster_, maps_[row], begin_);
  body_ends_[row].resize(inside_.size());
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    for (std::size_t i = pieces_[beam]; i < pieces_[beam + 1]; ++i)
      body_ends_[row][i] = place_at(row, beam, inside_[i].end);
  }
}

void Visibility::set_source(std::size_t source, const BeamRays& rays) {
  const double unit = FreeSpaceMap::unit_for(raster_.grid().range_max);
  maps_[source].set_source(rays, unit, raster_.grid().increment);
  find_ways(source);
}

void Visibility::set_places(std::size_t places, std::size_t observing) {
  rows_ = places;
  observing_ = observing;
  for (std::size_t s = 0; s < row_of_.size(); ++s) row_of_[s] = s % places;
}

void Visibility::set_place(std::size_t place, float x, float y, double width) {
  const double unit = FreeSpaceMap::unit_for(raster_.grid().range_max);
  for (std::size_t s = place; s < maps_.size(); s += rows_) maps_[s].set(x, y, width, unit);
  widths_.resize(rows_);
  widths_[place] = static_cast<float>(width);
  column_ = *std::max_element(widths_.begin(), widths_.end());
  find_ways(place);
}

void Visibility::begin() {
  nearest_.clear(beams());
  mixed_pixels_.clear(beams());
  for (FreeSpaceMap& map : maps_) map.clear();
}

void Visibility::compute() {
  for (FreeSpaceMap& map : maps_) map.find_runs();
  find_ends();
  find_open_wedges();
  seen_from_ = 0;
  for (std::size_t beam = 0; beam < beams(); ++beam) states_[beam] = decide(beam);
}

void Visibility::find_open_wedges() {
  for (std::size_t wedge = 0, s = 0; wedge < open_to_.size(); ++wedge) {
    // A stretch inside the vehicle consists of the point where the beam leaves the vehicle.
    std::size_t k = 0;
    for (std::size_t refused = 0; refused < observing_ && k < table_.stretches();) {
      if (maps_[s].size() > 0 && table_.wedge(wedge, row_of(s), k).is_free(maps_[s].runs()))
        refused = 0, ++k;
      else
        ++refused, s = s + 1 < observing_ ? s + 1 : 0;
    }
    open_to_[wedge] = k * many;
  }
}

void Visibility::combine(const std::vector<const PlacedScan*>& sweeps) {
  nearest_.clear(beams());
  mixed_pixels_.clear(beams());
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    layers_[s].clear(beams());
    if (sweeps[s] == nullptr) {
      maps_[s].clear();
      continue;
    }
    maps_[s].fill(*sweeps[s]);
    raster_.draw(*sweeps[s], layers_[s]);
    raster_.draw_mixed_pixels(*sweeps[s], mixed_pixels_);
    for (std::size_t beam = 0; beam < beams(); ++beam) {
      if (!(layers_[s].range[beam] < nearest_.range[beam])) continue;
      nearest_.range[beam] = layers_[s].range[beam];
      nearest_.intensity[beam] = layers_[s].intensity[beam];
    }
  }
}

void Visibility::find_ends() {
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    const float way = has_hit(beam) ? nearest_.range[beam] * (1 - column_) - approach_ : open_;
    ways_[beam] = way;
    end_x_[beam] = way * raster_.cosine(beam);
    end_y_[beam] = way * raster_.sine(beam);
  }
  for (std::size_t row = 0; row < rows_; ++row) {
    if (maps_[row].size() > 0)
      maps_[row].find_places(end_x_.data(), end_y_.data(), beams(), way_ends_[row].data());
  }
}

std::size_t Visibility::free_run(std::size_t source, std::size_t beam, std::size_t from,
                                 std::size_t to) const {
  const FreeSpaceMap& map = maps_[source];
  if (map.size() == 0) return from;
  const std::size_t row = row_of(source);
  const FreeSpaceMap::Place begin = table_.place(beam, row, from);
  if (!map.is_free(begin)) return from;
  for (std::size_t more = VisibilityTable::stretch_steps; more > 0; more /= 2) {
    if (from + more <= to && map.is_free(begin, table_.place(beam, row, from + more))) from += more;
  }
  return from;
}

/// From some place no return hides part `part` of a step.
bool Visibility::is_open_to_some(const Walk& walk, std::size_t part) const {
  for (std::size_t row = 0; row < rows_; ++row) {
    const Parts& parts = parts_[row];
    // A source that did not look there is no witness.
    bool open = maps_[row].size() > 0 && maps_[row].has_evidence(parts[part]) &&
                maps_[row].has_evidence(parts[part + 1]);
    for (std::size_t s = row; s < walk.sources && open; s += rows_)
      open = maps_[s].hidden_by(parts_[row][part], parts_[row][part + 1]) == infinite;
    if (open) return true;
  }
  return false;
}

bool Visibility::accept_unseen(Walk& walk, float from, std::size_t part) {
  float behind = infinite;
  for (std::size_t s = 0; s < walk.sources; ++s) {
    const Parts& parts = parts_[row_of(s)];
    behind = std::min(behind, maps_[s].hidden_by(parts[part], parts[part + 1]));
  }
  const auto gap = static_cast<float>(settings_.gap);
  if (behind <= gap)
    body_at_[walk.beam] = from;
  else if (observing_ < maps_.size() && is_open_to_some(walk, part))
    behind = infinite;
  const float most = std::max(gap, static_cast<float>(settings_.gap_share) * walk.at);
  walk.unseen += walk.at - from;
  return behind == infinite && has_hit(walk.beam) && walk.at - walk.known <= most && walk.unseen <= 2 * most;
}

void Visibility::see(Walk& walk, std::size_t source, float to) {
  // The blind way continues until another source sees a piece of the way; an accepted gap does not end it.
  float& blind_to = blind_to_[walk.beam];
  if (is_blind(source) && (blind_to <= 0 || blind_to == walk.known)) blind_to = to;
  walk.known = to;
  witness_ = source;
}

std::size_t Visibility::free_stretches(std::size_t source, std::size_t beam, std::size_t from,
                                       std::size_t to) const {
  if (maps_[source].size() == 0) return from;
  const FreeSpaceMap::Run* const runs = maps_[source].runs();
  const auto* stretch = &table_.stretch(beam, row_of(source), from / many);
  for (; from + many <= to && stretch->is_free(runs); from += many) stretch += beams();
  return from;
}

std::size_t Visibility::seen_stretches(Walk& walk, std::size_t from, std::size_t to) {
  const std::size_t open = std::min(open_to_[walk.beam / VisibilityTable::wedge_beams], to / many * many);
  if (walk.sources <= observing_ && open > from) walk.known = table_.edge(from = open);
  // Another source may see a stretch that one source does not see completely.
  for (std::size_t asked = 0; asked < walk.sources && from + many <= to; ++asked) {
    const std::size_t seen_to = free_stretches(walk.source, walk.beam, from, to);
    if (seen_to > from) asked = 0, see(walk, walk.source, table_.edge(seen_to));
    from = seen_to;
    if (from + many <= to) next_source(walk);
  }
  return from;
}

std::size_t Visibility::seen_run(Walk& walk, std::size_t from, std::size_t to) {
  for (std::size_t refused = 0; refused < walk.sources && from < to;) {
    if (refused == 0 && from % many == 0) from = seen_stretches(walk, from, to);
    if (from == to) break;
    const std::size_t stop = std::min(to, from / many * many + many);
    const std::size_t seen_to = free_run(walk.source, walk.beam, from, stop);
    refused = seen_to > from ? 0 : refused + 1;
    if (seen_to > from) see(walk, walk.source, table_.edge(seen_to));
    if (seen_to < stop) next_source(walk);
    from = seen_to;
  }
  return from;
}

bool Visibility::sees_piece(Walk& walk, std::size_t step, bool from_body, std::size_t to) {
  const std::size_t beam = walk.beam;
  const bool to_end = to > walk.last;
  for (std::size_t asked = 0; asked < walk.sources; ++asked, next_source(walk)) {
    const std::size_t s = walk.source, row = row_of(s);
    if (maps_[s].size() == 0) continue;
    const auto begin = from_body ? body_ends_[row][walk.body] : table_.place(beam, row, step);
    const auto end = to_end ? way_ends_[row][beam] : table_.place(beam, row, to);
    if (!maps_[s].is_free(begin, end)) continue;
    see(walk, s, to_end ? ways_[beam] : table_.edge(to));
    return true;
  }
  return false;
}

bool Visibility::accept(Walk& walk, float from, float to) {
  std::array<float, std::tuple_size_v<Parts>> at, x, y;
  for (std::size_t part = 0; part < at.size(); ++part) {
    at[part] = part < parts_of_step ? from + (to - from) * static_cast<float>(part) / parts_of_step : to;
    const float place = std::max(at[part], VisibilityTable::nearest_place);
    x[part] = place * raster_.cosine(walk.beam);
    y[part] = place * raster_.sine(walk.beam);
  }
  for (std::size_t row = 0; row < rows_; ++row) {
    if (maps_[row].size() > 0) maps_[row].find_places(x.data(), y.data(), at.size(), parts_[row].data());
  }
  bool accepted = true;
  for (std::size_t part = 0; part < parts_of_step; ++part) {
    walk.at = at[part + 1];
    std::size_t s = 0;
    const auto sees = [&](std::size_t source) {
      const Parts& of = parts_[row_of(source)];
      return maps_[source].size() > 0 && maps_[source].is_free(of[part], of[part + 1]);
    };
    while (s < walk.sources && !sees(s)) ++s;
    if (s < walk.sources)
      see(walk, s, walk.at);
    else if (was_inside(walk.beam, at[part]) && was_inside(walk.beam, walk.at))
      walk.known = walk.at;
    else
      accepted = accept_unseen(walk, at[part], part) && accepted;
    if (!accepted && is_decided(walk.beam)) return false;
  }
  return accepted;
}

bool Visibility::may_hold_body(const Walk& walk, std::size_t step) const {
  float behind = infinite;
  for (std::size_t s = 0; s < walk.sources; ++s) {
    if (maps_[s].size() == 0) continue;
    const auto begin = table_.place(walk.beam, row_of(s), step);
    const auto end =
        step < walk.last ? table_.place(walk.beam, row_of(s), step + 1) : way_ends_[row_of(s)][walk.beam];
    behind = std::min(behind, maps_[s].hidden_by(begin, end));
  }
  return behind <= static_cast<float>(settings_.gap);
}

bool Visibility::is_covered(std::size_t beam, std::size_t sources) {
  const float end = ways_[beam];
  std::size_t body = pieces_[beam];
  const std::size_t no_body = pieces_[beam + 1];
  const std::size_t last = table_.step_at(end);
  const auto body_from = [&] { return body < no_body ? inside_[body].from : last + 1; };
  Walk walk{beam, sources, last, witness_ < sources ? witness_ : 0};
  // What cannot be seen lies nearest.
  if (observing_ < sources) walk.source = observing_;
  blind_to_[beam] = 0;
  body_at_[beam] = infinite;
  bool from_body = false;
  bool covered = true;
  for (std::size_t m = 0; walk.at < end;) {
    if (body < no_body && m >= inside_[body].from) {
      const bool at_begin = m == 0 && begin_[beam] > 0;
      from_body = true;
      walk.body = body++;
      m = inside_[walk.body].to;
      walk.at = walk.known = inside_[walk.body].end;
      // If the origin lies inside, the table's stretches begin at the border, too.
      if (at_begin && sources <= observing_)
        m = std::max(m, seen_stretches(walk, m / many * many, std::min(body_from(), last) / many * many));
      if (m > inside_[walk.body].to) from_body = false, walk.at = table_.edge(m);
      continue;
    }
    // Try to walk to the end of the way or to the next stretch at once; otherwise stretch by stretch, then
    // step by step.
    std::size_t to = std::min(m / many * many + many, last + 1);
    if (body_from() < to || (!from_body && m % many == 0 && to <= last)) to = m;
    if (to == m || !sees_piece(walk, m, from_body, to)) {
      to = m;
      const std::size_t whole = last / many * many;
      const std::size_t limit = m < whole ? whole : last;
      if (!from_body && m < last) to = seen_run(walk, m, std::min(limit, body_from()));
    }
    if (to == m) {
      to = m + 1;
      covered = cross_step(walk, m, from_body, covered);
      if (!covered && is_decided(beam)) break;
    }
    m = to;
    from_body = false;
    walk.at = m > last ? end : table_.edge(m);
  }
  if (covered) covered_[beam] = walk.known;
  covered_[beam] = std::min(covered_[beam], std::max(end, begin_[beam]));
  return covered;
}

/// An object behind a return counts although the way to it was not observed.
bool Visibility::cross_step(Walk& walk, std::size_t step, bool from_body, bool covered) {
  if (from_body && sees_piece(walk, step, true, step + 1)) return covered;
  if (!covered && !may_hold_body(walk, step)) return false;
  const float known = walk.known;
  if (accept(walk, walk.at, step < walk.last ? table_.edge(step + 1) : ways_[walk.beam])) return covered;
  if (covered) covered_[walk.beam] = known;
  return false;
}

/// Of a way that begins where one place is blind: from where on some source sees it to be free.
float Visibility::seen_from(std::size_t beam) {
  const auto is_seen = [&](std::size_t step) {
    std::size_t s = 0;
    const auto sees = [&](const FreeSpaceMap& map, std::size_t row) {
      return map.size() > 0 && map.is_free(table_.place(beam, row, step), table_.place(beam, row, step + 1));
    };
    while (s < observing_ && !sees(maps_[s], row_of(s))) ++s;
    return s < observing_;
  };
  const std::size_t end = table_.step_at(blind_to_[beam]);
  const std::size_t first = begin_[beam] > 0 ? table_.step_at(begin_[beam]) + 1 : 0;
  // Mostly a beam is seen from the same step on as the beam before.
  std::size_t m = std::min(std::max(first, seen_from_), end);
  while (m < end && !is_seen(m)) ++m;
  if (m == end) m = first;
  while (m < end && !is_seen(m)) ++m;
  while (m > first && m < end && is_seen(m - 1)) --m;
  seen_from_ = m;
  return m < end ? table_.edge(m) : blind_to_[beam];
}

BeamState Visibility::decide(std::size_t beam) {
  if (!has_hit(beam)) return is_covered(beam, observing_) ? BeamState::free : BeamState::unobserved;
  if (!is_covered(beam, maps_.size())) return BeamState::gap;
  if (blind_to_[beam] > 0) blind_to_[beam] = seen_from(beam);
  bool seen = ways_[beam] <= begin_[beam];
  for (std::size_t s = 0; s < maps_.size() && !seen; ++s)
    seen = maps_[s].size() > 0 && maps_[s].is_free(way_ends_[row_of(s)][beam]);
  return seen ? BeamState::hit : BeamState::behind;
}

}  // namespace lidard
