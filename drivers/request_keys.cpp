// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/request_keys.h"

namespace lidard {
namespace {

using namespace keys;
using R = DeviceRequests;

std::optional<Misfit> no_receiver(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (address && !address->v6) return std::nullopt;
  return Misfit{"is {}, which is no IPv4 address",
                "an IPv4 address of this host (or a multicast group) like 192.168.0.100"};
}

constexpr const char* hash_form = "the hash of the password, 8 hexadecimal digits like F4724744";

std::optional<Misfit> no_hash(const KeyValue& value) {
  const auto& text = std::get<std::string>(value);
  if (text.size() == 8 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos)
    return std::nullopt;
  return Misfit{"is not 8 hexadecimal digits", hash_form};
}

}  // namespace

Keys<R> write_keys() {
  return {flag("allow_write", &R::allow_write,
               "settings of the device that differ from the configuration are written")};
}

Keys<R> receiver_keys() {
  return {flag("listen_only", &R::listen_only, "no connection to the device at all"),
          text("udp_receiver_ip", &R::host_address,
               "an IPv4 address of this host (or a multicast group) like 192.168.0.100",
               "where the device shall send its datagrams")
              .checked(no_receiver)};
}

Keys<R> login_keys() {
  auto level = whole("user_level", &R::user_level, 1, 9, "number of the level to log in at");
  level.preset = "of the model";
  level.set = [](R& requests, const KeyValue& value) {
    requests.user_level = number_text(std::get<double>(value));
  };
  return {level, text("user_level_password", &R::password_hash, hash_form, "hash of its password")
                     .by_default("of the model")
                     .checked(no_hash)};
}

}  // namespace lidard
