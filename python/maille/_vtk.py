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

    answer = answer.in_frame("world")
    u = answer.displacement
    vectors = np.zeros((u[..., 0].size, 3))
    vectors[:, : u.shape[-1]] = u.reshape(-1, u.shape[-1])
    add(grid.GetPointData(), "Displacement", scale * vectors)
    cells = grid.GetCellData()
    material = core.material_id.reshape(-1)
    add(cells, "MaterialId", material)
    add(cells, "vtkGhostType", np.where(material == 255, _HIDDEN, 0).astype(np.uint8))
    has_stress = answer._core.has_stress
    fields = {"Label": answer.label, "FiberDirection": answer.fibre_direction, "Strain": answer.strain,
              "PrincipalStrain": answer.principal_strain, "FiberStrain": answer.fibre_strain,
              "Stress": answer.stress if has_stress else None, "VonMises": answer.von_mises if has_stress else None,
              "FiberStress": answer.fibre_stress if has_stress else None}
    for name, values in fields.items():
        if values is not None:
            add(cells, name, values.reshape(material.size, -1) if values.size > material.size else values.reshape(-1))
    units = vtkStringArray()
    units.SetName("Units")
    units.InsertNextValue(f"{unit}, Pa")
    grid.GetFieldData().AddArray(units)
    return grid

