"""From files to a bank: sources, cache, worker processes, the job itself. Imports all rooms but `study`."""
