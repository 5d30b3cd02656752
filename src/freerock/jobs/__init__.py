"""What the steps of the workflow do, a module per step; the checksum of their code; their logs."""

import freerock.jobs.garbage  # noqa: F401
