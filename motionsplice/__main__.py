"""`python -m motionsplice`."""

from motionsplice.cli import main

main()
