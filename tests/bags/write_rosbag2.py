#!/usr/bin/env python3
"""Writes messages in CDR as rosbag2's SQLite storage does: a file by itself, a folder with two of them and what its
metadata.yaml has, and the same without it, as a recording leaves it that was killed.

usage: tests/bags/write_rosbag2.py CDR.json OUT_DIR [PAGE_BYTES]
"""

import base64
import json
import pathlib
import sqlite3
import subprocess
import sys

SCHEMA = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
                    offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
                      data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""
TOPICS = ((1, "/scan", "sensor_msgs/msg/LaserScan", "cdr", ""), (2, "/odom", "nav_msgs/msg/Odometry", "cdr", ""),
          (3, "/rosout", "rcl_interfaces/msg/Log", "cdr", ""))
TF_TOPICS = ((1, "/scan", "sensor_msgs/msg/LaserScan", "cdr", ""), (2, "/tf", "tf2_msgs/msg/TFMessage", "cdr", ""))
METADATA = """rosbag2_bagfile_information:
  version: 5
  storage_identifier: sqlite3
  relative_file_paths:
{paths}
  duration:
    nanoseconds: 1
  compression_format: ""
  compression_mode: ""
"""


def write_tf(path, messages, page_bytes):
    database = sqlite3.connect(path)
    database.execute(f"PRAGMA page_size = {page_bytes}")
    database.executescript(SCHEMA)
    database.executemany("INSERT INTO topics VALUES (?, ?, ?, ?, ?)", TF_TOPICS)
    for message in messages:
        for topic, key in ((1, "scan"), (2, "tf")):
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                             (topic, int(message["time"]), base64.b64decode(message[key])))
    database.commit()
    database.close()


def write(path, messages, page_bytes, pack=bytes):
    database = sqlite3.connect(path)
    database.execute(f"PRAGMA page_size = {page_bytes}")
    database.executescript(SCHEMA)
    database.executemany("INSERT INTO topics VALUES (?, ?, ?, ?, ?)", TOPICS)
    for message in messages:
        for topic, key in ((3, None), (1, "scan"), (2, "odom")):
            if key and message.get(key):
                data = pack(base64.b64decode(message[key]))
            elif key:
                continue
            else:
                data = b"\0\1\0\0log"
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                             (topic, int(message["time"]), data))
    database.commit()
    database.close()


def zstd(data):
    size = f"--stream-size={len(data)}"  # which rosbag2 gives too
    return subprocess.run(["zstd", "-c", "-q", size], input=data, capture_output=True, check=True).stdout


def main():
    messages = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    out = pathlib.Path(sys.argv[2])
    page_bytes = int(sys.argv[3]) if len(sys.argv) > 3 else 4096
    write(out / "run.db3", messages, page_bytes)
    write_tf(out / "tf.db3", messages, page_bytes)
    write(out / "messages_zstd.db3", messages[:20], page_bytes, zstd)
    middle = len(messages) // 2
    for name, numbers in (("folder", (9, 10)), ("killed_folder", (9, 10))):
        folder = out / name
        folder.mkdir()
        files = [f"run_{number}.db3" for number in numbers]
        write(folder / files[0], messages[:middle], page_bytes)
        write(folder / files[1], messages[middle:], page_bytes)
        if name == "folder":
            paths = "\n".join(f"    - {file}" for file in files)
            (folder / "metadata.yaml").write_text(METADATA.format(paths=paths), encoding="utf-8")


if __name__ == "__main__":
    main()
