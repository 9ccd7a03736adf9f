// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>

namespace lidard {

/// `lidard models`: the table of supported models and how each was verified, for people or as JSON. Returns
/// the exit code.
int run_models(bool json, std::ostream& out);

}  // namespace lidard
