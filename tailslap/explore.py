# /// script
# [tool.marimo.display]
# theme = "system"
# ///
"""Explore a scene on a page, opened by `tailslap explore`.

It is a marimo app, whose cells run again when their inputs change.
"""

import marimo

app = marimo.App(width="full", app_title="tailslap explore", html_head_file="explore_head.html")

with app.setup:
    import math
    import tempfile
    import time
    from dataclasses import replace
    from pathlib import Path

    import marimo as mo
    import tomlkit

    import postprocess
    import tailslap
    from postprocess.svg.chart import Chart
    from tailslap import progress
    from tailslap.scene import read, units
    from tailslap.scene.validate import value_in

    SLIDERS = {
        "impact.speed": ("Speed", "m/s", 5.0, 40.0),
        "impact.angle": ("Angle", "rad", math.radians(5.0), math.radians(45.0)),
        "vehicle.mass": ("Mass", "kg", 500.0, 40_000.0),
        "start.corner_speed": ("Speed of the corner", "m/s", 5.0, 40.0),
        "start.angle": ("Angle at the start", "rad", math.radians(5.0), math.radians(45.0)),
        "impact.friction": ("Friction", "", 0.0, 1.0),
        "impact.restitution": ("Restitution", "", 0.0, 0.95),
        "contact.friction": ("Friction", "", 0.0, 1.0),
        "contact.restitution": ("Restitution", "", 0.0, 0.95),
        "contact.stiffness": ("Crush stiffness", "N/m", 2e5, 1e7),
    }
    """Label, SI unit and ends of each slider, by key of the scene."""

    REPLACED = {
        "start.corner_speed": "impact.speed",
        "start.angle": "impact.angle",
        "start.omega": "impact.restitution",
        "contact.friction": "impact.friction",
        "contact.restitution": "impact.restitution",
    }
    """Keys of a scene, and those that have no effect beside them."""

    DEFAULT_UNITS = {"rad": "deg", "N/m": "MN/m"}
    """Units of sliders whose number has no unit in the scene."""

    STEPS = 50
    """Least number of steps of a slider."""

    NARROW = 400.0
    """Width of a chart in a narrow window [pixels]."""

    DARK = (Path(postprocess.__path__[0]) / "templates" / "dark.css").read_text(encoding="utf-8")
    """Colours of charts on dark screens."""

    STYLE = """<style>
    .sliders { display: grid; grid-template-columns: repeat(auto-fill, minmax(19rem, 1fr)); gap: 0.2rem 2rem; }
    .found { display: grid; grid-template-columns: 3fr 2fr; gap: 0.3rem 2rem; align-items: start; }
    .found > div:first-child { display: contents; }
    .found p, .found .force { grid-column: 1 / -1; }
    .found p { margin: 0; }
    .found p:first-child { font-size: 1.15rem; font-weight: 600; }
    .found .force { order: 1; }
    .found .set-up { order: 2; grid-row: span 3; }
    .found table { order: 3; font-size: 0.85rem; overflow-x: auto; }
    .found th, .found td { padding: 0.15rem 0.8rem 0.15rem 0; text-align: left; }
    .found td:first-child { white-space: nowrap; }
    .found caption { text-align: left; font-weight: 600; }
    .found svg { max-width: 100%; height: auto; overflow: visible; }
    .narrow { display: none; }
    @media (max-width: 700px) {
      .found { display: flex; flex-direction: column; }
      .wide { display: none; }
      .narrow { display: block; }
    }
    .found .paper { fill: none; }
    .found .halo { stroke: var(--background); }
    @media (prefers-color-scheme: dark) { DARK }
    </style>""".replace("DARK", DARK)


@app.function
def slider(key: str, quantity: str | float) -> tuple[mo.ui.slider, float, str]:
    """Return the slider of a key, its value and its unit.

    The unit is that of the scene.
    """
    label, si, low, high = SLIDERS[key]
    match = units.NUMBER.fullmatch(quantity) if isinstance(quantity, str) else None
    unit = match[2] if match else DEFAULT_UNITS.get(si, si)
    factor = units.converted(1.0, si, unit) if si else 1.0
    value = float(match[1]) if match else factor * float(quantity)
    low, high = min(factor * low, value), max(factor * high, value)
    step = 10.0 ** math.floor(math.log10((high - low) / STEPS))
    even = (float(f"{step * k:.6g}") for k in range(math.ceil(low / step), math.floor(high / step) + 1))
    heading = f"{label} [{unit}]" if unit else label
    element = mo.ui.slider(
        steps=sorted({*even, value}), value=value, label=heading, include_input=True, full_width=True
    )
    return element, value, unit


@app.function
def drawn(chart: Chart) -> str:
    """Return a chart in two widths, of which the window shows one."""
    narrow = replace(chart, width=NARROW)
    return f'<div class="{chart.name}"><div class="wide">{chart.svg}</div><div class="narrow">{narrow.svg}</div></div>'


@app.cell
def _():
    first = mo.query_params().get("scene", "mash-tl4-sut")
    shipped = mo.ui.dropdown(list(dict.fromkeys([first, *tailslap.scenes()])), first, label="Scene")
    opened = mo.ui.file(filetypes=[".toml"], max_size=read.MAX_BYTES, label="Open a scene file")
    mo.hstack([shipped, opened], justify="start", align="center", wrap=True, gap=1.0)
    return opened, shipped


@app.cell
def _(opened, shipped):
    try:
        text = opened.contents().decode("utf-8") if opened.value else read.scene_text(shipped.value)
        tables = read.read_source(opened.name() or shipped.value, text).tables
    except (tailslap.InputError, UnicodeDecodeError) as wrong:
        mo.stop(True, mo.callout(str(wrong), "danger"))
    return tables, text


@app.cell
def _(tables):
    replaced = {old for new, old in REPLACED.items() if value_in(tables, new) is not None}
    values = {key: value_in(tables, key) for key in SLIDERS if key not in replaced}
    elements = {key: slider(key, value) for key, value in values.items() if value is not None}
    sliders = mo.ui.dictionary({key: element for key, (element, _, _) in elements.items()})
    mo.Html(STYLE + f'<div class="sliders">{"".join(f"<div>{sliders[key]}</div>" for key in elements)}</div>')
    return elements, sliders


@app.cell
def _(elements, sliders, tables):
    changed = {key: value for key, value in sliders.value.items() if value != elements[key][1]}
    unit_of = {key: unit for key, (_, _, unit) in elements.items()}
    changes = {
        key: f"{value:.10g} {unit_of[key]}" if unit_of[key] else value for key, value in changed.items()
    }
    try:
        rigid = tailslap.rigid(tables, changes, band=False)
    except tailslap.InputError as wrong:
        mo.stop(True, mo.callout(str(wrong), "danger"))
    mo.Html(f'<div class="found">{rigid._repr_html_()}{"".join(map(drawn, rigid.charts.values()))}</div>')
    return changes, rigid


@app.cell
def _(changes, rigid, text):
    scene = tomlkit.parse(text)
    for dotted, chosen in changes.items():
        table, _, name = dotted.partition(".")
        scene[table][name] = chosen
    saved = tomlkit.dumps(scene).encode("utf-8")
    button = mo.ui.run_button(label="Run the finite elements")
    mo.hstack(
        [button, mo.download(saved, f"{rigid.scene}.toml", label="Save the scene")],
        justify="start",
        wrap=True,
    )
    return (button,)


@app.cell
def _(changes, rigid, tables):
    assert rigid, "force and saved scene come first; the band takes longer"
    banded = tailslap.rigid(tables, changes).headline
    mo.md(f"**With its band:** {banded.answer} {banded.band}")
    return


@app.cell
def _(button, changes, tables):
    mo.stop(not button.value)
    with mo.status.spinner("Finite elements ...") as spinner, tempfile.TemporaryDirectory() as place:
        last = [0.0]

        def follow(line: str) -> None:
            if time.monotonic() - last[0] > 0.2:
                last[0] = time.monotonic()
                spinner.update(subtitle=line)

        try:
            with progress.followed(follow):
                result = tailslap.run(tables, changes)
            spinner.update("Pictures ...")
            page = (result.save(Path(place) / "result") / "report.html").read_text(encoding="utf-8")
        except tailslap.InputError as wrong:
            mo.stop(True, mo.callout(str(wrong), "danger"))
    mo.vstack([mo.Html(f'<div class="found">{result._repr_html_()}</div>'), mo.iframe(page, height="85vh")])
    return


if __name__ == "__main__":
    app.run()
