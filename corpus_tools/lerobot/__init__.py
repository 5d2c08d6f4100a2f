"""LeRobot's datasets on a disk: reading versions 2.1 and 3, and putting language into copies."""
