"""The study `uncertainty`: how the peak force spreads when the inputs do, and which input it comes from."""

from __future__ import annotations

from pathlib import Path

import click

from tailslap.studies import study_arguments

DEFAULT_SAMPLES, LEAST_SAMPLES, MOST_SAMPLES = 100_000, 1_000, 4_000_000


@click.command("uncertainty")
@study_arguments
@click.option(
    "--samples",
    type=click.IntRange(LEAST_SAMPLES, MOST_SAMPLES),
    default=DEFAULT_SAMPLES,
    show_default=True,
    help="Combinations of inputs, at least.",
)
@click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="KEY=LOWER:UPPER",
    help="Vary a key between two values, like impact.friction=0.2:0.5 or impact.speed='50 mph:60 mph'.",
)
@click.option(
    "--fix", "fixed", multiple=True, metavar="KEY", help="Leave a key that varies by default alone."
)
def command(
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    samples: int,
    ranges: tuple[str, ...],
    fixed: tuple[str, ...],
) -> int:
    """Spread of the peak force over ranges of the inputs, and its Sobol indices."""
    from tailslap.planning.plan import make_plan
    from tailslap.results.result_folder import result_folder
    from tailslap.scene.files import read_scene
    from tailslap.studies.uncertainty.ranges import study_ranges

    plan = make_plan(*read_scene(name, changes))
    varied = study_ranges(name, changes, ranges, fixed)
    place = out or Path("results") / f"{plan.scene.name}-uncertainty"
    with result_folder(place) as folder:
        from tailslap.studies.uncertainty.report.write import write_spread
        from tailslap.studies.uncertainty.spread import find_spread

        spread = find_spread(plan, varied, samples)
        write_spread(spread, folder)
    from tailslap.studies.uncertainty.report.terminal import print_spread

    print_spread(spread, place)
    return 0
