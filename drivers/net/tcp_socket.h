// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "drivers/address.h"

namespace lidard {

/// Prepares a socket that is about to connect: no waiting for more bytes to send, stamps of arrival, and
/// keep-alives that find a peer gone without a word after about 3 s.
void prepare_tcp_socket(int fd);

/// Reads what has arrived, without waiting. As recv(2); `stamp` is when the last byte came.
ssize_t receive_bytes(int fd, std::uint8_t* to, std::size_t room, Stamp& stamp);

/// Sends what the kernel takes, without waiting. As send(2), but raises no signal.
ssize_t send_bytes(int fd, ByteView bytes);

/// Why a connection could not be opened (`error` as errno has it), with the remedy.
std::string why_not_connected(const Endpoint& device, int error);
/// Why a connection ended; 0: the device closed it.
std::string why_disconnected(const Endpoint& device, int error);

}  // namespace lidard
