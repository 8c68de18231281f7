"""What looks at a simulation or its record: pictures, figures, replays, reports."""
