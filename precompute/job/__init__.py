"""The offline job, from files to a bank: sources, cache, worker processes, the job itself."""
