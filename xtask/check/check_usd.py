"""Opens a .usda with usd-core and compares one of its frames with a CSV of the same frame.

Usage: check_usd.py SERIES.usda TIME_CODE POINTS.csv
The CSV has the columns fiber, x, y, z, radius. USD does not notice a wrong curveVertexCounts nor a
missing extent, so both are checked here. Points are in single precision: relative difference 2^-24.
"""

import csv
import math
import sys

from pxr import Usd, UsdGeom, UsdValidation


def main(path, code, table):
    with open(table, newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    stage = Usd.Stage.Open(path)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1 and UsdGeom.GetStageUpAxis(stage) == "Z"
    assert stage.GetDefaultPrim().IsValid(), "no default prim"
    prims = [p for p in stage.Traverse() if p.IsA(UsdGeom.BasisCurves)]
    assert len(prims) == 1, prims
    curves = UsdGeom.BasisCurves(prims[0])

    counts = list(curves.GetCurveVertexCountsAttr().Get())
    fibers = sorted({r["fiber"] for r in rows})
    assert counts == [sum(r["fiber"] == f for r in rows) for f in fibers], "curveVertexCounts"
    samples = curves.GetPointsAttr().GetTimeSamples()
    assert samples == curves.GetExtentAttr().GetTimeSamples(), "a sample without extent"
    assert samples[0] == stage.GetStartTimeCode() and samples[-1] == stage.GetEndTimeCode()
    assert all(len(curves.GetPointsAttr().Get(s)) == sum(counts) for s in samples)

    points = curves.GetPointsAttr().Get(float(code))
    size = max(abs(r[c]) for r in rows for c in "xyz")
    worst = max(abs(points[i][k] - r[c]) for i, r in enumerate(rows) for k, c in enumerate("xyz"))
    assert worst <= 2**-24 * size, worst
    widths = curves.GetWidthsAttr().Get()
    assert len(widths) == {"constant": 1, "vertex": sum(counts)}[curves.GetWidthsInterpolation()]
    for i, r in enumerate(rows):
        assert math.isclose(widths[i % len(widths)], 2 * r["radius"], rel_tol=2**-23), i
    low, high = curves.GetExtentAttr().Get(float(code))
    for i in range(len(rows)):
        assert all(low[k] < points[i][k] < high[k] for k in range(3)), f"point {i} outside of the extent"

    errors = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(stage)
    assert not errors, [e.GetMessage() for e in errors]
    print(f"{path}: {len(samples)} samples of {len(rows)} points in {len(counts)} curves at "
          f"{stage.GetTimeCodesPerSecond()} per second, largest difference {worst:.2e} m")


if __name__ == "__main__":
    main(*sys.argv[1:4])
