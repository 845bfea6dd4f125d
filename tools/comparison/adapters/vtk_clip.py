"""Breaks a mesh by vtkClipClosedSurface: clips it by the bisectors of each Voronoi cell, and caps the cuts."""
import sys
import time

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy


def read_parts(path):
    data = open(path, "rb").read()
    count, = np.frombuffer(data, "<u4", 1)
    offset, parts = 4, []
    for _ in range(count):
        vertices, triangles = (int(n) for n in np.frombuffer(data, "<u4", 2, offset))
        offset += 8
        points = np.frombuffer(data, "<f8", 3 * vertices, offset).reshape(-1, 3)
        offset += 24 * vertices
        faces = np.frombuffer(data, "<u4", 3 * triangles, offset).reshape(-1, 3)
        offset += 12 * triangles
        parts.append((points, faces))
    return parts


def write_parts(path, parts):
    with open(path, "wb") as file:
        file.write(np.array([len(parts)], "<u4").tobytes())
        for points, faces in parts:
            file.write(np.array([len(points), len(faces)], "<u4").tobytes())
            file.write(points.astype("<f8").tobytes() + faces.astype("<u4").tobytes())


def poly_data(points, faces):
    result, vtk_points, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(points, np.float64), deep=True))
    fours = np.hstack([np.full((len(faces), 1), 3), faces]).astype(np.int64).ravel()
    cells.SetCells(len(faces), numpy_to_vtkIdTypeArray(fours, deep=True))
    result.SetPoints(vtk_points)
    result.SetPolys(cells)
    return result


def bisectors(index, cell, sites):
    """The planes between a site and those that share a face with it; the faces of the box are outside the mesh."""
    points, faces = cell
    planes = vtk.vtkPlaneCollection()
    if len(points) == 0:
        return None
    a, b, c = (points[faces[:, k]] for k in range(3))
    size = np.ptp(points, axis=0).max()
    a, b, c = (p[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12 * size * size] for p in (a, b, c))
    neighbours = set()
    for centroid in (a + b + c) / 3:
        distances = np.linalg.norm(sites - centroid, axis=1)
        own, distances[index] = distances[index], np.inf
        if abs(distances.min() - own) < 1e-9 * size:
            neighbours.add(int(distances.argmin()))
    for neighbour in sorted(neighbours):
        plane = vtk.vtkPlane()
        plane.SetOrigin(*((sites[index] + sites[neighbour]) / 2))
        plane.SetNormal(*(sites[index] - sites[neighbour]))  # vtkClipClosedSurface keeps the side of the normal
        planes.AddItem(plane)
    return planes


def islands(surface):
    """The connected parts, each with the cavities within it."""
    label = vtk.vtkPolyDataConnectivityFilter()
    label.SetInputData(surface)
    label.SetExtractionModeToAllRegions()
    label.ColorRegionsOn()
    label.Update()
    output = label.GetOutput()
    points = vtk_to_numpy(output.GetPoints().GetData()).astype(np.float64)
    faces = vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    regions = vtk_to_numpy(output.GetPointData().GetArray("RegionId"))[faces[:, 0]]
    solids, cavities = [], []
    for region in np.unique(regions):
        own = faces[regions == region]
        corners = points[own]
        volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        shell = (corners.reshape(-1, 3).min(0), corners.reshape(-1, 3).max(0), [own], volume)
        (solids if volume > 0 else cavities).append(shell)
    for low, high, own, _ in cavities:
        around = [s for s in solids if (s[0] <= low).all() and (s[1] >= high).all()]
        if around:
            min(around, key=lambda s: s[3])[2].extend(own)
    pieces = []
    for solid in solids:
        own = np.vstack(solid[2])
        used, numbers = np.unique(own, return_inverse=True)
        pieces.append((points[used], numbers.reshape(-1, 3)))
    return pieces


def break_mesh(mesh, cells):
    pieces = []
    for planes in cells:
        if planes is None:
            continue
        clip, triangles = vtk.vtkClipClosedSurface(), vtk.vtkTriangleFilter()
        clip.SetInputData(mesh)
        clip.SetClippingPlanes(planes)
        clip.SetScalarModeToNone()
        clip.GenerateFacesOn()
        triangles.SetInputConnection(clip.GetOutputPort())
        triangles.PassVertsOff()
        triangles.PassLinesOff()
        triangles.Update()
        if triangles.GetOutput().GetNumberOfPolys():
            pieces += islands(triangles.GetOutput())
    return pieces


def main():
    mesh_file, sites_file, cells_file, _ = sys.argv[1:]
    sites = np.loadtxt(sites_file, ndmin=2)
    cells = [bisectors(i, cell, sites) for i, cell in enumerate(read_parts(cells_file))]
    mesh = poly_data(*read_parts(mesh_file)[0])
    pieces = []
    print("ready VTK", vtk.vtkVersion.GetVTKVersion(), flush=True)
    for line in sys.stdin:
        word, _, rest = line.strip().partition(" ")
        try:
            if word == "run":
                start = time.perf_counter()
                pieces = break_mesh(mesh, cells)
                print("done", 1000 * (time.perf_counter() - start), len(pieces), flush=True)
            elif word == "write":
                write_parts(rest, pieces)
                print("written", flush=True)
        except Exception as error:
            print("failed", error, flush=True)


main()
