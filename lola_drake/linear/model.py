"""A linear model with what it was made of, and how a notebook shows it."""

from dataclasses import dataclass

import control

from lola_drake.linear.poles import poles
from lola_drake.linear.tables import pole_table
from lola_drake.linear.text_table import Table


@dataclass(frozen=True)
class OperatingPoint:
    """Where and how a linear model was made.

    Attributes:
        time: of the context (s).
        drift: by how much each state moves in this tick, by name; all zero in an equilibrium.
        residual: the largest drift, relative to 100 N, 100 Nm, and 1 of everything else.
        held: blocks that were held.
        cut: states that were cut because nothing observes or excites them.
        kinks: states and inputs of blocks at which the two sides have different slopes; the model
            has the mean of both.
    """

    time: float
    drift: dict[str, float]
    residual: float
    held: tuple[str, ...]
    cut: tuple[str, ...]
    kinks: tuple[str, ...]

    def __repr__(self):
        told = f"{len(self.drift)} states, residual {self.residual:.1e}, {len(self.cut)} cut"
        return f"<OperatingPoint at {self.time:.3f} s: {told}>"


class LinearModel(control.StateSpace):
    """A `control.StateSpace` that knows its operating point.

    What is computed from it by python-control is a plain StateSpace.

    Attributes:
        operating_point: where and how it was made.
    """

    def __init__(self, *matrices, operating_point: OperatingPoint, **names):
        """Create a model; all but the operating point is python-control's."""
        super().__init__(*matrices, remove_useless_states=False, **names)
        self.operating_point = operating_point

    def __repr__(self):
        size = f"{self.nstates} states, {self.ninputs} in, {self.noutputs} out"
        return f"<LinearModel of {size}, dt = {self.dt:g} s>"

    def _repr_html_(self) -> str:
        point = self.operating_point
        rows = (
            ("inputs", ", ".join(self.input_labels)),
            ("outputs", ", ".join(self.output_labels)),
            ("states", f"{self.nstates}; {len(point.cut)} cut that nothing excites or observes"),
            ("held", ", ".join(point.held) or "–"),
            ("drift", f"{point.residual:.1e} in a tick"),
        )
        title = f"Linear model at {point.time:.3f} s"
        about = Table(title, ("sample time", f"{self.dt:g} s"), rows)
        return about.as_html() + (pole_table(poles(self)).as_html() if self.nstates else "")
