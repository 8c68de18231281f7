"""What a notebook shows of results, models, diagrams, and what is printed of the rest."""

import html
import re
import xml.etree.ElementTree as ElementTree

import pytest
from linear_toys import discrete, loop

import lola_drake as lola
from lola_drake.block_system import BlockSystem
from lola_drake.blocks.imu_stabilizer import ImuStabilizer, ImuStabilizerParams


def test_a_result_is_short_in_words_and_a_table_in_a_notebook(make_result):
    result = make_result(steps=2)
    assert repr(result) == "<Result of unnamed (dyn): completed at 3.599 s>"
    table = result._repr_html_()
    assert "completed at 3.599 s" in table and "max_inclination_deg.x" in table
    fallen = make_result(steps=1, completed=False, fall_time=1.5)
    assert "fell at 1.500 s" in repr(fallen) and "fell at 1.500 s" in fallen._repr_html_()
    assert "interrupted" in repr(make_result(steps=1, completed=False))


def test_show_is_a_frame_that_holds_its_page(make_result):
    view = lola.show(make_result(steps=1), height=300)
    frame = view._repr_html_()
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', frame)[1])
    assert "height: 300px" in frame and page == view.page and 'id="packed"' in page
    assert len(repr(view)) < 60
    with pytest.raises(ValueError, match="There is none"):
        lola.show()


@pytest.fixture(scope="module")
def feedback():
    return loop(discrete(0.9, 0.1, 1.0), gain=2.0)


def test_a_linear_model_is_a_table_of_its_poles_in_a_notebook(feedback):
    model = lola.linearize(feedback, "controller.y0", "plant.y0", feedback.CreateDefaultContext())
    assert repr(model) == "<LinearModel of 1 states, 1 in, 1 out, dt = 0.001 s>"
    table = model._repr_html_()
    assert "controller/y0/0" in table and "plant/y0/0" in table and "plant/x0 (100%)" in table
    # log(0.9 - 0.1 * 2) / 1 ms
    assert ">-357<" in table
    assert len(repr(model.operating_point)) < 80


def test_margins_are_a_table_in_a_notebook(feedback):
    found = lola.margins(lola.open_loop(feedback, "controller", feedback.CreateDefaultContext()))
    table = found._repr_html_()
    (one,) = found.each
    assert f"{one.gain_up:.3g} @" in table and f"{found.together.disk:.2f}" in table


def test_a_drawing_is_a_picture_in_a_notebook(feedback):
    whole = lola.block_diagram(feedback)
    texts = "".join(ElementTree.fromstring(whole._repr_svg_()).itertext())
    assert "plant" in texts and "controller" in texts
    card = lola.block_diagram(BlockSystem(ImuStabilizer(ImuStabilizerParams())))
    assert "torso_orientation" in card._repr_svg_()
    assert max(len(repr(drawing)) for drawing in (whole, card)) < 80


def test_what_is_printed_is_short():
    run = lola.start(lola.load_scenario("stand", {"duration": 1}))
    run.advance(0.05)
    gain = next(run.gains())
    assert repr(run) == "<Run of stand (dyn): at 0.050 s, fused>"
    assert repr(run.scenario) == "<Scenario stand (dyn): 1 s, seed 0>"
    assert repr(gain) == f"<Gain {gain.block}.{gain.name} ({gain.field.metadata['unit'] or '-'})>"
    blocks = {name: repr(block) for name, block in run.blocks.items()}
    assert blocks["imu_stabilizer"] == "<ImuStabilizer: modified_wrench>"
    assert "of foot l" in blocks["force_control_l"]
    assert all(len(text) < 150 for text in blocks.values()), blocks
