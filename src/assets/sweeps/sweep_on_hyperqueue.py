#!/usr/bin/env python3
"""Run a sweep's shards and their merge on HyperQueue (pip install hyperqueue), with the settings in sweep.json.

Connects to your running server (or the one in the folder $HQ_SERVER_DIR). With --local it starts a server on this machine,
with a worker that uses all cores. You can run this script again at any time: shards continue.
"""

import json
import os
import sys

from hyperqueue import Job, LocalCluster
from hyperqueue.client import Client
from hyperqueue.cluster import WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest

FOLDER = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(FOLDER, "sweep.json"), encoding="utf-8") as file:
    SWEEP = json.load(file)


def main(client):
    job = Job(name="decore", max_fails=None)
    # The scripts write their own logs, because HyperQueue would expand %{...} in its paths.
    quiet = {"stdout": None, "stderr": None}
    script = lambda name, *arguments: ["/bin/sh", os.path.join(FOLDER, name), *arguments]
    shards = []
    for index in range(1, SWEEP["tasks"] + 1):
        command = script("task.sh", str(index), f"task-{index}.log")
        resources = ResourceRequest(cpus=SWEEP["threads"])
        shards.append(job.program(command, resources=resources, name=f"shard-{index}", **quiet))
    job.program(script("merge.sh", "merge.log"), deps=shards, name="merge", **quiet)
    client.wait_for_jobs([client.submit(job)])


if "--local" in sys.argv[1:]:
    with LocalCluster() as cluster:
        cluster.start_worker(WorkerConfig())
        main(cluster.client())
else:
    main(Client(os.environ.get("HQ_SERVER_DIR")))
