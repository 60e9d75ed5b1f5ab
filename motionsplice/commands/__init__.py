"""The commands of `motionsplice`, one module a group. Imported by `cli`."""
