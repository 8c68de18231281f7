"""The public face of the package."""

import types

import lola_drake as lola


def test_every_public_name_is_where_the_face_says():
    assert {"simulate", "Scenario", "Block", "linearize"} <= set(lola.__all__) <= set(dir(lola))
    for name in lola.__all__:
        assert getattr(lola, name).__name__ == name
        assert not isinstance(getattr(lola, name), types.ModuleType)
