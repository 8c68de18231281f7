"""The robot in 3D: live in a browser, as a replay, as a film."""
