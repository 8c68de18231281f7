"""How long a tick takes, beside the bare plant and beside MuJoCo."""
