"""Reads traces and finds where they turn; for scripts/swings and scripts/sampling."""
import csv


def read_trace(path):
    """Columns by name, the first one the abscissa."""
    with open(path, newline="", encoding="utf-8") as file:
        names = next(csv.reader(file))  # the only row with quotes
        cells = file.read().replace("\n", ",").split(",")
    if cells[-1] == "":
        cells.pop()
    return {name: [float(cell) for cell in cells[k::len(names)]] for k, name in enumerate(names)}


def turning_points(values, size):
    """Positions of the greatest and least values between swings, a swing being a way up or down of more than `size`."""
    found = []
    high = low = direction = 0
    highest = lowest = values[0] if values else 0.0
    for i, value in enumerate(values):
        if value > highest:
            high, highest = i, value
        elif value < lowest:
            low, lowest = i, value
        if direction >= 0 and highest - value > size:
            found += [high] if direction else []
            low, lowest, direction = i, value, -1
        elif direction <= 0 and value - lowest > size:
            found += [low] if direction else []
            high, highest, direction = i, value, 1
    return found
