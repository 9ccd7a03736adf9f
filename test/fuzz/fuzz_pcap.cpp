// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any bytes as a capture file. Corpus: any captures; -max_len=65536.
#include <cstdlib>

#include "test/drivers/capture/pcap_testing.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const lidard::test::MemoryFile file(data, size);
  const lidard::test::Contents got = lidard::test::read_capture(file.path());
  if (!lidard::test::adds_up(got.counters)) std::abort();
  if (!got.opened && got.error.empty()) std::abort();
  return 0;
}
