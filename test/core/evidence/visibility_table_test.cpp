// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility_table.h"

#include <gtest/gtest.h>

#include "test/core/evidence/raster_bench.h"

namespace lidard::test::raster {
namespace {

// A stretch that is not free costs time only, since its steps are then walked one by one.
TEST(VisibilityTable, WhereASourceSeesAllAroundEveryStretchIsFree) {
  const Raster raster(full_circle(360));
  VisibilityTable table(raster);
  for (const float y : {0.5F, -0.5F}) {  // the beams cross the begin of the cells one way or the other
    FreeSpaceMap map;
    map.set(3, y, degree, FreeSpaceMap::unit_for(raster.grid().range_max));
    for (std::size_t cell = 0; cell < map.size(); ++cell) map.claim(cell, 0, 1000);
    map.find_runs();
    table.set(0, 1, raster, map, std::vector<float>(360, 0));
    for (std::size_t beam = 0; beam < 360; ++beam) {
      // Close to the source a stretch has too many cells.
      if (std::abs(3 * raster.sine(beam) - y * raster.cosine(beam)) < 0.45F) continue;
      for (std::size_t k = 0; k < table.stretches(); ++k)
        ASSERT_TRUE(table.stretch(beam, 0, k).is_free(map.runs())) << y << ' ' << beam << ' ' << k;
    }
  }
}

}  // namespace
}  // namespace lidard::test::raster
