"""The records of a job, one after the other: an error in one does not stop the others."""

import errno
import logging
from collections.abc import Callable, Sequence

from freerock.errors import FreerockError

# What the machine lacks, whatever the record: space, a disk that answers, memory, open files.
MACHINE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ESTALE}
MACHINE |= {errno.ENOMEM, errno.EMFILE, errno.ENFILE}


def make_each(tests: Sequence[str], make: Callable[[str], None], give_up: Callable[[str, str], None]) -> None:
    """Make the product of each test of a job; an unforeseen error in one does not stop the others.

    A `FreerockError` and what is the machine's fault, such as a full disk or a lack of memory, end the job.

    Parameters
    ----------
    tests : sequence of str
    make : callable
        Takes a test and writes its product.
    give_up : callable
        Takes a test and a reason, and writes a product that holds this reason.
    """
    logger = logging.getLogger("freerock")
    for number, test in enumerate(tests, 1):
        logger.info("%s (%d of %d)", test, number, len(tests))
        try:
            make(test)
        except Exception as error:
            if isinstance(error, FreerockError) or of_the_machine(error):
                raise
            reason = f"unforeseen: {type(error).__name__}: {error}; the log of the step has the traceback"
            logger.exception("%s: %s", test, reason)
            give_up(test, reason)


def of_the_machine(error: BaseException | None) -> bool:
    """Whether an error, or one it was raised from, says nothing about the record: a full disk, no memory."""
    while error is not None:
        if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno in MACHINE):
            return True
        error = error.__cause__ or error.__context__
    return False
