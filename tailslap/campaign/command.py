"""The command line of a sweep."""

from __future__ import annotations

from pathlib import Path

import click

from tailslap import options
from tailslap.errors import InputError

SEED = 307


@click.command("sweep")
@options.with_options(options.SCENE, options.SET)
@click.option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    metavar="KEY=VALUES",
    help="a:b:n, n values from a to b; log:a:b:n, the same in equal ratios; or a list v1,v2,v3. Units as in a scene.",
)
@click.option(
    "--sample",
    type=options.Whole(2, options.MAX_RUNS),
    metavar="N",
    help="Instead of the grid, N runs by Latin hypercube; ranges are then a:b or log:a:b.",
)
@click.option("--seed", type=options.Whole(0), default=SEED, show_default=True, help="Of the samples.")
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/NAME-sweep]")
@click.option(
    "--cluster", type=options.Text(), metavar="ADDRESS", help="A Dask scheduler, like tcp://10.0.0.1:8786."
)
@click.option(
    "--workers",
    type=options.Whole(1, 1024),
    metavar="N",
    help="Processes on this machine  [default: its cores]",
)
@options.with_options(options.UNITS, options.JSON, options.QUIET, options.PROGRESS)
def sweep(
    name: str,
    varied: tuple[str, ...],
    changes: tuple[str, ...],
    sample: int | None,
    seed: int,
    out: Path | None,
    cluster: str | None,
    workers: int | None,
    units: str,
    as_json: bool,
) -> int:
    """Run a scene for many values of its keys: one table, a row a run.

    Interrupted or killed, it resumes by the same command, and repeats nothing. Exit status: 0 if every run passed its
    checks or was refused by the theory; 1 if one failed a check or ended in an error; 3 if the cluster was lost.
    """
    if cluster and workers:
        raise InputError("--workers", workers, "--cluster has its own workers; leave out one of the two")
    from tailslap.campaign.definition import make_definition

    definition = make_definition(name, changes, varied, sample, seed)
    place = out or Path("results") / f"{definition.scene}-sweep"

    from tailslap.campaign import perform, report

    try:
        done = perform.perform(definition, place, cluster, workers, units=units)
    except perform.StoppedError as stopped:
        click.echo(f"tailslap: {stopped}", err=True)
        return stopped.status
    click.echo(
        (place / report.SUMMARY).read_text(encoding="utf-8").rstrip()
        if as_json
        else report.sweep_text(done, place)
    )
    return 1 if done.failures else 0
