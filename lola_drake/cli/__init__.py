"""The `lola` command: one file a theme, put together in `app`."""
