"""Stretches, shears and bends a block of neo-Hookean matter by dolfinx (FEniCS), whose authors share nothing with Maille.

usage: finite_strain_witness.py CASE N_X N_Y N_Z H MU LAMBDA BY
Prints x y z u_x u_y u_z of every corner of the mesh [m]. Displacement is Q2; dilatation and pressure are linear in every cell, and are
unknowns beside it.
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
linear = ufl.FiniteElement("DPC", box.ufl_cell(), 1)
space = fem.FunctionSpace(box, ufl.MixedElement([ufl.VectorElement("CG", box.ufl_cell(), 2), linear, linear]))
all_fields, variation = fem.Function(space), ufl.TestFunction(space)
u, theta, pressure = ufl.split(all_fields)
F = ufl.Identity(3) + ufl.grad(u)
J = ufl.det(F)
evened = (theta / J) ** (1 / 3) * F
law = mu / 2 * (ufl.inner(evened, evened) - 3) - mu * ufl.ln(theta) + lam / 2 * ufl.ln(theta)**2
energy = (law + mu / 2 * ufl.ln(theta / J)**2 + pressure * (J - theta)) * ufl.dx(metadata={"quadrature_degree": 5})
fraction = fem.Constant(box, PETSc.ScalarType(0))
along = {"stretch": 0, "shear": 1, "twist": None}[case]
displacements, place_of = space.sub(0).collapse()
moved, held = fem.Function(displacements), fem.Function(displacements)
all_fields.sub(1).interpolate(lambda x: np.ones((1, x.shape[1])))


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


def fixed(values, at):
    dofs = fem.locate_dofs_geometrical((space.sub(0), displacements), lambda x: np.isclose(x[0], at))
    return fem.dirichletbc(values, dofs, space.sub(0))


problem = fem.petsc.NonlinearProblem(ufl.derivative(energy, all_fields, variation), all_fields, [fixed(held, 0), fixed(moved, size[0])])
solver = nls.petsc.NewtonSolver(MPI.COMM_SELF, problem)
solver.rtol = solver.atol = 1e-12
solver.convergence_criterion = "incremental"
solver.krylov_solver.setType("preonly")
solver.krylov_solver.getPC().setType("lu")
solver.krylov_solver.getPC().setFactorSolverType("mumps")
for step in range(1, 9):
    fraction.value = step / 8
    moved.interpolate(displacement)
    solver.solve(all_fields)
x = displacements.tabulate_dof_coordinates()
values = all_fields.x.array[place_of].reshape(-1, 3)
for place, of in zip(x, values):
    if np.allclose(place / h, np.round(place / h), atol=1e-6):
        print(*(f"{number:.12g}" for number in (*place, *of)))
