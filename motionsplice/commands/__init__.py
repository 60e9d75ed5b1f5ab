"""The commands of `motionsplice`, one module per group. Each is imported when one of its commands is used."""
