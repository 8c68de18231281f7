"""What the page on models of one's own tells people to type runs, and gives what it says."""

import re
from pathlib import Path

import control
import matplotlib
import numpy as np
import pytest

import lola_drake as lola

PAGE = Path(__file__).parents[2] / "docs" / "linearise_your_own.md"


@pytest.fixture(scope="module")
def page():
    """Return the names that the page's code leaves behind."""
    matplotlib.use("Agg")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
        exec(block, names)  # noqa: S102
    return names


def test_the_cart_pole_stands_and_its_labels_have_units(page):
    assert page["model"].output_labels[:2] == [
        "plant/state/q/rail (m)",
        "plant/state/q/hinge (rad)",
    ]
    found = page["found"]
    assert found.stable
    assert 0.0 < found.gain_down < 1.0 < found.gain_up, "without its law the pole falls over"
    assert lola.poles(page["model"])[0].damping > 0


def test_a_servo_holds_against_gravity(page):
    assert control.dcgain(page["servo"]) == pytest.approx(20.0 / (20.0 + 9.81 * 0.5), rel=1e-6)
    assert page["servo"].input_labels == ["desired/q/hinge (rad)"]


def test_a_filter_chain_is_its_transfer_function(page):
    chain, textbook = page["chain"], page["textbook"]
    z = np.exp(1j * page["w"] * 0.001)
    np.testing.assert_allclose(chain(z), textbook(z), rtol=1e-8)
    assert chain.nstates == 5
