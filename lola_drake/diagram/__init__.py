"""From a Drake system to a picture: what is wired, where it goes, how it looks."""
