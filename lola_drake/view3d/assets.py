"""The files of which the pages of the 3D view are made."""

from importlib.resources import files


def asset(name: str) -> str:
    """Return a file of the folder `page` beside this module."""
    return files("lola_drake.view3d").joinpath("page", name).read_text(encoding="utf-8")


def with_script(page: str, *names: str) -> str:
    """Return a page of Meshcat's with scripts at its end."""
    body, end = page.rsplit("</body>", 1)
    return f"{body}<script>{''.join(map(asset, names))}</script></body>{end}"
