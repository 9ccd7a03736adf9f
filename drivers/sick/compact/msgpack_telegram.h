// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "drivers/sick/compact/segment.h"

namespace lidard::sick {

/// Parses a whole MSGPACK telegram (start mark, length, map, checksum) whose checksum was tested. `out`
/// points into it.
Reject parse_msgpack(ByteView telegram, Segment& out);

/// Parses a telegram without start mark, length and checksum.
Reject parse_msgpack_payload(ByteView payload, Segment& out);

}  // namespace lidard::sick
