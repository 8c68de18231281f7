"""Results in a notebook."""

import html
import re

import pytest

import lola_drake as lola


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
