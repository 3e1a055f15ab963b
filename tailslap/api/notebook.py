"""A result in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from postprocess.report.table import Table


def result_html(headline: str, text: str, tables: Mapping[str, Table]) -> str:
    """The headline and the tables as HTML without style of its own; without either, the text."""
    said = f"<p><b>{escape(headline)}</b></p>" if headline else ""
    shown = "".join(_table(name, table) for name, table in tables.items())
    return f"<div>{said}{shown}{'' if said or shown else f'<pre>{escape(text)}</pre>'}</div>"


def _table(title: str, table: Table) -> str:
    headed = any(column.label for column in table.columns)
    head = "".join(f"<th>{escape(column.heading)}</th>" for column in table.columns)
    body = "".join(f"<tr>{_row(table, row)}</tr>" for row in table.rows)
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    return (
        f"<table>{caption}{f'<thead><tr>{head}</tr></thead>' if headed else ''}<tbody>{body}</tbody></table>"
    )


def _row(table: Table, row: Any) -> str:
    return "".join(f"<td>{escape(column.text(row))}</td>" for column in table.columns)
