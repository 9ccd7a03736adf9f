// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/cola2_frame.h"

#include <gtest/gtest.h>

#include <string>

namespace lidard::sick {
namespace {

using Bytes = std::vector<std::uint8_t>;

ByteView view(const Bytes& bytes) { return {bytes.data(), bytes.size()}; }

TEST(Cola2Frame, OpensASessionWithTheBytesOfTheManual) {
  // SICK 8022708 p. 30: time-out 30 s, client 1.
  const Bytes data = {30, 0, 0, 0, 1};
  Cola2Telegram open;
  open.request = 1;
  open.type = 'O';
  open.mode = 'X';
  open.data = view(data);
  const Bytes expected = {2, 2, 2, 2, 0, 0, 0, 15, 0, 0, 0, 0, 0, 0, 0, 1, 'O', 'X', 30, 0, 0, 0, 1};
  EXPECT_EQ(encode_cola2(open), expected);
}

/// Three telegrams with different data, as one stream.
Bytes three_telegrams() {
  Bytes all;
  for (std::uint16_t i = 1; i <= 3; ++i) {
    const std::string words(i * 5U, static_cast<char>(i));  // holds runs of 02, too
    Cola2Telegram telegram;
    telegram.session = 0xabcd;
    telegram.request = i;
    telegram.type = 'R';
    telegram.mode = 'A';
    telegram.data = ByteView(words);
    const Bytes bytes = encode_cola2(telegram);
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  return all;
}

TEST(Cola2Frame, FindsTheSameTelegramsHoweverTheStreamIsCut) {
  const Bytes all = three_telegrams();
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    Cola2Stream stream;
    std::vector<std::uint16_t> requests;
    std::size_t data = 0;
    Cola2Telegram telegram;
    for (const ByteView part : {view(all).sub(0, cut), view(all).from(cut)}) {
      stream.add(part);
      while (stream.next(telegram)) {
        requests.push_back(telegram.request);
        data += telegram.data.size();
        EXPECT_TRUE(telegram.is('R', 'A'));
        EXPECT_EQ(telegram.session, 0xabcdU);
      }
    }
    EXPECT_EQ(requests, (std::vector<std::uint16_t>{1, 2, 3})) << cut;
    EXPECT_EQ(data, 30U);
  }
}

TEST(Cola2Frame, FindsItsStepAgain) {
  Bytes all = {'x', 2, 2, 2, 'y', 2, 2, 2, 2, 0xff, 0xff, 0xff, 0xff};  // the last has an impossible length
  const Bytes good = three_telegrams();
  all.insert(all.end(), good.begin(), good.end());
  Cola2Stream stream;
  Cola2Telegram telegram;
  std::size_t found = 0;
  for (const std::uint8_t& byte : all) {
    stream.add(ByteView(&byte, 1));
    while (stream.next(telegram)) ++found;
  }
  EXPECT_EQ(found, 3U);
}

TEST(Cola2Frame, ForgetsHalfATelegramOfALostConnection) {
  const Bytes all = three_telegrams();
  Cola2Stream stream;
  Cola2Telegram telegram;
  stream.add(view(all).sub(0, 20));
  EXPECT_FALSE(stream.next(telegram));
  stream.clear();
  stream.add(view(all));
  EXPECT_TRUE(stream.next(telegram));
  EXPECT_EQ(telegram.request, 1U);
}

}  // namespace
}  // namespace lidard::sick
