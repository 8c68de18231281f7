"""Tables of text: aligned, whole, and no wider than a terminal."""

import pytest

from lola_drake.linear.text_table import Table


def table(*widths):
    header = tuple(f"h{k}".ljust(width, ".") for k, width in enumerate(widths))
    return Table("title", header, (tuple(f"c{k}" for k in range(len(widths))),))


def test_columns_are_aligned_under_their_names():
    title, header, row = table(5, 9, 4).as_text().splitlines()
    assert title == "title"
    assert [header.index(f"h{k}") for k in range(3)] == [row.index(f"c{k}") for k in range(3)]


@pytest.mark.parametrize("widths", [(30, 24, 20), (30, 24, 21), (20, 30, 30, 30), (40, 36, 36, 36)])
def test_no_line_is_wider_than_a_terminal_and_every_cell_is_there(widths):
    text = table(*widths).as_text()
    assert max(map(len, text.splitlines())) <= 80
    assert all(cell in text for k in range(len(widths)) for cell in (f"h{k}", f"c{k}"))


def test_a_table_in_parts_begins_each_with_the_first_column():
    lines = table(20, 26, 26, 26).as_text().splitlines()[1:]
    assert [line.split()[0][:2] for line in lines] == ["h0", "c0", "h0", "c0"]
