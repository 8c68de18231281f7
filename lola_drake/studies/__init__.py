"""Many runs: variants side by side, sampled worlds, reproduction of the paper, tuning."""
