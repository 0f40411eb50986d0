"""Images in memory: labels that a body is made of, and what is warped."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Mapping, Optional, Protocol, Sequence, Tuple, Union, runtime_checkable

import numpy as np
import numpy.typing as npt

from . import _core

Rows = Tuple[Tuple[float, float, float, float], ...]

_TYPES = (np.uint8, np.uint16, np.int16, np.int32, np.int64)


@runtime_checkable
class SpatialImage(Protocol):
    """What a nibabel image has: values along i, j, k, and the affine to millimetres."""

    @property
    def affine(self) -> Any: ...

    @property
    def dataobj(self) -> Any: ...


def metres(affine: npt.ArrayLike, unit: str = "mm") -> Rows:
    """An affine's rows in metres. ``unit`` is that of its lengths: mm, cm or m."""
    scale = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}.get(unit)
    if scale is None:
        raise ValueError(f'expected unit = "mm", "cm" or "m", found {unit!r}')
    rows = np.array(affine, dtype=np.float64)
    if rows.shape != (4, 4) or not np.isfinite(rows).all():
        raise ValueError("expected an affine of 4 x 4 finite numbers")
    rows[:3] *= scale
    return tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in rows)


def labels_of(array: npt.ArrayLike) -> npt.NDArray[Any]:
    """Labels as the module takes them: three axes, one of five types, this machine's byte order.

    Strides may be any; only what has another type or byte order is copied.
    """
    if isinstance(array, np.ma.MaskedArray) and bool(np.any(np.ma.getmaskarray(array))):  # type: ignore[no-untyped-call]
        raise TypeError("expected labels without a mask, found masked voxels: fill them, as by array.filled(0)")
    values = np.asarray(array)
    if values.ndim == 4 and values.shape[3] == 1:
        values = values[..., 0]
    if values.ndim == 2:
        values = values[:, :, np.newaxis]
    if values.ndim != 3 or values.size == 0:
        raise TypeError(f"expected labels along two or three axes, found an array of shape {values.shape}")
    if values.dtype == np.bool_:
        values = values.view(np.uint8)
    if values.dtype.kind == "f":
        with np.errstate(invalid="ignore"):  # what is no number is told below
            whole = values.astype(np.int32)
        if not np.array_equal(whole, values):
            raise TypeError("expected labels, whole numbers, found others")
        values = whole
    if values.dtype.kind not in "iu":
        raise TypeError(f"expected labels, whole numbers, found an array of {values.dtype}")
    if values.dtype.kind == "u" and values.dtype.itemsize > 2:
        if values.size and int(values.max()) > np.iinfo(np.int64).max:
            raise TypeError("expected labels up to 2^24, found larger ones")
        values = values.astype(np.int64)
    elif values.dtype == np.int8:
        values = values.astype(np.int16)
    elif not values.dtype.isnative:
        values = values.astype(values.dtype.newbyteorder("="))
    if any(stride % values.dtype.itemsize for stride in values.strides):
        values = np.ascontiguousarray(values)
    assert values.dtype in _TYPES
    return values


@dataclass(frozen=True)
class Image:
    """Voxels of labels, and where they are: what a body is made of.

    Args:
        array: along i, j, k, as nibabel has it; any strides, byte order and type of whole numbers (float too)
        affine: 4 x 4, from indices of voxels to their middles, in ``unit`` (millimetres unless told otherwise);
            columns perpendicular; its world is right, anterior, superior, as nibabel's. Without one, ``spacing`` says how far voxels are apart:
            "1 mm" (default), three such, or numbers in a ``unit`` that is given; else they agree
        labels: which label is which material: a name of the library or a table of constants. Without it,
            ``material`` is that of every voxel that is not 0
        fibre: how fibres run, as ``fibre`` of scene files: a direction, or a mapping
        coarsen: voxels that one cell has along each axis: a number, or three
        keys: further keys of ``[specimen]``, such as ``{"partial_volume": True}``
    """

    array: Any
    affine: Optional[Any] = None
    labels: Optional[Mapping[int, Any]] = None
    material: Optional[Any] = None
    spacing: Optional[Union[float, str, Sequence[Union[float, str]]]] = None
    unit: Optional[str] = None
    fibre: Optional[Any] = None
    coarsen: Union[int, Tuple[int, int, int]] = 1
    keys: Mapping[str, Any] = field(default_factory=dict)

    def rows(self) -> Rows:
        """The affine in metres.

        Raises:
            ValueError: a spacing without a unit, or one that contradicts the affine
        """
        spacing = "1 mm" if self.spacing is None else self.spacing
        given = [spacing] * 3 if isinstance(spacing, (int, float, str)) else list(spacing)
        if self.affine is None:
            return metres(np.diag([*(self._metres(step, self.unit) for step in given), 1.0]), "m")
        rows = metres(self.affine, self.unit or "mm")
        own = np.linalg.norm(np.array(rows)[:3, :3], axis=0)
        if self.spacing is not None and not np.allclose(own, [self._metres(step, self.unit or "mm") for step in given], rtol=1e-5, atol=0):
            raise ValueError(f"spacing: expected that of the affine, {', '.join(f'{1e3 * step:.6g}' for step in own)} mm, or none, found {self.spacing!r}")
        return rows

    def _metres(self, step: Union[float, str], unit: Optional[str]) -> float:
        if not isinstance(step, str) and unit is not None:
            return metres(np.diag([float(step)] * 3 + [1.0]), unit)[0][0]
        length = _core.length(step) if isinstance(step, str) else None
        if length is None:
            raise ValueError(f'spacing: expected a length such as "1 mm", or a number and unit=, found {step!r}')
        return length

    def voxels(self) -> npt.NDArray[Any]:
        """The labels along i, j, k."""
        return labels_of(self.array)

    def table(self) -> dict[str, Any]:
        """The ``[specimen]`` of a scene file, without ``shape`` and ``image``."""
        table: dict[str, Any] = {}
        if self.labels is not None:
            table["labels"] = {str(label): material for label, material in self.labels.items()}
        if self.material is not None:
            table["material"] = self.material
        if self.fibre is not None:
            table["fibre"] = self.fibre
        if self.coarsen != 1:
            table["coarsen"] = self.coarsen if isinstance(self.coarsen, int) else list(self.coarsen)
        table.update(self.keys)
        return table


def are_labels(values: npt.NDArray[Any]) -> bool:
    """Whether an image is one of labels: whole numbers, of at most 255 values, as for bodies that are read."""
    return values.dtype.kind in "biu" and np.unique(values).size <= 256
