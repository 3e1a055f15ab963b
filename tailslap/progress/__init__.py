"""Signs of life on standard error: on a terminal a line that moves, for what takes over a second.

One line at a time: what runs within something that shows its progress is silent. The environment variable
`mode.MODE` says how: "auto"; "lines", from time to time a line also where standard error is no terminal; or "none".
"""

from tailslap.progress.bar import clock, counted, progress_bar
from tailslap.progress.mode import shown_as
from tailslap.progress.terminal import announced, compiling

__all__ = ["announced", "clock", "compiling", "counted", "progress_bar", "shown_as"]
