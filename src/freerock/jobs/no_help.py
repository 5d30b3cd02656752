"""Leaves the functions of Matplotlib without lists of what may be set; to be imported before what draws.

A job needs no such help. Matplotlib writes it for a hundred classes as it is imported: a tenth of a second.
"""

from matplotlib import artist

artist.kwdoc = lambda artist: ""
