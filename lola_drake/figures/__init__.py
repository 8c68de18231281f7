"""The figures of runs, for papers and reports."""
