"""A clip made ready for a bank: aligned, looped, measured. Imports `alignment` and `body`."""
