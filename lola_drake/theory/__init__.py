"""Plain NumPy: contact model, gait, CoM trajectory, leg masses. Nothing here knows Drake."""
