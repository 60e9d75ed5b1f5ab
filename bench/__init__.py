"""Benchmarks: each number in the documentation has a command that measures and prints it.

Nothing in the package imports `bench`. Run the commands from the project's root, with `python -m`:

bench.quality                   How close are splices to the true motion?
bench.quality.identities        Do the sanity checks hold: a clip spliced onto itself, a known time warp, turned axes?
bench.quality.baselines         How much does the choice of the baseline clip matter?
bench.quality.postures          How close are the run-time postures to the papers' exact transfer?
bench.quality.interpolation     How much is lost between the keys of a bank at 30, 60 or 120 Hz?
bench.speed.frames              How many nanoseconds does a splice take per character and frame?
bench.speed.flatness            Is that time independent of clip length, number of clips and time since the start?
bench.speed.memory              How long does a large bank take to open, and do processes share its memory?
bench.speed.first_call          How long does a fresh process take until its first frame?
bench.speed.precompute          How long does the offline job take, and how does that grow?
bench.characters                Do characters pop, lose step or slide, do replays match, and what does a frame cost?
bench.characters.worn_hands     What does a hands layer cost at run time?
bench.hands                     How close are alignments of hands to the true alignment?
bench.service                   How does the service behave under load?
bench.service.profile           Where does the server spend its time?
bench.structure                 How large are the packages, and which of them import each other?
"""
