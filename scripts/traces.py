"""Reads traces and finds where they turn; for scripts/swings and scripts/sampling."""
import csv


def read_trace(path):
    """Columns by name, the first one the abscissa."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = list(zip(*([float(cell) for cell in row] for row in rows)))
    return dict(zip(names, columns or [()] * len(names)))


def turning_points(values, size):
    """Positions of the greatest and least values between swings, a swing being a way up or down of more than `size`."""
    found = []
    high = low = direction = 0
    for i, value in enumerate(values):
        if direction >= 0 and value > values[high]:
            high = i
        if direction <= 0 and value < values[low]:
            low = i
        if direction >= 0 and values[high] - value > size:
            found += [high] if direction else []
            low, direction = i, -1
        elif direction <= 0 and value - values[low] > size:
            found += [low] if direction else []
            high, direction = i, 1
    return found
