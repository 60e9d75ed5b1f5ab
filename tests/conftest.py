from __future__ import annotations

from hypothesis import settings

# A first call may compile a kernel, and CI machines stall: how long an example takes says nothing here.
settings.register_profile("motionsplice", deadline=None)
settings.load_profile("motionsplice")
