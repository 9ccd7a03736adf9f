// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/outline.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// Beams farther apart than this (sine) are not neighbours; a scan plane that stands nearly upright has such
// beams.
constexpr float widest_step = 0.2F;
// Cosine of the angle between two vertices of a far side; its chords must stay beyond all ranges.
constexpr float far_step = 0.95F;
// m; free ways whose ends differ less end at one distance.
constexpr float same_length = 1e-4F;
// Share of the distance; free ways whose begins differ less begin along a straight line.
constexpr float same_begin = 0.03F;
// Share of the distance; a border that changes less is drawn with a vertex per so many rad.
constexpr float same_border = 0.0002F;
constexpr float border_step = 0.03F;
// The path of a scanner is drawn with a vertex per so many beams. It bends little within a sweep.
constexpr std::size_t path_stride = 16;

}  // namespace

void Outlines::clear() {
  x.clear();
  y.clear();
  edges.clear();
}

std::uint32_t Outlines::add_vertex(float at_x, float at_y) {
  x.push_back(at_x);
  y.push_back(at_y);
  return static_cast<std::uint32_t>(x.size() - 1);
}

Outlines::Edge& Outlines::add_edge(std::uint32_t from, std::uint32_t to, int free, int hidden) {
  edges.push_back({from, to, source_, static_cast<std::int8_t>(free), static_cast<std::int8_t>(hidden)});
  return edges.back();
}

void Outlines::add_polygon(std::size_t source, const Footprint& polygon) {
  source_ = static_cast<std::uint16_t>(source);
  const auto first = static_cast<std::uint32_t>(x.size());
  const auto count = static_cast<std::uint32_t>(polygon.vertices().size());
  for (const Eigen::Vector2d& v : polygon.vertices())
    add_vertex(static_cast<float>(v.x()), static_cast<float>(v.y()));
  for (std::uint32_t i = 0; i < count; ++i) add_edge(first + i, first + (i + 1) % count, -1, 0);
}

void Outlines::set_source(std::size_t source, float passed_share, float reach) {
  source_ = static_cast<std::uint16_t>(source);
  passed_share_ = passed_share;
  reach_ = reach;
}

void Outlines::add_sweep(const BeamRays& rays, const PlacedScan& sweep) {
  step_ = static_cast<float>(std::fabs(rays.increment));
  moved_ = sweep.moved;
  read_beams(rays, sweep);
  const std::size_t n = count_;
  const bool closes = closes_circle();
  // A full circle is read from a break on.
  std::size_t start = 0;
  if (closes) {
    while (start < n && joins(start, start + 1)) ++start;
    if (start == n) return add_run(0, n, true, 0, 0);
    ++start;
  }
  for (std::size_t k = start; k < start + n;) {
    if (beam(k).length <= 0) {
      ++k;
      continue;
    }
    std::size_t end = k + 1;
    while (end < start + n && (end != n || closes) && joins(end - 1, end)) ++end;
    add_run(k, end, false, 0.5F, 0.5F);
    k = end;
  }
}

void Outlines::add_strip(std::vector<Beam>& beams, float step, Side begin, Side end) {
  step_ = step;
  moved_ = true;
  drop_needless_beams(beams);
  beams_ = beams.data();
  count_ = beams.size();
  const auto share = [this](Side side) {
    return side == Side::unknown ? 0.5F : side == Side::other ? passed_share_ : 0;
  };
  add_run(0, count_, false, share(begin), share(end));
}

/// Drops beams within an open border, whose neighbours show the same.
void Outlines::drop_needless_beams(std::vector<Beam>& beams) const {
  const auto same = [&beams](std::size_t kept, std::size_t k) {
    const Beam &p = beams[kept], &b = beams[k];
    return p.to_next && !p.hides && !b.hides && std::fabs(p.length - b.length) <= same_border * p.length &&
           std::fabs(p.from - b.from) <= same_border * p.from;
  };
  const std::size_t n = beams.size();
  // The ends of the strip are as wide as the step to their neighbours.
  if (n < 5) return;
  std::size_t kept = 1;
  float since = 0;  // rad
  for (std::size_t k = 2; k < n; ++k) {
    since += step_;
    if (since < border_step && k + 2 < n && beams[k].to_next && same(kept, k) && same(kept, k + 1)) continue;
    beams[++kept] = beams[k];
    since = 0;
  }
  beams.resize(kept + 1);
}

void Outlines::read_beams(const BeamRays& rays, const PlacedScan& sweep) {
  const std::size_t n = sweep.kind.size();
  const bool clockwise = (rays.increment < 0) != (rays.pose.linear()(2, 2) < 0);
  sweep_.resize(n);
  beams_ = sweep_.data();
  count_ = n;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = clockwise ? n - 1 - k : k;
    transform_beam(rays, sweep, i, reach_, beams_[k]);
    // The last beam is linked to none.
    const bool last = k + 1 == n;
    beams_[k].to_next = !last && sweep.linked[clockwise ? i - 1 : i] == PlacedScan::linked_surely;
  }
  for (const PlacedScan::Corner& corner : sweep.corners)
    beams_[clockwise ? n - 2 - corner.beam : corner.beam].corner = &corner.at;
  for (const PlacedScan::LoneReturn& lone : sweep.lone_returns)
    if (!lone.thing) pass_lone_return(clockwise ? n - 1 - lone.beam : lone.beam);
}

void Outlines::transform_beam(const BeamRays& rays, const PlacedScan& sweep, std::size_t i, float reach,
                              Beam& b) {
  const auto at_x = static_cast<float>(rays.pose.translation().x()),
             at_y = static_cast<float>(rays.pose.translation().y());
  b.length = std::min(sweep.free_to[i], reach);
  b.from = sweep.free_from[i];
  b.hides = sweep.kind[i] != Return::nothing;
  b.vertex = none;
  b.corner = nullptr;
  if (sweep.moved) {
    b.ox = at_x + sweep.origin_x[i], b.oy = at_y + sweep.origin_y[i];
    b.x = at_x + sweep.free_x[i], b.y = at_y + sweep.free_y[i];
    const float per_m = sweep.free_to[i] > 0 ? 1 / sweep.free_to[i] : 0;
    b.ux = (b.x - b.ox) * per_m, b.uy = (b.y - b.oy) * per_m;
    if (b.length < sweep.free_to[i]) b.x = b.ox + b.ux * b.length, b.y = b.oy + b.uy * b.length;
  } else {
    const float per_m = 1 / rays.level[i];
    b.ox = at_x, b.oy = at_y;
    b.ux = rays.x[i] * per_m, b.uy = rays.y[i] * per_m;
    b.x = at_x + b.ux * b.length, b.y = at_y + b.uy * b.length;
  }
  b.bx = b.ox + b.ux * b.from, b.by = b.oy + b.uy * b.from;
  // A linked return is drawn where its surface is.
  const bool at_return =
      b.hides && std::fabs(b.length - sweep.range[i] * rays.level[i]) < same_length * b.length;
  if (at_return) b.x = sweep.x[i], b.y = sweep.y[i];
}

/// Adds the free space behind a return that one beam alone met: what it hides is no wider than the space
/// between the beams beside it.
void Outlines::pass_lone_return(std::size_t k) {
  const Beam &a = beams_[k - 1], &b = beams_[k], &c = beams_[k + 1];
  const float from = b.length + PlacedScan::lone_depth, to = std::min(a.length, c.length);
  if (!(to > from)) return;
  // A little more than what the return owns, so that nothing is left out in between.
  const float share = 1.01F * (1 - passed_share_);
  const float rx = b.ux + share * (a.ux - b.ux), ry = b.uy + share * (a.uy - b.uy);
  const float lx = b.ux + share * (c.ux - b.ux), ly = b.uy + share * (c.uy - b.uy);
  const std::uint32_t first = add_vertex(b.ox + rx * from, b.oy + ry * from);
  add_vertex(b.ox + rx * to, b.oy + ry * to);
  add_vertex(b.ox + lx * to, b.oy + ly * to);
  add_vertex(b.ox + lx * from, b.oy + ly * from);
  for (std::uint32_t side = 0; side < 4; ++side) add_edge(first + side, first + (side + 1) % 4, -1, 0);
}

bool Outlines::joins(std::size_t a, std::size_t b) const {
  const Beam &p = beam(a), &q = beam(b);
  return p.length > 0 && q.length > 0 && p.ux * q.ux + p.uy * q.uy > 0 &&
         std::fabs(p.ux * q.uy - p.uy * q.ux) < widest_step;
}

/// The last beam of a full circle is the neighbour of the first one while the vehicle stands; otherwise a
/// whole sweep lies between them.
bool Outlines::closes_circle() const {
  const std::size_t n = count_;
  if (n < 3 || moved_) return false;
  const auto turn = [this](std::size_t a, std::size_t b) {
    return beam(a).ux * beam(b).uy - beam(a).uy * beam(b).ux;
  };
  const float seam = turn(n - 1, n), step = turn(0, 1);
  // The last beam may point where the first one does.
  return seam > -0.1F * step && seam < 1.5F * step &&
         beam(0).ux * beam(n - 1).ux + beam(0).uy * beam(n - 1).uy > 0;
}

/// Adds the outline of beams [first, end), neighbours all; `closed`: they are the full circle.
/// `begin_share`, `end_share`: of a step, by which the run extends beyond its first and last beam.
void Outlines::add_run(std::size_t first, std::size_t end, bool closed, float begin_share, float end_share) {
  chain_.clear();
  const std::size_t pairs = closed ? end : end - 1;
  if (begin_share > 0) add_end(first, end, true, begin_share);
  for (std::size_t k = first; k < pairs; ++k) add_pair(k);
  if (!closed) push(vertex_of(end - 1), beam(end - 1), end_share > 0 && beam(end - 1).hides);
  if (end_share > 0) add_end(first, end, false, end_share);
  const std::size_t links = chain_.size();
  if (links < 2) return;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < links; ++i) {
    const Link& here = chain_[i];
    add_edge(here.vertex, link(i + 1).vertex, -1, here.hides ? 1 : 0).near = here.near;
  }
  add_inner_side(first, end, closed);
  add_hidden(closed);
}

std::uint32_t Outlines::vertex_of(std::size_t k) {
  Beam& b = beam(k);
  if (b.vertex == none) b.vertex = add_vertex(b.x, b.y);
  return b.vertex;
}

/// Extends the run beyond its first or last beam at the beam's distance.
void Outlines::add_end(std::size_t first, std::size_t end, bool begins, float share) {
  const Beam b = beam(begins ? first : end - 1);
  float tx = -b.uy * step_ * share, ty = b.ux * step_ * share;
  if (end - first > 1) {
    const Beam& before = beam(begins ? first : end - 2);
    const Beam& after = beam(begins ? first + 1 : end - 1);
    tx = (after.ux - before.ux) * share, ty = (after.uy - before.uy) * share;
  }
  Beam edge = b;
  if (begins) tx = -tx, ty = -ty;
  edge.ux += tx, edge.uy += ty;
  edge.bx += tx * b.from, edge.by += ty * b.from;
  push(add_vertex(b.x + tx * b.length, b.y + ty * b.length), edge, begins && b.hides);
}

void Outlines::push(std::uint32_t vertex, const Beam& beam, bool hides, Edge::Near near) {
  chain_.push_back({vertex, beam.ux, beam.uy, beam.bx, beam.by, hides, near});
}

/// Adds what lies between beam k and the next one, but for the end of the next one.
void Outlines::add_pair(std::size_t k) {
  const std::uint32_t vertex = vertex_of(k);
  const Beam &a = beam(k), &b = beam(k + 1);
  const bool nearer = a.length <= b.length;
  const bool hides = nearer ? a.hides : b.hides;
  if (a.to_next) {
    push(vertex, a, a.hides || b.hides);
    if (a.corner != nullptr) push(add_vertex(a.corner->x, a.corner->y), b, a.hides || b.hides);
    return;
  }
  push(vertex, a, a.hides);
  if (!hides && std::fabs(a.length - b.length) <= same_length) return;
  const float passed = hides ? passed_share_ : 0.5F;
  const float share = nearer ? 1 - passed : passed;
  Beam border = a;
  border.ux += share * (b.ux - a.ux), border.uy += share * (b.uy - a.uy);
  border.ox += share * (b.ox - a.ox), border.oy += share * (b.oy - a.oy);
  const float scale = 1 / std::sqrt(border.ux * border.ux + border.uy * border.uy);
  border.ux *= scale, border.uy *= scale;
  push(add_vertex(border.ox + border.ux * a.length, border.oy + border.uy * a.length), border, hides,
       nearer ? Edge::at_from : Edge::at_to);
  push(add_vertex(border.ox + border.ux * b.length, border.oy + border.uy * b.length), border, b.hides);
}

/// Between two beams of which one begins to see nearer, that one owns the passed share of the angle.
template <class Lead>
void Outlines::lead_along_border(const Beam& a, const Beam& b, Lead lead_to) {
  if (std::fabs(a.from - b.from) <= same_begin * std::min(a.from, b.from)) return;
  const float share = a.from < b.from ? passed_share_ : 1 - passed_share_;
  const auto at = [&](float from) {
    const float bx = a.bx + (a.ux * (from - a.from)), by = a.by + (a.uy * (from - a.from));
    const float ex = b.bx + (b.ux * (from - b.from)), ey = b.by + (b.uy * (from - b.from));
    return add_vertex(bx + share * (ex - bx), by + share * (ey - by));
  };
  lead_to(at(a.from));
  lead_to(at(b.from));
}

/// Adds the way back along the begins of the free ways.
void Outlines::add_inner_side(std::size_t first, std::size_t end, bool closed) {
  bool begins_later = false;  // nearer than somewhere nobody looked
  for (std::size_t k = first; k < end; ++k) begins_later = begins_later || beam(k).from > 0;
  if (closed && !begins_later) return;
  const std::size_t stride = begins_later ? 1 : moved_ ? path_stride : end - first;
  const std::uint32_t start = closed ? add_vertex(beam(end - 1).bx, beam(end - 1).by) : chain_.back().vertex;
  std::uint32_t at = start;
  const auto lead_to = [&](std::uint32_t vertex) {
    add_edge(at, vertex, -1, 0);
    at = vertex;
  };
  if (!closed) lead_to(add_vertex(chain_.back().bx, chain_.back().by));
  std::size_t drawn = end - 1;
  for (std::size_t k = end - 1; k > first + stride; k -= stride) {
    const Beam& next = beam(k - stride);
    const Beam& last = beam(drawn);
    const auto same = [&](std::size_t other) {
      return std::fabs(last.from - beam(other).from) <= same_border * last.from;
    };
    const bool near = std::fabs(last.ux * next.uy - last.uy * next.ux) < border_step;
    if (begins_later && near && same(k - 1) && same(k - 2)) continue;
    if (begins_later) lead_along_border(beam(k), next, lead_to);
    lead_to(add_vertex(next.bx, next.by));
    drawn = k - stride;
  }
  if (begins_later && end - first > 1) lead_along_border(beam(first + 1), beam(first), lead_to);
  if (closed || stride < end - first) lead_to(add_vertex(beam(first).bx, beam(first).by));
  if (closed) return lead_to(start);
  if (begins_later) lead_to(add_vertex(chain_.front().bx, chain_.front().by));
  lead_to(chain_.front().vertex);
}

/// Adds the borders and far sides of what the chain's returns hide.
void Outlines::add_hidden(bool closed) {
  const std::size_t links = chain_.size();
  const std::size_t count = closed ? links : links - 1;  // of edges
  std::size_t start = 0;
  if (closed) {
    while (start < links && chain_[start].hides) ++start;
    if (start == links) return add_far_side(0, links);
  }
  for (std::size_t k = start; k < start + count;) {
    if (!link(k).hides) {
      ++k;
      continue;
    }
    std::size_t end = k;
    while (end < start + count && link(end).hides) ++end;
    add_far_side(k, end);
    k = end;
  }
}

/// Links [first, last] of the chain, which may count on beyond its end.
void Outlines::add_far_side(std::size_t first, std::size_t last) {
  const auto far = [this](const Link& link) {
    return add_vertex(x[link.vertex] + link.ux * reach_, y[link.vertex] + link.uy * reach_);
  };
  std::uint32_t vertex = far(link(first));
  add_edge(link(first).vertex, vertex, 0, -1).near = Edge::at_from;
  std::size_t before = first;
  for (std::size_t k = first + 1; k <= last; ++k) {
    const bool turned = link(before).ux * link(k).ux + link(before).uy * link(k).uy < far_step;
    if (!turned && k < last) continue;
    const std::uint32_t next = far(link(k));
    add_edge(vertex, next, 0, -1).beyond = true;
    vertex = next;
    before = k;
  }
  add_edge(vertex, link(last).vertex, 0, -1).near = Edge::at_to;
}

}  // namespace lidard
