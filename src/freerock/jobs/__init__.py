"""What the steps of the workflow do, a module per step; the checksum of their code; their logs.

A process that imports this room looks for garbage seldom.
"""

import freerock.jobs.garbage  # noqa: F401
