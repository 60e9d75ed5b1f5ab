"""Time alignment: of clips to the baseline's stride, and of two clips to each other."""
