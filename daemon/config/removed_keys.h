// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace lidard {

/// The replacement of a key of former versions, by its path like merged_scans.m.fuse; empty: there was no
/// such key.
std::string_view instead_of(const std::string& path);

/// The key that stands for one of other drivers, like sensors.a.hostname; empty: not known.
std::string_view ours_for(const std::string& path);

}  // namespace lidard
