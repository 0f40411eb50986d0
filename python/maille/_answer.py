"""What a method answers."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._images import Image, Rows, SpatialImage, are_labels, labels_of, metres
from ._program import refuse_foreign
from ._progress import Progress, told

if TYPE_CHECKING:
    from ._scene import Scene

Record = Dict[str, Any]
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """How far an answer is from another: see ``compare``. None where one of the two has no such figure."""

    relative_l2: float  #: |u - r| / |r| over nodes that are neither held nor moved
    relative_max: float  #: largest |u - r| over largest |r|
    rms: float  #: root mean square of |u - r| [m]
    force: Optional[float]  #: of the reactions on moves (holds where there are none), relative
    strain_energy: Optional[float]  #: relative
    strain: Optional[float]  #: L2 over cells, away from edges of holds and moves, relative
    stress: Optional[float]  #: the same of stress


def axes_of(scene: _core.Scene, frame: str) -> Optional[Floats]:
    """The matrix from the grid's axes to those of ``frame``; None where they are the same."""
    if frame not in ("world", "grid"):
        raise ValueError(f'expected frame = "world" or "grid", found {frame!r}')
    axes = np.array(scene.direction)
    return None if frame == "grid" or np.array_equal(axes, np.eye(3)) else axes


def vectors_in(axes: Optional[Floats], vectors: Floats) -> Floats:
    """Vectors along the last axis; those of a plane get a third component where they are turned."""
    if axes is None:
        return vectors
    turned: Floats = vectors @ axes[:, : vectors.shape[-1]].T
    turned.flags.writeable = False
    return turned


_PLACE = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def _full(tensors: Floats) -> Floats:
    """3 x 3 matrices of symmetric tensors XX YY ZZ XY YZ XZ."""
    full = np.empty((*tensors.shape[:-1], 3, 3))
    for n, (a, b) in enumerate(_PLACE):
        full[..., a, b] = full[..., b, a] = tensors[..., n]
    return full


def _six(full: Floats) -> Floats:
    return np.stack([full[..., a, b] for a, b in _PLACE], axis=-1)


def _turned(tensors: Floats, axes: Any) -> Floats:
    return _six(axes @ _full(tensors) @ axes.T)


class Answer:
    """Displacement and what follows from it. Arrays cannot be written to.

    Vectors and tensors are in the world's frame, as in files and as forces are; with ``frame="grid"`` along the
    axes of the image, which are views without a copy, as are those in the world where both frames are the same.
    If an answer was refused or failed, ``message`` says why, and arrays raise ValueError.
    """

    def __init__(self, core: _core.Answer, scene: "Scene", frame: str = "world", fraction: float = 1.0) -> None:
        self.fraction = fraction  #: of the scene's moves and loads that it answers, see ``Series``
        self._core = core
        self._scene = scene
        self._frame = frame
        self._axes = axes_of(core.scene, frame)
        self._turned: Dict[str, Floats] = {}
        self._warnings: Optional[List[str]] = None
        self._mechanics: Optional[Dict[str, Any]] = None
        self._estimate: Optional[Dict[str, Any]] = None

    def __repr__(self) -> str:
        return f"<maille.Answer by {self.method}: {self.status} in {self.seconds:.3g} s>"

    def _repr_html_(self) -> str:
        from ._html import answer_html

        return answer_html(self)

    def __reduce__(self) -> Any:
        """Pickles: the scene is read anew where the answer is used."""
        return _restored, (self._scene, self._core.state(), self._frame, self.fraction)

    @property
    def scene(self) -> "Scene":
        """The question."""
        return self._scene

    @property
    def method(self) -> str:
        """``limits``, ``coupled``, ..."""
        return self._core.method

    @property
    def algorithm(self) -> str:
        """Which way the method took, in words."""
        return self._core.algorithm

    @property
    def status(self) -> str:
        """``done``, ``clamped``, ``budget_reached``, ``interrupted``, ``refused`` or ``failed``."""
        return self._core.status

    @property
    def is_converged(self) -> bool:
        """Whether it is the method's whole answer: done or clamped."""
        return self._core.is_converged

    @property
    def message(self) -> str:
        """Why it was clamped, refused or failed; else empty."""
        return self._core.message

    @property
    def warnings(self) -> List[str]:
        """What the command prints as warnings: of the question, and of the answer."""
        if self._warnings is None:
            self._warnings = self._core.warnings()
        return self._warnings

    @property
    def frame(self) -> str:
        """Of the arrays: ``world`` or ``grid``."""
        return self._frame

    def in_frame(self, frame: str) -> "Answer":
        """The same answer, with arrays in ``world`` or ``grid``."""
        return Answer(self._core, self._scene, frame, self.fraction)

    @property
    def seconds(self) -> float:
        """Wall-clock time of set-up and solve [s]."""
        return self._core.seconds

    @property
    def iterations(self) -> int:
        """Sweeps, iterations, or nodes settled; 0 for direct solvers."""
        return self._core.iterations

    @property
    def residual(self) -> float:
        """Estimated relative error of the algebra alone [1]; 0 where it is exact."""
        return self._core.residual

    @property
    def bytes(self) -> int:
        """Memory that the method held at its peak [bytes]."""
        return self._core.bytes

    @property
    def strain_energy(self) -> Optional[float]:
        """Elastic energy [J], in 2D [J/m]; None where the method knows none."""
        return self._core.strain_energy

    @property
    def displacement(self) -> Floats:
        """Displacement of every node [m]: array (nz, ny, nx, 3), of which x is fastest in memory and components slowest.

        In 2D (ny, nx, 2). Along the axes of ``frame``; 0 at grid points that are no nodes of the body. A view of the
        answer's own memory where those are the grid's: ``displacement.T`` is indexed [component, i, j, k].
        """
        return self._kept("displacement", lambda: vectors_in(self._axes, self._core.displacement))

    def _kept(self, name: str, make: Callable[[], Floats]) -> Floats:
        if name not in self._turned:
            array = make()
            if array.flags.writeable:
                array.flags.writeable = False
            if self._axes is None and array.base is not None:
                return array  # a view, which keeps the answer
            self._turned[name] = array
        return self._turned[name]

    def _tensors(self, name: str, tensors: Floats) -> Floats:
        if self._axes is None:
            return tensors
        return self._kept(name, lambda: _turned(tensors, self._axes))

    def _require_stress(self) -> None:
        if not self._core.has_stress:
            raise ValueError(f"expected a method that knows stress, such as coupled, found {self.method}, which keeps limits alone")

    @property
    def strain(self) -> Floats:
        """Mean strain of every cell [1]: array (cz, cy, cx, 6), XX YY ZZ XY YZ XZ, tensor shear; 0 without matter.

        Where moves turn the body, that of before it turned. Found on first use, about 1 us a cell.
        """
        return self._tensors("strain", self._core.strain)

    @property
    def stress(self) -> Floats:
        """Mean stress of every cell [Pa], as ``strain``.

        Raises:
            ValueError: a method without stress
        """
        self._require_stress()
        return self._tensors("stress", self._core.stress)

    @property
    def green_lagrange_strain(self) -> Floats:
        """(U^2 - I) / 2 of every cell, as ``strain``, which is U - I at finite strain."""
        strain = _full(self._core.strain)
        return self._tensors("green_lagrange", _six(strain + strain @ strain / 2))

    @property
    def logarithmic_strain(self) -> Floats:
        """ln U of every cell, as ``strain``."""
        values, axes = np.linalg.eigh(_full(self._core.strain))
        return self._tensors("logarithmic", _six((axes * np.log1p(values)[..., np.newaxis, :]) @ axes.swapaxes(-1, -2)))

    @property
    def nominal_stress(self) -> Floats:
        """Stress per area at rest, whose work is on U - I, of every cell [Pa], as ``stress``, which is Cauchy's."""
        self._require_stress()
        stretch = _full(self._core.strain) + np.eye(3)
        half = np.linalg.det(stretch)[..., np.newaxis, np.newaxis] * _full(self._core.stress) @ np.linalg.inv(stretch) / 2
        return self._tensors("nominal", _six(half + half.swapaxes(-1, -2)))

    @property
    def von_mises(self) -> Floats:
        """Von Mises stress of every cell [Pa]: array (cz, cy, cx).

        Raises:
            ValueError: a method without stress
        """
        self._require_stress()
        return self._core.von_mises

    @property
    def principal_strain(self) -> Floats:
        """Principal strains of every cell [1]: array (cz, cy, cx, 3), the largest first."""
        return self._kept("principal", lambda: np.linalg.eigvalsh(_full(self._core.strain))[..., ::-1].copy())

    @property
    def fibre_direction(self) -> Optional[Floats]:
        """Unit vectors along the fibres of every cell: array (cz, cy, cx, 3); None where the scene has no fibres.

        A fibre has no sign: of the two the one that is nearer to the mean direction.
        """
        fibres = self._core.scene.fibres
        if fibres is None:
            return None
        flat = fibres.reshape(-1, 3)
        mean = np.linalg.eigh(flat.T @ flat)[1][:, -1]
        signed = fibres * np.where(fibres @ (mean if mean[np.abs(mean).argmax()] > 0 else -mean) < 0, -1.0, 1.0)[..., np.newaxis]
        return self._kept("fibres", lambda: vectors_in(self._axes, signed))

    def _along_fibres(self, tensors: Floats) -> Optional[Floats]:
        fibres = self._core.scene.fibres
        return None if fibres is None else np.einsum("...i,...ij,...j->...", fibres, _full(tensors), fibres)

    @property
    def fibre_strain(self) -> Optional[Floats]:
        """Strain along the fibre of every cell [1]: array (cz, cy, cx); None where the scene has no fibres."""
        return self._along_fibres(self._core.strain)

    @property
    def fibre_stress(self) -> Optional[Floats]:
        """Stress along the fibre of every cell [Pa], as ``fibre_strain``.

        Raises:
            ValueError: a method without stress
        """
        self._require_stress()
        return self._along_fibres(self._core.stress)

    @property
    def label(self) -> Optional[npt.NDArray[np.int32]]:
        """The label of every cell: array (cz, cy, cx), 0 without matter; None where the body is no segmentation."""
        return self._core.scene.labels

    @property
    def estimated_error(self) -> Optional[float]:
        """Estimated relative error of the displacement against elasticity (L2), without finite elements [1].

        Found on first use, by multigrid: about ten times the time of ``coupled``. None where there is no estimate
        (``estimate()["reason"]`` says why).
        """
        found = self.estimate().get("relative_l2")
        return None if found is None else float(found)

    def estimate(self, *, threads: Optional[int] = None, progress: Progress = None) -> Dict[str, Any]:
        """Estimated errors: relative_l2, relative_max, rms [m], force, strain_energy, strain, stress, or the reason."""
        if self._estimate is None:
            with told(progress) as tell:
                self._estimate = self._core.estimate(threads or os.cpu_count() or 1, tell)
        return self._estimate

    def _of_mechanics(self, key: str) -> List[Record]:
        if self._mechanics is None:
            self._mechanics = self._core.mechanics()
        rows: List[Record] = self._mechanics[key]
        return rows

    @property
    def labels(self) -> List[Record]:
        """A record a label (``label`` has the array): cells, volumes [m^3], strains [1] and stresses [Pa] as mean, min, max and percentiles.

        Read them by ``pandas.DataFrame(answer.labels)``. Empty where the body is no segmentation.
        """
        return self._of_mechanics("labels")

    @property
    def materials(self) -> List[Record]:
        """The same, a record a material."""
        return self._of_mechanics("materials")

    @property
    def body(self) -> Record:
        """The same of the whole body."""
        record: Record = self._of_mechanics("body")  # type: ignore[assignment]
        return record

    @property
    def holds(self) -> List[Record]:
        """A record a hold: name, where, centroid [m], force [N] and moment [N m] on the body."""
        return self._of_mechanics("holds")

    @property
    def moves(self) -> List[Record]:
        """The same of moves."""
        return self._of_mechanics("moves")

    @property
    def loads(self) -> List[Record]:
        """The same of loads."""
        return self._of_mechanics("loads")

    @property
    def measures(self) -> Dict[str, Any]:
        """What the scene's measures say, by name: a number, three of a vector, a list of points of a line, or None."""
        found: Dict[str, Any] = {}
        for row in self._core.measures():
            found[row["name"]] = row["line"] or (row["value"] if row["vector"] is None else row["vector"])
        return found

    def to_vtk(self, unit: str = "m") -> Any:
        """A vtkImageData with Displacement at points, and of cells what files have: MaterialId, Label, FiberDirection,
        Strain, PrincipalStrain, FiberStrain, and of methods that know stress Stress, VonMises and FiberStress.

        In the world's place and frame, lengths in ``unit``, m or mm; ``pyvista.wrap`` takes it. Cells without matter
        are hidden. One copy: VTK keeps vectors interleaved. Needs VTK for Python (python3-vtk9, or pip install vtk).
        """
        from ._vtk import image_data

        return image_data(self, unit)

    def plot(self, field: Any = "displacement", *, axis: Optional[int] = None, at: Optional[int] = None,
             file: Optional[Union[str, "os.PathLike[str]"]] = None) -> Any:
        """A slice of the deformed body in the grid's axes, to scale, as a Matplotlib figure.

        Args:
            field: the colour: displacement (its size), von_mises, fibre_strain, fibre_stress, label, or an array of cells
            axis: across the slice: 0, 1 or 2 for x, y or z; default: the one with the fewest cells
            at: the cell's number along it; default: the middle
            file: .svg or .png, written too
        """
        from ._plots import save, slice_figure

        figure = slice_figure(self, field, axis, at)
        if file is not None:
            save(figure, os.fspath(file))
        return figure

    def warp(self, image: Any, *, labels: Optional[bool] = None, background: float = 0.0) -> Any:
        """The image where its matter has gone, on the same grid: what is no matter is ``background``.

        Cell by cell, so that labels that slide apart keep their voxels. Cost: about 0.1 us a voxel.

        Args:
            image: a nibabel image (comes back as one), a ``maille.Image``, or an array on the grid of the scene's
                own image
            labels: True: the nearest voxel's value; False: linear. Without it, whole numbers of at most 256 values
                are labels
        """
        values, grid = self._values_and_grid(image)
        is_labels = are_labels(values) if labels is None else labels
        warped = self._pull(grid).warp(_planes(values), is_labels, background).T
        if values.dtype.kind in "biu" and is_labels:
            warped = warped.astype(values.dtype)
        if isinstance(image, Image):
            return Image(warped, affine=image.affine, labels=image.labels, material=image.material,
                         spacing=image.spacing, unit=image.unit)
        if isinstance(image, SpatialImage):
            return type(image)(warped, image.affine)  # type: ignore[call-arg]
        return warped

    def warped_labels(self, image: Any = None) -> List[Record]:
        """A record a label of an image (the scene's own): volume at rest, warped, integral of det F, centroids, folds.

        ``volume`` counts voxels as a viewer does, ``sub_voxel_volume`` parts of voxels too. Volumes in m^3, centroids in the image's world [m].
        """
        values, grid = self._values_and_grid(self._scene._own_image() if image is None else image)
        rows: List[Record] = self._pull(grid).table(_planes(values))
        return rows

    def save_transform(self, file: Union[str, "os.PathLike[str]"], image: Any = None, *, forward: bool = False, overwrite: bool = False) -> None:
        """Writes the field that carries images (``forward``: points) for 3D Slicer, ANTs, ITK, plastimatch, elastix.

        Args:
            file: .nii, .nii.gz, .mha or .nrrd: displacement in mm along left, posterior, superior; of NIfTI in five
                axes with intent 1007. A forward field is to be a .nrrd, which alone can say what it is.
            image: whose grid it is on; the scene's own without one
        """
        if forward and not os.fspath(file).endswith(".nrrd"):
            raise ValueError("expected a .nrrd for a forward field: other files are taken for the inverse")
        refuse_foreign(file, overwrite)
        self._pull(self._grid_of(image)).save(os.fspath(file), forward)

    def _pull(self, grid: Tuple[Tuple[int, int, int], Rows, str]) -> _core.Pull:
        pull = _core.Pull(self._core, *grid)
        if pull.counts["voxels"] == 0:
            raise ValueError("expected an image that meets the body, found none of its voxels where the matter has gone")
        return pull

    def _grid_of(self, image: Any) -> Tuple[Tuple[int, int, int], Rows, str]:
        return self._scene._grid() if image is None else self._values_and_grid(image)[1]

    def _values_and_grid(self, image: Any) -> Tuple[npt.NDArray[Any], Tuple[Tuple[int, int, int], Rows, str]]:
        if isinstance(image, Image):
            values, rows, world = image.voxels(), image.rows(), "ras"
        elif isinstance(image, SpatialImage):
            values, rows, world = np.asarray(image.dataobj), metres(image.affine), "ras"
            if values.ndim == 4 and values.shape[3] == 1:
                values = values[..., 0]
        else:
            values = np.asarray(image)
            grid = self._scene._grid()
            if values.shape != grid[0]:
                raise ValueError(f"expected an array of the scene's own grid, {grid[0]}, found {values.shape}")
            return values, grid
        if values.ndim != 3:
            raise ValueError(f"expected an image of three axes, found {values.ndim}")
        i, j, k = values.shape
        return values, ((i, j, k), rows, world)


def _restored(scene: "Scene", state: Any, frame: str, fraction: float) -> Answer:
    asked = scene._built if fraction == 1 else scene._built.scaled(fraction)
    return Answer(_core.answer_of(asked, state), scene, frame, fraction)


def _planes(values: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """As the module takes voxels: (k, j, i), x fastest."""
    return np.ascontiguousarray(values.T, dtype=np.float32)


def compare(answer: Answer, *, reference: Answer) -> Errors:
    """How far ``answer`` is from ``reference``, on the same grid, in displacement and in mechanics."""
    return Errors(**_core.compare(answer._core, reference._core))


__all__ = ["Answer", "Errors", "compare", "labels_of"]
