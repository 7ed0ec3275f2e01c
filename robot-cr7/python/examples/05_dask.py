"""A set of jobs on Dask: a parquet of jobs becomes a parquet of trajectories, and what cannot be planned a row with its reason.

    pip install "dask[distributed,dataframe]" pyarrow
    python 05_dask.py [JOBS, else 40] [WORKERS, else 2]

A worker that dies costs nothing: Dask gives its partitions to another. Motions are kept as polynomials of the time, which are a tenth of their
samples. Another cluster takes the place of LocalCluster by its address: Client("tcp://scheduler:8786").
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

import arcfeed


def make_jobs(count, seed=1):
    """Random paths of five points; one of ten is out of reach."""
    random = np.random.default_rng(seed)
    points = np.cumsum(random.uniform(-0.02, 0.03, (count, 5, 3)), axis=1)
    points[::10, -1] += 3.0
    return pd.DataFrame(
        {
            "id": np.arange(count),
            "robot": random.choice(["cr7", "ur5e", "kr6_r700"], count),
            "points": [list(p.ravel()) for p in points],
            "feed_mm_s": random.uniform(20, 200, count),
        }
    )


def plan(job):
    """One job as a row of results."""
    begin = time.perf_counter()
    row = {"id": job.id, "error": None, "duration_s": None, "trajectory": None}
    try:
        path = arcfeed.Path.through(np.reshape(job.points, (-1, 3)))
        limits = arcfeed.Job(feed={"feed_mm_s": job.feed_mm_s}, path={"bulge_mm": 1000.0}, sampling={"period_ms": 4.0})
        motion = arcfeed.plan(path, job.robot, limits, compile_rad=1e-5)
        row |= {"duration_s": motion.duration, "trajectory": motion.compiled.to_json()}
    except arcfeed.ArcfeedError as error:
        row["error"] = str(error)
    return row | {"computing_s": time.perf_counter() - begin}


COLUMNS = {"id": "int64", "error": "string", "duration_s": "float64", "trajectory": "string", "computing_s": "float64"}


def plan_all(frame):
    return pd.DataFrame([plan(job) for job in frame.itertuples()], columns=list(COLUMNS)).astype(COLUMNS)


def main():
    import dask
    import dask.dataframe as dd
    from dask.distributed import Client, LocalCluster

    dask.config.set({"dataframe.convert-string": False})  # a list of points stays a list

    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    with tempfile.TemporaryDirectory() as folder:
        jobs, results = Path(folder) / "jobs.parquet", Path(folder) / "trajectories"
        make_jobs(count).to_parquet(jobs)
        with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster):
            begin = time.perf_counter()
            frame = dd.from_pandas(pd.read_parquet(jobs), npartitions=max(workers, count // 20))
            frame.map_partitions(plan_all, meta=pd.DataFrame(columns=list(COLUMNS)).astype(COLUMNS)).to_parquet(results)
            seconds = time.perf_counter() - begin
        done = pd.read_parquet(results)
    assert sorted(done["id"]) == list(range(count))
    failed = done["error"].notna()
    print(
        f"{(~failed).sum()} motions, {failed.sum()} failures with their reason, {count / seconds:.1f} jobs a second by {workers} workers"
    )
    print(f"one process alone would make {count / done['computing_s'].sum():.1f} a second")
    example = arcfeed.JointTrajectory.from_json(done.loc[~failed, "trajectory"].iloc[0])
    print(f"first motion: {example}")
    print(f"first failure: {done.loc[failed, 'error'].iloc[0][:100]}...")


if __name__ == "__main__":
    main()
