#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Datagrams over a veth cable from an own sender with exact losses: 50,000 packets/s from a wrong address change no frame and cost no
packet; every lost packet is counted within 1 s, on the way or in the kernel; four VLP-16 with two returns lose nothing while the
daemon stands still for 500 ms."""
import contextlib
import pathlib
import random
import signal
import threading
import time

from harness import Starved, ask, expect, figure, item, scene_of, wait_for, write
from harness import daemon as started_daemon
from network import Burst, Network, recorded, send_paced
from ros_tools import Listener, ros_test
from sensor_msgs.msg import PointCloud2

HOST = "192.168.1.100"
LIDARS = [f"192.168.1.{n}" for n in (201, 202, 203, 204)]
STRANGER = "192.168.1.66"
# What four VLP-16 with two returns send, and the bytes that the daemon asks for: 600 ms fit in.
RATE, STALL = 6032, 0.5
BUFFER = int(RATE * 0.6 * 1152)


def packets_of_a_lidar(tmp, seconds, mode="strongest"):
    keys = f"model: velodyne_vlp16, from: '192.168.1.201:2368', to: '192.168.1.100:2368', options: {{return_mode: {mode}}}"
    return recorded(tmp, scene_of({"roof": keys}, seconds=seconds))


@contextlib.contextmanager
def daemon(tmp, sensors):
    config = write(tmp / "c.yaml", "sensors:\n" + "".join(
        f"  {name}: {{model: velodyne_vlp16, ip_address: {address}}}\n" for name, address in sensors.items()))
    with started_daemon(config) as child:
        wait_for(lambda: ask("status"), 20, "the daemon answers")
        yield child


def value(name, key):
    return int(figure("sensor " + name, key))


def counted(name):
    return value(name, "Packets"), value(name, "Lost packets"), int(figure("port 2368", "Kernel drops"))


class Flood(threading.Thread):
    """Somebody who sends a lidar's own packets from another address."""

    def __init__(self, network, payloads, rate):
        super().__init__(daemon=True)
        self.socket, self.bursts = network.lidar(STRANGER), [Burst(payloads[i:i + 50], (HOST, 2368)) for i in range(0, 500, 50)]
        self.rate, self.sent, self.begin, self.ended = rate, 0, time.monotonic(), threading.Event()
        self.start()

    def run(self):
        while not self.ended.is_set():
            while self.sent < (time.monotonic() - self.begin) * self.rate and not self.ended.is_set():
                self.sent += self.bursts[self.sent // 50 % len(self.bursts)].send(self.socket)
            time.sleep(0.001)

    def reached(self):
        return self.sent / (time.monotonic() - self.begin)

    def end(self):
        self.ended.set()
        self.join()


def run_of_frames(tmp, datagrams, senders, during=contextlib.nullcontext):
    """The clouds of all of these datagrams, live; what was counted, and how long we were starved."""
    clouds = Listener("/roof/points", PointCloud2, buff_size=1 << 24)
    with daemon(tmp, {"roof": LIDARS[0]}):
        wait_for(lambda: clouds.subscriber.get_num_connections() > 0, 20, "the subscriber is connected")
        with during():
            starved = Starved()
            _, sent = send_paced(datagrams, senders, HOST)
            wait_for(lambda: value("roof", "Packets") == sent, 5, f"all {sent} packets are received: {counted('roof')}")
            waited = starved.seconds()
        time.sleep(0.5)  # what must not come may come
        result = counted("roof")
    clouds.close()
    return [bytes(cloud.data) for cloud in clouds.messages], result, sent, waited


def strangers_change_nothing(network, tmp):
    datagrams = packets_of_a_lidar(tmp, 5)
    senders = {LIDARS[0]: network.lidar(LIDARS[0])}
    quiet, result, sent, waited = run_of_frames(tmp, datagrams, senders)
    expect(result == (sent, 0, 0), f"alone: packets, lost, dropped {result} of {sent}")
    floods = []

    @contextlib.contextmanager
    def flooded():
        flood = Flood(network, [payload for _, _, _, payload in datagrams], 50_000)
        yield floods.append(flood)
        print(f"P4: {flood.sent} packets of a stranger, {flood.reached():.0f} per second")
        flood.end()

    clouds, result, sent, waited = run_of_frames(tmp, datagrams, senders, flooded)
    print(f"P4: {len(clouds)} clouds, {len(quiet)} without the stranger; packets, lost, dropped {result} of {sent}; starved {waited:.3f} s")
    # The kernel counts what found the buffer full and what the filter refused in one number, which is reported as the former while
    # the buffer is half full: no packet is missing all the same.
    expect(result[:2] == (sent, 0) and (result[2] == 0 or waited > 0.1), f"P4: packets, lost, dropped {result} of {sent}, starved {waited:.3f} s")
    expect(len(quiet) >= 40 and (len(clouds) == len(quiet) or waited > 0.1), f"P4: {len(clouds)} clouds of {len(quiet)}, starved {waited:.3f} s")
    rest = iter(quiet)
    expect(all(cloud in rest for cloud in clouds), "P4: a cloud is not that of the undisturbed run")
    expect(floods[0].reached() > 5000, f"the sender reaches {floods[0].reached():.0f} packets/s only")


def disturb(rng, lost):
    """Loses single packets and bursts, sends some twice and exchanges neighbours; counts what is lost."""
    state = {"burst": 0, "since": 0}

    def change(due):
        out = []
        for one in due:
            state["since"] += 1
            if state["burst"] == 0 and state["since"] > 100 and rng.random() < 0.01:
                state["burst"], state["since"] = rng.choice((1, 1, 2, 20, 75)), 0
            if state["burst"] > 0:
                state["burst"] -= 1
                lost.append(one)
                continue
            out.append(one)
            if rng.random() < 0.01:
                out.append(one)
        return out

    return change


def every_loss_is_counted(network, tmp):
    datagrams = packets_of_a_lidar(tmp, 8)
    senders = {LIDARS[0]: network.lidar(LIDARS[0])}
    # The last ones come, so that all losses lie between others.
    half, lost = len(datagrams) // 2, []
    with daemon(tmp, {"roof": LIDARS[0]}) as child:
        change = disturb(random.Random(4), lost)
        first = [d for d in datagrams if d[0] <= datagrams[half][0]]
        _, sent = send_paced(first[:half - 200], senders, HOST, change)
        later = [(t - datagrams[half - 200][0], *rest) for t, *rest in datagrams[half - 200:half]]
        sent += send_paced(later, senders, HOST)[1]
        # On a busy machine the kernel's buffer loses some, too.
        wait_for(lambda: (lambda p, _, k: p + k == sent)(*counted("roof")), 5, f"{sent} packets: {counted('roof')}")
        starved, begin = Starved(), time.monotonic()
        wait_for(lambda: (lambda _, l, k: l == len(lost) + k)(*counted("roof")), 5, f"{len(lost)} lost packets are counted: {counted('roof')}")
        print(f"P5: {len(lost)} packets lost on the way, all counted; {sent} sent, {item('sensor roof')['values']['Rejected']}")
        # The buffer holds half a second of them.
        child.send_signal(signal.SIGSTOP)
        rest = [(t - datagrams[half][0], *more) for t, *more in datagrams[half:]]
        stopped = [d for d in rest if d[0] < 2.5]
        sent += send_paced(stopped, senders, HOST)[1]
        child.send_signal(signal.SIGCONT)
        sent += send_paced([(t - 2.5, *more) for t, *more in rest if t >= 2.5], senders, HOST)[1]
        starved, begin = Starved(), time.monotonic()
        exact = lambda: (lambda p, l, k: k > 100 and p + k == sent and l == len(lost) + k)(*counted("roof"))
        wait_for(exact, 5, f"all of {sent} packets are accounted for, {len(lost)} lost on the way: {counted('roof')}")
        took, waited = time.monotonic() - begin, starved.seconds()
        print(f"P5: {counted('roof')[2]} dropped by the kernel, all counted {took:.2f} s after the last packet")
        expect(took <= 1 + waited, f"P5: after {took:.2f} s, starved {waited:.3f} s")


def nothing_is_lost_in_a_stall(network, tmp):
    limit = int(pathlib.Path("/proc/sys/net/core/rmem_max").read_text()) if pathlib.Path("/proc/sys/net/core/rmem_max").exists() else BUFFER
    if limit < BUFFER:
        return print(f"P7 skipped: net.core.rmem_max is {limit}; the package sets 8388608 (config/60-lidard.conf)")
    payloads = [payload for _, _, _, payload in packets_of_a_lidar(tmp, 3, "dual")]
    slot = 0.005
    limits = [min(len(payloads), round(n * RATE / 4 * slot)) for n in range(int(len(payloads) / (RATE / 4 * slot)) + 2)]
    bursts = [Burst(payloads[a:b], (HOST, 2368)) for a, b in zip(limits, limits[1:]) if b > a]
    senders = [network.lidar(address) for address in LIDARS]
    names = ("a", "b", "c", "d")
    for attempt in range(3):
        with daemon(tmp, dict(zip(names, LIDARS))) as child:
            time.sleep(0.5)  # the daemon has begun
            starved, begin, stopped, stalled = Starved(), time.monotonic(), None, 0
            for n, burst in enumerate(bursts):
                for sender in senders:
                    burst.send(sender)
                if stopped is None and n * slot > 1:
                    child.send_signal(signal.SIGSTOP)
                    stopped = time.monotonic()
                elif stopped and not stalled and time.monotonic() - stopped >= STALL:
                    child.send_signal(signal.SIGCONT)
                    stalled = time.monotonic() - stopped
                time.sleep(max(0, begin + (n + 1) * slot - time.monotonic()))
            rate = 4 * len(payloads) / (time.monotonic() - begin)
            time.sleep(1)  # counters follow
            got = [counted(name) for name in names]
            waited = starved.seconds()
        print(f"P7: {4 * len(payloads)} packets at {rate:.0f}/s, stopped for {stalled:.3f} s, starved {waited:.3f} s: packets, lost, dropped {got}")
        if all(one == (len(payloads), 0, 0) for one in got):
            expect(stalled >= STALL, "it was stopped")
            return None
        # A processor that was busy otherwise makes the stall longer than the buffer is made for.
        expect(waited > 0.05 or stalled > STALL + 0.02, "P7: packets are lost though the machine had time")
    return print("P7 not shown: the machine was starved in three attempts")


def main():
    network = Network()
    network.plug(host=HOST + "/24", lidars=[a + "/24" for a in (*LIDARS, STRANGER)])
    with ros_test() as (tmp, _):
        every_loss_is_counted(network, tmp)
        nothing_is_lost_in_a_stall(network, tmp)
        strangers_change_nothing(network, tmp)
    print("ok")


if __name__ == "__main__":
    main()
