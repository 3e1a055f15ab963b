"""Compiled interpolation between the rows of a motion."""

from machine_code.compiled import compiled


@compiled
def interpolate(rows, interval, end, integrals, rates, times, values, count):
    """Fill the values at instants from the rows of a motion.

    rows: at even instants, `interval` apart up to the end [s]; times, values: of `count` instants, values of shape
    (instants, columns). Columns `integrals` are cubic with the rates in the columns `rates`, the others linear.
    """
    last = last_interval(interval, end)
    for k in range(count):
        place = times[k] / interval
        j = min(int(place), last)
        u = place - float(j)
        before, after = rows[j], rows[j + 1]
        for c in range(values.shape[1]):
            values[k, c] = before[c] + u * (after[c] - before[c])
        for c in range(integrals.size):
            i, rate = integrals[c], rates[c]
            secant = after[i] - before[i]
            one, two = before[rate] * interval - secant, after[rate] * interval - secant
            values[k, i] += u * (1.0 - u) * ((1.0 - u) * one - u * two)


@compiled
def last_interval(interval, end):
    """Return the number of the interval between rows that contains the end."""
    place = end / interval * (1.0 - 1e-12)
    whole = int(place)
    return max(whole if place > float(whole) else whole - 1, 0)
