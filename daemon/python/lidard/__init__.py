# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Captures of SICK, Hokuyo and Velodyne lidars as numpy arrays, without ROS.

    import lidard

    for frame in lidard.open("drive.pcap"):              # clouds and scans of all sensors in it
        print(frame.sensor, frame.stamp, frame)
    for stamp, points in lidard.open("vlp16.pcap"):      # a cloud: structured array, x y z in m
        print(stamp, points["x"].max())
    for frame in lidard.replay("vehicle.yaml", "drive.pcap", topics=["scan"]):
        print(frame.stamp, frame.ranges.min())           # merged and virtual scans of a configuration

`inspect`, `models` and `check` answer what `lidard inspect`, `models` and `check` print; `Driver` decodes live bytes.
Errors are FileNotFoundError, or ValueError with the sentence that the command line has. What is wrong with a capture
(cut, damaged) is a warning of the module `warnings`; log lines go to the logger `lidard` of the module `logging`.
Threads that share a reader wait for each other; other threads go on while one decodes.
"""
import contextlib as _contextlib
import dataclasses as _dataclasses
import json as _json
import os as _os
import pathlib as _pathlib
import time as _time
from typing import Any, Dict, Iterable, Iterator, List, Optional, Tuple, Union

import numpy as _np

from . import _lidard
from ._lidard import __version__

__all__ = ["Cloud", "Driver", "Frame", "HIT", "INVALID", "NEAR", "NONE", "Reader", "Scan", "check", "inspect", "models", "open", "replay"]

Path = Union[str, "_os.PathLike[str]"]
Captures = Union[Path, Iterable[Path]]

HIT, NONE, NEAR, INVALID = range(4)  # of Scan.statuses

_point = {"names": ["x", "y", "z", "intensity", "ring", "time"], "formats": ["<f4", "<f4", "<f4", "<f4", "<u2", "<f4"],
          "offsets": [0, 4, 8, 12, 16, 18], "itemsize": 22}
_POINT = _np.dtype(_point)
_MERGED_POINT = _np.dtype({"names": _point["names"] + ["sensor"], "formats": _point["formats"] + ["<u2"],
                           "offsets": _point["offsets"] + [22], "itemsize": 24})
_COLUMN = _np.dtype({"names": ["first_point", "packet", "block", "echo", "azimuth", "stamp_ns"],
                     "formats": ["<u4", "<u4", "u1", "u1", "<f4", "<i8"], "offsets": [0, 4, 8, 9, 12, 16], "itemsize": 24})


@_dataclasses.dataclass(eq=False, repr=False)
class Frame:
    """What clouds and scans have in common."""

    sensor: str  #: its name; "" in a replay for what is made of several
    topic: str  #: in a replay, as in ROS; else ""
    frame_id: str
    stamp_ns: int  #: nanoseconds since 1970, of the first firing or beam, by the smoothed clock of the device

    @property
    def stamp(self) -> float:
        """`stamp_ns` in seconds."""
        return self.stamp_ns * 1e-9

    def __repr__(self) -> str:
        size = f"{self.points.size} points" if isinstance(self, Cloud) else f"{self.ranges.size} beams"
        return f"<lidard.{type(self).__name__} {self.topic or self.sensor} at {self.stamp:.6f} s, {size}>"


@_dataclasses.dataclass(eq=False, repr=False)
class Cloud(Frame):
    """A revolution of a multi-plane lidar, or a merged cloud. Unpacks as `stamp, points`.

    points: structured array with the fields x y z (m, sensor's frame, x ahead, y left), intensity, ring (0 is the
        lowest) and time (s after `stamp`; a merged cloud also has `sensor`, its index among the sources). Shape (n,), or
        (rows, columns) where a configuration organises clouds. It is the decoder's own memory, which the array keeps.
        `stamp + time` follows the clock of the device; the column stamp_ns of `lidard decode --format csv` is by the
        arrival of each packet and differs by its jitter, up to 15 ms. columns["stamp_ns"] of open(clock="arrival") has it.
    columns: structured array, one element per firing: first_point (index of its first return), packet, block, echo
        (number of the return that it has), azimuth (rad, as the sensor counts it), stamp_ns. Empty if not known.
    complete: False if the begin or end of the capture cut the revolution.
    """

    points: _np.ndarray
    columns: _np.ndarray
    complete: bool

    def __iter__(self) -> Iterator[Any]:
        return iter((self.stamp, self.points))

    @property
    def xyz(self) -> _np.ndarray:
        """The coordinates as a (n, 3) array of float32, m; a view of `points`."""
        flat = self.points.reshape(-1)
        return _np.ndarray((flat.size, 3), _np.float32, flat.view(_np.uint8).data, strides=(flat.itemsize, 4))

    @property
    def column(self) -> _np.ndarray:
        """The index in `columns` of each point, shape (n,)."""
        ends = _np.append(self.columns["first_point"][1:], self.points.size) if self.columns.size else []
        return _np.repeat(_np.arange(self.columns.size, dtype=_np.uint32), _np.diff(ends, prepend=0))

    @property
    def echo(self) -> _np.ndarray:
        """The number of the return of each point: 0, or in dual return mode 0 and 1; shape (n,)."""
        return self.columns["echo"][self.column]


@_dataclasses.dataclass(eq=False, repr=False)
class Scan(Frame):
    """A sweep of a planar scanner, or a merged or virtual scan. Unpacks as `stamp, ranges`.

    echo_ranges: m, shape (echoes, beams). Without a return the value says why, as REP 117 has it: inf (observed,
        nothing there), -inf (too near), nan (not observed), unless the configuration sets other values.
    echo_intensities: likewise in units of the device; None if it has none.
    echo_statuses: likewise as lidard.HIT, NONE, NEAR or INVALID.
    angle_min, angle_increment: rad, counter-clockwise from x. time_increment, scan_time: s. range_min, range_max: m.
    wave: (amplitude, phase) in rad, by which the beams of an uneven mirror deviate; `angles` has it.
    """

    echo_ranges: _np.ndarray
    echo_intensities: Optional[_np.ndarray]
    echo_statuses: _np.ndarray
    angle_min: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    wave: Tuple[float, float]

    def __iter__(self) -> Iterator[Any]:
        return iter((self.stamp, self.ranges))

    @property
    def echoes(self) -> int:
        """Returns of a beam at most."""
        return len(self.echo_ranges)

    @property
    def ranges(self) -> _np.ndarray:
        """m, of the first echo, shape (beams,)."""
        return self.echo_ranges[0]

    @property
    def intensities(self) -> Optional[_np.ndarray]:
        """Of the first echo, shape (beams,); None if the device sends none."""
        return None if self.echo_intensities is None else self.echo_intensities[0]

    @property
    def statuses(self) -> _np.ndarray:
        """Of the first echo, shape (beams,): HIT, NONE, NEAR or INVALID."""
        return self.echo_statuses[0]

    @property
    def angles(self) -> _np.ndarray:
        """rad, where each beam points, shape (beams,)."""
        even = self.angle_min + self.angle_increment * _np.arange(self.echo_ranges.shape[1])
        return even + self.wave[0] * _np.sin(even + self.wave[1])

    @property
    def xy(self) -> _np.ndarray:
        """The returns of all echoes as points, m, shape (n, 2)."""
        echo, beam = _np.nonzero(self.echo_statuses == HIT)
        angle, distance = self.angles[beam], self.echo_ranges[echo, beam]
        return _np.column_stack((distance * _np.cos(angle), distance * _np.sin(angle)))


def _frame(raw: tuple) -> Frame:
    kind, sensor, topic, frame_id, stamp_ns, *rest = raw
    if kind == "scan":
        return Scan(sensor, topic, frame_id, stamp_ns, *rest)
    complete, has_sensors, height, points, columns = rest
    points = points.view(_MERGED_POINT if has_sensors else _POINT)
    return Cloud(sensor, topic, frame_id, stamp_ns, points.reshape(height, -1) if height else points, columns.view(_COLUMN), complete)


def _paths(captures: Captures) -> List[str]:
    paths = [captures] if isinstance(captures, (str, _os.PathLike)) else list(captures)
    if not paths:
        raise ValueError("no capture is given")
    return [_os.fspath(path) for path in paths]


@_contextlib.contextmanager
def _of_files(*paths: str):
    """What fails since one of the files is not there is a FileNotFoundError."""
    try:
        yield
    except ValueError as error:
        if any(path not in ("", "-") and not _os.path.exists(path) for path in paths):
            raise FileNotFoundError(str(error)) from None
        raise


class Reader:
    """An iterator over frames, of open() and replay(). `with` closes it; so does its end."""

    def __init__(self, source: Any) -> None:
        self._source = source

    def __iter__(self) -> "Reader":
        return self

    def __next__(self) -> Frame:
        raw = self._source.next()
        if raw is None:
            raise StopIteration
        return _frame(raw)

    def __enter__(self) -> "Reader":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Ends the iteration and closes the captures. Frames that were given stay."""
        self._source.close()

    @property
    def sensors(self) -> Dict[str, Dict[str, Any]]:
        """By name: model, sender, serial, packets, lost and rejected ones so far, and warnings with their remedies."""
        return _json.loads(self._source.sensors())


def open(captures: Captures, model: Optional[str] = None, calibration: Optional[Path] = None, source: Optional[str] = None,
         clock: str = "smooth") -> Reader:
    """The frames of all sensors in captures (pcap, pcapng; packed with gzip or zstd, too), in the order of their ends.

    captures: a path or several, which are read as one. model: a name of models(); by default the packets show it.
    calibration: file of the one sensor (Velodyne). source: only packets from this "IP" or "IP:PORT".
    clock: "smooth", as on the vehicle; "arrival": each packet has the stamp of its arrival, as `lidard decode` by default.
    The begin of the captures (5 s) shows which sensors there are; only where it does not, they are read twice.
    """
    paths, file = _paths(captures), _os.fspath(calibration or "")
    with _of_files(*paths, file):
        return Reader(_lidard.CaptureReader(paths, model or "", file, source or "", clock))


def _config_of(config: Path) -> Tuple[str, str]:
    text = _os.fspath(config)
    if "\n" in text:
        return text, "the configuration"
    return _pathlib.Path(text).read_text(encoding="utf-8"), text


def replay(config: Path, captures: Captures, motion: Optional[Path] = None, topics: Iterable[str] = ()) -> Reader:
    """What a configuration makes of captures, as `lidard replay --bag` does: the frames of its sensors, merged scans,
    merged clouds and virtual scans, in the order in which they would be published.

    config: path of a YAML file, or its text. motion: table of the vehicle's motion, CSV with rows of stamp,x,y,yaw (s since
    1970, m, m, rad). topics: only these; by default all. At the end of the captures an output that never came raises a
    ValueError that says why.
    """
    text, name = _config_of(config)
    paths, file = _paths(captures), _os.fspath(motion or "")
    for path in (*paths, file):
        if path.endswith(".bag"):
            raise ValueError(f"{path}: bags need ROS; use `lidard replay`, or a capture and a table of the motion")
    with _of_files(*paths, file):
        return Reader(_lidard.ReplayReader(text, name, paths, file, set(topics)))


def inspect(captures: Captures) -> Dict[str, Any]:
    """Which sensors are in captures, with rates and losses, as `lidard inspect --json`: "sensors", "captures", "unknown" senders,
    and "config", the text of a configuration that replays them."""
    paths = _paths(captures)
    with _of_files(*paths):
        for path in paths:
            if path != "-" and not _os.path.exists(path):
                raise ValueError(f"{path}: No such file or directory")
        return _json.loads(_lidard.inspect(paths))


def models() -> List[Dict[str, Any]]:
    """The supported models and how each was verified, as `lidard models --json`."""
    return _json.loads(_lidard.models())


def check(config: Path) -> Dict[str, Any]:
    """What `lidard check` says of a configuration (path or text): "warnings", "config" (with every default), and "outputs": for
    each merged and virtual scan the share of its beams that can be +inf in an empty field, all round and ahead (%), and what is
    in the way. A mistake raises ValueError `file:line:column: what; expected …`."""
    return _json.loads(_lidard.check(*_config_of(config)))


class Driver:
    """One device, live: its bytes in, frames out. It opens no socket and sends nothing.

        driver = lidard.Driver("velodyne_vlp16")
        while True:
            data = udp.recv(2000)
            for frame in driver.feed(data):
                ...
    """

    def __init__(self, model: str, calibration: Optional[Path] = None, clock: str = "smooth") -> None:
        file = _os.fspath(calibration or "")
        with _of_files(file):
            self._source = _lidard.LiveReader(model, file, clock)

    def feed(self, data: Any, stamp: Union[None, int, float] = None, port: int = 0) -> List[Frame]:
        """The frames that a datagram, or a chunk of a TCP stream, completes; mostly none.

        stamp: when it arrived, s since 1970, or an int in ns; by default now. port: UDP port that it was sent to, where
        that is not the usual one of the model's data.
        """
        if stamp is None:
            stamp = _time.time_ns()
        return [_frame(raw) for raw in self._source.feed(data, stamp if isinstance(stamp, int) else round(stamp * 1e9), port)]

    def finish(self) -> List[Frame]:
        """What is complete enough at the end of the stream."""
        return [_frame(raw) for raw in self._source.finish()]

    @property
    def state(self) -> Dict[str, Any]:
        """Model, serial, packets, lost and rejected ones so far, and warnings with their remedies."""
        return _json.loads(self._source.sensors())
