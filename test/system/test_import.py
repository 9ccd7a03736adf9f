#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`lidard import`: launch files of the form that five packages have become configurations that `lidard check` takes."""
import os
import shutil

import yaml

from harness import expect, folder, run

TYPES = {str: "string", bool: "bool", int: "int", float: "double"}


def node(package, program, name, *inside, attributes="", **parameters):
    """A node of a launch file, with its parameters as these packages have them: each with its type."""
    lines = [f'<param name="{key}" type="{TYPES[type(value)]}" value="{value}"/>' for key, value in parameters.items()]
    return f'<node pkg="{package}" type="{program}" name="{name}" {attributes}>' + "\n".join([*lines, *inside]) + "</node>\n"


def launch(*inside):
    return "<launch>\n" + "".join(inside) + "</launch>"


def argument(name, default):
    return f'<arg name="{name}" default="{default}"/>\n'


SAFETY = launch(
    argument("sensor_ip", "192.168.1.11"), '<group ns="left">',
    node("sick_safetyscanners", "sick_safetyscanners_node", "scanner", '<remap from="scan" to="/scan_left"/>', attributes='output="screen"',
         sensor_ip="$(arg sensor_ip)", host_ip="192.168.1.9", host_udp_port=6061, frame_id="left_laser", angle_start=-1.5, angle_end=1.5,
         skip=1, min_intensities=0.0), "</group>",
    node("sick_safetyscanners", "sick_safetyscanners_node", "right", attributes='if="$(eval 1 > 2)"', sensor_ip="192.168.1.12"))
SICK_SCAN = launch(
    argument("hostname", "192.168.0.1"),
    node("sick_scan_xd", "sick_generic_caller", "front", '<remap from="scan" to="scan_front"/>', attributes='respawn="false"',
         scanner_type="sick_tim_7xx", hostname="$(arg hostname)", port="2112", min_ang=-2.35619449, max_ang=2.35619449,
         frame_id="/front_laser", intensity=True, range_filter_handling=0, tf_base_frame_id="base_link",
         tf_base_lidar_xyz_rpy="1.5,0,0.3,0,0,0.5"),
    node("sick_scan_xd", "sick_generic_caller", "pico", scanner_type="sick_picoscan", hostname="192.168.0.2", udp_receiver_ip="192.168.0.100",
         udp_port=2116, publish_frame_id="pico", publish_laserscan_fullframe_topic="scan_fullframe", tf_base_frame_id="base_link",
         msgpack_validator_enabled=False),
    node("sick_scan_xd", "sick_generic_caller", "radar", scanner_type="sick_rms_xxxx"),
    '<param name="robot_description" command="touch $(arg hostname).was_run"/>\n')
URG = launch(node(
    "urg_node", "urg_node", "urg_node", "<rosparam>{angle_max: 1.5707963, cluster: 2, skip: 1}</rosparam>", ip_address="192.168.0.10",
    serial_baud=115200, frame_id="laser", calibrate_time=True, publish_intensity=True, publish_multiecho=True, angle_min=-1.5707963))
DRIVER = launch(
    argument("device_ip", ""), '<arg name="manager"/>',
    '<node pkg="nodelet" type="nodelet" name="$(arg manager)" args="manager"/>',
    node("nodelet", "nodelet", "$(arg manager)_driver", attributes='args="load velodyne_driver/DriverNodelet $(arg manager)"',
         device_ip="$(arg device_ip)", frame_id="roof", model="VLP16", rpm=600.0, cut_angle=-0.01))


def driver(manager, address):
    return (f'<include file="$(find velodyne_driver)/launch/driver.launch"><arg name="device_ip" value="{address}"/>'
            f'<arg name="manager" value="{manager}"/></include>\n')


POINTS = launch(
    argument("device_ip", "192.168.1.201"), argument("calibration", "$(find velodyne_pointcloud)/params/VLP16db.yaml"), '<group ns="roof">',
    driver("m", "$(arg device_ip)"),
    node("nodelet", "nodelet", "m_transform", attributes='args="load velodyne_pointcloud/TransformNodelet m"', calibration="$(arg calibration)",
         min_range=0.4, max_range=100.0, fixed_frame="/odom", target_frame="base_link"),
    node("nodelet", "nodelet", "m_laserscan", attributes='args="load velodyne_laserscan/LaserScanNodelet m"', ring=-1, resolution=0.01),
    "</group>", driver("other", "192.168.1.202"))
TOOLS = launch(
    node("urg_node", "urg_node", "urg_node", '<remap from="scan" to="/scansx"/>', ip_address="192.168.0.10", frame_id="laser"),
    node("tf", "static_transform_publisher", "a", attributes='args="1 2 0.5 0.3 0 0 cart_frame laser 100"'),
    node("tf2_ros", "static_transform_publisher", "b", attributes='args="0 0 1 0 0 0 1 cart_frame plane"'),
    node("ira_laser_tools", "laserscan_multi_merger", "merger", destination_frame="cart_frame", scan_destination_topic="scan_multi",
         laserscan_topics="/scansx /scandx", angle_min=-2.0, angle_max=2.0),
    node("ira_laser_tools", "laserscan_virtualizer", "laserscan_virtualizer", cloud_topic="/cloud_in", base_frame="/cart_frame",
         virtual_laser_scan="plane"),
    node("rviz", "rviz", "rviz"))


def imported(file, *arguments):
    """The configuration, and the comments below it."""
    out = file.with_suffix(".lidard.yaml")
    result = run("import", file, *arguments, "-o", out)
    expect(result.returncode == 0, f"{file.name}: exit {result.returncode}\n{result.stderr}")
    check = run("check", out)
    expect(check.returncode == 0, f"{file.name}: check refuses it\n{check.stderr}\n{out.read_text()}")
    return yaml.safe_load(out.read_text()), [line for line in out.read_text().splitlines() if line.startswith("# - ")]


def changes_of(file):
    """The comments on what changes for the robot."""
    text = file.with_suffix(".lidard.yaml").read_text()
    return text.partition("# What changes for the robot:")[2].partition("# What is no longer needed")[0].splitlines()


def one_with(lines, *words):
    found = [line for line in lines if all(word in line for word in words)]
    expect(len(found) == 1, f"{len(found)} remarks have {words}:\n" + "\n".join(lines))


def written(tmp, name, text):
    path = tmp / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def safety_scanners(tmp):
    config, remarks = imported(written(tmp, "safety.launch", SAFETY), "sensor_ip:=192.168.1.77")
    expect(list(config["sensors"]) == ["scanner"], f"a condition that is false leaves a node out: {config}")
    scanner = config["sensors"]["scanner"]
    wanted = {"model": "sick_microscan3", "ip_address": "192.168.1.77", "udp_receiver_ip": "192.168.1.9",
              "ip_port": 6061, "frame_id": "left_laser", "allow_write": True, "scan_topic": "/scan_left",
              "angle_min": -1.5, "angle_max": 1.5}
    expect({key: scanner[key] for key in wanted} == wanted, scanner)
    one_with(remarks, "~skip (1)", "no effect")
    expect(scanner["extended_scan_topic"] == "/left/extended_laser_scan" and scanner["output_paths_topic"] == "/left/output_paths", scanner)
    pair = "".join(f"<node pkg='sick_safetyscanners' type='sick_safetyscanners_node' name='{name}'><remap from='scan' to='/{name}'/>"
                   f"<param name='sensor_ip' value='192.168.1.{last}'/></node>" for name, last in (("left", 1), ("right", 2)))
    config, remarks = imported(written(tmp, "pair.launch", f"<launch>{pair}</launch>"))
    expect([("output_paths_topic" in s) for s in config["sensors"].values()] == [True, False], config)
    one_with(remarks, "/right", "output_paths_topic was left out", "/output_paths")
    # As launch/sick_safetyscanners.launch has it: the namespace is called as the node, so that its topics are NAME/output_paths.
    config, _ = imported(written(tmp, "same.launch", f"<launch><group ns='left'>{pair}</group></launch>"))
    expect(config["sensors"]["left"]["output_paths_topic"] == "/left/output_paths", config)


def sick_scan(tmp):
    config, remarks = imported(written(tmp, "xd.launch", SICK_SCAN))
    front, pico = config["sensors"]["front"], config["sensors"]["pico"]
    expect(config["vehicle"]["base_frame"] == "base_link", config)
    expect(front["model"] == "sick_tim7xx" and front["scan_topic"] == "/scan_front", front)
    expect(front["frame_id"] == "front_laser" and front["pose"]["xyz"] == [1.5, 0, 0.3], front)
    expect(abs(front["pose"]["rpy_deg"][2] - 28.6479) < 1e-3, front)
    expect(pico["model"] == "sick_picoscan150" and pico["ip_port"] == 2116, pico)
    expect(pico["udp_receiver_ip"] == "192.168.0.100" and pico["scan_topic"] == "/scan_fullframe", pico)
    one_with(remarks, "/radar was not imported", "sick_rms_xxxx")
    one_with(remarks, "robot_description", "was not run")
    one_with(remarks, "msgpack_validator_enabled")
    expect(config["merged_scans"]["front_cloud"]["cloud_destination_topic"] == "/cloud", config)
    expect(len(config["merged_scans"]) == 1, "a picoScan has no cloud unless it is asked for")
    changes = changes_of(tmp / "xd.launch")
    expect(not any("msgpack" in line for line in changes), changes)
    one_with(changes, "/radar was not imported")
    expect(not list(tmp.glob("*.was_run")) and not os.path.exists("192.168.0.1.was_run"), "a program was run")


# The parameters of sick_lrs_36x0_upside_down.launch; T[world,cloud] of add_transform_xyz_rpy turns it by 180 degrees.
UPSIDE_DOWN = launch(node(
    "sick_scan_xd", "sick_generic_caller", "sick_lrs_36x0", attributes='respawn="false"', scanner_type="sick_lrs_36x0", min_ang=-3.14159,
    max_ang=3.14159, use_binary_protocol=True, hostname="192.168.0.1", cloud_topic="cloud", frame_id="cloud", port="2111", timelimit=5,
    sw_pll_only_publish=True, add_transform_xyz_rpy="0,0,0,3.141592653589793,0,0", add_transform_check_dynamic_updates=False,
    range_filter_handling=0, message_monitoring_enabled=True, tf_base_frame_id="map", tf_base_lidar_xyz_rpy="0,0,0,0,0,0",
    tf_publish_rate=10.0))


def upside_down(tmp):
    file = written(tmp, "upside_down.launch", UPSIDE_DOWN)
    config, _ = imported(file)
    (name, sensor), = config["sensors"].items()
    expect(abs(abs(sensor["pose"]["rpy_deg"][0]) - 180) < 1e-6 and sensor["pose"]["rpy_deg"][1:] == [0, 0], sensor)
    merged, = config["merged_scans"].values()
    expect(merged == {"laserscan_topics": [name], "destination_frame": "cloud", "cloud_destination_topic": "/cloud"}, merged)
    changes = [line for line in changes_of(file) if line]
    expect(len(changes) == 2 and "add_transform_xyz_rpy" in changes[0] and "base_frame is map" in changes[1], changes)
    # With a mount, and where another node publishes the frame.
    mounted = UPSIDE_DOWN.replace("map", "base_link").replace('xyz_rpy" type="string" value="0,0,0,0,0,0"',
                                                              'xyz_rpy" type="string" value="1,0,0.5,0,0,1.5707963267948966"')
    sensor, = imported(written(tmp, "mounted.launch", mounted))[0]["sensors"].values()
    expect(sensor["pose"]["xyz"] == [1, 0, 0.5], sensor)
    expect([abs(angle) for angle in sensor["pose"]["rpy_deg"]] == [180, 0, 90], sensor)
    elsewhere = UPSIDE_DOWN.replace('value="10.0"', 'value="0"')
    config, _ = imported(written(tmp, "elsewhere.launch", elsewhere))
    sensor, = config["sensors"].values()
    expect(config["vehicle"]["base_frame"] == "cloud" and sensor["frame_id"] == "cloud_device", config)
    expect(abs(abs(sensor["pose"]["rpy_deg"][0]) - 180) < 1e-6, sensor)
    # Two vehicles in one file: what cannot be a pose here is said.
    file = written(tmp, "two.launch", mounted.replace("</launch>", "") + UPSIDE_DOWN.replace("<launch>", "").replace(
        'name="sick_lrs_36x0"', 'name="b" ns="b"').replace("192.168.0.1", "192.168.0.2").replace('value="cloud"', 'value="other"'))
    config, _ = imported(file)
    one_with(changes_of(file), "sensors.b", "the pose of other in map", "base_link", "publish it on tf", "180")


def own_nodes(tmp):
    """Launch files that start the nodes of this package."""
    changed = POINTS[:POINTS.index("<group")] + """
      <node pkg="lidard" type="velodyne_node" name="velodyne"><param name="model" value="VLP16"/></node>
      <node pkg="lidard" type="lidard" name="lidard" args="run -c /etc/lidard/lidard.yaml"/></launch>"""
    config, remarks = imported(written(tmp, "own.launch", changed))
    sensor = config["sensors"]["velodyne"]
    expect(sensor["model"] == "velodyne_vlp16" and sensor["scan_topic"] == "/scan", sensor)
    expect(sensor["raw_topic"] == "/velodyne_packets", sensor)
    one_with(remarks, "/lidard", "a configuration of its own")
    for name, text in (("safety", SAFETY), ("urg", URG), ("tools", TOOLS)):
        own = text
        for package in ("sick_safetyscanners", "urg_node", "ira_laser_tools"):
            own = own.replace(f'pkg="{package}"', 'pkg="lidard"')
        expect(own != text, name)
        there, _ = imported(written(tmp, f"{name}_there.launch", text))
        here, _ = imported(written(tmp, f"{name}_here.launch", own))
        expect(here == there, f"{name}: {here}\n{there}")


def urg_node(tmp):
    config, remarks = imported(written(tmp, "urg.launch", URG))
    wanted = {"model": "hokuyo_scip", "ip_address": "192.168.0.10", "frame_id": "laser", "calibrate_time": True,
              "publish_multiecho": True, "angle_min": -1.5707963, "angle_max": 1.5707963, "cluster": 2, "skip": 1,
              "scan_topic": "/scan"}
    sensor = config["sensors"]["urg_node"]
    expect({key: sensor[key] for key in wanted} == wanted, sensor)
    one_with(remarks, "~serial_baud (115200)", "no serial ports")


def velodyne(tmp):
    for package, name, text in (("velodyne_pointcloud", "points.launch", POINTS), ("velodyne_driver", "driver.launch", DRIVER)):
        written(tmp, f"velodyne/{package}/package.xml", f"<package><name>{package}</name></package>")
        written(tmp, f"velodyne/{package}/launch/{name}", text)
    config, remarks = imported(tmp / "velodyne/velodyne_pointcloud/launch/points.launch")
    expect(len(config["sensors"]) == 2, f"two drivers are two sensors: {config}")
    roof, other = config["sensors"]["m_driver"], config["sensors"]["other_driver"]
    wanted = {"model": "velodyne_vlp16", "ip_address": "192.168.1.201", "frame_id": "roof", "min_range": 0.4,
              "max_range": 100, "scan_ring": "auto", "scan_resolution": 0.01, "frame_stamp": "last",
              "points_topic": "/roof/velodyne_points", "scan_topic": "/roof/scan", "calibration_model": "ros_drivers",
              "points_frame": "base_link", "deskew": True}
    expect({key: roof[key] for key in wanted} == wanted, roof)
    expect("calibration" not in roof, "the model's own table needs no file of another package")
    expect(other["ip_address"] == "192.168.1.202" and "scan_ring" not in other, other)
    expect(roof["raw_topic"] == "/roof/velodyne_packets" and other["raw_topic"] == "/velodyne_packets", config)
    expect(config["vehicle"] == {"base_frame": "roof", "odometry_frame": "odom"}, config["vehicle"])
    one_with(remarks, "m_driver", "~rpm (600.0)")
    one_with(remarks, "VLP16db.yaml", "the model has here too")
    # A copy of the file alone: what it includes is not there.
    loose = run("import", written(tmp, "elsewhere/points.launch", POINTS))
    expect(loose.returncode == 78 and "velodyne_driver" in loose.stderr, loose.stderr)


def laser_tools(tmp):
    config, remarks = imported(written(tmp, "tools.launch", TOOLS))
    expect(config["vehicle"]["base_frame"] == "cart_frame", config)
    merged = config["merged_scans"]["merger"]
    expect(merged["laserscan_topics"] == ["urg_node", "scandx"], f"a topic of a sensor of the file is that sensor: {merged}")
    expect(merged["scan_destination_topic"] == "/scan_multi" and merged["angle_min"] == -2, merged)
    expect(config["sensors"]["scandx"] == {"topic": "/scandx"}, config)
    pose = config["sensors"]["urg_node"]["pose"]
    expect(pose["xyz"] == [1, 2, 0.5] and abs(pose["rpy_deg"][2] - 17.1887) < 1e-3, pose)
    plane = config["virtual_scans"]["laserscan_virtualizer"]
    expect(plane["poses"]["plane"]["xyz"] == [0, 0, 1] and plane["cloud_topic"] == "cloud_in", plane)
    one_with(remarks, "/rviz (rviz/rviz)", "stays in a launch file")


def parameter_files(tmp):
    config, _ = imported(written(tmp, "urg.yaml", "urg_node:\n  ros__parameters:\n    ip_address: 192.168.0.10\n"
                                 "    ip_port: 10940\n    laser_frame_id: nose\n    angle_min: -1.0\n"))
    expect(config["sensors"]["urg_node"]["frame_id"] == "nose", config)
    config, _ = imported(written(tmp, "safety.yaml", "sensor_ip: 192.168.1.11\nhost_ip: 192.168.1.9\nframe_id: s\n"))
    expect(config["sensors"]["lidar"]["model"] == "sick_microscan3", config)


DESCRIPTION = """<robot name="amr"><link name="base_link"/><link name="front"/><link name="rear"/><link name="arm"/>
<joint name="a" type="fixed"><parent link="base_footprint"/><child link="base_link"/><origin xyz="0 0 0.1"/></joint>
<joint name="b" type="fixed"><parent link="base_link"/><child link="front"/><origin xyz="0.4 0.25 0.2" rpy="3.14159265 0 0.785398"/></joint>
<joint name="c" type="fixed"><parent link="base_link"/><child link="rear"/><origin rpy="0 0 -2.356194"/></joint>
<joint name="d" type="continuous"><parent link="base_link"/><child link="arm"/><origin xyz="9 9 9"/></joint></robot>"""


def description(tmp):
    """Fixed joints of robot_description are poses, however it comes to the parameter; no other program than xacro is run."""
    urdf = written(tmp, "robot/urdf/amr.urdf", DESCRIPTION)
    written(tmp, "robot/package.xml", "<package><name>robot</name></package>")
    xacro = written(tmp, "bin/xacro", f"#!/bin/sh\necho \"$@\" > {tmp}/xacro_was_run\nexec cat {urdf}\n")
    xacro.chmod(0o755)
    scanners = "".join(f"<node pkg='urg_node' type='urg_node' name='{name}' ns='{name}'><param name='ip_address' value='192.168.0.1{n}'/>"
                       f"<param name='frame_id' value='{name}'/></node>" for n, name in enumerate(("front", "rear", "arm")))
    robot = f"<launch><param name='robot_description' %s/><node pkg='robot_state_publisher' type='robot_state_publisher' name='rsp'/>{scanners}</launch>"
    path = {**os.environ, "PATH": f"{tmp}/bin:{os.environ['PATH']}"}
    for name, source in (("text", f"textfile='{urdf}'"), ("find", "textfile='$(find robot)/urdf/amr.urdf'"), ("cat", f"command='cat {urdf}'"),
                         ("xacro", "command='$(find xacro)/xacro --inorder $(find robot)/urdf/amr.urdf lidar:=two'")):
        file = written(tmp, f"robot/launch/{name}.launch", robot % source)
        result = run("import", file, "-o", file.with_suffix(".yaml"), env=path)
        expect(result.returncode == 0, f"{name}: {result.stderr}")
        config = yaml.safe_load(file.with_suffix(".yaml").read_text())
        expect(config["vehicle"]["base_frame"] == "base_link", config)
        front, rear = (config["sensors"][one]["pose"] for one in ("front", "rear"))
        expect(front["xyz"] == [0.4, 0.25, 0.2] and abs(abs(front["rpy_deg"][0]) - 180) < 1e-4 and abs(front["rpy_deg"][2] - 45) < 1e-4, front)
        expect(rear["xyz"] == [0, 0, 0] and abs(rear["rpy_deg"][2] + 135) < 1e-4, rear)
        expect("pose" not in config["sensors"]["arm"], "the pose of a joint that moves comes from tf")
    expect((tmp / "xacro_was_run").read_text().split()[1:] == [str(urdf), "lidar:=two"], "xacro gets its arguments")
    file = written(tmp, "program.launch", robot % f"command='touch {tmp}/was_run'")
    imported(file)
    one_with(changes_of(file), "robot_description", "was not run")
    expect(not (tmp / "was_run").exists(), "a program was run")
    file = written(tmp, "no_xacro.launch", robot % f"command='/nowhere/xacro {urdf}'")
    if shutil.which("xacro") is None:
        imported(file)
        one_with(changes_of(file), "robot_description", "install xacro")
    file = written(tmp, "broken.launch", robot % "value='&lt;robot&gt;&lt;joint'")
    imported(file)
    one_with(changes_of(file), "robot_description", "stay with tf")


def without_packages(tmp):
    """Debian has no velodyne_pointcloud: lidard's launch files stand in. The first words about another package are the reason."""
    bare = {**os.environ, "ROS_PACKAGE_PATH": ""}
    include = "<launch><group ns='roof'><include file='$(find %s)/launch/%s'><arg name='device_ip' value='192.168.1.202'/>%s</include></group></launch>"
    args = "<arg name='port' value='2369'/><arg name='frame_id' value='left'/><arg name='manager' value='m'/>"
    for name, model in (("VLP16", "vlp16"), ("VLP-32C", "vlp32c"), ("32e", "hdl32e"), ("VLS128", "vls128")):
        file = written(tmp, f"bare/{name}.launch", include % ("velodyne_pointcloud", f"{name}_points.launch", args))
        result = run("import", file, "-o", file.with_suffix(".yaml"), env=bare)
        expect(result.returncode == 0, result.stderr)
        sensor, = yaml.safe_load(file.with_suffix(".yaml").read_text())["sensors"].values()
        wanted = {"model": f"velodyne_{model}", "ip_address": "192.168.1.202", "ip_port": 2369, "frame_id": "left", "points_topic": "/roof/velodyne_points"}
        expect({key: sensor[key] for key in wanted} == wanted, sensor)
        expect("in its place" in file.with_suffix(".yaml").read_text(), "it is said")
    for package, name in (("velodyne_pointcloud", "cloud_nodelet.launch"), ("another_robot", "base.launch")):
        result = run("import", written(tmp, "bare/missing.launch", include % (package, name, "")), env=bare)
        first = result.stderr.splitlines()[0]
        expect(result.returncode == 78 and f"missing.launch: package {package} is neither installed" in first and name in first, result.stderr)
    ros2 = "<launch><node pkg='velodyne_driver' exec='velodyne_driver_node' name='d'/></launch>"
    for name, text in (("two.launch.xml", ros2), ("two.launch.py", "import launch\n")):
        result = run("import", written(tmp, name, text))
        expect(result.returncode == 78 and "ROS 2" in result.stderr, f"{name}: {result.stderr}")


def clouds_of_a_picoscan(tmp):
    """The first whole cloud in x, y and z keeps its topic; what is long is shortened."""
    properties = "topic=/%s frameid=world publish=1 layers=1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16 coordinateNotation=%d updateMethod=%d"
    clouds = {"segments": (0, 1), "polar": (1, 0), "whole": (0, 0), "second": (0, 0)}
    more = "".join(f"<param name='{name}' value='{properties % (name, *kind)}'/>" for name, kind in clouds.items())
    more += "".join(f"<param name='cloud_polar_{n}' value='{properties % ('x', 1, 1)}'/>" for n in range(12))
    for scanner, place in (("sick_picoscan", "merged_scans"), ("sick_multiscan", "sensors")):
        file = written(tmp, f"{scanner}.launch", f"<launch><node name='s' pkg='sick_scan_xd' type='sick_generic_caller'><param name='scanner_type' value='{scanner}'/>"
                       f"<param name='custom_pointclouds' value='{' '.join(clouds)}'/><param name='sopas_tcp_port' value='2111'/>{more}</node></launch>")
        config, remarks = imported(file)
        entry, = config[place].values()
        expect(entry.get("cloud_destination_topic", entry.get("points_topic")) == "/whole", config)
        one_with(changes_of(file), "not published", "/segments, /polar, /second", "/whole")
        one_with(remarks, "~sopas_tcp_port (2111)", "settings are asked for")
        expect(max(map(len, remarks)) < 700, max(remarks, key=len))


def mistakes(tmp):
    for name, text, code, words in (
            ("none.launch", "<launch><node pkg='rviz' type='rviz' name='r'/></launch>", 1, ("nothing in it", "urg_node")),
            ("broken.launch", "<launch><node", 78, ("broken.launch",)),
            ("no_arg.launch", "<launch><arg name='x'/><node pkg='a' type='b' name='$(arg x)'/></launch>", 78, ("x",)),
            ("no.yaml", "- 1\n- 2\n", 78, ("no.yaml", "parameters")),
            ("mrs.launch", SICK_SCAN.replace("sick_tim_7xx", "x").replace("sick_picoscan", "sick_mrs_6xxx"), 1,
             ("sick_mrs_6xxx", "nothing in it"))):
        result = run("import", written(tmp, name, text))
        expect(result.returncode == code, f"{name}: exit {result.returncode}\n{result.stderr}")
        for word in words:
            expect(word in result.stderr, f"'{word}' is not in the answer to {name}: {result.stderr}")
    there = written(tmp, "there.yaml", "kept\n")
    wrong = written(tmp, "wrong.launch", "<launch><node pkg='urg_node' type='urg_node' name='u'><param name='ip_address' value='192.168.0.10'/>"
                    "<param name='ip_port' value='99999'/></node></launch>")
    result = run("import", wrong, "-o", there)
    expect(result.returncode == 78 and "sensors.u.ip_port is 99999" in result.stderr and there.read_text() == "kept\n", result.stderr)
    gone = run("import", tmp / "gone.launch")
    expect(gone.returncode == 78 and "gone.launch: cannot be read" in gone.stderr, gone.stderr)
    expect(run("import").returncode == 2, "no file is a mistake of usage")


def without_roslaunch(tmp):
    """Where roslaunch is not installed (a module of this name that is not it stands first), the answer says what to install."""
    written(tmp, "without/roslaunch/__init__.py", "raise ImportError('No module named roslaunch')\n")
    answer = run("import", tmp / "urg.launch", env={**os.environ, "PYTHONPATH": str(tmp / "without")})
    expect(answer.returncode == 1 and "apt install python3-roslaunch" in answer.stderr, answer.stderr)


with folder() as tmp:
    for step in (safety_scanners, sick_scan, upside_down, own_nodes, urg_node, velodyne, laser_tools, parameter_files, description, without_packages,
                 clouds_of_a_picoscan, mistakes, without_roslaunch):
        step(tmp)
        print(f"{step.__name__}: fine")
