"""Opens a .vtp with VTK and compares it with a CSV of the same frame.

Usage: check_vtp.py FRAME.vtp POINTS.csv
The CSV has the columns fiber, x, y, z, radius, tension. Prints the largest differences; fails where
one is not zero: both files hold all bits.
"""

import csv
import sys

import vtk
from vtk.util.numpy_support import vtk_to_numpy


def main(path, table):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    assert reader.GetErrorCode() == 0, "VTK reports an error"

    with open(table, newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    points = vtk_to_numpy(data.GetPoints().GetData())
    assert points.dtype == "float64", points.dtype
    assert len(points) == len(rows), (len(points), len(rows))

    worst = {"position": max(abs(points[i][k] - r[c]) for i, r in enumerate(rows) for k, c in enumerate("xyz"))}
    for name in ("radius", "tension"):
        column = vtk_to_numpy(data.GetPointData().GetArray(name))
        worst[name] = max(abs(column[i] - r[name]) for i, r in enumerate(rows))
    for name in ("velocity", "curvature", "force", "d1", "d2", "d3"):
        array = data.GetPointData().GetArray(name)
        assert array is not None and array.GetNumberOfComponents() == 3, name
        assert array.GetNumberOfTuples() == len(rows), name

    fibers = vtk_to_numpy(data.GetCellData().GetArray("fiber"))
    assert data.GetNumberOfLines() == len(fibers) == len({r["fiber"] for r in rows})
    for cell, fiber in enumerate(fibers):
        ids = data.GetCell(cell).GetPointIds()
        mine = [ids.GetId(i) for i in range(ids.GetNumberOfIds())]
        assert mine == [i for i, r in enumerate(rows) if r["fiber"] == fiber], f"line {cell}"
    time = data.GetFieldData().GetArray("TimeValue")
    assert time is not None and time.GetNumberOfTuples() == 1, "no time"

    print(f"{path}: {len(rows)} points, {len(fibers)} lines, t = {time.GetValue(0)} s, largest differences {worst}")
    assert all(value == 0 for value in worst.values()), worst


if __name__ == "__main__":
    main(*sys.argv[1:3])
