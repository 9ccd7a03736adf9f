// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/free_space_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/base/bytes.h"
#include "core/base/clones.h"

namespace lidard {
namespace {

// Resolution at which the free way between two returns of a slanting wall is interpolated.
constexpr double widest_cell = 0.2 * rad_per_deg;
constexpr double most_cells = 65000;
// Beams farther apart than this are not neighbours; a scan plane that stands nearly upright has such beams.
constexpr float widest_step = 0.2F;  // rad
// m from a scanner to the way of a beam: nearer, nothing is overlooked between them.
constexpr float least_aside = 0.005F;

}  // namespace

void FreeSpaceMap::set(float x, float y, double beam_width, double unit) {
  x_ = x;
  y_ = y;
  per_meter_ = static_cast<float>(1 / unit);
  const double width = std::clamp(std::abs(beam_width), two_pi / most_cells, 0.1);
  const double cell = width / std::ceil(width / widest_cell - 1e-3);
  const double count = std::min(std::round(two_pi / cell), most_cells);
  per_rad_ = static_cast<float>(count / (two_pi));
  hides_.assign(static_cast<std::size_t>(count), 0);
  // After the last cell the first cells follow again.
  runs_.assign(run_lengths * (size() + longest_run), {});
  slots_.clear();
}

bool FreeSpaceMap::find_run(std::size_t cell, std::size_t length, RunAt& at) const {
  if (length == 0 || length > longest_run) return false;
  at = run_at(cell, length);
  return true;
}

LIDARD_CLONES void FreeSpaceMap::find_runs() {
  const std::size_t row = size() + longest_run;
  if (size() == 0) return;
  std::copy_n(runs_.begin(), longest_run, runs_.begin() + static_cast<std::ptrdiff_t>(size()));
  for (std::size_t power = 1; power < run_lengths; ++power) {
    const std::size_t half = std::size_t{1} << (power - 1);
    // As one list of numbers, which the processor compares eight at a time.
    const std::int16_t* const shorter = &runs_[(power - 1) * row].from;
    std::int16_t* const longer = &runs_[power * row].from;
    for (std::size_t i = 0; i < 2 * (row + 1 - 2 * half); ++i)
      longer[i] = std::max(shorter[i], shorter[i + 2 * half]);
  }
}

void FreeSpaceMap::clear() {
  std::fill_n(runs_.begin(), size(), Run{});
  std::fill(hides_.begin(), hides_.end(), char{0});
}

void FreeSpaceMap::span_of(std::uint16_t a, std::uint16_t b, std::size_t& first, std::size_t& count) const {
  const std::size_t low = std::min(a, b), high = std::max(a, b);
  const bool around = high - low > size() / 2;
  first = around ? high : low;
  count = around ? low + size() - high + 1 : high - low + 1;
}

bool FreeSpaceMap::is_free_between(Place a, Place b) const {
  const std::uint16_t nearest = std::min(a.distance, b.distance);
  const std::uint16_t farthest = std::max(a.distance, b.distance);
  std::size_t first = 0, count = 0;
  span_of(a.cell, b.cell, first, count);
  const std::int16_t near = ordered(nearest);
  const auto not_far = static_cast<std::int16_t>(~ordered(farthest));
  std::int16_t from = ordered(0);
  const auto are_free = [&](std::size_t cell, std::size_t length) {
    const RunAt run = run_at(cell, length);
    const Run one = runs_[run.first], other = runs_[run.second];
    from = std::max({from, one.from, other.from});
    return from <= near && std::max(one.not_to, other.not_to) <= not_far;
  };
  std::size_t rest = count;
  for (; rest > longest_run; rest -= longest_run) {
    if (!are_free(first, longest_run)) return false;
    first += longest_run;
    first -= first >= size() ? size() : 0;
  }
  if (!are_free(first, rest)) return false;
  if (from == ordered(0)) return true;
  // A way that passes the source comes nearer to it than both of its ends: to nearest * cos(angle / 2) if
  // both ends are equally far away. The way does not pass the source if the farther end lies beyond the
  // nearer one.
  const float angle = static_cast<float>(count) / per_rad_;
  const auto to_nearest = static_cast<float>(nearest);
  if (to_nearest <= static_cast<float>(farthest) * (1 - angle * angle / 2)) return true;
  const float passing = to_nearest * std::max(0.0F, 1 - angle * angle / 8);
  return from <= ordered(static_cast<std::uint16_t>(passing));
}

float FreeSpaceMap::hidden_by(Place a, Place b) const {
  const std::int32_t nearest = std::min(a.distance, b.distance), farthest = std::max(a.distance, b.distance);
  std::int32_t least = -1;
  std::size_t first = 0, count = 0;
  if (size() > 0) span_of(a.cell, b.cell, first, count);
  for (std::size_t k = first; k < first + count; ++k) {
    const std::size_t cell = k < size() ? k : k - size();
    const std::int32_t to = runs_[cell].to();
    if (hides_[cell] == 0 || to >= farthest) continue;
    const std::int32_t behind = std::max(0, nearest - to);
    if (least < 0 || behind < least) least = behind;
  }
  return least < 0 ? std::numeric_limits<float>::infinity() : static_cast<float>(least) / per_meter_;
}

FreeSpaceMap::Run FreeSpaceMap::run_of(float from, float to) const {
  const float units = std::min(from * per_meter_, 65534.0F);
  const float last = std::min(to * per_meter_, 65533.0F);
  // Rounded up, without a call of the mathematical library.
  auto first = static_cast<std::int32_t>(units);
  first += static_cast<float>(first) < units ? 1 : 0;
  const float span = last - static_cast<float>(first);
  const bool is_way = to > 0 && span >= 0;
  const std::int32_t length = static_cast<std::int32_t>(span);
  return {ordered(static_cast<std::uint16_t>(is_way ? first : 0xFFFF)),
          static_cast<std::int16_t>(~ordered(static_cast<std::uint16_t>(is_way ? first + length : 0xFFFF)))};
}

std::uint16_t FreeSpaceMap::cell_towards(float dx, float dy) const {
  const auto cell = static_cast<std::size_t>((fast_atan2(dy, dx) + static_cast<float>(pi_d)) * per_rad_);
  return static_cast<std::uint16_t>(cell < size() ? cell : 0);
}

LIDARD_CLONES void FreeSpaceMap::find_places(const float* x, const float* y, std::size_t count,
                                             Place* places) const {
  const float at_x = x_, at_y = y_, per_rad = per_rad_, per_meter = per_meter_;
  const auto cells = static_cast<std::int32_t>(size());
  // The results equal those of place_of(); the loop is vectorised.
  for (std::size_t i = 0; i < count; ++i) {
    const float dx = x[i] - at_x;
    const float dy = y[i] - at_y;
    const auto towards = static_cast<std::int32_t>((fast_atan2(dy, dx) + static_cast<float>(pi_d)) * per_rad);
    const float units = std::min(std::sqrt(dx * dx + dy * dy) * per_meter + 0.5F, 65534.0F);
    places[i] = {static_cast<std::uint16_t>(towards < cells ? towards : 0),
                 static_cast<std::uint16_t>(static_cast<std::int32_t>(units))};
  }
}

/// Adds the cells whose middle lies between the direction of a beam and its border to a neighbour, both in
/// cells from -pi.
void FreeSpaceMap::add_slots(std::size_t beam, std::size_t neighbour, std::size_t link, double at,
                             double border) {
  const auto count = static_cast<double>(size());
  const double width = 2 * std::fabs(border - at);
  const double to = std::max(at, border);
  for (double cell = std::ceil(std::min(at, border) - 0.5); cell + 0.5 < to; ++cell) {
    const double inside = cell - count * std::floor(cell / count);
    slots_.push_back({static_cast<std::uint16_t>(inside),
                      static_cast<float>(std::fabs(cell + 0.5 - at) / width),
                      static_cast<std::uint32_t>(beam), static_cast<std::uint32_t>(neighbour),
                      static_cast<std::uint32_t>(link)});
  }
}

void FreeSpaceMap::place_beams(const float* dx, const float* dy, std::size_t beams) {
  slots_.clear();
  if (beams == 0) return;
  const auto azimuth = [&](std::size_t beam) { return fast_atan2(dy[beam], dx[beam]); };
  const auto step_from = [&](std::size_t beam) {
    if (beam + 1 >= beams) return 0.0F;
    const float step = wrapped(azimuth(beam + 1) - azimuth(beam));
    return std::fabs(step) > widest_step ? 0.0F : step;
  };
  const auto per_rad = static_cast<double>(per_rad_);
  const std::size_t last = beams - 1;  // linked to none
  double at = (static_cast<double>(azimuth(0)) + pi_d) * per_rad;
  double step = static_cast<double>(step_from(0)) * per_rad;
  // The outer halves of the first and the last beam are as wide as their inner halves. Both beams at a border
  // use the same number for it, so that every cell belongs to exactly one beam.
  // Of a full circle they are neighbours.
  const double seam = static_cast<double>(wrapped(azimuth(0) - azimuth(last))) * per_rad;
  closed_ = last > 1 && std::fabs(seam) < 1.5 * std::fabs(step);
  double border = at - (closed_ ? seam : step) / 2;
  half_beam_ = static_cast<float>(step / 2);
  for (std::size_t beam = 0; beam < beams; ++beam) {
    add_slots(beam, beam > 0 ? beam - 1 : closed_ ? last : beam, beam > 0 ? beam - 1 : last, at, border);
    if (beam < last) step = static_cast<double>(step_from(beam)) * per_rad;
    border = at + (beam == last && closed_ ? seam : step) / 2;
    add_slots(beam, beam < last ? beam + 1 : closed_ ? 0 : last, beam, at, border);
    at += step;
    // Beyond a wide step the sum of steps is not the direction.
    if (beam < last && step == 0) at = border = (static_cast<double>(azimuth(beam + 1)) + pi_d) * per_rad;
  }
}

void FreeSpaceMap::set_runs() {
  for (std::size_t cell = 0; cell < size(); ++cell) runs_[cell] = run_of(starts_[cell], ends_[cell]);
}

void FreeSpaceMap::fill(const PlacedScan& sweep) {
  starts_.assign(size(), 0);
  ends_.assign(size(), -1);
  hides_.assign(size(), 0);
  if (sweep.moved) {
    fill_moved(sweep);
    return set_runs();
  }
  const float *const from = sweep.free_from.data(), *const ends = sweep.free_to.data();
  const Return* const kinds = sweep.kind.data();
  for (const Slot& slot : slots_) {
    const float to = ends[slot.beam], other = ends[slot.neighbour];
    const bool linked = sweep.linked[slot.link] == PlacedScan::linked_surely;
    // The neighbour's object may extend into the cell.
    const bool cut = !linked && kinds[slot.neighbour] != Return::nothing && other > 0 && other < to &&
                     slot.share > passed_share_;
    // The inverse of the distance changes (nearly) evenly along a straight line.
    const float on_line = to * other / (other + slot.share * (to - other));
    starts_[slot.cell] = cut ? std::max(from[slot.beam], from[slot.neighbour]) : from[slot.beam];
    ends_[slot.cell] = linked ? on_line : cut ? other : to;
    hides_[slot.cell] = cut || kinds[slot.beam] != Return::nothing ? 1 : 0;
  }
  set_runs();
}

void FreeSpaceMap::limit(float begin, float end, float from, float a, float b, bool hides) {
  // Both ends of a stretch are included, so that no cell between two stretches is left out.
  constexpr float slack = 0.01F;
  const float width = end - begin;
  const auto first = static_cast<std::int32_t>(std::ceil(std::min(begin, end) - 0.5F - slack));
  const float last = std::max(begin, end) - 0.5F + slack;
  for (std::int32_t cell = first; static_cast<float>(cell) <= last; ++cell) {
    const std::size_t at = inside(cell);
    const float share = std::fabs(width) > slack ? (static_cast<float>(cell) + 0.5F - begin) / width : 0.0F;
    const float within = std::clamp(share, 0.0F, 1.0F);
    const float to = a == b ? a : a * b / (b + within * (a - b));
    starts_[at] = std::max(starts_[at], from);
    if (ends_[at] >= 0 && to >= ends_[at]) continue;
    ends_[at] = to;
    hides_[at] = hides ? 1 : 0;
  }
}

void FreeSpaceMap::limit_pair(const PlacedScan& sweep, std::size_t beam, std::size_t after, float step) {
  const float at = azimuths_[beam];
  const float to = lengths_[beam];
  const float next = lengths_[after];
  const float from = std::max(begins_[beam], begins_[after]);
  const bool nearer = to <= next;
  const bool hides = sweep.kind[nearer ? beam : after] != Return::nothing;
  if (sweep.linked[beam] == PlacedScan::linked_surely) {
    limit(at, at + step, from, to, next, hides);
    return;
  }
  const float shorter = nearer ? to : next, longer = nearer ? next : to;
  const float passed = std::clamp(step, -2 * std::fabs(half_beam_), 2 * std::fabs(half_beam_)) *
                       (hides ? passed_share_ : 0.5F);
  const float begin = nearer ? at : at + step, end = nearer ? at + step : at;
  const float border = nearer ? end - passed : end + passed;
  limit(begin, border, from, shorter, shorter, hides);
  if (hides) {
    // The farther beam has moved towards the object, which ends where that beam passed it.
    const float reach = 2 * half_beam_ * (1 - passed_share_);
    limit(begin, nearer ? begin + reach : begin - reach, from, shorter, shorter, true);
  }
  limit(border, end, begins_[nearer ? after : beam], longer, longer,
        sweep.kind[nearer ? after : beam] != Return::nothing);
}

FreeSpaceMap::Edge FreeSpaceMap::edge_of(const PlacedScan& sweep, std::size_t beam, float outward) const {
  const float x = sweep.free_x[beam], y = sweep.free_y[beam];
  const float dx = sweep.origin_x[beam], dy = sweep.origin_y[beam];
  const float length = std::max(std::hypot(x - dx, y - dy), 1e-3F);
  const float sign = outward > 0 ? 1.0F : -1.0F;
  return {(fast_atan2(y - dy, x - dx) + static_cast<float>(pi_d)) * per_rad_, sign,
          sign * (dx * y - dy * x) / length};
}

/// Beside the outermost beam of a field, and beside beams without evidence, nobody has seen the strip between
/// the scanner's present place and the way of the beam, which began elsewhere.
void FreeSpaceMap::begin_later(const Edge& edge, bool keeps_near) {
  constexpr float housing = 0.3F;  // m from the scanner
  if (edge.aside < least_aside) return;
  // From half a beam on the unseen side as far as the strip reaches.
  const float end = std::min(edge.aside / housing, 1.5F) * per_rad_;
  for (float inward = -std::fabs(half_beam_); inward <= end; ++inward) {
    const std::size_t cell = cell_at(edge.towards - edge.outward * inward);
    const float from = edge.aside / std::max(std::sin(inward / per_rad_), 1e-6F);
    if (!keeps_near || from < ends_[cell]) starts_[cell] = std::max(starts_[cell], from);
  }
}

/// What a return hides begins at the way of the beam that passed it, if the scanner is on the other side of
/// that now.
void FreeSpaceMap::end_earlier(const Edge& edge, float hit) {
  if (edge.aside > -least_aside) return;
  const auto count = static_cast<float>(size());
  const float turn = hit - edge.towards;
  const float span = edge.outward * (turn - count * std::round(turn / count));
  for (float within = 0; within <= span; ++within) {
    const std::size_t cell = cell_at(edge.towards + edge.outward * within);
    const float to = -edge.aside / std::max(std::sin(within / per_rad_), 1e-6F);
    if (to >= ends_[cell]) continue;
    ends_[cell] = to;
    hides_[cell] = 1;
  }
}

/// The last beam of a full circle was measured a sweep after the first one. They are neighbours only if the
/// vehicle moved little, and nothing lies between their ways.
bool FreeSpaceMap::joins_ends(const PlacedScan& sweep) const {
  if (!closed_) return false;
  const std::size_t last = sweep.kind.size() - 1;
  const auto count = static_cast<float>(size());
  const float step = azimuths_[0] - azimuths_[last];
  const float turn = step - count * std::round(step / count);
  const float dx = sweep.origin_x[0], dy = sweep.origin_y[0];
  const float x = sweep.free_x[0] - dx, y = sweep.free_y[0] - dy;
  const float aside = std::fabs((dx - sweep.origin_x[last]) * y - (dy - sweep.origin_y[last]) * x) /
                      std::max(std::hypot(x, y), 1e-3F);
  return std::fabs(turn) < 3 * std::fabs(half_beam_) && aside < least_aside;
}

void FreeSpaceMap::fill_moved(const PlacedScan& sweep) {
  const std::size_t beams = sweep.kind.size();
  const auto count = static_cast<float>(size());
  resize_amply(beams, azimuths_, lengths_, begins_);
  // Local copies let the loop be vectorised.
  const float per_rad = per_rad_;
  const float *const x = sweep.free_x.data(), *const y = sweep.free_y.data(),
                     *const to = sweep.free_to.data(), *const from = sweep.free_from.data(),
                     *const origin_x = sweep.origin_x.data(), *const origin_y = sweep.origin_y.data();
  float *const azimuths = azimuths_.data(), *const lengths = lengths_.data(), *const begins = begins_.data();
  for (std::size_t i = 0; i < beams; ++i) {
    const float length = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    azimuths[i] = (fast_atan2(y[i], x[i]) + static_cast<float>(pi_d)) * per_rad;
    lengths[i] = to[i] > 0 ? length : 0;
    begins[i] = from[i] > 0 ? from[i] + std::fabs(origin_x[i]) + std::fabs(origin_y[i]) : 0;
  }
  const auto is_free = [&](std::size_t i) { return i < beams && lengths_[i] > 0; };
  // A few missing beams hide at most a narrow thing. `onward`: 1, or -1 for the beams before.
  const auto is_outer = [&](std::size_t i, std::size_t onward) {
    constexpr std::size_t few = 4;
    for (std::size_t k = 2; k <= few; ++k) {
      if (is_free(i + k * onward)) return false;
    }
    return true;
  };
  const bool joined = beams > 2 && joins_ends(sweep);
  passed_.clear();
  for (std::size_t i = 0; i < beams; ++i) {
    if (!is_free(i)) continue;
    const float at = azimuths_[i];
    const bool hides = sweep.kind[i] != Return::nothing;
    const std::size_t before = i > 0 ? i - 1 : joined ? beams - 1 : beams;
    const std::size_t after = i + 1 < beams ? i + 1 : joined ? 0 : beams;
    if (!is_free(before)) {
      limit(at - half_beam_, at, begins_[i], lengths_[i], lengths_[i], hides);
      if (is_outer(i, ~std::size_t{0})) begin_later(edge_of(sweep, i, -half_beam_), false);
    }
    if (!is_free(after)) {
      limit(at, at + half_beam_, begins_[i], lengths_[i], lengths_[i], hides);
      if (is_outer(i, 1)) begin_later(edge_of(sweep, i, half_beam_), false);
      continue;
    }
    float step = azimuths_[after] - at;
    if (step > count / 2) step -= count;
    if (step < -count / 2) step += count;
    if (std::fabs(step) < widest_step * per_rad_) {
      limit_pair(sweep, i, after, step);
      continue;
    }
    // What is near has moved away from its neighbours in direction; it still hides what is behind.
    for (const std::size_t k : {i, after}) {
      if (sweep.kind[k] == Return::nothing) continue;
      limit(azimuths_[k] - 2 * half_beam_, azimuths_[k] + 2 * half_beam_, begins_[k], lengths_[k],
            lengths_[k], true);
    }
    const bool nearer = lengths_[i] <= lengths_[after];
    const std::size_t hit = nearer ? i : after;
    if (sweep.kind[hit] == Return::nothing) continue;
    passed_.push_back(
        {edge_of(sweep, nearer ? after : i, nearer ? -half_beam_ : half_beam_), azimuths_[hit]});
  }
  for (const auto& [edge, hit] : passed_) {
    begin_later(edge, true);
    end_earlier(edge, hit);
  }
}

}  // namespace lidard
