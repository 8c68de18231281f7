"""Pages about runs: figures, replays, settings and diagram in one file."""
