"""What characters are like from one second to the next."""
