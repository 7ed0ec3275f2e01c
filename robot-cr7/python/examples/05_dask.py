"""A set of jobs on Dask: a parquet of jobs becomes a parquet of trajectories, and what cannot be planned a row with its reason.

    pip install "dask[distributed,dataframe]" pyarrow
    python 05_dask.py [JOBS, else 200] [WORKERS, else 2] [KILLS, else 1]

A worker that dies costs nothing: Dask gives its partitions to another. The example kills workers itself and shows that no job is lost.
Another cluster takes the place of LocalCluster by its address: Client("tcp://scheduler:8786").
"""

import os
import random
import signal
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

import arcfeed

PARTITION = 200  # jobs that a worker does at a time, and does again if it dies
NUMBERS = pd.ArrowDtype(pa.list_(pa.float64()))
COLUMNS = {"id": "int64", "error": "string", "duration_s": "float64", "q_rad": NUMBERS, "processor_s": "float64"}


def make_jobs(count, seed=1):
    """Straight lines of 2 to 10 mm before an arm, at 20 to 200 mm/s; one of ten is out of reach."""
    random_numbers = np.random.default_rng(seed)
    ends = random_numbers.uniform([0.002, -0.005, -0.002], [0.008, 0.005, 0.002], (count, 3))
    at = random_numbers.uniform([350, -150, 150], [450, 150, 250], (count, 3))
    at[::10] = [4000, 0, 0]
    return pd.DataFrame(
        {
            "id": np.arange(count),
            "robot": random_numbers.choice(["cr7", "ur5e", "kr6_r700"], count),
            "end_m": list(ends),
            "position_mm": list(at),
            "feed_mm_s": random_numbers.uniform(20, 200, count),
        }
    )


def plan(job):
    """One job as a row of results: the joints of each control period, row by row, or the reason."""
    begin = time.thread_time()
    row = {"id": job.id, "error": None, "duration_s": None, "q_rad": None}
    try:
        path = arcfeed.Path.nurbs(1, [np.zeros(3), job.end_m], [0, 0, 1, 1])
        limits = arcfeed.Job(
            feed={"feed_mm_s": job.feed_mm_s},
            workpiece={"position_mm": list(job.position_mm)},
            sampling={"period_ms": 4.0},
            plan={"planner": "continuous-acceleration"},  # the quickest to compute
        )
        motion = arcfeed.plan(path, job.robot, limits)
        row |= {"duration_s": motion.duration, "q_rad": motion.q.ravel()}
    except arcfeed.ArcfeedError as error:
        row["error"] = str(error)
    return row | {"processor_s": time.thread_time() - begin}


def plan_all(frame):
    return pd.DataFrame([plan(job) for job in frame.itertuples()], columns=list(COLUMNS)).astype(COLUMNS)


def kill_workers(cluster, client, kills, done, killed):
    """Kills a worker now and then, as a machine that goes away would; adds its process to killed.

    All of them work before the next one dies: one that is killed while it starts is given up by its nanny, as one that can never start.
    """
    while len(killed) < kills and not done.wait(random.uniform(2.0, 10.0)):
        nannies = list(cluster.workers.values())
        # A nanny knows the address of its worker once that has started; the scheduler forgets it when the worker dies.
        if not nannies or {nanny.worker_address for nanny in nannies} != set(client.nthreads()):
            continue
        process = random.choice(nannies).pid
        if process is None:  # it has just ended by itself
            continue
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            continue
        killed.append(process)


def run(jobs, results, workers, kills):
    """Plans all jobs on a cluster; seconds, and how many workers were killed."""
    import dask
    import dask.dataframe as dd
    from dask.distributed import Client, LocalCluster

    # A list of numbers stays a list. A partition that was on several workers when they died is not to blame. A worker whose start takes
    # long, as on a computer under load, is waited for: after 15 s the cluster gives it up else, and goes on with fewer or none.
    dask.config.set(
        {
            "dataframe.convert-string": False,
            "distributed.scheduler.allowed-failures": 100,
            "distributed.deploy.lost-worker-timeout": "10 minutes",
        }
    )
    done, killed = threading.Event(), []
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        client.wait_for_workers(workers)
        begin = time.perf_counter()
        killer = threading.Thread(target=kill_workers, args=(cluster, client, kills, done, killed))
        killer.start()
        try:
            frame = dd.read_parquet(jobs, split_row_groups=1)
            meta = pd.DataFrame(columns=list(COLUMNS)).astype(COLUMNS)
            frame.map_partitions(plan_all, meta=meta).to_parquet(results)
            seconds = time.perf_counter() - begin
        finally:
            done.set()
            killer.join()
    return seconds, len(killed)


def main():
    count, workers, kills = (int(sys.argv[i]) if len(sys.argv) > i else default for i, default in [(1, 200), (2, 2), (3, 1)])
    if count < 1 or workers < 1:
        sys.exit(f"{count} jobs, {workers} workers: give at least 1 of each")
    all_jobs = make_jobs(count)
    few = all_jobs.head(PARTITION)
    begin, used = time.perf_counter(), time.process_time()
    alone = plan_all(few)
    seconds, used = time.perf_counter() - begin, time.process_time() - used
    print(f"this process: {len(few) / seconds:.1f} jobs a second, {len(few) / used:.1f} a second of processor time", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        jobs, results = Path(folder) / "jobs.parquet", Path(folder) / "trajectories"
        all_jobs.to_parquet(jobs, row_group_size=PARTITION)
        seconds, killed = run(jobs, results, workers, kills)
        size = sum(file.stat().st_size for file in results.iterdir())
        done = pq.read_table(results).to_pandas(ignore_metadata=True).sort_values("id", ignore_index=True)
    used = done["processor_s"].sum()
    print(f"{workers} workers: {count / seconds:.1f} jobs a second, {count / used:.1f} a second of processor time, {size / count / 1e3:.1f} kB a job")

    failed = done["error"].notna()
    assert done["id"].tolist() == list(range(count))
    assert failed.tolist() == [i % 10 == 0 for i in range(count)]
    for i, (ours, theirs) in enumerate(zip(alone["q_rad"], done["q_rad"])):
        assert failed[i] or np.array_equal(ours, theirs)
    print(f"{killed} workers killed; {(~failed).sum()} motions, {failed.sum()} failures with their reason, none lost, none twice")
    for motion in done[~failed].head(1).itertuples():
        print(f"first motion: {len(np.reshape(motion.q_rad, (-1, 6)))} setpoints in {motion.duration_s:.3f} s")
    print(f"first failure: {done['error'][0][:100]}...")


if __name__ == "__main__":
    main()
