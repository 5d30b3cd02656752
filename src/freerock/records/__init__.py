"""Record files: one module per format behind `read.read_record`, all of them on an even time base.

`at2`, of ground motions alone, is read by `response.motions`.
"""

__all__ = ["at2", "channels", "read"]
