"""What lies in `models/`: the same in a checkout and in an installed wheel."""

from pathlib import Path

from lola_drake import typed_yaml


def models_dir() -> Path:
    """Return the folder of robot and scenario files.

    The wheel carries it inside the package; a checkout has it beside the package.
    """
    package = Path(__file__).resolve().parent
    packaged = package / "models"
    return packaged if packaged.is_dir() else package.parent / "models"


def scenario_paths() -> dict[str, Path]:
    """Return the files of the scenarios that come with the package, by name."""
    return {path.stem: path for path in sorted(models_dir().glob("scenarios/*.yaml"))}


def list_scenarios() -> dict[str, str]:
    """Return the scenarios that come with the package: name and one-line description.

    Reads the descriptions only, so that a list needs neither the robot nor Drake.
    """
    return {
        name: typed_yaml.parse(path.read_text(encoding="utf-8"))["description"]
        for name, path in scenario_paths().items()
    }


def arena_records() -> list[Path]:
    """Return the evaluations of laws that come with the package."""
    return sorted((models_dir() / "arena").glob("*.json"))
