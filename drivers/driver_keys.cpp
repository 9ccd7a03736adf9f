// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/driver_keys.h"

namespace lidard {
namespace {

using namespace keys;
using R = DeviceRequests;
using D = DriverConfig;

constexpr double farthest_m = 1000;

std::optional<Rejection> no_receiver(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (address && !address->v6) return std::nullopt;
  return Rejection{"is {}, which is not an IPv4 address",
                   "an IPv4 address of this host (or a multicast group) like 192.168.0.100"};
}

constexpr const char* hash_form = "the hash of the password, 8 hexadecimal digits like F4724744";

std::optional<Rejection> no_hash(const KeyValue& value) {
  const auto& text = std::get<std::string>(value);
  if (text.size() == 8 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos)
    return std::nullopt;
  return Rejection{"is not 8 hexadecimal digits", hash_form};
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

Keys<R> scip_keys() { return {whole("cluster", &R::cluster, 1, 99, "beams merged into one").or_else(1.0)}; }

Keys<R> scip_clock_keys() {
  return {flag("calibrate_time", &R::calibrate_time, "compares both clocks once before the stream starts")};
}

Keys<D> receiver_clock_keys() {
  return {flag("expect_pps", &D::expect_pps,
               "warns when the sensor's clock does not follow a receiver's PPS and NMEA")};
}

Keys<R> state_keys() {
  return {flag("publish_states", &R::device_states,
               "its states too, on NAME/lferec, lidinputstate, lidoutputstate, encoder, or system_state, "
               "output_paths, intrusion, beam_status")};
}

Keys<R> skip_keys() {
  return {whole("skip", &R::skip, 0, 999, "scans left out between two; of a Hokuyo 0 to 9")
              .unless_set("as a SICK scanner is set, 0 of a Hokuyo")};
}

Keys<D> revolution_keys() {
  return {
      angle("cut_angle", &D::cut_angle, -two_pi, two_pi, "where a frame ends, as the sensor counts azimuth"),
      number("min_range", &D::min_range, 0, farthest_m, "m", "nearer returns are left out"),
      number("max_range", &D::max_range, 0, farthest_m, "m", "farther returns are left out; 0: no limit"),
      angle("view_direction", &D::view_direction, -two_pi, two_pi,
            "middle of the sector that is kept, counter-clockwise from the front"),
      angle("view_width", &D::view_width, 0, two_pi, "width of that sector")};
}

}  // namespace lidard
