"""Answers as VTK has them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ._answer import Answer


_HIDDEN = 32  # vtkDataSetAttributes.HIDDENCELL


def image_data(answer: "Answer", unit: str = "m") -> Any:
    """See Answer.to_vtk. Vectors and tensors are turned into the world's frame, as in files for viewers."""
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk  # type: ignore[import]
        from vtkmodules.vtkCommonCore import vtkStringArray  # type: ignore[import]
        from vtkmodules.vtkCommonDataModel import vtkImageData  # type: ignore[import]
        from vtkmodules.vtkCommonMath import vtkMatrix3x3  # type: ignore[import]
    except ImportError as error:
        raise ImportError("to_vtk needs VTK for Python: apt install python3-vtk9, or pip install vtk") from error
    scale = {"m": 1.0, "mm": 1e3}.get(unit)
    if scale is None:
        raise ValueError(f'expected unit = "m" or "mm", found {unit!r}')
    core = answer._core.scene
    rows = np.array(core.node_affine)
    spacing = np.array(core.spacing)
    direction = rows[:3, :3] / spacing
    grid = vtkImageData()
    grid.SetDimensions(*core.nodes)
    grid.SetSpacing(*(scale * spacing))
    grid.SetOrigin(*(scale * rows[:3, 3]))
    matrix = vtkMatrix3x3()
    for row in range(3):
        for column in range(3):
            matrix.SetElement(row, column, direction[row, column])
    grid.SetDirectionMatrix(matrix)

    def add(data: Any, name: str, values: Any) -> None:
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        data.AddArray(array)

    u = answer.displacement
    vectors = np.zeros((u[..., 0].size, 3))
    vectors[:, : u.shape[-1]] = u.reshape(-1, u.shape[-1])
    add(grid.GetPointData(), "Displacement", scale * (vectors @ direction.T))
    cells = grid.GetCellData()
    material = core.material_id.reshape(-1)
    add(cells, "MaterialId", material)
    add(cells, "vtkGhostType", np.where(material == 255, _HIDDEN, 0).astype(np.uint8))
    if core.labels is not None:
        add(cells, "Label", core.labels.reshape(-1))
    add(cells, "Strain", _turned(answer.strain.reshape(-1, 6), direction))
    if answer._core.has_stress:
        add(cells, "Stress", _turned(answer.stress.reshape(-1, 6), direction))
        add(cells, "VonMises", answer.von_mises.reshape(-1))
    units = vtkStringArray()
    units.SetName("Units")
    units.InsertNextValue(f"{unit}, Pa")
    grid.GetFieldData().AddArray(units)
    return grid


def _turned(tensors: Any, direction: Any) -> Any:
    """R T R^T of symmetric tensors XX YY ZZ XY YZ XZ."""
    place = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    full = np.empty((tensors.shape[0], 3, 3))
    for n, (a, b) in enumerate(place):
        full[:, a, b] = full[:, b, a] = tensors[:, n]
    turned = direction @ full @ direction.T
    return np.stack([turned[:, a, b] for a, b in place], axis=1)
