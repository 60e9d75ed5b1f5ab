"""When: aligning clips to a baseline's stride, and in pairs. Imports `body`."""
