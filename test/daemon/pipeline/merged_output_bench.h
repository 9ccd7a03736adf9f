// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "test/support/pipeline_bench.h"

namespace lidard::test::merged {

/// Two scanners at one place and a merged scan `m` of both.
inline std::string two_sources(const std::string& keys, const std::string& vehicle = "") {
  return "vehicle: {" + vehicle +
         "}\n"
         "sensors:\n"
         "  a: {topic: /a, pose: {xyz: [0, 0, 0]}}\n"
         "  b: {topic: /b, pose: {xyz: [0, 0, 0]}}\n"
         "merged_scans: {m: {laserscan_topics: [a, b], beams: 360, range_max: 20, " +
         keys + "}}\n";
}

inline const Span sweep_time = ms(80);

/// A sweep of 80 ms whose last beam is measured, and which comes in, at `end`.
inline void sweep(PipelineBench& bench, const std::string& source, Span end, float range = 5) {
  bench.give(source, round_scan(source, bench_begin + end - sweep_time, range, 361, sweep_time),
             bench_begin + end);
}

inline void expect_near(Stamp is, Stamp should, const char* what = "") {
  EXPECT_NEAR(seconds(is - should), 0, 2e-6) << what;
}

/// Knots every 10 ms of a vehicle that turns, up to `newest` of the bench's time; none comes before its time.
inline void poses_until(PipelineBench& bench, Span newest, Stamp arrival) {
  for (Span at = newest - ms(600); at <= newest; at += ms(10))
    bench.pipeline.pose_message(bench_begin + at, make_pose({0, 0, 0}, {0, 0, 0.3 * seconds(at)}), "",
                                std::max(arrival, bench_begin + at));
}

}  // namespace lidard::test::merged
