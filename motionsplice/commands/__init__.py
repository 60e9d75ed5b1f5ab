"""The commands of `motionsplice`, one module a group. `cli` imports a module when one of its commands is used."""
