// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace lidard {

/// What to write instead of a key that former versions had, by its path like merged_scans.m.fuse; empty: there never
/// was such a key.
std::string_view instead_of(const std::string& path);

}  // namespace lidard
