"""Sheets, films and charts. Imported by the commands and by benchmarks."""
