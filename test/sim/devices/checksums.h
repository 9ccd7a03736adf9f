// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace lidard::sim {

/// Makes the checksums of changed bytes right again, so that decoders look at what is inside: of a Compact or
/// MSGPACK telegram, of each whole CoLa B telegram, UAM frame or SCIP line. What has none stays as it is.
void make_checksums_right(std::vector<std::uint8_t>& bytes);

}  // namespace lidard::sim
