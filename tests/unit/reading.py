"""What the tests of all readers share."""

import pytest

from freerock.errors import FreerockError
from freerock.records.read import read_record


def refusal(path, channel=None):
    """The one line with which a record file is refused, less the path that begins it."""
    with pytest.raises(FreerockError) as error:
        read_record(path, channel)
    message = str(error.value)
    assert message.startswith(f"{path}: ") and "\n" not in message
    return message.removeprefix(f"{path}: ")
