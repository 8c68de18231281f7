"""The blocks of the paper's Fig. 2 and the sensors, one `Block` per file."""
