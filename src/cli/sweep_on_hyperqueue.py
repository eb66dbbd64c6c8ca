#!/usr/bin/env python3
"""Runs a sweep's shards and their merge on HyperQueue (pip install hyperqueue); @STUDY@

Connects to the running server of this user (or that in the folder $HQ_SERVER_DIR); with --local it starts one on this
machine with a worker of as many cores as there are. May be run again at any time: shards continue.
"""

import os
import sys

from hyperqueue import Job, LocalCluster
from hyperqueue.client import Client
from hyperqueue.cluster import WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest

TASKS = @TASKS@
THREADS = @THREADS@
TASK = @TASK@
MERGE = @MERGE@
LOGS = @LOGS@


def main(client):
    job = Job(name="decore", max_fails=None)
    shards = []
    for index in range(1, TASKS + 1):
        log = os.path.join(LOGS, f"task-{index}.log")
        command = ["/bin/sh", TASK, str(index)]
        resources = ResourceRequest(cpus=THREADS)
        shards.append(job.program(command, stdout=log, stderr=log + ".err", resources=resources, name=f"shard-{index}"))
    log = os.path.join(LOGS, "merge.log")
    job.program(["/bin/sh", MERGE], stdout=log, stderr=log + ".err", deps=shards, name="merge")
    client.wait_for_jobs([client.submit(job)])


if "--local" in sys.argv[1:]:
    with LocalCluster() as cluster:
        cluster.start_worker(WorkerConfig())
        main(cluster.client())
else:
    main(Client(os.environ.get("HQ_SERVER_DIR")))
