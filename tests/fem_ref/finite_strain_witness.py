"""Stretches, shears and bends a block of neo-Hookean matter by dolfinx (FEniCS), whose authors share nothing with Maille.

usage: finite_strain_witness.py CASE N_X N_Y N_Z H MU LAMBDA BY
Prints x y z u_x u_y u_z of every corner of the mesh [m]. The element is Q2 without a pressure of its own.
Exit code 77 without dolfinx.
"""
import sys

try:
    import numpy as np
    import ufl
    from dolfinx import fem, mesh, nls
    from mpi4py import MPI
    from petsc4py import PETSc
except ImportError:
    sys.exit(77)

case, cells, (h, mu, lam, by) = sys.argv[1], [int(n) for n in sys.argv[2:5]], [float(x) for x in sys.argv[5:9]]
size = [n * h for n in cells]
box = mesh.create_box(MPI.COMM_SELF, [[0, 0, 0], size], cells, mesh.CellType.hexahedron)
space = fem.VectorFunctionSpace(box, ("CG", 2))
u, v = fem.Function(space), ufl.TestFunction(space)
F = ufl.Identity(3) + ufl.grad(u)
log_J = ufl.ln(ufl.det(F))
energy = (mu / 2 * (ufl.inner(F, F) - 3) - mu * log_J + lam / 2 * log_J**2) * ufl.dx(metadata={"quadrature_degree": 5})
fraction = fem.Constant(box, PETSc.ScalarType(0))
along = {"stretch": 0, "shear": 1, "twist": None}[case]
moved = fem.Function(space)


def displacement(x):
    value = np.zeros_like(x)
    angle = float(fraction.value) * by
    if along is None: # about the axis of the bar
        y, z = x[1] - size[1] / 2, x[2] - size[2] / 2
        value[1] = np.cos(angle) * y - np.sin(angle) * z - y
        value[2] = np.sin(angle) * y + np.cos(angle) * z - z
    else:
        value[along] = float(fraction.value) * by
    return value


low = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[0], 0))
high = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[0], size[0]))
held = fem.Function(space)
problem = fem.petsc.NonlinearProblem(ufl.derivative(energy, u, v), u, [fem.dirichletbc(held, low), fem.dirichletbc(moved, high)])
solver = nls.petsc.NewtonSolver(MPI.COMM_SELF, problem)
solver.rtol = solver.atol = 1e-12
solver.convergence_criterion = "incremental"
solver.krylov_solver.setType("preonly")
solver.krylov_solver.getPC().setType("lu")
for step in range(1, 9):
    fraction.value = step / 8
    moved.interpolate(displacement)
    solver.solve(u)
x = space.tabulate_dof_coordinates()
values = u.x.array.reshape(-1, 3)
for place, of in zip(x, values):
    if np.allclose(place / h, np.round(place / h), atol=1e-6):
        print(*(f"{number:.12g}" for number in (*place, *of)))
