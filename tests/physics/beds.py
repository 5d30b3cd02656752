"""Beds and starts that the properties of a motion are tried on."""

from hypothesis import strategies as st

beds = st.tuples(st.floats(2e6, 1e9), st.floats(0, 0.05), st.booleans()).map(
    lambda x: (
        ("winkler", {"k": x[0], "c": x[0] * x[1]})
        if x[2]
        else ("hunt_crossley", {"k": x[0], "lambda": 1e3 * x[0] * x[1]})
    )
)
starts = st.tuples(st.floats(-0.12, 0.12), st.floats(-0.5, 0.5))
