"""Loads a scene with Mitsuba, compares its curves with a CSV of the same frame, and renders it.

Usage: check_mitsuba.py SCENE.xml POINTS.csv PICTURE.png
The CSV has the columns fiber, x, y, z, radius, in metres. Curves are B-splines in millimetres that
pass through the points; their control points are in single precision: relative difference 2^-24.
"""

import csv
import sys

import mitsuba as mi


def main(path, table, picture):
    with open(table, newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    mi.set_variant("scalar_rgb")
    scene = mi.load_file(path, spp=16)
    values = {name.split(".", 1)[-1]: value for name, value in mi.traverse(scene)}
    controls = list(values["control_points"])
    fibers = sorted({r["fiber"] for r in rows})
    assert values["control_point_count"] == len(rows) + 2 * len(fibers), "control points"
    size = max(abs(x) for x in controls)
    first, last, worst = 0, None, 0.0
    for r in rows:
        # Every fiber has one control point more at either end.
        first += 2 if last not in (None, r["fiber"]) else 0
        last = r["fiber"]
        for k, name in enumerate(["x", "y", "z", "radius"]):
            a, b, c = (controls[4 * (first + i) + k] for i in range(3))
            worst = max(worst, abs((a + 4 * b + c) / 6 - 1e3 * r[name]))
        first += 1
    assert worst <= 2**-24 * size, worst
    image = mi.render(scene)
    pixels = list(image.array)
    assert all(0 <= x < float("inf") for x in pixels), "a pixel is no number"
    assert min(pixels) < 0.5 * max(pixels), "nothing is to be seen"
    mi.util.write_bitmap(picture, image)
    print(f"{path}: {len(fibers)} curves through {len(rows)} points, largest difference {worst:.2e} mm")


if __name__ == "__main__":
    main(*sys.argv[1:4])
