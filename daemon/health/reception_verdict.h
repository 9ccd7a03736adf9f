// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "daemon/health/diagnostics.h"
#include "drivers/reception.h"

namespace lidard {

/// The verdict on the reception.
struct ReceptionVerdict {
  Health health = Health::ok;
  std::string figures;  ///< "7.4 of 10.0 frames/s, 10 % of packets lost"; empty: no fault
  std::string remedy;   ///< what to check
};

/// Compares received with expected data.
///
/// - No frame although packets arrive: ERROR after 2 s or 5 periods. The slowest turn is 0.2 s, so full turns
///   fit in.
/// - Frames missing: WARN below 90 %, since a window counts one frame more or less and nominal rates are off
///   by 2 %; ERROR below 50 %, where a sensor is of no use for driving.
/// - Packets lost: WARN from 1 % and two packets on, since a cable loses nothing and a host that stalls loses
///   bursts; ERROR from 5 % on, which is 18 degrees of each turn.
/// - Duplicated packets: WARN from 10 % on; they are harmless, but indicate the state of the network.
/// - Packets rejected otherwise: WARN from 1 % and two packets on; ERROR from 99 % on, when another device
///   sends.
/// - Beams blind: WARN where 95 % are too near (0.3 m) or invalid, or none has a return; of a multi-plane
///   lidar, which sees the ground, less than 1 % of the shots. A cover and an empty field look the same.
///
/// Losses of a scanner that counts scans show in its frames, so after a loss missing frames are compared with
/// the limits for losses. Checks begin after 2 s, those of beams after 10 frames.
ReceptionVerdict judge(const Reception& reception, FrameKind kind);

/// The message if several sensors send to one entry; empty: one does. Senders that alternate send at the same
/// time, unlike a sensor with a changed address; less than 1 % of the packets, or 20, are packets astray.
std::string rivals_text(const Reception& reception, std::uint16_t port);

/// "3 (size 1, magic 2)", or "0".
std::string rejected_text(const Counters& counters);

}  // namespace lidard
