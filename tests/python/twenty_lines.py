import maille, nibabel as nib, numpy as np
image = nib.load("labels.nii.gz")
scene = maille.Scene(
    specimen=maille.Image(np.asarray(image.dataobj), affine=image.affine, labels={17: "muscle/soleus"}, fibre=(0, 0, 1)),
    holds=[maille.hold("z-")],
    moves=[maille.move("z+", by=(0, 0, "7.5 mm"))])
scene.check()                                  # raises SceneFaults, every fault at once, with key and value
limits  = scene.run("limits")                  # releases the GIL; Ctrl-C stops it; threads=, progress=
elastic = scene.run("coupled", tolerance=1e-3)
print(elastic.status, elastic.seconds, elastic.iterations, elastic.estimated_error)
u = elastic.displacement                       # ndarray (nz, ny, nx, 3), metres, a view: no copy
print(maille.compare(limits, reference=elastic).relative_l2)
warped = elastic.warp(image)                   # labels carried along; nibabel image, same grid and affine
nib.save(warped, "labels_warped.nii.gz")
elastic.save_transform("pull.nii.gz")          # for Slicer, ANTs, ITK, plastimatch, elastix
grid = elastic.to_vtk()                        # vtkImageData; pyvista.wrap(grid) just works
drag = scene.drag()                            # step by step, for interactive use
for t in np.linspace(0, 1, 50):
    drag.move("z+", by=(0, 0, 0.0075 * t)); field = drag.displacement
scene.save("soleus.toml"); same = maille.load("soleus.toml")   # the file is the truth
