// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility.h"

#include <cmath>
#include <limits>

namespace lidard {
namespace {

// Half of the longest way that may go unseen (0.3 m or 5 % of the range), or finer.
constexpr double shortest_step = 0.12;  // m
constexpr double growth = 0.025;        // of the range

}  // namespace

VisibilityTable::VisibilityTable(const Raster& raster) : beams_(raster.grid().beams) {
  double at = 0;
  while (at < raster.grid().range_max) {
    const double step = std::max(shortest_step, growth * at);
    edges_.push_back(static_cast<float>(at));
    middles_.push_back(static_cast<float>(at + step / 2));
    at += step;
  }
  edges_.push_back(static_cast<float>(at));
  stretches_of_beam_ = (middles_.size() + stretch_steps - 1) / stretch_steps;
  // No two steps begin within a shortest one.
  for (std::size_t k = 0; at > 0 && static_cast<double>(k) * shortest_step <= at; ++k) {
    const auto end = static_cast<float>(static_cast<double>(k + 1) * shortest_step);
    const auto steps = std::lower_bound(edges_.begin(), edges_.end(), end) - edges_.begin();
    steps_to_.push_back(static_cast<std::uint32_t>(steps));
  }
}

std::size_t VisibilityTable::step_at(float range) const {
  return static_cast<std::size_t>(std::lower_bound(middles_.begin(), middles_.end(), range) -
                                  middles_.begin());
}

std::size_t VisibilityTable::steps_to(float range) const {
  if (!(range > 0)) return 0;
  const auto bucket = static_cast<std::size_t>(range * static_cast<float>(1 / shortest_step));
  if (bucket >= steps_to_.size()) return middles_.size();
  std::size_t steps = std::min<std::size_t>(steps_to_[bucket] + 1, middles_.size());
  while (steps > 0 && edges_[steps - 1] >= range) --steps;
  return steps;
}

VisibilityTable::Stretch VisibilityTable::stretch_of(const Step* steps, const FreeSpaceMap& map) {
  const auto count = static_cast<std::int32_t>(map.size());
  std::int32_t at = 0, low = 0, high = 0;  // cells from the first step's
  std::uint16_t nearest = steps[0].distance, farthest = steps[0].distance;
  for (std::size_t m = 1; m < stretch_steps; ++m) {
    std::int32_t turn = steps[m].cell - steps[m - 1].cell;
    if (turn > count / 2) turn -= count;
    if (turn < -count / 2) turn += count;
    at += turn;
    low = std::min(low, at);
    high = std::max(high, at);
    nearest = std::min(nearest, steps[m].distance);
    farthest = std::max(farthest, steps[m].distance);
  }
  Stretch stretch{
      {}, FreeSpaceMap::ordered(nearest), static_cast<std::int16_t>(~FreeSpaceMap::ordered(farthest))};
  const std::int32_t first = steps[0].cell + low;
  const auto cell = static_cast<std::size_t>(first < 0 ? first + count : first);
  // Nothing is free from before the source.
  if (!map.find_run(cell, static_cast<std::size_t>(high - low + 1), stretch.cells))
    stretch.nearest = FreeSpaceMap::ordered(0), stretch.not_farthest = FreeSpaceMap::ordered(0);
  return stretch;
}

void VisibilityTable::set(std::size_t source, std::size_t sources, const Raster& raster,
                          const FreeSpaceMap& map) {
  if (sources != sources_) {
    sources_ = sources;
    stretches_.assign(beams_ * sources * stretches_of_beam_, {});
    steps_.assign(stretches_.size() * stretch_steps, {0, 0xFFFF});
  }
  for (std::size_t beam = 0; beam < beams_; ++beam) {
    for (std::size_t k = 0; k < stretches_of_beam_; ++k) {
      Step* const steps = steps_.data() + index(beam, source, k) * stretch_steps;
      for (std::size_t i = 0; i < stretch_steps; ++i) {
        const float range = middles_[std::min(k * stretch_steps + i, middles_.size() - 1)];
        const float dx = range * raster.cosine(beam) - map.x();
        const float dy = range * raster.sine(beam) - map.y();
        steps[i] = {map.cell_towards(dx, dy), map.distance(std::sqrt(dx * dx + dy * dy))};
      }
      stretches_[index(beam, source, k)] = stretch_of(steps, map);
    }
  }
}

namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
// At the end of a way: some source sees that nothing is there; no beam can see what is.
constexpr char seen_free = 1;
constexpr char blind = 2;

}  // namespace

Visibility::Visibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources)
    : settings_(settings),
      raster_(grid),
      table_(raster_),
      rays_(sources),
      maps_(sources),
      layers_(sources),
      range_max_(static_cast<float>(grid.range_max)),
      approach_(static_cast<float>(std::max(settings.approach, 5 * settings.noise))),
      ways_(grid.beams),
      last_step_(grid.beams),
      end_x_(grid.beams),
      end_y_(grid.beams),
      begin_(grid.beams, 0),
      inside_(grid.beams),
      states_(grid.beams, BeamState::unobserved),
      covered_(grid.beams, 0),
      blind_to_(grid.beams, 0) {
  const double asked = settings_.free_required > 0 ? settings_.free_required : grid.range_max;
  open_ = std::min(static_cast<float>(asked), range_max_);
  nearest_.clear(grid.beams);
  doubtful_.clear(grid.beams);
}

void Visibility::set_footprint(const Footprint& footprint) {
  const Footprint body = footprint.padded(Footprint::margin_m);
  const bool inside = footprint.contains({0, 0}) || body.contains({0, 0});
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    const double angle = raster_.grid().angle(beam);
    const auto crossing = body.crossing({0, 0}, {std::cos(angle), std::sin(angle)});
    begin_[beam] = inside && crossing ? static_cast<float>(crossing->out) : 0.0F;
    inside_[beam] = {};
    if (!crossing) continue;
    const auto end = static_cast<float>(crossing->out);
    // The step that holds the border is the body's too: nobody sees into it.
    const std::size_t border = table_.steps_to(static_cast<float>(crossing->in));
    inside_[beam] = {inside || border == 0 ? 0 : border - 1, table_.step_at(end), end};
  }
}

void Visibility::set_source(std::size_t source, const BeamRays& rays) {
  rays_[source] = rays;
  maps_[source].set_source(rays, FreeSpaceMap::unit_for(raster_.grid().range_max));
  table_.set(source, rays_.size(), raster_, maps_[source]);
}

void Visibility::set_place(float x, float y, double width) {
  const double unit = FreeSpaceMap::unit_for(raster_.grid().range_max);
  for (FreeSpaceMap& map : maps_) map.set(x, y, width, unit);
  table_.set(0, 1, raster_, maps_[0]);
  one_place_ = true;
  has_blind_ = true;
}

void Visibility::begin() {
  nearest_.clear(beams());
  doubtful_.clear(beams());
  ends_.clear(beams());
  for (FreeSpaceMap& map : maps_) map.clear();
}

void Visibility::compute(const std::vector<const PlacedScan*>& sweeps) {
  combine(sweeps);
  compute();
}

void Visibility::compute() {
  for (FreeSpaceMap& map : maps_) map.find_runs();
  look_at_ends();
  for (std::size_t beam = 0; beam < beams(); ++beam) states_[beam] = decide(beam);
}

void Visibility::combine(const std::vector<const PlacedScan*>& sweeps) {
  nearest_.clear(beams());
  doubtful_.clear(beams());
  ends_.clear(beams());
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    layers_[s].clear(beams());
    if (sweeps[s] == nullptr) {
      maps_[s].clear();
      continue;
    }
    maps_[s].fill(*sweeps[s]);
    raster_.draw(*sweeps[s], layers_[s]);
    raster_.mark_ends(*sweeps[s], rays_[s], ends_);
    raster_.draw_doubtful(*sweeps[s], doubtful_);
    for (std::size_t beam = 0; beam < beams(); ++beam) {
      if (!(layers_[s].range[beam] < nearest_.range[beam])) continue;
      nearest_.range[beam] = layers_[s].range[beam];
      nearest_.intensity[beam] = layers_[s].intensity[beam];
    }
  }
  if (!settings_.mean || sweeps.size() < 2) return;
  for (std::size_t beam = 0; beam < beams(); ++beam) average(beam);
}

void Visibility::average(std::size_t beam) {
  if (nearest_.range[beam] == infinite) return;
  const float limit = nearest_.range[beam] + static_cast<float>(3 * settings_.noise);
  float range = 0;
  float intensity = 0;
  float count = 0;
  for (const RangeLayer& layer : layers_) {
    if (!(layer.range[beam] <= limit)) continue;
    range += layer.range[beam];
    intensity += layer.intensity[beam];
    ++count;
  }
  nearest_.range[beam] = range / count;
  nearest_.intensity[beam] = intensity / count;
}

void Visibility::look_at_ends() {
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    const float way = has_hit(beam) ? nearest_.range[beam] - approach_ : open_;
    ways_[beam] = way;
    last_step_[beam] = static_cast<std::uint32_t>(table_.steps_to(way));
    end_x_[beam] = way * raster_.cosine(beam);
    end_y_[beam] = way * raster_.sine(beam);
  }
  end_free_.assign(beams(), 0);
  for (std::size_t s = 0; s < maps_.size(); ++s) {
    const char mark = has_blind_ && s + 1 == maps_.size() ? blind : seen_free;
    maps_[s].find_free(end_x_.data(), end_y_.data(), beams(), mark, end_free_.data());
  }
}

std::size_t Visibility::free_run(std::size_t source, std::size_t beam, std::size_t from,
                                 std::size_t to) const {
  if (source >= maps_.size() || maps_[source].size() == 0) return from;
  const FreeSpaceMap::Cell* const cells = maps_[source].cells();
  const FreeSpaceMap::Run* const runs = maps_[source].runs();
  const std::size_t row = row_of(source);
  constexpr std::size_t many = VisibilityTable::stretch_steps;
  while (from < to) {
    const std::size_t begin = from / many * many;
    if (from == begin && begin + many <= to && table_.stretch(beam, row, from / many).is_free(runs)) {
      from += many;
      continue;
    }
    const VisibilityTable::Step* const steps = table_.steps(beam, row, from / many);
    const std::size_t stop = std::min(to, begin + many);
    while (from < stop && cells[steps[from - begin].cell].is_free(steps[from - begin].distance)) ++from;
    if (from < stop) break;
  }
  return from;
}

bool Visibility::is_covered(std::size_t beam, std::size_t sources) {
  const float end = ways_[beam];
  const auto gap = static_cast<float>(settings_.gap);
  const auto share = static_cast<float>(settings_.gap_share);
  const std::size_t last = last_step_[beam];
  const Inside& body = inside_[beam];
  std::size_t m = 0;
  // What cannot be seen lies nearest.
  const std::size_t blind_source = has_blind_ ? maps_.size() - 1 : maps_.size();
  std::size_t source = blind_source < sources ? blind_source : witness_ < sources ? witness_ : 0;
  blind_to_[beam] = 0;
  std::size_t refused = 0;  // sources that do not see step m, one after the other
  float known = 0;
  while (m < last) {
    if (m >= body.from && m < body.to) {
      m = body.to;
      known = std::max(known, body.end);
      refused = 0;
      continue;
    }
    const std::size_t seen_to = free_run(source, beam, m, m < body.from ? std::min(last, body.from) : last);
    refused = seen_to > m ? 1 : refused + 1;
    if (seen_to > m) {
      known = table_.edge(seen_to);
      witness_ = source;
      if (source == blind_source && blind_to_[beam] <= 0) blind_to_[beam] = known;
    }
    m = seen_to;
    source = source + 1 < sources ? source + 1 : 0;
    if (refused < sources || m >= last) continue;
    const float edge = std::min(table_.edge(m + 1), end);
    if (edge - known > std::max(gap, share * edge)) break;
    ++m;
    refused = 0;
  }
  covered_[beam] = std::min(known, std::max(end, begin_[beam]));
  return m >= last;
}

BeamState Visibility::decide(std::size_t beam) {
  const float way = ways_[beam];
  // Nothing bounds what was not seen at the end of an open way, so its very end must be free.
  if (!has_hit(beam)) {
    const std::size_t sources = maps_.size() - (has_blind_ ? 1 : 0);
    const bool free =
        is_covered(beam, sources) && ends_.marked[beam] == 0 && (end_free_[beam] & seen_free) != 0;
    return free ? BeamState::free : BeamState::unobserved;
  }
  if (!is_covered(beam, maps_.size()) || ends_.range[beam] < way) return BeamState::gap;
  return way <= begin_[beam] || end_free_[beam] != 0 ? BeamState::hit : BeamState::behind;
}

void Visibility::encode(Profile profile, PlanarScan& scan, bool with_intensities) const {
  raster_.grid().prepare(scan, with_intensities);
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    float range = nearest_.range[beam];
    float intensity = nearest_.intensity[beam];
    bool hit = states_[beam] == BeamState::hit;
    bool free = states_[beam] == BeamState::free;
    if (profile == Profile::safety) {
      if (doubtful_.range[beam] < range) {
        range = doubtful_.range[beam];
        intensity = doubtful_.intensity[beam];
      }
      hit = range <= scan.range_max;
      free = free && !hit;
    }
    if (free) scan.set_without_hit(beam, BeamStatus::none);
    if (!hit) continue;
    if (range < scan.range_min) {
      scan.set_without_hit(beam, BeamStatus::near);
    } else {
      scan.set_hit(beam, range);
      if (with_intensities) scan.intensities[beam] = intensity;
    }
  }
  if (!has_blind_) return;
  scan.free_from.assign(beams(), 0);
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    if (scan.statuses[beam] != BeamStatus::hit) continue;
    // The way to a hit that is not known to be free proves nothing.
    const float range = scan.ranges[beam];
    scan.free_from[beam] = states_[beam] == BeamState::hit ? std::min(blind_to_[beam], range) : range;
  }
}

}  // namespace lidard
