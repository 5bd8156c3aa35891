"""Read meshes of strangers, a file a step, in a process of its own, checked twice."""
