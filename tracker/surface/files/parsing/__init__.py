"""Meshes out of files of strangers. Everything here runs in the child process, never beside a page.

One module per kind of file gives a `RawMesh`; whatever is wrong with a file raises `Refused`. What
trimesh does otherwise each of them names; it also takes half a second and 60 MB to be imported.
"""
