// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/health/sentence.h"

/// \file
/// What /diagnostics, `lidard status` and `lidard events` say: each sentence with its level, cause and
/// remedy. config/doc/sentences.md is made of this table: test/sentences.py --write.
namespace lidard::says {

constexpr Sentence ok(std::string_view words) { return {Health::ok, words, ""}; }
constexpr Sentence warn(std::string_view words, std::string_view remedy) {
  return {Health::warn, words, remedy};
}
constexpr Sentence error(std::string_view words, std::string_view remedy) {
  return {Health::error, words, remedy};
}
/// WARN, or ERROR where the code says so.
constexpr Sentence graded(std::string_view words, std::string_view remedy) { return warn(words, remedy); }
/// A cause that stands behind the colon of another sentence, whose level applies.
constexpr Sentence cause(std::string_view words, std::string_view remedy) { return warn(words, remedy); }
/// A piece of another sentence.
constexpr Sentence part(std::string_view words) { return ok(words); }

// # `sensor NAME`: data come
inline constexpr auto receiving = ok("receiving");
inline constexpr auto part_of_a_frame =
    ok("only about {frames:.1f} of a frame: {packets} packets in {time:.3f} s, a whole one usually takes "
       "{period} s");
inline constexpr auto no_whole_frame =
    ok("no whole frame: {packets} packets in {time:.3f} s, a whole one usually takes {period} s; {lost} "
       "lost, {cut} frames cut off by begin, end or loss");
inline constexpr auto no_usable_packet =
    error("no packet could be used, rejected {counts}", "is it a {product}?");
inline constexpr auto other_model = error("this is a {product}, not a {expected}", "set model: {model}");
inline constexpr auto two_senders = error("{first} and {second} both send to port {port}",
                                          "one entry takes one sensor: set ip_address: {first} here, and "
                                          "give each other sensor an entry of its own");
inline constexpr auto two_devices =
    error("two devices have the address {address} ({marks})", "give one of them another IP address");
inline constexpr auto serial_numbers = part("serial numbers {serials}");
inline constexpr auto hardware_addresses = part("hardware addresses {addresses}");
inline constexpr auto stamps_replaced = warn(
    "the stamps of {source} are {seconds:.2f} s {ahead_or_behind} this computer's clock, so they are placed "
    "by their arrival",
    "synchronise the clocks of both computers (chrony){or_offset}; of a bag or a simulator, set "
    "/use_sim_time");
inline constexpr auto ahead_of = part("ahead of");
inline constexpr auto behind = part("behind");
inline constexpr auto or_offset = part(" or set time_offset: {offset:.3f}");
inline constexpr auto filter_removes_all =
    warn("its filter removed every return of the last {frames} frames on {topic}",
         "correct the limits below `filter`");
inline constexpr auto no_intensities =
    warn("its filter has limits of intensity, but the device sends scans without intensities",
         "switch them on in the device, or take the limits out");
inline constexpr auto filter_counts = part("filter removed {removed} of {returns} returns{reasons}");

// # `sensor NAME`: fewer data come than expected
constexpr std::string_view check_network = "check the cable, the switch and the load of this computer";
constexpr std::string_view check_path =
    "look for a proxy, a mirror port or a loop between sensor and computer";
constexpr std::string_view check_sensor =
    "check the sensor's state and settings, and the load of this computer";
constexpr std::string_view check_model = "is it the configured model, and the only one that sends here?";
constexpr std::string_view check_window = "is its window covered? An empty field looks the same";
inline constexpr auto too_little = part("{figures} in the last {seconds:.0f} s; {remedy}");
inline constexpr auto too_little_in_all = part("{figures} in {seconds:.1f} s; {remedy}");
inline constexpr auto device_says = part("{sentence}. The device says: {warnings}");
inline constexpr auto no_frame = error("no frame for {seconds:.1f} s although packets come", check_sensor);
inline constexpr auto no_frame_of =
    error("0 of {expected:.1f} frames/s, no frame for {seconds:.1f} s although packets come", check_sensor);
inline constexpr auto frames_missing = graded("{rate:.1f} of {expected:.1f} frames/s", check_sensor);
inline constexpr auto frames_lost = graded("{rate:.1f} of {expected:.1f} frames/s", check_network);
inline constexpr auto packets_lost = graded("{share} of packets lost", check_network);
inline constexpr auto scans_lost = graded("{count} packets or scans lost", check_network);
inline constexpr auto packets_twice = warn("{share} of packets came twice", check_path);
inline constexpr auto packets_rejected = graded("{share} of packets rejected: {counts}", check_model);
inline constexpr auto no_returns = warn("{share} of the beams with a return", check_window);
inline constexpr auto beams_blind = warn("{share} of the beams blind (too near or invalid)", check_window);

// # `sensor NAME`: nothing comes
inline constexpr auto waiting_for_data = ok("waiting for data from {source}");
inline constexpr auto from_topic = part("topic {topic}");
inline constexpr auto from_any = part("any sender to port {port}");
inline constexpr auto from_address = part("{address} to port {port}");
inline constexpr auto only_telemetry =
    error("no data, only telemetry on port {telemetry}",
          "check that its laser and motor are on and that it sends data to port {port}");
inline constexpr auto silent = graded("silent: {cause}", "");
inline constexpr auto nothing_because = error("nothing received from {source}: {cause}", "");
inline constexpr auto nothing_from_driver = error("nothing received from {source}", "is its driver running?");
inline constexpr auto nothing_but_others =
    error("nothing received from {source}, but there are packets from {sender}", "correct ip_address?");
inline constexpr auto nothing_measured = error("nothing received from {source}", "does the device measure?");
inline constexpr auto nothing_received =
    error("nothing received from {source}",
          "check the sensor's power, its destination address and port, and the firewall");

// # Causes on this host why nothing comes
inline constexpr auto no_address =
    cause("no interface of this host has an address in the network of {sensor} (there is {addresses})",
          "add one: `ip address add {free} dev {interface}`");
inline constexpr auto no_address_nor_router =
    cause("no interface of this host has an address in the network of {sensor} (there is {addresses})",
          "unless a router leads there, add one: `ip address add {free} dev {interface}`");
inline constexpr auto none = part("none");
inline constexpr auto interface_off =
    cause("{interface} is switched off", "switch it on: `ip link set {name} up`");
inline constexpr auto no_link =
    cause("{interface} has no link", "check the cable, the switch and the sensor's power");
inline constexpr auto path_filter = cause(
    "the reverse path filter of this host drops {rate:.0f} packets/s: they come in at an interface that does "
    "not lead back to their sender",
    "give that interface an address in the sensor's network, or run `sysctl -w net.ipv4.conf.all.rp_filter=0 "
    "net.ipv4.conf.INTERFACE.rp_filter=0`");
inline constexpr auto another_port = cause(
    "{rate:.0f} datagrams/s come to ports of this host where nobody listens",
    "does the sensor send to another port than {port}? `tcpdump -ni any udp and src host {sensor}` shows it");
inline constexpr auto another_address =
    cause("{rate:.0f} packets/s come in for an address that this host does not have",
          "does the sensor send elsewhere? `tcpdump -ni any udp and src host {sensor}` shows where to; set "
          "its destination to an address of this host");
inline constexpr auto interface_silent = cause("next to nothing comes in at {interface}",
                                               "check the sensor's power, cable and destination address");
inline constexpr auto only_others =
    cause("{rate:.0f} packets/s come in at {interface}, but none from {sensor} to port {port}",
          "does it send elsewhere, or does a firewall drop them? Compare `tcpdump -ni {name} src host "
          "{sensor}` with `nft list ruleset`");
inline constexpr auto besides = part("{fault}. Besides, {other}");

// # `unknown senders`
inline constexpr auto unknown_sender = warn("{sender} sends to a port of ours but belongs to no sensor",
                                            "add it to the configuration, or correct an ip_address");
inline constexpr auto unknown_senders =
    warn("{sender} and others send to a port of ours but belong to no sensor",
         "add them to the configuration, or correct an ip_address");

// # `port NUMBER`, `link NAME`
inline constexpr auto listening = ok("listening");
inline constexpr auto lost_in_kernel = warn(
    "packets were lost in the kernel's receive buffer in the last 10 s: this computer was too busy to fetch "
    "them",
    "see `top`, and raise net.core.rmem_max");
inline constexpr auto buffer_small = warn(
    "the receive buffer of port {port} has {got} bytes instead of {asked}, so packets are lost when the "
    "machine is busy for more than {time:.0f} ms",
    "run `sysctl -w net.core.rmem_max={asked}`");
inline constexpr auto port_in_use = error("port {port} is in use by another program",
                                          "find it with `ss -lunp 'sport = :{port}'`{held_by_program}");
inline constexpr auto held_by_program = part(" (it is {program}, process {process})");
inline constexpr auto held_by_user = part(" (it is a program of user {user})");
inline constexpr auto port_forbidden =
    error("this user may not open port {port}",
          "ports below 1024 need the capability cap_net_bind_service, or choose another port");
inline constexpr auto port_not_readable =
    error("cannot receive at UDP port {port}: {reason}", "it is tried again");
inline constexpr auto group_without_interface =
    warn("cannot join the multicast group {group}: there is no interface {interface}",
         "compare with `ip link`, it is joined as soon as there is one");
inline constexpr auto group_without_address =
    warn("cannot join the multicast group {group}: no interface has the address {address}",
         "compare with `ip -4 address`, it is joined as soon as one has");
inline constexpr auto group_without_route =
    warn("cannot join the multicast group {group}: no interface leads to it",
         "name the sensor's interface, or add a route for 224.0.0.0/4");
inline constexpr auto group_not_joined =
    graded("cannot join the multicast group {group}: {reason}", "it is tried again");
inline constexpr auto no_socket =
    graded("no socket for {peer}: too many files are open",
           "raise the limit (LimitNOFILE= of the unit, `ulimit -n`), it is tried again");
inline constexpr auto connecting = ok("connecting");
inline constexpr auto connected = ok("connected");
inline constexpr auto stopped = ok("stopped");
inline constexpr auto not_needed = ok("not needed now");
inline constexpr auto connection_refused =
    graded("{device} refuses the connection",
           "is this the device's port, and does another program use the device already? it is tried again");
inline constexpr auto no_answer =
    graded("{device} does not answer", "check the device's power, cable and address, it is tried again");
inline constexpr auto no_way = graded("{device} cannot be reached ({reason})",
                                      "check cable and this host's network address, it is tried again");
inline constexpr auto not_connected = graded("no connection to {device}: {reason}", "it is tried again");
constexpr std::string_view device_restarted =
    "did it restart, or does another program use the device? the connection is opened again";
inline constexpr auto connection_closed = graded("{device} closed the connection", device_restarted);
inline constexpr auto connection_reset = graded("{device} reset the connection", device_restarted);
inline constexpr auto no_answer_any_more =
    graded("{device} does not answer any more", "check its power and cable, it is tried again");
inline constexpr auto connection_broke =
    graded("the connection to {device} broke: {reason}", "it is opened again");
inline constexpr auto connection_silent =
    graded("{device} sent nothing for {time:.1f} s",
           "is it still starting, or has it lost power or cable? the connection is opened again");
inline constexpr auto dialogue_failed = graded(
    "the dialogue with {device} could not go on; it is begun again", "the sensor's diagnostics say more");

// # `merged NAME`, `merged cloud NAME`, `virtual NAME`
inline constexpr auto publishing = ok("publishing");
inline constexpr auto not_built =
    ok("not built: nobody subscribes to {topic}, and no virtual scan is made of it");
inline constexpr auto waiting_for_input = ok("waiting for input");
inline constexpr auto no_input = error("no output: no input has come in yet", "see the state of its sensors");
inline constexpr auto no_output = error("no output: {cause}", "");
inline constexpr auto no_output_any_more = error("no output any more: {cause}", "");
inline constexpr auto output_stopped =
    error("no output for more than {limit:.0f} s", "see the state of its sensors");
inline constexpr auto no_source =
    error("no output, since no source delivers", "see the state of its sensors");
inline constexpr auto no_source_because =
    error("no output, since no source delivers: {cause}", "see the state of its sensors");
inline constexpr auto sources_lost = error("publishing without {sources}", "see the state of its sensors");
inline constexpr auto sources_late = warn("publishing without {sources}, whose sweeps are too old",
                                          "a deadline of {deadline:.2f} waits for them");
inline constexpr auto sources_old =
    warn("publishing without {sources}, whose sweeps are too old", "see the state of its sensors");
inline constexpr auto published_without = graded("publishing without {names}: {cause}", "");
inline constexpr auto clocks_apart =
    warn("merges scans whose stamps are {apart:.0f} s apart",
         "let all sources follow one clock, a simulator's (/use_sim_time) or this computer's");
inline constexpr auto points_alone = warn("points alone, nothing is known to be free: of the cloud {cause}",
                                          "give it the whole cloud of a multi-plane lidar");
inline constexpr auto source_state = part("{state}, {rate:.1f} Hz, age {age:.0f} ms");

// # `merged NAME`: mounts
inline constexpr auto nothing_in_common =
    warn("{one} sees nothing of what {other} sees where their fields of view overlap",
         "check the pose of {which} (since {since:%H:%M:%S} UTC; `lidard calibrate -c FILE CAPTURE` of the "
         "parked vehicle finds it)");
inline constexpr auto both = part("both");
inline constexpr auto mount_wrong =
    warn("{first} and {second} do not agree on where surfaces are",
         "correct {which} by {correction} (since {since:%H:%M:%S} UTC; `lidard calibrate -c FILE CAPTURE` of "
         "the parked vehicle finds it)");
inline constexpr auto the_mount = part("the mount of {source}");
inline constexpr auto a_mount = part("a mount, e.g. that of {source}");
inline constexpr auto mount_check =
    part("{surfaces} surfaces; mount of {source}: {correction}; +- {mm:.1f} mm, {degrees:.3f} deg");
inline constexpr auto correction = part("{axis} {value:+.3f} {unit}");
inline constexpr auto undetermined = part("{axis} not determined by the surroundings");

// # `motion`, and what lacks poses of the vehicle
inline constexpr auto poses_come = ok("poses come in");
inline constexpr auto no_pose_yet =
    warn("no pose of the vehicle yet, so scans are not deskewed", "see that odometry is published");
inline constexpr auto no_pose_any_more =
    warn("no pose of the vehicle any more", "see that odometry is published");
inline constexpr auto poses_late =
    warn("the newest pose of the vehicle is {lag:.1f} s older than the newest scan, which is not deskewed",
         "does odometry still come, and are its stamps of the same clock?");
inline constexpr auto poses_early =
    warn("the oldest pose of the vehicle is {lag:.1f} s newer than the newest scan, which is not deskewed",
         "are the stamps of both of the same clock?");
inline constexpr auto pose_refused = part("{fault}: {cause}");
inline constexpr auto no_speed = cause("no speed comes on {topic}", "see that it is published");
inline constexpr auto as_if_it_stood =
    warn("published as if the vehicle stood still: its poses at the time of measuring are missing",
         "see that odometry is published");
inline constexpr auto dropped_for_poses =
    warn("on_missing_motion: drop, and poses of the vehicle are missing", "see that odometry is published");
inline constexpr auto not_in_frame = warn("not published in {frame}: {cause}", "");
inline constexpr auto clouds_left_out = part("{count} cloud{s} not published");
inline constexpr auto clouds_not_deskewed = part("{count} cloud{s} not deskewed");
inline constexpr auto track_empty = part("no poses yet");
inline constexpr auto track_too_short = part("not deskewed: poses of the sweeps' time are missing");
inline constexpr auto track_extrapolated = part("deskewed, partly beyond the newest pose");
inline constexpr auto track_complete = part("deskewed");
inline constexpr auto tf_unnamed = cause("a frame name is empty", "set frame_id and base_frame");
inline constexpr auto tf_unknown =
    cause("tf does not know {child} in {parent}", "publish it on tf or configure the pose");
inline constexpr auto tf_reason = cause("{reason}", "publish it on tf or configure the pose");
inline constexpr auto tf_absent =
    cause("no tf: there was no ROS master yet", "publish it on tf or configure the pose");

// # `topic NAME`, `NAME input`, `reconfigure NAME`
inline constexpr auto slow_subscriber = warn("a subscriber of {topic} is too slow and loses messages",
                                             "`rosnode info` names the subscribers, `rostopic bw` the load");
inline constexpr auto waiting_for_message = ok("waiting for the first message");
inline constexpr auto nobody_publishes = warn("nobody publishes {topic}", "start its driver");
inline constexpr auto wrong_type = error("topic {topic} carries {type}", "expected {types}");
inline constexpr auto unusable_messages =
    warn("unusable messages: {reason}", "correct what publishes {topic}");
inline constexpr auto values_in_force = ok("values in force");
inline constexpr auto change_refused = warn("change refused, the values before stay: {reason}", "");

// # `ROS`
inline constexpr auto master_asked = ok("asking the master");
inline constexpr auto master_silent = warn("the master does not answer", "check roscore");
inline constexpr auto shut_down = warn("shut down from outside", "look for a node of the same name");
inline constexpr auto too_many_files = error("ROS cannot start: too many files are open",
                                             "raise the limit (LimitNOFILE= of the unit, `ulimit -n`)");
inline constexpr auto no_thread = error("ROS cannot start without a free thread",
                                        "raise the limit of threads (TasksMax= of the unit, `ulimit -u`)");
inline constexpr auto publisher_hangs = error("the thread that publishes has stood still for {seconds:.1f} s",
                                              "see `top`; systemd starts lidard again if that lasts");
inline constexpr auto master_call_hangs =
    error("the thread that talks to the ROS master has stood still for {seconds:.1f} s", "check roscore");
inline constexpr auto no_report =
    error("no report from the sensor thread for {age:.1f} s",
          "`journalctl -u lidard` names the thread that hangs; before that: {before}");

// # `configuration`, `black box`, `clock`, `computer`, `virtual scans to merge`, and in the log
inline constexpr auto as_in_file = ok("as in {file}");
inline constexpr auto file_refused = error("{cause}", "the last good configuration is in force");
inline constexpr auto not_kept =
    warn("the configuration cannot be kept for a start with a wrong file: {reason}",
         "make room there, or correct its rights");
inline constexpr auto keeps_packets = ok("keeps the newest packets");
inline constexpr auto box_not_written =
    warn("the black box cannot be written: {reason}", "make room there, or correct its rights");
inline constexpr auto box_used_up =
    warn("errors started {captures} captures within a day, so no further one is written",
         "mend what fails again and again, or raise blackbox.per_day; `lidard dump` writes one");
inline constexpr auto box_written = ok("the last {seconds:.1f} s are in {file}");
inline constexpr auto box_written_with_gaps =
    ok("the last {seconds:.1f} s are in {file}; {count} errors before that are in no capture, since one a "
       "minute is written; set blackbox.seconds to 60 for captures without gaps");
inline constexpr auto clock_even = ok("the host's clock runs evenly");
inline constexpr auto clock_set = warn("the host's clock was set by {step:+.3f} s",
                                       "keep it with chrony or ntpd, which turn its rate instead");
inline constexpr auto read_in_time = ok("reads what comes in time");
inline constexpr auto too_busy =
    warn("this computer is too busy: {seconds:.1f} s passed before what came was read, so outputs were late",
         "see `top`");
inline constexpr auto all_handed_over = ok("all are handed over");
inline constexpr auto scans_dropped =
    warn("scans were dropped, since this computer is too busy to merge them", "see `top`");
inline constexpr auto no_interface_news =
    warn("the kernel does not report changes of interfaces ({reason}), so they are checked once per second",
         "allow AF_NETLINK in the service's unit");
inline constexpr auto recurs = part("{sentence} (keeps changing; `lidard events` counts what follows)");

}  // namespace lidard::says
