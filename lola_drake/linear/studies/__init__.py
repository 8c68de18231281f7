"""What linear models say about LOLA: operating points, named analyses, maps, the gait."""
