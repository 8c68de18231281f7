"""The blocks of the paper's Fig. 2 and the sensors, one LeafSystem per file."""
