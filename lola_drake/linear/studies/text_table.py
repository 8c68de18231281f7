"""Tables of text."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """A titled table of text."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def as_text(self) -> str:
        """Return the table with aligned columns."""
        lines = [self.header, *self.rows]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.header))]
        texts = ["  ".join(f"{c:{w}}" for c, w in zip(line, widths, strict=True)) for line in lines]
        return "\n".join([self.title, *(f"  {text.rstrip()}" for text in texts)])
