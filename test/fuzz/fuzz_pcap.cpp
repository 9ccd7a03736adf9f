// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any bytes as a capture file, whose sensors are recognized and decoded by their drivers; the configuration
// made of them must be accepted. Corpus: the captures of pcaps/, so that packets of every family are changed
// in single bytes; -max_len=65536.
#include <cstdlib>

#include "daemon/config/config.h"
#include "daemon/offline/survey.h"
#include "test/drivers/capture/pcap_testing.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const lidard::test::MemoryFile file(data, size);
  const lidard::test::Contents got = lidard::test::read_capture(file.path());
  if (!lidard::test::adds_up(got.counters)) std::abort();
  if (!got.opened && got.error.empty()) std::abort();
  const lidard::Survey seen = lidard::survey({file.path()});
  if (!seen.sensors.empty()) static_cast<void>(lidard::parse_config(lidard::config_of(seen), "f"));
  return 0;
}
