"""The program from Python: functions that do what the commands do, by the same code, and what they return.

`import tailslap` offers them; a function's module, and with it NumPy and the rest, is loaded when it is asked for.
"""
