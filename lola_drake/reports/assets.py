"""What pages are made of: their own files, and Plotly."""

from functools import cache
from importlib.metadata import distribution
from importlib.resources import files
from pathlib import Path

from lola_drake.view3d.replay import packed


def page_asset(name: str) -> str:
    """Return a file of the folder `page` beside this module."""
    return files("lola_drake.reports").joinpath("page", name).read_text(encoding="utf-8")


@cache
def packed_plotly() -> str:
    """Return Plotly's JavaScript, packed; the package itself is not imported, that takes long."""
    script = distribution("plotly").locate_file("plotly/package_data/plotly.min.js")
    return packed(Path(str(script)).read_bytes())
