"""Write and read motion, keypoints and cameras in other programs' formats, a module each."""
