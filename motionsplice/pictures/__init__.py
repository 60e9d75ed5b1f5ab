"""Contact sheets, animations and charts. Imported by the commands and by benchmarks."""
