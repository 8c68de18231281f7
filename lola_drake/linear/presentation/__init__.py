"""How the studies are shown: figures, text, plain numbers."""
