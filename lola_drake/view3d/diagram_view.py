"""The block diagram of a live page, with room for values at every port."""

from lola_drake.diagram.block_diagram import block_diagram
from lola_drake.diagram.drawing import to_svg
from lola_drake.scenario import Scenario
from lola_drake.world import build_simulation

ROW = 29.0
"""Height of a port's row (pt): its name, and below it value and sparkline."""


def live_diagram(scenario: Scenario) -> str:
    """Return the controller of a scenario as SVG; ports say their signals in `data-signal`."""
    return to_svg(block_diagram(build_simulation(scenario), system="controller", row=ROW))
