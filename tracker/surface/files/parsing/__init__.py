"""Parse mesh files: PLY, OBJ and GLB.

Everything here runs in the child process, never beside a page.

One module per kind of file gives a `RawMesh`; whatever is wrong with a file raises `Refused`. GLB
is read by trimesh; why PLY and OBJ are not, each of them names.
"""
