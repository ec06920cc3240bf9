"""Parts as STEP files and points of their faces with outward normals, by Open CASCADE.

    pip install "cadquery-ocp-novtk<7.9" numpy
    python generate.py FOLDER

Written files are the golden data of `truing import step`. Points and normals come from Open
CASCADE's own evaluation of the shapes that were written; lengths in mm.
"""

import sys
from pathlib import Path

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_NurbsConvert,
    BRepBuilderAPI_Transform,
)
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.Geom import Geom_BSplineSurface
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Controller, STEPControl_Reader, STEPControl_Writer
from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound

from OCP.TColgp import TColgp_Array2OfPnt as Points
from OCP.TColStd import TColStd_Array1OfInteger as Integers
from OCP.TColStd import TColStd_Array1OfReal as Reals

FOLDER = Path(sys.argv[1])
PLACES = 5  # points along u and along v of every face


def array(kind, values):
    made = kind(1, len(values))
    for n, value in enumerate(values, 1):
        made.SetValue(n, value)
    return made


def freeform(rows, columns, size, height):
    """A bicubic B-spline over uneven knots."""
    points = Points(1, rows, 1, columns)
    for i in range(rows):
        for j in range(columns):
            x, y = (i / (rows - 1) - 0.5) * size, (j / (columns - 1) - 0.5) * 0.8 * size
            z = height * (np.sin(1.3 * i) * 0.4 + 0.02 * i * j - 0.5 * np.cos(0.9 * j))
            points.SetValue(i + 1, j + 1, gp_Pnt(x, y, z))
    knots, counts = [], []
    for count in (rows, columns):
        spans = count - 3
        inner = [n + 0.3 * np.sin(n) for n in range(1, spans)]
        knots.append(array(Reals, [0.0, *inner, float(spans)]))
        counts.append(array(Integers, [4] + [1] * (spans - 1) + [4]))
    return Geom_BSplineSurface(points, knots[0], knots[1], counts[0], counts[1], 3, 3, False, False)


def faces(shape):
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        current = explorer.Current()
        yield TopoDS.Face_s(current)
        explorer.Next()


def write(name, shape, unit="MM"):
    STEPControl_Controller.Init_s()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_AsIs)
    writer.Write(str(FOLDER / f"{name}.step"))


def golden(name, shape):
    """Points inside of every face's range of parameters, with the normal out of the part."""
    with open(FOLDER / f"{name}.csv", "w") as table:
        table.write("face,x_mm,y_mm,z_mm,nx,ny,nz\n")
        for number, face in enumerate(faces(shape), 1):
            surface = BRepAdaptor_Surface(face)
            sign = -1 if face.Orientation() == TopAbs_REVERSED else 1
            u = np.linspace(surface.FirstUParameter(), surface.LastUParameter(), PLACES + 2)[1:-1]
            v = np.linspace(surface.FirstVParameter(), surface.LastVParameter(), PLACES + 2)[1:-1]
            for a in u:
                for b in v:
                    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
                    surface.D1(a, b, point, du, dv)
                    n = du.Crossed(dv).Normalized() * sign
                    row = [point.X(), point.Y(), point.Z(), n.X(), n.Y(), n.Z()]
                    table.write(f"{number}," + ",".join(repr(float(q)) for q in row) + "\n")


def turned(shape):
    """Off the axes, so that no coordinate is round by luck."""
    turn = gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(0.2, -0.3, 1)), 0.4)
    return BRepBuilderAPI_Transform(shape, turn, True).Shape()


def block(size):
    """A solid whose top and bottom are freeform; one of the two is reversed."""
    face = BRepBuilderAPI_MakeFace(freeform(8, 7, size, 0.05 * size), 1e-6).Face()
    return BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, -0.25 * size)).Shape()


def read(name):
    """A part as Open CASCADE reads it, in mm."""
    reader = STEPControl_Reader()
    reader.ReadFile(str(FOLDER / f"{name}.step"))
    reader.TransferRoots()
    return reader.OneShape()


block_ = turned(block(80.0))
write("block", block_)
golden("block", block_)

# The writer takes the numbers of the shape for inches.
write("inch", block(3.0), "INCH")
golden("inch", read("inch"))

cylinder = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(5, 0, 0), gp_Dir(0.1, 0.2, 1)), 25.0, 40.0, np.pi / 2).Shape()
cylinder = BRepBuilderAPI_NurbsConvert(cylinder, True).Shape()
write("quarter-cylinder", cylinder)
golden("quarter-cylinder", cylinder)

sphere = BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeSphere(gp_Pnt(1, 2, 3), 12.5, np.pi / 2).Shape(), True).Shape()
write("sphere", sphere)
golden("sphere", sphere)

# A box with a spherical hollow, a hole and a torus' groove: every analytic face, outside and inside.
part = BRepPrimAPI_MakeBox(gp_Pnt(-30, -30, -20), gp_Pnt(30, 30, 0)).Shape()
part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeSphere(gp_Pnt(-10, -10, 4), 10.0).Shape()).Shape()
part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(18, 18, -30), gp_Dir(0, 0, 1)), 5.0, 60.0).Shape()).Shape()
part = BRepAlgoAPI_Cut(part, BRepPrimAPI_MakeTorus(gp_Ax2(gp_Pnt(10, -12, 0), gp_Dir(0, 0, 1)), 8.0, 2.0).Shape()).Shape()
write("analytic", part)
golden("analytic", part)

# A closed cavity: its shell is used turned over.
cavity = BRepAlgoAPI_Cut(
    BRepPrimAPI_MakeSphere(gp_Pnt(0, 0, 0), 30.0).Shape(),
    BRepPrimAPI_MakeSphere(gp_Pnt(5, 0, 0), 10.0).Shape(),
).Shape()
write("cavity", cavity)
golden("cavity", cavity)

# Two placed instances of one part.
box = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape()
compound, builder = TopoDS_Compound(), BRep_Builder()
builder.MakeCompound(compound)
for shift in (0.0, 100.0):
    move = gp_Trsf()
    move.SetTranslation(gp_Vec(shift, 0, 0))
    builder.Add(compound, box.Moved(TopLoc_Location(move)))
Interface_Static.SetIVal_s("write.step.assembly", 1)
write("assembly", compound)
